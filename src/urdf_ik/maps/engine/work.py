"""What long work asks of an arm, as it travels to workers and as it stands in a store."""

from __future__ import annotations

import hashlib
from dataclasses import fields
from typing import TYPE_CHECKING, Any

from urdf_ik.maps.engine.dask_workers import versions

if TYPE_CHECKING:
    from urdf_ik.arm import Arm
    from urdf_ik.cell import World

Pairs = tuple[tuple[str, str], ...]


class AskedOfAnArm:
    """A frozen dataclass of what is asked of an arm; it is pickled for workers.

    Attributes:
        arm: the arm.
        world: obstacles, or None.
    """

    arm: Arm
    world: World | None

    @property
    def pairs(self) -> Pairs | None:
        """Pairs of links that are checked for collision; None where no collision is asked for."""
        raise NotImplementedError

    @property
    def of_the_arm(self) -> dict[str, Any]:
        """What the answers depend on of arm and world, and who makes them, for a store."""
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
        # An arm is pickled without its collision model: it is built anew, and pairs that were changed are told apart.
        state = {each.name: getattr(self, each.name) for each in fields(self)}  # type: ignore[arg-type]
        return state | {"pairs": self.pairs}

    def __setstate__(self, state: dict[str, Any]) -> None:
        pairs = state.pop("pairs")
        self.__dict__.update(state)
        if pairs is not None:
            cell = self.arm.cell
            self.__dict__["arm"] = self.arm.with_cell(cell.with_collisions(cell.collisions.checking(pairs)))


def urdf_digest(arm: Arm) -> str:
    """SHA-256 of the URDF that an arm was read from, as it was read, in hexadecimal.

    Example:
        >>> import urdf_ik
        >>> len(urdf_digest(urdf_ik.load("planar_2r")))
        64
    """
    return hashlib.sha256(arm.model.xml).hexdigest()
