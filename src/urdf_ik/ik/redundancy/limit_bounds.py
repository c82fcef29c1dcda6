"""Joint limits of turning joints, for intervals in closed form."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from urdf_ik.support.angles import TURN, wrapped
from urdf_ik.typing import Array


class Bounds:
    """Limits (n, 2) [rad], which joints they matter for, middles and half widths; any image of an angle counts."""

    def __init__(self, limits: Array) -> None:
        self.limits = limits
        self.matter = np.isfinite(limits).all(axis=1) & (limits[:, 1] - limits[:, 0] < TURN)
        low, high = np.where(self.matter, limits.T, 0.0)
        self.middle, self.half = 0.5 * (low + high), np.where(self.matter, 0.5 * (high - low), np.inf)

    def inside(self, j: int | slice, q: Array) -> NDArray[np.bool_]:
        """Whether angles (...) of joint ``j``, or (..., k) of joints, are inside their limits."""
        return np.asarray(np.abs(wrapped(q - self.middle[j])) <= self.half[j])
