"""The nearest postures: where no joint vector does what is asked, those that miss least of it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from urdf_ik.errors import ArgumentError
from urdf_ik.ik.descent import Wanted, constrained, descended
from urdf_ik.ik.redundancy.region import spread_evenly
from urdf_ik.ik.solutions import IKSolutions
from urdf_ik.ik.solver import Solver
from urdf_ik.ik.task import Task
from urdf_ik.model.poses import project_rotation
from urdf_ik.support import inputs
from urdf_ik.support.angles import wrapped
from urdf_ik.typing import Array

INCOMPLETE = 32
"""Flags of the first column of a pose whose solutions were searched."""
STARTS = 48
"""Joint vectors from which each pose's minima are searched, spread evenly over the ranges of the joints."""
_BLOCK = 64
"""Poses that are searched at once."""
_SAME = 1e-5
"""rad, share of size: minima that differ by less in every joint are one."""
_EXACT = 1e-11
"""Share of the size, rad: what is missed by no more is reached."""
_STAGES = ((30.0, 15), (300.0, 5))
"""Weights of the part that counts first beside the other, with Newton's rounds at each."""
_HARD = 1e4
"""Weight of the part that counts first, where it is not reached at once."""


_Keys = Callable[[Array, Array], tuple[Array, ...]]
"""What is missed of the place and of the angle, each (m,), to what minima are sorted by."""


def closest(
    solver: Solver,
    T: Any,
    weights: ArrayLike | None = None,
    first: str | None = None,
    *,
    task: Any = "pose",
    within_limits: bool = False,
) -> IKSolutions:
    """The joint vectors that miss least of targets: every local minimum that is found, the best first.

    For targets that an arm cannot reach, or of which its joints are too few to reach all. ``IKSolutions.error`` says
    what each misses. The minima are searched from 48 joint vectors spread evenly over the ranges of the joints, by
    Newton's method with the exact Hessian; ``status`` is 'incomplete', since a search proves nothing.

    Args:
        solver: of the arm.
        T: (..., 4, 4) poses, or targets of the task; see :meth:`urdf_ik.Arm.ik`.
        weights: per m and per rad; the root of the sum of squared weighted errors is least.
        first: 'position' (the default without ``weights``): the position is missed by as little as possible, by 1e-9 m
            where it can be reached, and of the joint vectors that do so the rotation is nearest; 'orientation': the
            other way round.
        task: what is asked for; see :class:`urdf_ik.Task`.
        within_limits: whether only joint vectors inside the joint limits count.

    Returns:
        One column a minimum, named 'closest', 'closest 2', ...

    Raises:
        PoseError: a target is not a rigid pose.
        ArgumentError: ``weights``, ``first`` or ``task`` does not fit.

    Example:
        >>> import urdf_ik
        >>> arm = urdf_ik.load("so100")
        >>> s = arm.ik_closest(urdf_ik.pose([0.0, -0.2, 0.1], rpy=[3.0, 0.2, 0.0]))
        >>> bool(s.error.position[0] < 1e-9), float(s.error.rotation[0].round(4))
        (True, 0.0)
    """
    asked = Task.read(task)
    place, turn = _weights(weights, first, solver.chain.size)
    first = "position" if weights is None and first is None else first
    if not (asked.has_turn and asked.has_place):
        place, turn, first = float(asked.has_place), float(asked.has_turn), None
    target = project_rotation(asked.read_targets(T))
    seen = asked.chain(solver.chain)
    bounds = seen.limits if within_limits else np.where(seen.prismatic[:, None], seen.limits, [-np.inf, np.inf])
    found = [
        _searched(Wanted(seen, t[:, :3, 3], *asked.matrix(t)), bounds, first, place, turn)[..., : solver.dof]
        for t in _blocks(target.reshape(-1, 4, 4))
    ]
    count = max((each.shape[1] for each in found), default=1)
    q = np.concatenate([_padded(each, count) for each in found]) if found else np.empty((0, 1, solver.dof))
    info = (~np.isnan(q[..., 0])).astype(np.uint8)
    info[:, 0] |= np.uint8(INCOMPLETE)
    names = tuple("closest" if k == 1 else f"closest {k}" for k in range(1, count + 1))
    shape = target.shape[:-2]
    q, info = q.reshape(*shape, count, solver.dof), info.reshape(*shape, count)
    return IKSolutions(replace(solver, asked=asked), target, q, info, names)


def _weights(weights: ArrayLike | None, first: str | None, size: float) -> tuple[float, float]:
    """The weights of the place [per share of size] and of the angle [per rad], the greater one 1."""
    if first is not None:
        inputs.choice(first, "first", ("position", "orientation"))
        if weights is not None:
            raise ArgumentError(f"weights and first={first!r} given: one part counts first, or both by their weights")
    if weights is None:
        return 1.0, 1.0
    pair = inputs.array(weights, "weights", (2,))
    if not (pair >= 0.0).all() or not pair.any():
        raise ArgumentError(f"weights={weights!r} given; two numbers are needed, per m and per rad, none negative")
    pair = pair * [size, 1.0] / max(pair[0] * size, pair[1])
    return float(pair[0]), float(pair[1])


def _blocks(stack: Array) -> list[Array]:
    return [stack[k : k + _BLOCK] for k in range(0, len(stack), _BLOCK)]


def _padded(q: Array, count: int) -> Array:
    return np.concatenate([q, np.full((len(q), count - q.shape[1], q.shape[2]), np.nan)], axis=1)


def _searched(wanted: Wanted, bounds: Array, first: str | None, place: float, turn: float) -> Array:
    """(m, B, n) minima for targets (m), the best first, padded with NaN."""
    chain = wanted.chain
    m, n = len(wanted.place), chain.n
    low, high = np.clip(bounds.T, -np.pi * wanted.unit, np.pi * wanted.unit)
    low, high = np.where(low > high, bounds.T, (low, high))
    starts = low + spread_evenly(STARTS, n) * (high - low)
    q = np.tile(starts, (m, 1))
    owner = np.repeat(np.arange(m), STARTS)
    if first is None:
        q = descended(wanted[owner], q, bounds, place, turn, 60)
        q, owner = _distinct(wanted, q, owner)
        return _sorted(wanted, q, owner, bounds, lambda off, angle: (np.hypot(place * off, turn * angle),))
    for weight, rounds in _STAGES:
        pair = (weight, 1.0) if first == "position" else (1.0, weight)
        q = descended(wanted[owner], q, bounds, *pair, rounds)
        q, owner = _distinct(wanted, q, owner)
    part = 0 if first == "position" else 1
    exact, good = constrained(wanted[owner], q, bounds, first)
    q[good] = exact[good]
    if not good.all():
        # Joints rest at their limits, the Jacobian is nearly singular there, or the first part is out of reach.
        rest = wanted[owner[~good]]
        near = descended(rest, q[~good], bounds, *((_HARD, 1.0) if part == 0 else (1.0, _HARD)), 12)
        again, settled = constrained(rest, near, bounds, first)
        onto = descended(rest, near, bounds, 1.0 - part, float(part), 8)
        onto = np.where((missed(rest, onto)[part] < _EXACT)[:, None], onto, near)
        q[~good] = np.where(settled[:, None], again, onto)
    off = missed(wanted[owner], q)[part] < _EXACT
    reached = np.zeros(m, dtype=np.bool_)
    reached[owner[off]] = True
    keep = off | ~reached[owner]
    q, owner = q[keep], owner[keep]
    q, owner = _distinct(wanted, q, owner)
    return _sorted(wanted, q, owner, bounds, lambda off, angle: (off, angle) if first == "position" else (angle, off))


def _distinct(wanted: Wanted, q: Array, owner: NDArray[np.intp]) -> tuple[Array, NDArray[np.intp]]:
    """Joint vectors with angles in (-pi, pi], of nearly equal ones of a target the first."""
    turning = ~wanted.chain.prismatic
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


def _sorted(wanted: Wanted, q: Array, owner: NDArray[np.intp], bounds: Array, keys: _Keys) -> Array:
    """(m, B, n): the joint vectors of each target in columns, the best first."""
    m, n = len(wanted.place), q.shape[1]
    off, angle = missed(wanted[owner], q)
    ranks = tuple(np.round(np.where(each < _EXACT, 0.0, each), 12) for each in keys(off, angle))
    order = np.lexsort(np.stack([*ranks[::-1], owner]))
    owner, q = owner[order], q[order]
    start = np.searchsorted(owner, np.arange(m))
    column = np.arange(len(owner)) - start[owner]
    out = np.full((m, max(int(column.max(initial=0)) + 1, 1), n), np.nan)
    out[owner, column] = np.where(np.isinf(bounds).all(axis=1) & ~wanted.chain.prismatic, wrapped(q), q)
    return out


def missed(wanted: Wanted, q: Array) -> tuple[Array, Array]:
    """What joint vectors (m, n) miss: of the place [share of size] and of the angle [rad]."""
    T = wanted.chain.fk(q)
    off = np.linalg.norm(T[:, :3, 3] - wanted.place, axis=1) / wanted.chain.size
    A = T[:, :3, :3] @ np.swapaxes(wanted.matrix, 1, 2)
    skew = np.stack([A[:, 1, 2] - A[:, 2, 1], A[:, 2, 0] - A[:, 0, 2], A[:, 0, 1] - A[:, 1, 0]], -1)
    cosine = np.trace(A, axis1=1, axis2=2) - (wanted.constant - 2.0)
    return off, np.arctan2(np.linalg.norm(skew, axis=1), cosine)
