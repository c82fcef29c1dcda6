"""Question: the inputs that determine a map's arrays. Solver: the arrays at given positions."""

from __future__ import annotations

import hashlib
from dataclasses import asdict, dataclass, field
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from urdf_ik.arm import Arm
from urdf_ik.cell import World
from urdf_ik.errors import ArgumentError
from urdf_ik.maps.engine import versions
from urdf_ik.maps.engine.arm_jobs import ArmQuestion, urdf_digest
from urdf_ik.maps.workspaces.grid import Grid
from urdf_ik.maps.workspaces.orientations import Targets, sampled
from urdf_ik.maps.workspaces.solution_counts import Counting, sum_over_samples
from urdf_ik.maps.workspaces.workspace_map import About
from urdf_ik.support.text import quoted
from urdf_ik.typing import Array


class Held(NamedTuple):
    """An array of a map.

    Attributes:
        kind: type of its numbers.
        per: 'orientation' or 'branch', the meaning of its last dimension.
        words: description of the numbers.
        units: of the numbers; '1' without a unit.
    """

    kind: type[np.generic]
    per: str
    words: str
    units: str = "1"

    @property
    def fill(self) -> float:
        """The fill value: NaN for measured values, else 0."""
        return float("nan") if self.kind is np.float32 else 0


HELD = {
    "solutions": Held(np.uint8, "orientation", "number of solutions"),
    "within": Held(np.uint8, "orientation", "number of solutions within the limits"),
    "free": Held(np.uint8, "orientation", "number of solutions within the limits and free of collision"),
    "manipulability": Held(np.float32, "orientation", "greatest manipulability of the solutions that count"),
    "margin": Held(np.float32, "orientation", "greatest limit margin of the solutions that count"),
    "clearance": Held(np.float32, "orientation", "greatest clearance of the solutions that count", "m"),
    "branch_poses": Held(np.uint16, "branch", "number of orientations in which a branch has a solution that counts"),
}
"""The arrays that a map can hold."""


@dataclass(frozen=True, eq=False)
class Question(ArmQuestion):
    """The inputs that determine a map; pickled for workers.

    Attributes:
        arm: the arm.
        grid: the voxels.
        samples: (S, ...) orientations, directions or angles sampled at each position.
        holds: names of the requested arrays, a subset of ``HELD``.
        world: obstacles for 'free' and 'clearance', or None.
        redundancy: value of the redundancy parameter, or None.
        threads: number of threads that solve.
        at_once: positions that are solved at a time.
    """

    arm: Arm
    grid: Grid
    samples: Array = field(repr=False)
    holds: tuple[str, ...]
    world: World | None
    redundancy: float | None
    threads: int
    at_once: int

    @property
    def counted(self) -> str:
        """The last filter: solutions that pass it count for branches, manipulability, margin and clearance."""
        return next(name for name in ("free", "within", "solutions") if name in self.holds)

    @property
    def branches(self) -> tuple[str, ...]:
        """Names of the branches."""
        return self.arm.for_task(self.arm.task).structure.branches

    @property
    def pairs(self) -> tuple[tuple[str, str], ...] | None:
        """Pairs of links that are checked for collision; None if no requested array needs collision."""
        if "free" not in self.holds and "clearance" not in self.holds:
            return None
        return self.arm.cell.collisions.checked_pairs

    def shape(self, name: str, positions: tuple[int, ...]) -> tuple[int, ...]:
        """Shape of an array at positions of some shape."""
        return (*positions, len(self.branches) if HELD[name].per == "branch" else len(self.samples))

    def size(self, positions: int) -> int:
        """Size of all arrays at so many positions [bytes]."""
        return sum(
            int(np.prod(self.shape(name, (positions,)))) * np.dtype(HELD[name].kind).itemsize for name in self.holds
        )

    def scratch(self) -> int:
        """Bytes that solving takes beside the answers."""
        return self.at_once * len(self.samples) * (128 + 20 * len(self.branches) * (self.arm.dof + 1) * 8)

    def solver(self) -> Solver:
        """The solver of this question at given positions."""
        return Solver(self)

    def about(self) -> About:
        """The description of the map."""
        arm, free = self.arm, self.arm.redundancy
        return About(
            robot=arm.name,
            urdf_sha256=urdf_digest(arm),
            base=arm.base,
            tip=arm.tip,
            joints=arm.joint_names,
            limits=tuple(
                (None if np.isinf(lower) else lower, None if np.isinf(upper) else upper)
                for lower, upper in arm.limits.tolist()
            ),
            locked=dict(arm.chain.locked),
            task=arm.task,
            sampled=sampled(arm),
            branches=self.branches,
            counted=self.counted,
            redundancy=None if free is None else float(free.default if self.redundancy is None else self.redundancy),
            world=None if self.world is None else self.world.digest(),
            made_by=versions()["urdf-ik"],
        )

    def described(self) -> dict[str, Any]:
        """All that the answers depend on, for a store."""
        return {
            **self.of_the_arm,
            **asdict(self.about()),
            "grid": self.grid.described(),
            "samples": {"count": len(self.samples), "sha256": hashlib.sha256(self.samples.tobytes()).hexdigest()},
            "holds": list(self.holds),
        }


class Solver:
    """Answers of a question at positions, into memory that is used again."""

    def __init__(self, asked: Question) -> None:
        self._asked = asked
        self._targets = Targets(asked.arm.task, asked.samples, asked.at_once)

    def answers(self, positions: Array) -> dict[str, NDArray[Any]]:
        """Every array at positions (k, 3) m: (k, S), or (k, B) for what is counted by branch."""
        asked = self._asked
        found = {name: np.empty(asked.shape(name, (len(positions),)), HELD[name].kind) for name in asked.holds}
        for start in range(0, len(positions), asked.at_once):
            part = slice(start, start + asked.at_once)
            for name, values in self._part(positions[part]).items():
                found[name][part] = values
        return found

    def _part(self, positions: Array) -> dict[str, NDArray[Any]]:
        asked = self._asked
        arm, count, columns = asked.arm, len(asked.samples), {}
        solved = arm.ik(self._targets.at(positions), task=arm.task, threads=asked.threads, redundancy=asked.redundancy)
        counting = Counting(arm, solved.q, solved.valid)
        columns["solutions"] = counting.counts()
        if "within" in asked.holds:
            counting.keep_within_limits()
            columns["within"] = counting.counts()
        if "free" in asked.holds:
            counting.keep_free(asked.world)
            columns["free"] = counting.counts()
        if "manipulability" in asked.holds:
            columns["manipulability"] = counting.greatest(counting.manipulability())
        if "margin" in asked.holds:
            columns["margin"] = counting.greatest(counting.margin())
        if "clearance" in asked.holds:
            columns["clearance"] = counting.greatest(counting.clearance(asked.world))
        shaped = {name: values.reshape(-1, count) for name, values in columns.items()}
        return {**shaped, "branch_poses": sum_over_samples(counting.kept, count)}


def require_map_of(about: About, arm: Arm) -> None:
    """Refuse a map of another arm: its voxels would stand where this one's tip cannot be.

    Raises:
        ArgumentError: it was made for another URDF, other frames, or with other joints held.

    Example:
        >>> import urdf_ik
        >>> arm = urdf_ik.load("planar_2r")
        >>> require_map_of(urdf_ik.maps.workspace(arm, voxel=0.05, orientations=4).about, arm)
    """
    if (about.base, about.tip) != (arm.base, arm.tip):
        raise ArgumentError(
            f"the map is one of {quoted(about.robot)} from {about.base} to {about.tip}, and the arm is one from "
            f"{arm.base} to {arm.tip}; give the same base and tip"
        )
    if about.urdf_sha256 != urdf_digest(arm) or about.locked != dict(arm.chain.locked):
        raise ArgumentError(
            f"the map is one of another URDF of {quoted(about.robot)}, or with other joints held, than the arm "
            f"{quoted(arm.name)}; make it anew: urdf-ik workspace"
        )
