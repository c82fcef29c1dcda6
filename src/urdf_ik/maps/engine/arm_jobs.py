"""Job: makes the chunks of a store. ArmQuestion: the part of a job that asks about an arm, as workers receive it."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from dataclasses import fields
from typing import Any, Protocol

from urdf_ik import _core
from urdf_ik.arm import Arm
from urdf_ik.cell import World

Pairs = tuple[tuple[str, str], ...]


class Job(Protocol):
    """Makes the files of a chunk, the same bytes on every machine. It is pickled for workers."""

    def __call__(self, chunk: int, /) -> Mapping[str, bytes]:
        """The files of a chunk, by their paths in the store."""


class ArmQuestion:
    """Base of frozen dataclasses that hold all that the answers about an arm depend on; pickled for workers.

    Attributes:
        arm: the arm.
        world: obstacles, or None.
    """

    arm: Arm
    world: World | None

    @property
    def pairs(self) -> Pairs | None:
        """Pairs of links that are checked for collision; None without a collision check."""
        raise NotImplementedError

    @property
    def of_the_arm(self) -> dict[str, Any]:
        """The arm, the world and the version of this package, as a store records them."""
        pairs = self.pairs
        return {
            "robot": self.arm.name,
            "urdf_sha256": urdf_digest(self.arm),
            "base": self.arm.base,
            "tip": self.arm.tip,
            "locked": dict(self.arm.chain.locked),
            "pairs_sha256": None if pairs is None else hashlib.sha256(repr(pairs).encode()).hexdigest(),
            "world": None if self.world is None else self.world.digest(),
            "made_by": versions()["urdf-ik"],
            "instructions": versions()["instructions"],
        }

    def __getstate__(self) -> dict[str, Any]:
        # A pickled arm has no collision model; the copy builds a new one, which needs the pairs that are checked.
        state = {each.name: getattr(self, each.name) for each in fields(self)}  # type: ignore[arg-type]
        return state | {"pairs": self.pairs}

    def __setstate__(self, state: dict[str, Any]) -> None:
        pairs = state.pop("pairs")
        self.__dict__.update(state)
        if pairs is not None:
            cell = self.arm.cell
            self.__dict__["arm"] = self.arm.with_cell(cell.with_collisions(cell.collisions.checking(pairs)))


def versions() -> dict[str, str]:
    """The versions that must be the same wherever chunks are made, for their bytes to be the same.

    Example:
        >>> sorted(versions())
        ['instructions', 'urdf-ik']
    """
    from urdf_ik.version import __version__

    return {"urdf-ik": __version__, "instructions": _core.isa()}


def urdf_digest(arm: Arm) -> str:
    """SHA-256 of the URDF that an arm was read from, as it was read, in hexadecimal.

    Example:
        >>> import urdf_ik
        >>> len(urdf_digest(urdf_ik.load("planar_2r")))
        64
    """
    return hashlib.sha256(arm.model.xml).hexdigest()
