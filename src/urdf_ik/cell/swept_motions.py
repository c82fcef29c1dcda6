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

from urdf_ik.cell.coal_scene import QUERY_ERROR
from urdf_ik.errors import ArgumentError, printable
from urdf_ik.support import inputs

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from urdf_ik.cell.coal_scene import Scene

    Array = NDArray[np.float64]
    Pair = tuple[str, str]

TOUCH = 1e-4
"""Clearance beyond the margin [m] below which two shapes count as in contact: no finite number of distances proves a
motion free along which they slide on each other. A motion along which everything stays farther apart is found free."""

LONGEST = 1e4
"""How far a joint may go in one motion [rad or m], some 1600 turns: the pieces to be proven grow with the way."""

STRIDE = 0.02
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
        """The pair of the first contact of a single motion, None where it is free."""
        if self.free.ndim:
            raise ArgumentError(f"{self.free.size} motions have a pair each: see pairs")
        return self.pairs[0]

    def __bool__(self) -> bool:
        if self.free.ndim:
            raise ArgumentError(f"{self.free.size} motions have no single truth value: use free.all() or free.any()")
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


def check_margin(margin: float) -> float:
    """``margin`` as a float; refuses one that is no length.

    Raises:
        ArgumentError: it is negative or not finite.
    """
    return inputs.number(margin, "margin", low=0.0, unit="m")


def check_length(q0: Array, q1: Array, names: Sequence[str]) -> None:
    """Refuse motions from q0 (k, n) to q1 (k, n) on which a joint goes farther than ``LONGEST``.

    Raises:
        ArgumentError: one does.
    """
    if (bad := inputs.first_bad(q1 - q0, LONGEST)) is not None:
        motion, joint = bad
        raise ArgumentError(
            f"motion {motion}: joint {printable(names[joint])} goes from {q0[bad]:g} to {q1[bad]:g}; a motion of at "
            f"most {LONGEST:g} rad or m is needed, a longer one in several"
        )


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
    for part, placed in scene.chunks(q):
        still[part], closer = scene.within_reach(placed, travel[part], margin, still[part])
        for i, row in enumerate(closer, part.start):
            if not still[i].any() or row[still[i]].max() > STRIDE or middle[i] >= first[motion[i]]:
                continue
            contact = _contact(scene, q[i], row, still[i], margin)
            if contact is not None:
                # Where the whole half piece lies within TOUCH of the contact, there is nothing left to find.
                at_start = row[contact] <= TOUCH
                first[motion[i]], pair[motion[i]] = start[i] if at_start else middle[i], contact
    rest = still.any(axis=1)
    left, right = rest & (start < first[motion]), rest & (middle < first[motion])
    return _Pieces(
        np.concatenate([motion[left], motion[right]]),
        np.concatenate([start[left], middle[right]]),
        np.concatenate([middle[left], end[right]]),
        np.concatenate([still[left], still[right]]),
    )


def _contact(scene: Scene, q: Array, closer: Array, still: NDArray[np.bool_], margin: float) -> int | None:
    """Ask coal about the pairs ``still`` open at the middle q (n,) of a piece, and close those that are proven free.

    Returns:
        A pair in contact, if there is one.
    """
    shapes = scene.place(q)
    for k in np.flatnonzero(still).tolist():
        if not scene.touches(shapes, k, margin + closer[k] + QUERY_ERROR):
            still[k] = False
        elif scene.touches(shapes, k, margin + TOUCH):
            return k
    return None
