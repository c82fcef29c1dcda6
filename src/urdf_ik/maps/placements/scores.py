"""The scores of base positions: their names, the question that they answer, and the job that computes them."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from urdf_ik.arm import Arm
from urdf_ik.cell import World
from urdf_ik.maps.engine import zarr_writer
from urdf_ik.maps.engine.arm_jobs import ArmQuestion
from urdf_ik.maps.workspaces import Grid
from urdf_ik.maps.workspaces.solution_counts import Counting
from urdf_ik.maps.workspaces.store.blocks import Blocks
from urdf_ik.model.poses import pose
from urdf_ik.support.angles import TURN
from urdf_ik.typing import Array

AXES = ("x", "y", "z", "heading")
BASES = 64
"""Base positions of a block where only poses are asked for."""
BASES_OF_A_PATH = 8
"""The same where a path is followed from each."""
FREE_VALUES = 16
"""Values of a redundancy parameter at which a target is solved; of a path all are searched."""
_AT_ONCE = 4096  # poses that are solved at a time


@dataclass(frozen=True)
class Score:
    """A number that every base position has.

    Attributes:
        kind: type of the number.
        words: what it is.
        fill: what stands for nothing.
        units: of the number; '1' for one without.
    """

    kind: str
    words: str
    fill: float = 0
    units: str = "1"


NOTHING = float("nan")
SCORES = {
    "reached": Score("uint32", "number of targets that are reached"),
    "solutions": Score("uint16", "least number of solutions of any target"),
    "branches": Score("uint16", "number of branches that reach every target"),
    "margin": Score("float32", "least limit margin of any target, of its best solution", NOTHING),
    "clearance": Score("float32", "least clearance of any target, of its best solution", NOTHING, "m"),
    "followed": Score("uint8", "1 where the path is followed without a jump"),
    "cost": Score("float32", "least cost of following the path", NOTHING),
}
"""All that a base position is scored by; a score of all targets is 0, or NaN, where one of them is not reached."""


@dataclass(frozen=True, eq=False)
class Asked(ArmQuestion):
    """The targets and all else that the scores of base positions depend on; pickled for workers.

    Attributes:
        arm: the arm.
        targets: (m, 4, 4) m, poses of the tip in the cell.
        grid: positions of the base link in the cell, the voxels' centres.
        headings: (h,) rad, turns of the base link about the cell's z axis.
        mount: (3, 3) the base link's rotation at heading zero.
        is_path: whether the targets are waypoints to be followed.
        world: obstacles in the cell, or None.
        margin: m that bodies must stay apart.
        collisions: whether collisions are looked for.
        threads: number of threads that solve.
    """

    arm: Arm
    targets: Array
    grid: Grid
    headings: Array
    mount: Array
    is_path: bool
    world: World | None
    margin: float
    collisions: bool
    threads: int

    @property
    def pairs(self) -> tuple[tuple[str, str], ...] | None:
        """Pairs of links that are checked for collision; None where no collision is looked for."""
        return self.arm.cell.collisions.checked_pairs if self.collisions else None

    @property
    def holds(self) -> tuple[str, ...]:
        """Names of the scores."""
        left_out = {"clearance"} if not self.collisions else set()
        left_out |= set() if self.is_path else {"followed", "cost"}
        return tuple(name for name in SCORES if name not in left_out)

    @property
    def blocks(self) -> Blocks:
        """How the positions are cut into chunks."""
        most = BASES_OF_A_PATH if self.is_path else BASES
        return Blocks.of(self.grid, max(1, most // len(self.headings)))

    @property
    def plans(self) -> tuple[zarr_writer.ArrayPlan, ...]:
        """The arrays of a store."""
        shape, chunk = (*self.grid.shape, len(self.headings)), (*self.blocks.shape, len(self.headings))
        return tuple(
            zarr_writer.ArrayPlan(
                name, AXES, shape, chunk, SCORES[name].kind, SCORES[name].fill,
                {"long_name": SCORES[name].words, "units": SCORES[name].units},
            )
            for name in self.holds
        )  # fmt: skip

    def described(self) -> dict[str, Any]:
        """All that the scores depend on, for a store."""
        return {
            **self.of_the_arm,
            "targets": {"count": len(self.targets), "sha256": hashlib.sha256(self.targets.tobytes()).hexdigest()},
            "grid": self.grid.described(),
            "headings": self.headings.tolist(),
            "mount": self.mount.tolist(),
            "is_path": self.is_path,
            "margin": self.margin,
            "holds": list(self.holds),
        }

    def base(self, position: Array, heading: float) -> Array:
        """(4, 4) pose of the base link in the cell."""
        found = pose(position, rotvec=[0.0, 0.0, heading])
        found[:3, :3] = found[:3, :3] @ self.mount
        return found

    def scores(self, position: Array) -> dict[str, list[float]]:
        """Every score of a position (3,) m, one number a heading."""
        each = [
            self._scores_at(np.linalg.inv(self.base(position, heading)).astype(np.float64))
            for heading in self.headings.tolist()
        ]
        return {name: [scores[name] for scores in each] for name in self.holds}

    def _scores_at(self, into_base: Array) -> dict[str, float]:
        """The scores of one pose of the base, by what brings the cell into it."""
        found = {name: SCORES[name].fill for name in self.holds}
        in_base, world = into_base @ self.targets, self._moved(into_base)
        counts: list[Any] = []
        margins, clearances, common = np.inf, np.inf, np.ones(len(self.arm.structure.branches), np.bool_)
        for start in range(0, len(in_base), _AT_ONCE):
            counting = self._solved(in_base[start : start + _AT_ONCE])
            counting.keep_within_limits()
            if self.collisions:
                counting.keep_free(world, self.margin)
            counts.append(counting.counts())
            if counts[-1].all():
                margins = min(margins, float(counting.greatest(counting.margin()).min()))
                kept = counting.kept.reshape(len(counting.kept), -1, len(common))
                common &= kept.any(axis=1).all(axis=0)
                if self.collisions:
                    clearances = min(clearances, float(counting.greatest(counting.clearance(world)).min()))
        each = np.concatenate(counts)
        found["reached"] = int((each > 0).sum())
        if not each.all():
            return found
        found |= {"solutions": int(each.min()), "branches": int(common.sum()), "margin": margins}
        if self.collisions:
            found["clearance"] = clearances
        if self.is_path:
            plan = self.arm.follow(in_base, world=world, margin=self.margin, collisions=self.collisions)
            found |= {"followed": int(plan.found), "cost": plan.cost if plan.found else NOTHING}
        return found

    def _solved(self, in_base: Array) -> Counting:
        """The solutions of poses (k, 4, 4), at all values of the redundancy parameters."""
        values = self._free_values
        if values is None:
            solved = self.arm.ik(in_base, threads=self.threads)
            return Counting(self.arm, solved.q, solved.valid)
        solved = self.arm.ik(in_base[:, None], redundancy=values, threads=self.threads)
        count = len(in_base)
        return Counting(self.arm, solved.q.reshape(count, -1, self.arm.dof), solved.valid.reshape(count, -1))

    @cached_property
    def _free_values(self) -> Array | None:
        """(v,) or (v, k) values of the redundancy parameters, evenly spread; None for an arm without."""
        free = self.arm.solver.parameters
        if not free:
            return None
        each = [np.linspace(*one.range, FREE_VALUES, endpoint=not one.round) for one in free]
        if len(each) == 1:
            return each[0]
        return np.stack(np.meshgrid(*each, indexing="ij"), axis=-1).reshape(-1, len(each))

    def _moved(self, into_base: Array) -> World | None:
        """The obstacles in the base link: one world, whose shapes are built once."""
        if self.world is None:
            return None
        for obstacle in self.world:
            self._own_world.move(obstacle.name, into_base @ obstacle.pose)
        return self._own_world

    @cached_property
    def _own_world(self) -> World:
        from urdf_ik.cell import World

        own = World()
        for name, shape, placed in self.world or ():
            own.add(name, shape, placed)
        return own


class Scoring:
    """Makes the files of a block of base positions."""

    def __init__(self, asked: Asked) -> None:
        self._asked = asked

    def __getstate__(self) -> dict[str, Any]:
        return {"_asked": self._asked}

    def __call__(self, chunk: int) -> Mapping[str, bytes]:
        """The files of a block."""
        return self._encoder.files(self._asked.blocks.place(chunk), self.arrays(chunk))

    def arrays(self, chunk: int) -> dict[str, NDArray[Any]]:
        """The scores of a block."""
        part = self._asked.blocks.part(chunk)
        shape = (*(each.stop - each.start for each in part), len(self._asked.headings))
        rows = [self._asked.scores(position) for position in self._asked.grid.centres_of(part)]
        return {
            name: np.array([row[name] for row in rows], dtype=SCORES[name].kind).reshape(shape)
            for name in self._asked.holds
        }

    @cached_property
    def _encoder(self) -> zarr_writer.Encoder:
        return zarr_writer.Encoder(self._asked.plans)


def headings(count: int) -> Array:
    """(count,) rad, evenly spaced turns from zero on."""
    return TURN * np.arange(count) / count
