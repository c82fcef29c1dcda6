"""Lower bounds on distances, many joint vectors at a time, from balls about the shapes and boxes about the obstacles.

Coal checks only the pairs that the bounds do not decide. Pairs of two links are few, and each gets a bound. Pairs of a
link and an obstacle are never listed one by one: the index of the obstacles returns the near ones.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from urdf_ik.cell.bodies import Bodies, Placed
from urdf_ik.cell.obstacles.index import ObstacleIndex
from urdf_ik.typing import Array

Indices = NDArray[np.intp]

QUERY_ERROR = 1e-5
"""Bound on the error of coal's distances [m]: its iterations stop at 1e-6."""

CHUNK = 128
"""Joint vectors per block of bounds: few enough for the processor's cache."""

CROWDED = 4096
"""A row with at least so many nodes in one level of the obstacles' tree is crowded.

A crowded piece of a motion is halved before its obstacles are listed; a crowded joint vector is checked alone."""


class Open(NamedTuple):
    """Pairs of a link's shape and an obstacle's piece that the bounds do not decide.

    Attributes:
        row: (e,) index of the joint vector.
        pair: (e,) number of the pair.
        closer: (e,) greatest distance by which the pair comes closer [m]; zero without motion.
        crowded: (k,) bool: rows whose open pairs are too many to be listed.
    """

    row: Indices
    pair: Indices
    closer: Array
    crowded: NDArray[np.bool_]


class DistanceBounds:
    """Pairs that must not touch, by number, and lower bounds on their distances.

    Pairs of two links are numbered first, from 0 to ``among_links - 1``; the pair of shape i and the piece in slot s of
    the index has the number ``among_links + i * index.count + s``.

    Attributes:
        among_links: number of pairs of two links.
    """

    def __init__(
        self,
        bodies: Bodies,
        links: Sequence[tuple[int, int]],
        index: ObstacleIndex,
        moving: Sequence[int],
        excepted: Collection[tuple[int, int]] = (),
        added: Collection[tuple[int, int]] = (),
    ) -> None:
        """Choose the pairs.

        Args:
            bodies: how the arm's shapes move.
            links: pairs of shapes of two links.
            index: the obstacles.
            moving: shapes that must not touch any obstacle.
            excepted: (shape, slot) of pairs that may touch all the same.
            added: (shape, slot) of further pairs that must not touch.
        """
        self._bodies, self._index = bodies, index
        pairs = np.array(links, dtype=np.intp).reshape(-1, 2)
        self._first, self._second = pairs[:, 0], pairs[:, 1]
        self.among_links = len(pairs)
        self._moving = np.array(moving, dtype=np.intp)
        self._excepted = np.array(sorted(self.number(*each) for each in excepted), dtype=np.intp)
        self._added = np.array(sorted(self.number(*each) for each in added), dtype=np.intp)
        ones, others = bodies.path[self._first], bodies.path[self._second]
        # Joints (A, J) that move a pair's first shape against its second, and its second against its first.
        self._moves_first = (ones & ~others).astype(np.float64)
        self._moves_second = (others & ~ones).astype(np.float64)

    @property
    def has_obstacles(self) -> bool:
        """Whether a link is checked against an obstacle."""
        return bool(self._index.count and (len(self._moving) or len(self._added)))

    def number(self, shape: int, slot: int) -> int:
        """Number of the pair of a shape and the piece in a slot."""
        return self.among_links + shape * self._index.count + slot

    def split(self, pairs: Indices) -> tuple[Indices, Indices]:
        """Shapes (e,) and slots (e,) of pairs (e,) with obstacles."""
        shape, slot = np.divmod(pairs - self.among_links, max(self._index.count, 1))
        return shape, slot

    def chunks(self, q: Array) -> Iterator[tuple[slice, Placed]]:
        """The joint vectors (k, n) a chunk at a time, with the bodies placed."""
        for start in range(0, len(q), CHUNK):
            part = slice(start, start + CHUNK)
            yield part, self._bodies.place(q[part])

    def reaches(self, placed: Placed, travel: Array) -> Array:
        """(k, S, m, J) m; see :meth:`Bodies.reaches`."""
        return self._bodies.reaches(placed, travel)

    def near_in_rows(self, placed: Placed, margin: float) -> Iterator[tuple[int, list[int]]]:
        """Each row in which pairs may be apart by no more than a margin [m], with these pairs."""
        links, k = self.links_near(placed, margin), len(placed.centres)
        row = pair = np.zeros(0, dtype=np.intp)
        crowded = np.zeros(k, dtype=np.bool_)
        extra = np.full(placed.centres.shape[:2], margin)
        if self.has_obstacles:
            row, pair, crowded = self.near(placed.centres, extra, np.full(k, CROWDED))
        if len(row):
            close = self.gaps(placed, row, pair).min(axis=1) <= margin
            row, pair = row[close], pair[close]
        ends = np.searchsorted(row, np.arange(k + 1)).tolist()
        for i in np.flatnonzero(links.any(axis=1) | (np.diff(ends) > 0) | crowded).tolist():
            own = pair[ends[i] : ends[i + 1]]
            if crowded[i]:  # one row at a time, for the memory's sake
                _, own, _ = self.near(placed.centres[i : i + 1], extra[i : i + 1])
            yield i, [*np.flatnonzero(links[i]).tolist(), *own.tolist()]

    # ------------------------------------------------------------ pairs of two links

    def links_least(self, placed: Placed) -> Array:
        """(k, A) m that the links are apart at least, by one ball about each shape; may be negative."""
        points, radii = placed.centres, self._bodies.ball_radii
        between = points[:, self._first] - points[:, self._second]
        out: Array = _length(between) - (radii[self._first] + radii[self._second])
        return out

    def links_gaps(self, placed: Placed, rows: Indices, pairs: Indices) -> Array:
        """(e, m, m) m that the balls of the one shape are apart at least from those of the other: of pairs in rows."""
        first, second, radii = self._first[pairs], self._second[pairs], self._bodies.radii
        ones, others = self._bodies.balls(placed, rows, first), self._bodies.balls(placed, rows, second)
        out: Array = _length(ones[:, :, None] - others[:, None]) - (radii[first, :, None] + radii[second, None])
        return out

    def links_closest(self, placed: Placed) -> Array:
        """(k, A) m that the links are apart at least, by all balls."""
        shape = len(placed.poses), self.among_links
        rows, pairs = (index.reshape(-1) for index in np.indices(shape))
        return np.asarray(self.links_gaps(placed, rows, pairs).min(axis=(1, 2)).reshape(shape))

    def links_near(self, placed: Placed, margin: float) -> NDArray[np.bool_]:
        """(k, A) which links may be apart by no more than a margin [m]."""
        out: NDArray[np.bool_] = self.links_least(placed) <= margin
        rows, pairs = np.nonzero(out)
        out[rows, pairs] = self.links_gaps(placed, rows, pairs).min(axis=(1, 2)) <= margin
        return out

    def links_in_reach(
        self, placed: Placed, reaches: Array, margin: float, asked: NDArray[np.bool_]
    ) -> tuple[NDArray[np.bool_], Array]:
        """Which links may come within a margin on a motion through the poses ``placed``, and how much closer at most.

        Where two balls stay apart by more than the margin, what they hold does. The bound of a pair is that of the
        balls for which this is open: a long link is fast where it is far from its axis, and often near to others
        where it is slow.

        Args:
            placed: the bodies in the middle of k motions.
            reaches: (k, S, m, J) m; see :meth:`Bodies.reaches`.
            margin: m.
            asked: (k, A) pairs to look at.

        Returns:
            (k, A) which pairs; (k, A) m, by which the parts of them that are in question come closer at most.
        """
        most = reaches.max(axis=2)
        closer: Array = np.einsum("kpj,pj->kp", most[:, self._first], self._moves_first)
        closer += np.einsum("kpj,pj->kp", most[:, self._second], self._moves_second)
        out: NDArray[np.bool_] = (self.links_least(placed) <= margin + closer) & asked
        rows, pairs = np.nonzero(out)
        ones = reaches[rows, self._first[pairs]] @ self._moves_first[pairs][..., None]
        others = reaches[rows, self._second[pairs]] @ self._moves_second[pairs][..., None]
        both = ones + others.swapaxes(1, 2)
        in_question = self.links_gaps(placed, rows, pairs) <= margin + both
        closer[rows, pairs] = np.where(in_question, both, 0.0).max(axis=(1, 2), initial=0.0)
        out[rows, pairs] = in_question.any(axis=(1, 2))
        return out, closer

    # ------------------------------------------------------------ pairs of a link and an obstacle

    def near(
        self, centres: Array, extra: Array, most: Indices | None = None
    ) -> tuple[Indices, Indices, NDArray[np.bool_]]:
        """Pairs with obstacles whose distance, by one ball about each shape, may be ``extra`` or less.

        Args:
            centres: (k, S, 3) m of the balls.
            extra: (k, S) m, of any sign; infinite: all pairs.
            most: (k,) as in :meth:`ObstacleIndex.near`.

        Returns:
            Rows (e,) and pairs (e,), by rows and numbers, and the crowded rows (k,), whose pairs are left out.
        """
        k, moving = len(centres), self._moving
        crowded = np.zeros(k, dtype=np.bool_)
        row = pair = np.zeros(0, dtype=np.intp)
        if len(moving) and self._index.count:
            of_row = np.repeat(np.arange(k), len(moving))
            radii = np.maximum(self._bodies.ball_radii[moving] + extra[:, moving], 0.0).reshape(-1)
            found = self._index.near(centres[:, moving].reshape(-1, 3), radii, of_row, most)
            if most is not None:
                crowded = found.crowded
            at, shape = np.divmod(found.point, len(moving))
            row, pair = at, self.among_links + moving[shape] * self._index.count + found.box
            kept = ~crowded[row]
            if len(self._excepted):
                kept &= ~np.isin(pair, self._excepted)
            row, pair = row[kept], pair[kept]
        if len(self._added):
            row = np.concatenate([row, np.repeat(np.arange(k), len(self._added))])
            pair = np.concatenate([pair, np.tile(self._added, k)])
        close = self.least(centres, row, pair) <= extra[row, self.split(pair)[0]]
        row, pair = row[close], pair[close]
        order = np.lexsort((pair, row))
        return row[order], pair[order], crowded

    def every(self, k: int) -> tuple[Indices, Indices]:
        """Rows and pairs with obstacles in k rows, all that are checked; of an index that has no tree."""
        first = self.among_links + self._moving * self._index.count
        pair = (first[:, None] + np.arange(self._index.count)).reshape(-1)
        if len(self._excepted):
            pair = pair[~np.isin(pair, self._excepted)]
        pair = np.concatenate([pair, self._added])
        return np.repeat(np.arange(k), len(pair)), np.tile(pair, k)

    def nearby(self, centres: Array) -> tuple[Indices, Indices]:
        """Rows and pairs with obstacles, a few of each row, that are likely to be its nearest."""
        k, moving = len(centres), self._moving
        row = pair = np.zeros(0, dtype=np.intp)
        if len(moving) and self._index.count:
            point, slot = self._index.nearby(centres[:, moving].reshape(-1, 3))
            row, shape = np.divmod(point, len(moving))
            pair = self.among_links + moving[shape] * self._index.count + slot
            if len(self._excepted):
                kept = ~np.isin(pair, self._excepted)
                row, pair = row[kept], pair[kept]
        rows = np.concatenate([row, np.repeat(np.arange(k), len(self._added))])
        return rows, np.concatenate([pair, np.tile(self._added, k)])

    def least(self, centres: Array, rows: Indices, pairs: Indices) -> Array:
        """(e,) m that pairs with obstacles are apart at least, by one ball about each shape."""
        shapes, slots = self.split(pairs)
        gaps = self._from_obstacles(centres[rows, shapes][:, None], slots)[:, 0]
        return np.asarray(gaps - self._bodies.ball_radii[shapes])

    def gaps(self, placed: Placed, rows: Indices, pairs: Indices) -> Array:
        """(e, m) m that the balls of the shapes are apart at least from the obstacles: of pairs in rows."""
        shapes, slots = self.split(pairs)
        gaps = self._from_obstacles(self._bodies.balls(placed, rows, shapes), slots)
        return np.asarray(gaps - self._bodies.radii[shapes])

    def in_reach(
        self,
        placed: Placed,
        reaches: Array,
        margin: float,
        given: tuple[Indices, Indices],
        listed: NDArray[np.bool_],
        may_be_crowded: float,
    ) -> Open:
        """Obstacles that links may come to within a margin on a motion; see :meth:`links_in_reach`.

        Args:
            placed: the bodies in the middle of k motions.
            reaches: (k, S, m, J) m.
            margin: m.
            given: rows and pairs to look at, in rows that are listed.
            listed: (k,) bool: of the other rows all pairs are looked at.
            may_be_crowded: m; rows that may come closer by more may be left crowded.
        """
        if not self.has_obstacles:
            none = np.zeros(0, dtype=np.intp)
            return Open(none, none, np.zeros(0), np.zeros(len(listed), dtype=np.bool_))
        both = reaches.sum(axis=3)  # (k, S, m): obstacles stand still, and only joints before the shape count
        most = both.max(axis=2)
        rows, pairs = given
        shapes, _ = self.split(pairs)
        kept = self.least(placed.centres, rows, pairs) <= margin + most[rows, shapes]
        rows, pairs = rows[kept], pairs[kept]
        crowded = np.zeros(len(listed), dtype=np.bool_)
        if not listed.all():
            others = np.flatnonzero(~listed)
            limit = np.where(most[others].max(axis=1) > may_be_crowded, CROWDED, np.iinfo(np.intp).max)
            row, pair, full = self.near(placed.centres[others], margin + most[others], limit)
            crowded[others] = full
            rows, pairs = np.concatenate([rows, others[row]]), np.concatenate([pairs, pair])
        closer = both[rows, self.split(pairs)[0]]
        in_question = self.gaps(placed, rows, pairs) <= margin + closer
        still = in_question.any(axis=1)
        closer = np.where(in_question, closer, 0.0).max(axis=1, initial=0.0)
        return Open(rows[still], pairs[still], closer[still], crowded)

    def _from_obstacles(self, points: Array, slots: Indices) -> Array:
        """(e, m) m from points (e, m, 3) in the base link to the pieces in slots (e,), not above zero inside."""
        holds = self._index.holds(slots)
        local = points @ holds["rotation"] - holds["origin"][:, None]
        below = holds["low"][:, None] - local
        np.maximum(below, local - holds["high"][:, None], out=below)
        np.maximum(below, 0.0, out=below)
        out = _length(below)
        for standing, own, field in self._index.clouds:
            ours = np.flatnonzero((slots >= own.start) & (slots < own.stop))
            local = (points[ours] - standing.pose[:3, 3]) @ standing.pose[:3, :3]
            out[ours] = np.maximum(out[ours], field.least(local))
        return np.asarray(out - holds["radius"][:, None])


def _length(vectors: Array) -> Array:
    """Euclidean length of vectors (..., 3), component by component."""
    square = vectors[..., 0] * vectors[..., 0]
    square += vectors[..., 1] * vectors[..., 1]
    square += vectors[..., 2] * vectors[..., 2]
    return np.asarray(np.sqrt(square))
