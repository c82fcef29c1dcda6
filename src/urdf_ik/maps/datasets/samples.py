"""Samples of an arm, drawn chunk by chunk: a chunk depends on the seed and its own number alone."""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import Any

import numpy as np
from numpy.typing import NDArray

from urdf_ik.arm import Arm
from urdf_ik.cell import World
from urdf_ik.ik.solutions import limits as joint_limits
from urdf_ik.kinematics import velocity
from urdf_ik.maps.engine.arm_jobs import ArmQuestion
from urdf_ik.support.angles import TURN
from urdf_ik.typing import Array

Mask = NDArray[np.bool_]

CHUNK = 2**14
"""Samples that are drawn with one stream of random numbers."""
SAME = 1e-6
"""rad or m by which a solution may differ from the joint vector that was drawn and still be it; a double root that is
solved to 1e-9 m is that far off."""


@dataclass(frozen=True, eq=False)
class Samples:
    """Joint vectors drawn evenly within the limits, with pose, solutions and contacts of each.

    Attributes:
        q: (n, dof) rad or m.
        T: (n, 4, 4) m, pose of the tip in the base.
        solutions: (n, B, dof) rad or m, every solution of the pose, one row a branch, NaN where there is none; those of
            an arm with a redundancy parameter are at the value that ``q`` has.
        within: (n, B) whether a solution has an image inside the limits.
        branch: (n,) number of the branch that is ``q`` itself; -1 where none is, as where it is singular.
        singular_values: (n, 6) of the Jacobian at ``q``, greatest first, see ``arm.singular_directions``.
        collision: (n,) whether links touch each other or the world at ``q``; None where the URDF has no shapes.
    """

    q: Array
    T: Array
    solutions: Array
    within: Mask
    branch: NDArray[np.int8]
    singular_values: Array
    collision: Mask | None

    def __len__(self) -> int:
        return len(self.q)

    def __repr__(self) -> str:
        return f"<Samples: {len(self)} of {self.q.shape[1]} joints, {', '.join(self.columns)}>"

    @property
    def columns(self) -> dict[str, NDArray[Any]]:
        """The arrays that there are, by their names."""
        named = {each.name: getattr(self, each.name) for each in fields(self)}
        return {name: array for name, array in named.items() if array is not None}


@dataclass(frozen=True, eq=False)
class Drawing(ArmQuestion):
    """All that the samples depend on; pickled for workers.

    Attributes:
        arm: the arm.
        n: number of samples.
        seed: of the random numbers.
        world: obstacles, or None.
        collisions: whether collisions are looked for.
        chunk: samples of a chunk.
        threads: number of threads that solve.
    """

    arm: Arm
    n: int
    seed: int
    world: World | None
    collisions: bool
    chunk: int
    threads: int

    @property
    def pairs(self) -> tuple[tuple[str, str], ...] | None:
        """Pairs of links that are checked for collision; None where no collision is asked for."""
        return self.arm.cell.collisions.checked_pairs if self.collisions else None

    @property
    def chunks(self) -> int:
        """Number of chunks."""
        return -(-self.n // self.chunk)

    def rows(self, chunk: int) -> slice:
        """The samples of a chunk."""
        return slice(chunk * self.chunk, min((chunk + 1) * self.chunk, self.n))

    def samples(self, chunk: int) -> Samples:
        """The samples of a chunk, the same whoever draws them."""
        arm, rows = self.arm, self.rows(chunk)
        low, high = joint_limits.drawn(arm.limits, ~arm.chain.prismatic).T
        stream = np.random.Generator(np.random.Philox(key=self.seed, counter=[0, 0, 0, chunk]))
        q = stream.uniform(low, high, (rows.stop - rows.start, arm.dof))
        T = arm.fk(q)
        held = None if arm.redundancy is None else arm.redundancy_of(q)
        found = arm.ik(T, redundancy=held, threads=self.threads)
        inside = found.within_limits().valid
        solutions = np.where(found.valid[..., None], found.q, np.nan)
        touching = arm.cell.collisions.in_world(self.world).in_collision(q) if self.collisions else None
        return Samples(
            q,
            T,
            solutions,
            np.asarray(inside),
            self._own(q, solutions),
            velocity.singular_directions(arm.chain, q).gains,
            None if touching is None else np.asarray(touching),
        )

    def described(self) -> dict[str, Any]:
        """All that the samples depend on, for a store."""
        return {
            **self.of_the_arm,
            "joints": self.arm.joint_names,
            "branches": self.arm.structure.branches,
            "n": self.n,
            "seed": self.seed,
            "chunk": self.chunk,
        }

    def _own(self, q: Array, solutions: Array) -> NDArray[np.int8]:
        """(n,) the branch that is ``q``, up to whole turns."""
        apart = np.abs(solutions - q[:, None])
        turns = np.where(self.arm.chain.prismatic, 0.0, TURN)
        wrapped = np.where(turns > 0.0, np.abs(np.mod(apart + 0.5 * TURN, TURN) - 0.5 * TURN), apart)
        off = np.where(np.isnan(wrapped).any(axis=-1), np.inf, wrapped.max(axis=-1))
        best = off.argmin(axis=-1)
        return np.where(off[np.arange(len(q)), best] <= SAME, best, -1).astype(np.int8)
