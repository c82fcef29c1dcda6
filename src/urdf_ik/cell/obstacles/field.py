"""Lower bounds on the distance to a cloud of points, looked up in a grid: they decide most of what is away from it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from urdf_ik.typing import Array

CELLS = 2**20
"""Cells of a grid at most, with a few more for a cloud that is flat."""
_ROUNDING = 1e-6
"""Share of a distance that single precision may lose, and more."""


class DistanceField:
    """A grid about a cloud whose cells know how far the nearest point is at least from anywhere in them.

    A point outside the grid has its bound from the nearest cell: the cloud is in the grid's box, so the way to it
    does not become shorter by leaving the box.
    """

    def __init__(self, points: Array) -> None:
        """Make the grid of points (n, 3) m."""
        from scipy import ndimage  # slow to import, and only large clouds need it

        self._low = points.min(axis=0)
        size = points.max(axis=0) - self._low
        # Cells are cubes; a flat cloud has one layer of them.
        self._side = max(float(np.prod(np.maximum(size, 1e-3 * size.max())) / CELLS) ** (1.0 / 3.0), 1e-9)
        self._last = np.floor(size / self._side).astype(np.intp)
        empty = np.ones(tuple(self._last + 1), dtype=np.bool_)
        empty[tuple(self._cells(points).T)] = False
        # Between cells in a row by their middles; a point, and where it is asked from, may be half a diagonal off.
        apart = ndimage.distance_transform_edt(empty, sampling=self._side)
        bound = apart * (1.0 - _ROUNDING) - np.sqrt(3.0) * self._side
        self._bound = np.maximum(bound, 0.0).astype(np.float32).reshape(-1)
        self._stride = np.array([empty.shape[1] * empty.shape[2], empty.shape[2], 1])

    def least(self, points: Array) -> Array:
        """(...) m that the cloud is at least away from points (..., 3) in its frame."""
        return np.asarray(self._bound[self._cells(points) @ self._stride], dtype=np.float64)

    def _cells(self, points: Array) -> NDArray[np.intp]:
        """(..., 3) the cells of points (..., 3), the nearest one for those outside."""
        return np.asarray(np.clip((points - self._low) / self._side, 0, self._last), dtype=np.intp)
