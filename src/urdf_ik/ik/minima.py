"""All local minima of what joint vectors miss of targets: a search from evenly spread starts."""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from urdf_ik.ik.descent import Wanted, angle_missed, constrained, descended
from urdf_ik.support.angles import wrapped
from urdf_ik.typing import Array

STARTS = 48
"""Joint vectors from which each pose's minima are searched, spread evenly over the ranges of the joints."""
_SAME = 1e-5
"""rad, share of size: minima that differ by less in every joint are one."""
EXACT = 1e-11
"""Share of the size, rad: what is missed by no more is reached."""
_STAGES = ((30.0, 15), (300.0, 5))
"""Weights of the part that counts first beside the other, with Newton's rounds at each."""
_HARD = 1e4
"""Weight of the part that counts first, where it is not reached at once."""


_Keys = Callable[[Array, Array], tuple[Array, ...]]
"""What is missed of the place and of the angle, each (m,), to what minima are sorted by."""


def searched(
    wanted: Wanted, bounds: Array, first: str | None, place: float, turn: float, known: Array | None = None
) -> Array:
    """(m, B, n) minima for targets (m), the best first, padded with NaN; ``known`` (m, K, n): some of them, or NaN."""
    chain = wanted.chain
    m, n = len(wanted.place), chain.n
    starts = spread_inside(bounds, wanted.unit, STARTS)
    q = np.tile(starts, (m, 1))
    owner = np.repeat(np.arange(m), STARTS)
    known = np.empty((m, 0, n)) if known is None else known
    which, column = np.nonzero(~np.isnan(known[..., 0]))
    sure = known[which, column]
    if first is None:
        q = descended(wanted[owner], q, bounds, place, turn, 60)
        q, owner = distinct(wanted, *_joined(sure, which, q, owner))
        return ranked(wanted, q, owner, bounds, lambda off, angle: (np.hypot(place * off, turn * angle),))
    for weight, rounds in _STAGES:
        pair = (weight, 1.0) if first == "position" else (1.0, weight)
        q = descended(wanted[owner], q, bounds, *pair, rounds)
        q, owner = distinct(wanted, q, owner)
    q, owner = distinct(wanted, *_joined(sure, which, q, owner))
    part, hard = (0, (_HARD, 1.0)) if first == "position" else (1, (1.0, _HARD))
    exact, good = constrained(wanted[owner], q, bounds, first)
    q[good] = exact[good]
    minimal = good.copy()
    if not good.all():
        # Joints rest at their limits, the Jacobian is nearly singular there, or the first part is out of reach.
        rest = wanted[owner[~good]]
        near = descended(rest, q[~good], bounds, *hard, 12)
        again, settled = constrained(rest, near, bounds, first)
        onto = descended(rest, near, bounds, 1.0 - part, float(part), 40)
        onto = np.where((missed(rest, onto)[part] < EXACT)[:, None], onto, near)
        q[~good] = np.where(settled[:, None], again, onto)
        minimal[~good] = settled
    miss = missed(wanted[owner], q)
    off = miss[part] < EXACT
    reached = np.zeros(m, dtype=np.bool_)
    reached[owner[off]] = True
    # What Newton's method does not settle at is a minimum at a fold only where it misses least.
    least = np.full(m, np.inf)
    np.minimum.at(least, owner[off & minimal], miss[1 - part][off & minimal])
    keep = off & (minimal | (miss[1 - part] < least[owner])) | ~reached[owner]
    q, owner = q[keep], owner[keep]
    if not reached.all():
        lost = np.repeat(np.flatnonzero(~reached), STARTS)
        more = descended(wanted[lost], np.tile(starts, (len(lost) // STARTS, 1)), bounds, 1.0 - part, float(part), 40)
        more = descended(wanted[lost], more, bounds, *hard, 12)
        q, owner = _joined(q, owner, more, lost)
    q, owner = distinct(wanted, q, owner)
    return ranked(wanted, q, owner, bounds, lambda off, angle: (off, angle) if first == "position" else (angle, off))


def _joined(q: Array, owner: NDArray[np.intp], more: Array, whose: NDArray[np.intp]) -> tuple[Array, NDArray[np.intp]]:
    """Joint vectors of two kinds, target by target, the first kind first."""
    owner = np.concatenate([owner, whose])
    order = np.argsort(owner, kind="stable")
    return np.concatenate([q, more])[order], owner[order]


def distinct(wanted: Wanted, q: Array, owner: NDArray[np.intp]) -> tuple[Array, NDArray[np.intp]]:
    """Joint vectors with angles in (-pi, pi], of nearly equal ones of a target the first."""
    turning = wanted.chain.image_turns == 1.0  # a joint that others follow by halves is not there after a turn
    inside = (np.abs(q) <= np.pi) | ~turning
    seen = np.where(inside, q, wrapped(q))
    rounded = np.where(turning, (seen + np.pi) % (2 * np.pi), seen / wanted.unit)
    cells = np.concatenate([owner[:, None], np.round(rounded / 1e-3)], axis=1)
    _, first = np.unique(cells, axis=0, return_index=True)
    first = np.sort(first)
    q, owner, seen = q[first], owner[first], seen[first]
    # Neighbours across a cell's edge: each with the few of its own target.
    keep = np.ones(len(q), dtype=np.bool_)
    for shift in range(1, int(np.bincount(owner).max(initial=1))):
        same = owner[shift:] == owner[:-shift]
        gap = np.abs(seen[shift:] - seen[:-shift])
        gap = np.where(turning, np.minimum(gap, np.abs(2 * np.pi - gap)), gap / wanted.unit)
        keep[shift:] &= ~(same & (gap.max(axis=1) < _SAME * 100))
    return q[keep], owner[keep]


def ranked(wanted: Wanted, q: Array, owner: NDArray[np.intp], bounds: Array, keys: _Keys) -> Array:
    """(m, B, n): the joint vectors of each target in columns, the best first."""
    m, n = len(wanted.place), q.shape[1]
    off, angle = missed(wanted[owner], q)
    ranks = tuple(np.round(np.where(each < EXACT, 0.0, each), 12) for each in keys(off, angle))
    order = np.lexsort(np.stack([*ranks[::-1], owner]))
    owner, q = owner[order], q[order]
    start = np.searchsorted(owner, np.arange(m))
    column = np.arange(len(owner)) - start[owner]
    out = np.full((m, max(int(column.max(initial=0)) + 1, 1), n), np.nan)
    out[owner, column] = np.where(np.isinf(bounds).all(axis=1) & (wanted.chain.image_turns == 1.0), wrapped(q), q)
    return out


def missed(wanted: Wanted, q: Array) -> tuple[Array, Array]:
    """What joint vectors (m, n) miss: of the place [share of size] and of the angle [rad]."""
    T = wanted.chain.fk(q)
    off = np.linalg.norm(T[:, :3, 3] - wanted.place, axis=1) / wanted.chain.size
    return off, angle_missed(T[:, :3, :3], wanted.matrix, wanted.constant)


def spread_inside(bounds: Array, unit: Array, count: int) -> Array:
    """(count, n) joint vectors spread evenly inside bounds (n, 2), within half a turn or a ``unit`` (n,) pi."""
    low, high = np.clip(bounds.T, -np.pi * unit, np.pi * unit)
    low, high = np.where(low > high, bounds.T, (low, high))
    return np.asarray(low + spread_evenly(count, len(bounds)) * (high - low))


def spread_evenly(count: int, wide: int) -> Array:
    """(count, wide) shares of a unit cube, evenly spread: multiples of powers of a root of x^(wide + 1) = x + 1."""
    if not wide:
        return np.empty((count, 0))
    root = 2.0
    for _ in range(60):
        root = (1.0 + root) ** (1.0 / (wide + 1))
    steps = root ** -np.arange(1.0, wide + 1.0)
    return np.asarray((0.5 + np.arange(count)[:, None] * steps) % 1.0)
