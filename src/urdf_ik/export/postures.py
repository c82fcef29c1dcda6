"""A joint vector that shows what an arm can do."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from urdf_ik.arm import Arm
from urdf_ik.errors import UnsupportedArm

# Joint vectors among which one is chosen, and their seed.
_DRAWS, _SEED = 64, 0


def example(arm: Arm) -> NDArray[np.float64]:
    """Of seeded joint vectors inside the limits, (n,) rad or m, the one whose pose has most regular solutions there.

    Example:
        >>> import urdf_ik
        >>> arm = urdf_ik.load("zyyzyz_6r")
        >>> len(arm.ik(arm.fk(example(arm))))
        8
    """
    turning = ~arm.chain.prismatic
    lower, upper = np.clip(arm.limits.T, *np.where(turning, np.pi, 1.0)[None] * [[-1.0], [1.0]])
    lower, upper = np.minimum(lower, arm.limits[:, 1]), np.maximum(upper, arm.limits[:, 0])
    draws: NDArray[np.float64] = lower + (upper - lower) * np.random.default_rng(_SEED).uniform(
        0.2, 0.8, (_DRAWS, arm.dof)
    )
    try:
        at = None if arm.redundancy is None else arm.redundancy_of(draws)
        solutions = arm.ik(arm.fk(draws), redundancy=at).within_limits()
    except UnsupportedArm:
        best = 0
    else:
        best = int(np.argmax((solutions.valid & (solutions.singular == 0)).sum(axis=-1)))
    chosen: NDArray[np.float64] = draws[best]
    return chosen
