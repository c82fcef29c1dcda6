"""Straight motions in joint space, proven free of contact from end to end.

Conservative advancement: from the middle of a piece of the motion, no pair of shapes can come closer on the way to
either end than the sum over the joints between them of how far each can carry their points (:mod:`.bodies`). A pair
that is farther apart than that is free over the whole piece; else the piece is cut. Nothing is sampled: a wall between
two joint vectors is seen however thin it is.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from urdf_ik.errors import ArgumentError

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from urdf_ik.collision.scene import Scene

    Array = NDArray[np.float64]
    Pair = tuple[str, str]

TOUCH = 1e-4
"""Clearance beyond the margin [m] below which two shapes count as in contact: no finite number of distances proves a
motion free along which they slide on each other. A motion along which everything stays farther apart is found free."""

QUERY_ERROR = 1e-5
"""What a distance of coal may be too large by [m]: its iterations stop at 1e-6."""

STRIDE = 0.05
"""Pieces on which a pair may come closer by more than this [m] are cut without asking coal: bounds are cheap, and a
query with so wide a margin visits most of a mesh."""


@dataclass(frozen=True, eq=False)
class Motions:
    """Straight motions in joint space, one or a batch of them, and whether they are free.

    A single one is true where it is free: ``if arm.motion_is_free(q0, q1): ...``.

    Attributes:
        free: (...) bool: proven that everything stays apart by more than the margin, from end to end.
        share: (...) of the motion at the first contact, NaN where it is free. What comes before is proven free; at it
            the pair is apart by no more than the margin and two ``TOUCH``.
        pairs: of the first contact, two links or a link and an obstacle, None where the motion is free; a list in the
            order of the motions.
    """

    free: NDArray[np.bool_]
    share: Array
    pairs: list[Pair | None]

    @property
    def pair(self) -> Pair | None:
        """The pair of the first contact of a single motion, None where it is free."""
        if self.free.ndim:
            raise ArgumentError(f"{self.free.size} motions have a pair each: see pairs")
        return self.pairs[0]

    def __bool__(self) -> bool:
        if self.free.ndim:
            raise ArgumentError(f"{self.free.size} motions are not one truth: ask free.all() or free.any()")
        return bool(self.free)

    def __repr__(self) -> str:
        if self.free.ndim:
            return f"<Motions: {int(self.free.sum())} of {self.free.size} free>"
        return "<Motions: free>" if self.free else f"<Motions: {' and '.join(self.pairs[0] or ())} at {self.share:.4f}>"


class _Pieces(NamedTuple):
    """Pieces of motions.

    Attributes:
        motion: (m,) which motion.
        start: (m,) share of the motion at which the piece begins.
        end: (m,) share at which it ends.
        open: (m, P) pairs that are not yet proven free on it.
    """

    motion: NDArray[np.intp]
    start: Array
    end: Array
    open: NDArray[np.bool_]


def motions(scene: Scene, q0: Array, q1: Array, margin: float) -> Motions:
    """Which of the motions from q0 (k, n) to q1 (k, n) are free; see :class:`Motions`."""
    k, P = len(q0), len(scene.pairs)
    first, pair = np.full(k, np.inf), np.full(k, -1, dtype=np.intp)
    pieces = _Pieces(np.arange(k), np.zeros(k), np.ones(k), np.ones((k, P), dtype=np.bool_))
    while len(pieces.motion):
        pieces = _halved(scene, q0, q1, margin, pieces, first, pair)
    free = np.isinf(first)
    names: list[Pair | None] = [None if at < 0 else scene.pairs[at].names for at in pair]
    return Motions(free, np.where(free, np.nan, first), names)


def _halved(
    scene: Scene, q0: Array, q1: Array, margin: float, pieces: _Pieces, first: Array, pair: NDArray[np.intp]
) -> _Pieces:
    """What is left to prove after a look at the middle of each piece; contacts go into ``first`` and ``pair``."""
    before = pieces.start < first[pieces.motion]
    motion, start, end = pieces.motion[before], pieces.start[before], pieces.end[before]
    still = pieces.open[before]
    middle, half = 0.5 * (start + end), 0.5 * (end - start)
    way = q1[motion] - q0[motion]
    q = q0[motion] + middle[:, None] * way
    travel = half[:, None] * np.abs(way)
    clear = np.zeros(len(motion))  # share of the half piece about the middle that is proven free
    for part, placed in scene.chunks(q):
        closer = scene.approach(placed, travel[part])
        still[part] &= scene.least(placed) <= margin + closer
        for i, row in enumerate(closer, part.start):
            if not still[i].any():
                clear[i] = np.inf
            elif row[still[i]].max() <= STRIDE and middle[i] < first[motion[i]]:
                clear[i], contact = _look(scene, q[i], row, still[i], margin)
                if contact is not None:
                    # Where the whole half piece lies within TOUCH of the contact, there is nothing left to find.
                    at_start = row[contact] <= TOUCH
                    first[motion[i]], pair[motion[i]] = start[i] if at_start else middle[i], contact
    rest = clear < 1.0
    gap = np.maximum(clear, 0.0) * half
    left, right = rest & (start < first[motion]), rest & (middle < first[motion])
    return _Pieces(
        np.concatenate([motion[left], motion[right]]),
        np.concatenate([start[left], (middle + gap)[right]]),
        np.concatenate([(middle - gap)[left], end[right]]),
        np.concatenate([still[left], still[right]]),
    )


def _look(scene: Scene, q: Array, closer: Array, still: NDArray[np.bool_], margin: float) -> tuple[float, int | None]:
    """Ask coal about the pairs ``still`` open at the middle q (n,) of a piece; those proven free are closed.

    Returns:
        The share of the half piece that is free about the middle, infinite where all of it is, and a pair in contact.
    """
    shapes = scene.place(q)
    clear = np.inf
    for k in np.flatnonzero(still):
        near = float(closer[k])
        if not scene.touches(shapes, int(k), margin + near + QUERY_ERROR):
            still[k] = False
            continue
        apart = scene.distance(shapes, int(k)) - margin
        if apart <= TOUCH:
            return 0.0, int(k)
        if apart - QUERY_ERROR < near:
            clear = min(clear, (apart - QUERY_ERROR) / near)
        else:
            still[k] = False
    return clear, None
