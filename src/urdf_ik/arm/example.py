"""Seeded joint vectors of an arm that are easy to picture, and the example among them."""

import numpy as np

from urdf_ik.arm.arm import Arm
from urdf_ik.errors import UnsupportedArm
from urdf_ik.typing import Array

_DRAWS, _SHARE = 256, 0.6
"""The example is drawn from the middle of each joint's range."""


def draws(arm: Arm, count: int, seed: int, share: float = 1.0) -> Array:
    """Joint vectors (count, n) from the middle ``share`` of the limits, within half a turn or a metre of zero."""
    reach = np.where(arm.chain.prismatic, 1.0, np.pi)
    lower, upper = np.clip(arm.limits.T, -reach, reach)
    # A joint whose whole range lies beyond half a turn is left as it is: clipping would leave its limits.
    outside = (arm.limits[:, 0] > reach) | (arm.limits[:, 1] < -reach)
    lower, upper = np.where(outside, arm.limits[:, 0], lower), np.where(outside, arm.limits[:, 1], upper)
    middle, half = 0.5 * (lower + upper), 0.5 * share * (upper - lower)
    return np.asarray(middle + half * np.random.default_rng(seed).uniform(-1.0, 1.0, size=(count, arm.dof)))


def example(arm: Arm, seed: int = 0) -> Array:
    """Of seeded joint vectors with short values, (n,) rad or m, the one whose pose has most regular solutions."""
    q = draws(arm, _DRAWS, seed, _SHARE)
    lower, upper = arm.limits.T
    rounded = np.round(q, 1)
    q = np.where((rounded >= lower) & (rounded <= upper), rounded, q)
    try:
        solutions = arm.ik(arm.fk(q), redundancy=None if arm.redundancy is None else arm.redundancy_of(q))
    except UnsupportedArm:
        return np.asarray(q[0])
    regular = (solutions.valid & (solutions.singular == 0)).sum(axis=-1)
    inside = solutions.within_limits().valid.sum(axis=-1)
    return np.asarray(q[int(np.lexsort((-inside, -regular))[0])])
