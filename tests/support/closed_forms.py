"""Members of the families with three parallel axes at one end or a spherical middle, and their other solver."""

from functools import lru_cache

import numpy as np
from arms import random_arm
from arms_closed_forms import KINDS
from arms_general import tilted
from cases import VARIANTS, Case, described
from numpy.typing import NDArray

from urdf_ik.ik.families import general
from urdf_ik.kinematics.structure import analyse

Array = NDArray[np.float64]


@lru_cache
def member(kind: str, seed: int = 0, orthogonal: bool = False, aligned: bool = False) -> Case:
    """Load a random member of one of the families."""
    return described(random_arm(kind, seed, orthogonal=orthogonal, aligned=aligned, kinds=KINDS))


@lru_cache
def near_member(kind: str, eps: float) -> Case:
    """Load a random member that is ``eps`` [rad, share of length] off its family."""
    return described(tilted(random_arm(kind, 0, kinds=KINDS), eps, 0))


def members(kind: str) -> list[Case]:
    """One member of a kind for each of ``VARIANTS``."""
    return [member(kind, *variant) for variant in VARIANTS]


def by_elimination(case: Case, target: Array) -> Array:
    """The solutions (k, 6) of one pose that the general elimination finds."""
    solver = general.TURNING.plan(analyse(case.arm.chain), case.arm.chain).solver
    Q, marks = np.empty((1, 16, 6)), np.empty((1, 16), np.uint8)
    assert solver.solve(np.ascontiguousarray(target[None]), None, Q, marks) == -1
    return Q[marks & 1 != 0]
