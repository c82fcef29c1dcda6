"""Straight motions in joint space, proven free of contact from end to end.

Conservative advancement: on the way from the middle of a piece of the motion to either end, the distance of two shapes
shrinks by at most the sum, over the joints between them, of how far each joint can carry their points
(:mod:`.distance_bounds`). A pair that is farther apart than this sum at the middle is free over the whole piece;
otherwise the piece is halved. Nothing is sampled: even the thinnest wall between two joint vectors is found.
"""

from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from urdf_ik.cell.distance_bounds import QUERY_ERROR, Open
from urdf_ik.errors import ArgumentError
from urdf_ik.typing import Array

if TYPE_CHECKING:  # coal and Pinocchio are imported where a motion is checked
    from urdf_ik.cell.coal_check import CoalCheck

Pair = tuple[str, str]

TOUCH = 1e-4
"""Clearance beyond the margin [m] below which two shapes count as in contact. No finite number of distances can prove a
motion free if two shapes slide on each other; a motion on which all stay farther apart than this is proven free."""

LONGEST = 1e4
"""Longest way of a joint in one motion [rad or m], some 1600 turns: the number of pieces grows with the way."""

STRIDE = 0.02
"""A piece on which a pair may come closer by more than this [m] is halved without a coal query: bounds are cheap, and a
query with so wide a margin visits most of a mesh."""


@dataclass(frozen=True, eq=False)
class Motions:
    """One straight motion in joint space or a batch of them, and whether they are free.

    A single motion is true if it is free: ``if arm.motion_is_free(q0, q1): ...``.

    Attributes:
        free: (...) bool: every pair provably stays apart by more than the margin, from end to end.
        share: (...) share of the motion at the first contact, NaN if it is free. The motion is proven free up to
            there; at the contact the distance is at most the margin plus two ``TOUCH``.
        pairs: for each motion the pair of the first contact, two links or a link and an obstacle; None if the motion
            is free.

    Example:
        >>> import urdf_ik
        >>> arm, q0 = urdf_ik.load("scara_rrpr"), [0.0, 0.0, 0.1, 0.0]
        >>> motions = arm.motion_is_free(q0, [[0.5, 0.5, 0.1, 0.0], [1.0, 0.5, 0.1, 0.0]])
        >>> motions.free.tolist(), motions.pairs
        ([True, True], [None, None])
    """

    free: NDArray[np.bool_]
    share: Array
    pairs: list[Pair | None]

    @property
    def pair(self) -> Pair | None:
        """The pair of the first contact of a single motion, None if it is free."""
        if self.free.ndim:
            raise ArgumentError(f"{self.free.size} motions have a pair each: see pairs")
        return self.pairs[0]

    def spread(self, places: NDArray[np.bool_]) -> "Motions":
        """These motions at ``places`` (k,), and between them motions that are not free."""
        free, share = np.zeros(len(places), dtype=np.bool_), np.full(len(places), np.nan)
        free[places], share[places] = self.free, self.share
        remaining = iter(self.pairs)
        return Motions(free, share, [next(remaining) if there else None for there in places])

    def __bool__(self) -> bool:
        if self.free.ndim:
            raise ArgumentError(f"{self.free.size} motions have no single truth value: use free.all() or free.any()")
        return bool(self.free)

    def __repr__(self) -> str:
        if self.free.ndim:
            return f"<Motions: {int(self.free.sum())} of {self.free.size} free>"
        return "<Motions: free>" if self.free else f"<Motions: {' and '.join(self.pairs[0] or ())} at {self.share:.4f}>"


class _Pieces(NamedTuple):
    """Pieces of motions, with the pairs that are not yet proven free on them.

    Attributes:
        motion: (m,) index of the motion.
        start: (m,) share of the motion at which the piece begins.
        end: (m,) share at which it ends.
        links: (m, A) pairs of two links that are open.
        listed: (m,) whether its open pairs with obstacles are listed; if not, all of them are open.
        piece: (e,) piece of each listed pair.
        pair: (e,) the listed pairs.
    """

    motion: NDArray[np.intp]
    start: Array
    end: Array
    links: NDArray[np.bool_]
    listed: NDArray[np.bool_]
    piece: NDArray[np.intp]
    pair: NDArray[np.intp]

    def some(self, which: NDArray[np.bool_]) -> "_Pieces":
        """The pieces ``which`` (m,)."""
        number = np.cumsum(which) - 1
        kept = which[self.piece]
        of_pieces = [each[which] for each in self[:5]]
        return _Pieces._make([*of_pieces, number[self.piece[kept]], self.pair[kept]])


def motions(check: "CoalCheck", q0: Array, q1: Array, margin: float) -> Motions:
    """Which of the motions from q0 (k, n) to q1 (k, n) are free; see :class:`Motions`."""
    k = len(q0)
    first, pair = np.full(k, np.inf), np.full(k, -1, dtype=np.intp)
    none = np.zeros(0, dtype=np.intp)
    links = np.ones((k, check.bounds.among_links), dtype=np.bool_)
    listed = np.full(k, not check.bounds.has_obstacles)
    pieces = _Pieces(np.arange(k), np.zeros(k), np.ones(k), links, listed, none, none)
    while len(pieces.motion):
        pieces = _halved(check, q0, q1, margin, pieces, first, pair)
    free = np.isinf(first)
    names: list[Pair | None] = [None if at < 0 else check.names(at) for at in pair.tolist()]
    return Motions(free, np.where(free, np.nan, first), names)


def _halved(
    check: "CoalCheck", q0: Array, q1: Array, margin: float, pieces: _Pieces, first: Array, pair: NDArray[np.intp]
) -> _Pieces:
    """Check the middle of each piece; return the halves left to prove, write contacts to ``first`` and ``pair``."""
    pieces = pieces.some(pieces.start < first[pieces.motion])
    motion, start, end = pieces.motion, pieces.start, pieces.end
    middle, half = 0.5 * (start + end), 0.5 * (end - start)
    way = q1[motion] - q0[motion]
    q = q0[motion] + middle[:, None] * way
    travel = half[:, None] * np.abs(way)
    rest = np.zeros(len(motion), dtype=np.bool_)
    open_pairs = [(pieces.piece[:0], pieces.pair[:0])]
    for part, placed in check.bounds.chunks(q):
        reaches = check.arm.bodies.reaches(placed, travel[part])
        links, links_closer = check.bounds.links_in_reach(placed, reaches, margin, pieces.links[part])
        mine = slice(*np.searchsorted(pieces.piece, [part.start, part.start + len(links)]))
        listed_pairs = pieces.piece[mine] - part.start, pieces.pair[mine]
        world = check.bounds.in_reach(placed, reaches, margin, listed_pairs, pieces.listed[part])
        farthest = np.where(links, links_closer, 0.0).max(axis=1, initial=0.0)
        np.maximum.at(farthest, world.row, world.closer)
        rest[part] = links.any(axis=1)
        rest[part.start + world.row] = True
        still = np.ones(len(world.row), dtype=np.bool_)
        checked = rest[part] & (farthest <= STRIDE)
        order = np.argsort(world.row, kind="stable")
        ends = np.searchsorted(world.row[order], np.arange(len(links) + 1)).tolist()
        for row in np.flatnonzero(checked).tolist():
            i = part.start + row
            if middle[i] >= first[motion[i]]:
                continue
            own = order[ends[row] : ends[row + 1]]
            contact = _contact(check, q[i], margin, links[row], links_closer[row], world, own, still)
            if contact is not None:
                # If the pair can come closer by at most TOUCH, the first half of the piece need not be searched.
                pair[motion[i]], closer = contact
                first[motion[i]] = start[i] if closer <= TOUCH else middle[i]
        pieces.links[part] = links
        rest[part] = links.any(axis=1)
        rest[part.start + world.row[still]] = True
        # After the first coal query the open pairs are listed, so that pairs proven free stay closed.
        pieces.listed[part] |= checked
        kept = still & pieces.listed[part][world.row]
        open_pairs.append((part.start + world.row[kept], world.pair[kept]))
    piece, open_pair = (np.concatenate(parts) for parts in zip(*open_pairs, strict=True))
    order = np.lexsort((open_pair, piece))
    pieces = pieces._replace(piece=piece[order], pair=open_pair[order])
    left = pieces._replace(end=middle).some(rest & (start < first[motion]))
    right = pieces._replace(start=middle).some(rest & (middle < first[motion]))
    right = right._replace(piece=right.piece + len(left.motion))
    return _Pieces._make(np.concatenate(parts) for parts in zip(left, right, strict=True))


def _contact(
    check: "CoalCheck",
    q: Array,
    margin: float,
    links: NDArray[np.bool_],
    links_closer: Array,
    world: Open,
    own: NDArray[np.intp],
    still: NDArray[np.bool_],
) -> tuple[int, float] | None:
    """Check the open pairs with coal at the middle q (n,) of a piece, and close those that are proven free.

    The pair in contact, and the distance by which it can come closer on the piece [m]; None without one.
    """
    placing = check.arm.place(q)
    candidates = [(pair, pair, links, float(links_closer[pair])) for pair in np.flatnonzero(links).tolist()]
    ranked = own[np.argsort(world.pair[own])].tolist()
    candidates += [(int(world.pair[k]), k, still, float(world.closer[k])) for k in ranked]
    for pair, k, is_open, closer in candidates:
        if not check.touches(placing, pair, margin + closer + QUERY_ERROR):
            is_open[k] = False
        elif check.touches(placing, pair, margin + TOUCH):
            return pair, closer
    return None
