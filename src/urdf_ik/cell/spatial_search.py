"""Search in space: which axis-aligned boxes are near points, and how far a cloud of points is at least.

Coal has trees of boxes (its broad-phase managers), but from Python one cannot choose which pairs they check: their
callbacks cannot be derived from, and the built-in ones know neither allowed pairs nor a margin for each pair. Here the
tree only proposes pairs, and coal's narrow phase decides about each of them.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from urdf_ik.typing import Array

Indices = NDArray[np.intp]

FANOUT = 16
"""Children of a node: wide nodes make the tree shallow, and a level costs a few NumPy calls however wide it is."""

CELLS = 2**20
"""Cells along the longest side in which boxes are sorted by their centres: neighbours get into the same node."""

SLACK = 1e-9
"""Relative and absolute (m) slack of a box's distance, far above its rounding errors: no box is missed."""


class Found(NamedTuple):
    """Boxes near points.

    Attributes:
        point: (e,) index of a point.
        box: (e,) index of a box near it.
        crowded: (r,) bool: rows of points that have so many boxes near them that they were given up.
    """

    point: Indices
    box: Indices
    crowded: NDArray[np.bool_]


class BoxTree:
    """Axis-aligned boxes, sorted into a tree of ``FANOUT`` children a node. It does not change.

    Attributes:
        size: number of boxes.
    """

    def __init__(self, low: Array, high: Array) -> None:
        """Sort the boxes into a tree, in time n log n.

        Args:
            low: (n, 3) m, finite; n is at least 1.
            high: (n, 3) m, finite.
        """
        self.size = len(low)
        self._order = np.argsort(cell_codes(0.5 * (low + high)), kind="stable")
        self._levels: list[tuple[Array, Array]] = []  # from the leaves up, each (nodes, 3, FANOUT)
        low, high = low[self._order], high[self._order]
        while True:
            nodes = -(-len(low) // FANOUT)
            missing = nodes * FANOUT - len(low)
            # Boxes that fill up the last node lie at an infinite distance.
            low = np.concatenate([low, np.full((missing, 3), np.inf)]).reshape(nodes, FANOUT, 3)
            high = np.concatenate([high, np.full((missing, 3), -np.inf)]).reshape(nodes, FANOUT, 3)
            self._levels.append(
                (np.ascontiguousarray(low.transpose(0, 2, 1)), np.ascontiguousarray(high.transpose(0, 2, 1)))
            )
            low, high = low.min(axis=1), high.max(axis=1)
            if nodes == 1:
                return

    def within(self, points: Array, radii: Array, row: Indices, most: NDArray[np.intp] | None) -> Found:
        """The boxes that points are near.

        Args:
            points: (p, 3) m.
            radii: (p,) m, not negative, how near; infinite: every box.
            row: (p,) row that each point is part of, counted from zero on.
            most: (r,) nodes of a level up to which a row is looked at; a row that needs more is given up as crowded.
                None: no row is given up.
        """
        crowded = np.zeros(0 if most is None else len(most), dtype=np.bool_)
        near = radii + SLACK * (1.0 + radii + np.abs(points).max(axis=1, initial=0.0))
        square, everywhere = near * near, bool(np.isinf(near).any())
        point, node = np.arange(len(points)), np.zeros(len(points), dtype=np.intp)
        below = [self.size, *(len(low) for low, _ in self._levels)]
        for level in reversed(range(len(self._levels))):
            low, high = self._levels[level]
            hit, child = np.nonzero(_squared_gaps(points[point], low[node], high[node]) <= square[point, None])
            point, node = point[hit], node[hit] * FANOUT + child
            if everywhere:
                point, node = point[node < below[level]], node[node < below[level]]
            if most is not None:
                crowded |= np.bincount(row[point], minlength=len(most)) > most
                if crowded.any():
                    kept = ~crowded[row[point]]
                    point, node = point[kept], node[kept]
        return Found(point, self._order[node], crowded)

    def nearby(self, points: Array, present: NDArray[np.bool_]) -> Indices:
        """(p,) a ``present`` (n,) box near each point (p, 3), mostly the nearest; -1 where none was found."""
        node = np.zeros(len(points), dtype=np.intp)
        rows = np.arange(len(points))
        for low, high in reversed(self._levels[1:]):
            gaps = _squared_gaps(points, low[node], high[node])
            node = node * FANOUT + gaps.argmin(axis=1)
        gaps = _squared_gaps(points, self._levels[0][0][node], self._levels[0][1][node])
        boxes = self._order[np.minimum(node[:, None] * FANOUT + np.arange(FANOUT), self.size - 1)]
        gaps[~present[boxes]] = np.inf
        best = gaps.argmin(axis=1)
        return np.where(np.isfinite(gaps[rows, best]), boxes[rows, best], -1)


def _squared_gaps(points: Array, low: Array, high: Array) -> Array:
    """(p, FANOUT) m^2 from points (p, 3) to the boxes low, high (p, 3, FANOUT), zero inside."""
    at = points[:, :, None]
    gaps = low - at
    np.maximum(gaps, at - high, out=gaps)
    np.maximum(gaps, 0.0, out=gaps)
    gaps *= gaps
    return np.asarray(gaps.sum(axis=1))


def cell_codes(centres: Array) -> NDArray[np.uint64]:
    """(n,) Morton codes of points (n, 3): the bits of the three cell numbers, interleaved."""
    least = centres.min(axis=0)
    side = float((centres.max(axis=0) - least).max()) or 1.0
    cells = ((centres - least) * ((CELLS - 1) / side)).astype(np.uint64)
    code = np.zeros(len(centres), dtype=np.uint64)
    for axis in range(3):
        bits = cells[:, axis]
        # Two zero bits are put in front of every bit, by halves (20 bits become 60).
        for shift, mask in (
            (32, 0x1F00000000FFFF),
            (16, 0x1F0000FF0000FF),
            (8, 0x100F00F00F00F00F),
            (4, 0x10C30C30C30C30C3),
            (2, 0x1249249249249249),
        ):
            bits = (bits | (bits << np.uint64(shift))) & np.uint64(mask)
        code |= bits << np.uint64(axis)
    return code


FIELD_CELLS = 2**20
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
        self._side = max(float(np.prod(np.maximum(size, 1e-3 * size.max())) / FIELD_CELLS) ** (1.0 / 3.0), 1e-9)
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
