"""Counts of the solutions of poses, filter by filter, and the best value of each pose's solutions."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from urdf_ik.arm import Arm
from urdf_ik.cell import World
from urdf_ik.ik.solutions import limits as joint_limits
from urdf_ik.typing import Array

Mask = NDArray[np.bool_]

_WORD = 8  # as many branches, a byte each, are one machine word


def sum_over_samples(kept: Mask, count: int) -> NDArray[np.uint16]:
    """(k, B) number of poses with a solution, of (k * count, B)."""
    columns = kept.shape[1]
    if columns != _WORD:
        return np.asarray(kept.reshape(-1, count, columns).sum(axis=1, dtype=np.uint16))
    # Eight branches at a time: their bytes are added as one word, and no more of them than a byte can count.
    words = kept.view(np.uint64).reshape(-1, count)
    sums = np.add.reduceat(words, np.arange(0, count, 255), axis=1).view(np.uint8)
    return np.asarray(sums.reshape(len(words), -1, columns).sum(axis=1, dtype=np.uint16))


class Counting:
    """The solutions of a chunk, fewer with every filter; joint vectors are looked at where there are any."""

    def __init__(self, arm: Arm, q: Array, valid: Mask) -> None:
        self.kept = valid
        self._arm, self._all = arm, q
        self._q: Array | None = None
        self._turning = ~arm.chain.prismatic

    @property
    def vectors(self) -> Array:
        """(k, n) the remaining solutions, pose by pose."""
        if self._q is None:
            self._q = self._all[self.kept]
        return self._q

    def counts(self) -> NDArray[Any]:
        """(m,) number of solutions left of each pose."""
        if self.kept.shape[1] == _WORD:
            return np.asarray(np.bitwise_count(self.kept.view(np.uint64))[:, 0])
        return np.asarray(np.sum(self.kept, axis=-1, dtype=np.intp))

    def keep_within_limits(self) -> None:
        """Drop solutions without an image inside the limits."""
        inside = joint_limits.has_image(self._all, self.kept, self._arm.limits, self._turning)
        self.kept, self._q = inside, None

    def keep_free(self, world: World | None, margin: float = 0.0) -> None:
        """Drop solutions in which links come within ``margin`` [m] of each other, or of the obstacles of a world."""
        model = self._arm.cell.collisions.in_world(world)
        kept = self.kept.copy()
        kept[self.kept] = ~np.asarray(model.in_collision(self.vectors, margin), dtype=np.bool_)
        self.kept, self._q = kept, None

    def clearance(self, world: World | None) -> Array:
        """(k,) m, of the remaining solutions: see ``arm.clearance``."""
        return np.asarray(self._arm.clearance(self.vectors, world), dtype=np.float64)

    def manipulability(self) -> Array:
        """(k,) of the remaining solutions; for positions that of the tip's translation."""
        return self._arm.manipulability(self.vectors, self._arm.solver.control.part)

    def margin(self) -> Array:
        """(k,) least distance to a limit as a share of half the joint's range; negative outside, 1 without limits."""
        image = joint_limits.nearest_image(self.vectors, self._arm.limits, self._turning)[0]
        return joint_limits.margin(np.where(np.isnan(image), self.vectors, image), self._arm.limits)

    def greatest(self, values: Array) -> Array:
        """(m,) greatest of the values (k,) of each pose's solutions, NaN for a pose without one."""
        spread = np.full(self.kept.shape, -np.inf)
        spread[self.kept] = values
        best = spread.max(axis=-1)
        return np.where(np.isneginf(best), np.nan, best)
