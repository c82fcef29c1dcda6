"""A second way to all solutions of a six-joint arm, as independent of its own solver as there is one."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from urdf_ik._kernels import hidden_joint, layout
from urdf_ik._kernels.refine import is_new, keep, refine
from urdf_ik._kernels.thresholds import CONVERGED, FINISHED, LONG_PATIENCE
from urdf_ik.families import general_6r

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from urdf_ik.arm import Arm
    from urdf_ik.families.plan import Plan

    Array = NDArray[np.float64]

STARTS = 200
_ROUNDS = 40
_NO_REFERENCE = np.zeros(7)


@dataclass(frozen=True)
class SecondWay:
    """Elimination, with or without Newton's method from random starts.

    Attributes:
        name: what it does, in words.
        plan: the elimination.
        starts: number of random starts; 0 for none.
    """

    name: str
    plan: Plan
    starts: int

    @classmethod
    def of(cls, arm: Arm) -> SecondWay:
        """The second way for this arm."""
        plan = general_6r.prepare_for_kernels(arm.chain)
        newton = f"Newton's method from {STARTS} random starts"
        if arm.structure.family == plan.family:
            _without_first(plan.arm)
            return cls(f"the elimination set up in its other ways, and {newton}", plan, STARTS)
        if arm.structure.is_exact:
            return cls("the general elimination", plan, 0)
        return cls(f"the general elimination alone, and {newton}", plan, STARTS)

    def solve(self, T: Array, rng: np.random.Generator) -> Array:
        """Solutions (k, 6) [rad] of one pose (4, 4), verified on the arm as written."""
        Q, flags = np.empty((1, 16, 6)), np.zeros((1, 16), np.uint8)
        self.plan.solve(T[None], self.plan.arm, _NO_REFERENCE, Q, flags)
        for q in rng.uniform(-math.pi, math.pi, (self.starts, 6)):
            converged = refine(self.plan.arm, T, q, _ROUNDS, FINISHED, LONG_PATIENCE) <= CONVERGED
            if converged and is_new(self.plan.arm, T, Q[0], flags[0], q):
                keep(Q[0], flags[0], 0, q, 0)
        return np.asarray(Q[0, (flags[0] & layout.VALID) > 0])

    def name_of(self, column: int) -> str:
        """What the report calls a solution of its."""
        return f"number {column + 1} of the second way"


def _without_first(arm: Array) -> None:
    """Take the first variant of the elimination out of an arm's numbers, in place, where there are others."""
    count = int(arm[layout.VARIANTS])
    if count > 1:
        variants = arm[layout.FIRST_VARIANT : layout.FIRST_VARIANT + count * hidden_joint.VARIANT]
        variants[: -hidden_joint.VARIANT] = variants[hidden_joint.VARIANT :].copy()
        arm[layout.VARIANTS] = count - 1
