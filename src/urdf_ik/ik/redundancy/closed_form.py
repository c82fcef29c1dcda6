"""Intervals of the redundancy parameter in closed form: S-R-S arms, and a free axis that is the last joint's."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from urdf_ik import _core
from urdf_ik.ik.families.parts.family import FamilyMember
from urdf_ik.ik.pose_solving import solve
from urdf_ik.ik.redundancy.curves import End, Found, joined
from urdf_ik.ik.solver import Solver
from urdf_ik.kinematics.chain.redundancy import SWIVEL
from urdf_ik.support import tolerances
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


Columns = NDArray[np.intp]
Mask = NDArray[np.bool_]

_AT = TURN / 3.0 * np.array([0.0, 1.0, -1.0])
"""Swivel angles at which the arm is solved: three values fix a, b and c."""
_TRIPLES = (("shoulder", (0, 1, 2)), ("wrist", (4, 5, 6)))
_ELBOW = 3
# Sine of the middle angle below which a triple is so nearly aligned that its curves are followed instead.
_ALIGNED = 1e-6
# Poses at a time, whose expressions at all breaks fit a processor's second cache.
_AT_ONCE = 128
# Intervals narrower than this [rad] are rounding.
_NARROWEST = 1e-13


def is_closed(plan: FamilyMember) -> bool:
    """Whether the intervals of an arm have this closed form."""
    if plan.parameters[0].kind != SWIVEL or not plan.is_exact:
        return False
    arm: Any = plan.solver.arm
    return bool(arm.shoulder.square and arm.wrist.square)


def swivel_intervals(solver: Solver, plan: FamilyMember, T: Array, limits: Array) -> tuple[Found, Columns]:
    """The intervals of poses (m, 4, 4) inside limits (7, 2), without samples; and the poses that it does not decide.

    These are poses near a singularity of a triple at one of the three values, or at the edge of the elbow's reach.
    """
    bounds = Bounds(limits)
    parts, undecided = [], []
    for start in range(0, len(T), _AT_ONCE):
        found, open_ = _some(solver, plan, T[start : start + _AT_ONCE], bounds)
        parts.append(replace(found, pose=found.pose + start))
        undecided.append(open_ + start)
    return joined(parts), np.concatenate(undecided)


def _some(solver: Solver, plan: FamilyMember, T: Array, bounds: Bounds) -> tuple[Found, Columns]:
    """:func:`intervals` of few poses."""
    solutions = solve(solver, T[:, None], redundancy=np.broadcast_to(_AT, (len(T), 3)))
    q, valid = solutions.q.reshape(len(T), 3, 2, 2, 2, 7), solutions.valid.all(axis=(1, 2))
    open_ = np.flatnonzero(~valid & solutions.valid.any(axis=(1, 2)))
    # Of each elbow the first branch of shoulder and wrist; both flips share the expressions.
    first = q[:, :, 0, :, 0]  # (m, 3, elbow, 7)
    expressions, sign, shifts = [], [], []
    fourier = np.stack([np.ones(3), 2.0 * np.cos(_AT), 2.0 * np.sin(_AT)]) / 3.0
    for name, (j1, j2, j3) in _TRIPLES:
        shift = getattr(plan.solver.arm, name).shift
        s2, c2 = np.sin(first[..., j2] + shift), np.cos(first[..., j2] + shift)
        samples = np.stack(
            [s2 * np.cos(first[..., j1]), s2 * np.sin(first[..., j1]), c2, s2 * np.cos(first[..., j3]),
             s2 * np.sin(first[..., j3])],
        )  # fmt: skip
        # (5, 3, m, elbow): a, b and c of each expression.
        expressions.append(np.einsum("ks,gmse->gkme", fourier, samples))
        sign.append(np.sign(s2[:, 0]))
        shifts.append(shift)
        open_ = np.union1d(open_, np.flatnonzero(valid & (np.abs(s2) < _ALIGNED).any(axis=(1, 2))))
    found = np.setdiff1d(np.flatnonzero(valid), open_)
    E, signs = np.stack(expressions)[:, :, :, found], np.stack(sign)[:, found]
    rows = _Rows(E, signs, np.array(shifts), q[found, 0, 0, :, 0, _ELBOW])
    return _assembled(solver, found, rows, bounds), open_


class _Rows:
    """What the branches of poses are made of.

    Attributes:
        E: (triple, 5, 3, m, elbow) the expressions.
        signs: (triple, m, elbow) of sin t2 where the triple is not flipped.
        shifts: (triple,) rad, t2 less q2.
        elbow: (m, elbow) rad, joint 4.
    """

    def __init__(self, E: Array, signs: Array, shifts: Array, elbow: Array) -> None:
        self.E, self.signs, self.shifts, self.elbow = E, signs, shifts, elbow

    def inside(self, bounds: Bounds, at: Array) -> Mask:
        """(m, 8, K) whether the branches are inside their limits, at swivel angles (m, elbow, K).

        An angle q is within h of the middle of its limits where cos(q - middle) >= cos h, which takes no arc tangent.
        """
        wave = np.cos(at), np.sin(at)
        flipped = []  # of each triple, of each flip: (m, elbow, K)
        for t, (_, joints) in enumerate(_TRIPLES):
            x1, y1, c2, x3, y3 = self.E[t]  # each (3, m, elbow)
            cosine = _at(c2, wave)
            sine = np.sqrt(np.maximum(1.0 - cosine * cosine, 0.0))
            sign = self.signs[t, :, :, None]
            parts: list[tuple[Array, Array | float]] = []  # odd in sin t2, and what that must not fall below
            for j, x, y in ((joints[0], x1, y1), (joints[2], x3, y3)):
                if bounds.matter[j]:
                    middle = np.cos(bounds.middle[j]) * x + np.sin(bounds.middle[j]) * y
                    parts.append((sign * _at(middle, wave), sine * np.cos(bounds.half[j])))
            if bounds.matter[joints[1]]:
                turned = self.shifts[t] + bounds.middle[joints[1]]
                parts.append((sign * np.sin(turned) * sine, np.cos(bounds.half[joints[1]]) - np.cos(turned) * cosine))
            for flip in (1.0, -1.0):
                all_inside = np.ones(at.shape, dtype=bool)
                for odd, least in parts:
                    all_inside &= flip * odd >= least
                flipped.append(all_inside)
        shoulder, wrist = np.stack(flipped[:2], axis=1), np.stack(flipped[2:], axis=2)
        wrist &= bounds.inside(_ELBOW, self.elbow)[:, :, None, None]
        inside: Mask = shoulder[:, :, :, None] & wrist[:, None]
        return inside.reshape(len(at), 8, at.shape[-1])

    def at_limit(self, bounds: Bounds, i: Columns, b: Columns, at: Array) -> Columns:
        """(k,) which limit branches ``b`` of poses ``i`` are at, at swivel angles (k,): 2 * joint + side.

        It is the one whose difference from its joint has the greatest cosine.
        """
        e = b >> 1 & 1
        E, cosines = self.E[..., i, e], np.full((7, 2, len(at)), -1.0)
        values = E[:, :, 0] + E[:, :, 1] * np.cos(at) + E[:, :, 2] * np.sin(at)
        for t, (_, joints) in enumerate(_TRIPLES):
            x1, y1, c2, x3, y3 = values[t]
            sine = np.where((b >> 2 if t == 0 else b) & 1, -1.0, 1.0) * self.signs[t, i, e]
            sine *= np.sqrt(np.maximum(1.0 - c2 * c2, _ALIGNED * _ALIGNED))
            for j, x, y in (
                (joints[0], x1 / sine, y1 / sine),
                (joints[1], c2, sine),
                (joints[2], x3 / sine, y3 / sine),
            ):
                for side, limit in enumerate(bounds.limits[j] if bounds.matter[j] else ()):
                    angle = limit + self.shifts[t] if j == joints[1] else limit
                    cosines[j, side] = np.cos(angle) * x + np.sin(angle) * y
        return np.asarray(np.argmax(cosines.reshape(14, len(at)), axis=0))


def _breaks(E: Array, bounds: Bounds, shifts: Array) -> Array:
    """Swivel angles (m, elbow, K) at which some joint is at a limit, sorted; NaN last, where there are fewer."""
    breaks = []
    for t, (_, joints) in enumerate(_TRIPLES):
        for place, j in enumerate(joints):
            for limit in bounds.limits[j] if bounds.matter[j] else ():
                if place == 1:
                    a, b, c = E[t, 2]
                    breaks.append(_roots(a - np.cos(limit + shifts[t]), b, c))
                else:
                    x, y = E[t, :2] if place == 0 else E[t, 3:]
                    breaks.append(_roots(*(np.sin(limit) * x - np.cos(limit) * y)))
    every = np.sort(np.concatenate([np.full((*E.shape[3:], 1), np.nan), *breaks], axis=-1), axis=-1)
    most = np.isfinite(every).sum(axis=-1).max(initial=1)
    return every[..., :most]


def _at(abc: Array, wave: tuple[Array, Array]) -> Array:
    """Values (m, elbow, K) of a + b cos s + c sin s, (3, m, elbow), for (cos s, sin s), each (m, elbow, K)."""
    a, b, c = abc[..., None]
    return np.asarray(a + b * wave[0] + c * wave[1])


def _roots(a: Array, b: Array, c: Array) -> Array:
    """Angles (m, elbow, 2) where a + b cos s + c sin s vanishes, of (m, elbow); NaN where it does not."""
    with np.errstate(invalid="ignore", divide="ignore"):
        half = np.arccos(-a / np.hypot(b, c))
    middle = np.arctan2(c, b)
    both = np.stack([middle - half, middle + half], axis=-1)  # within two turns
    return np.minimum(both - TURN * np.ceil(both / TURN - 0.5), np.pi)


def _assembled(solver: Solver, pose: Columns, rows: _Rows, bounds: Bounds) -> Found:
    """The intervals of all branches of the poses."""
    breaks = _breaks(rows.E, bounds, rows.shifts)
    K = breaks.shape[-1]
    real = np.isfinite(breaks)
    # Angles that do not exist stand at the last one that does, as pieces of no width.
    last = np.take_along_axis(breaks, np.maximum(real.sum(axis=-1) - 1, 0)[..., None], axis=-1)
    breaks = np.where(real, breaks, np.where(np.isfinite(last), last, -np.pi))
    after = np.concatenate([breaks[..., 1:], breaks[..., :1] + TURN], axis=-1)
    # Pieces of no width are what the wide one before them is, round the circle.
    wide = np.where(after - breaks > _NARROWEST, np.arange(K), -1)
    of = np.maximum.accumulate(wide, axis=-1)
    of = np.where(of < 0, wide.max(axis=-1, keepdims=True), of)
    inside = rows.inside(bounds, np.take_along_axis(0.5 * (breaks + after), of, axis=-1))
    before = np.roll(inside, 1, axis=-1)
    i, b, k = np.nonzero(inside & ~before)
    i_end, b_end, stop = np.nonzero(before & ~inside)
    stop = _paired(8 * i + b, k, 8 * i_end + b_end, stop)
    low, high = breaks[i, b >> 1 & 1, k], breaks[i, b >> 1 & 1, stop]
    table = np.array([End("limit", name, upper=upper) for name in solver.joint_names for upper in (False, True)])
    ends = np.stack([table[rows.at_limit(bounds, i, b, each)] for each in (low, high)], axis=-1)
    i_whole, b_whole = np.nonzero(inside.all(axis=-1))
    ends = np.concatenate([ends, np.full((len(i_whole), 2), End("none"))])
    half_turns = np.full(len(i_whole), np.pi)
    column = np.concatenate([b, b_whole])
    where = np.concatenate([pose[i], pose[i_whole]])
    low, high = (
        np.concatenate([low, -half_turns]),
        np.concatenate([np.where(high <= low, high + TURN, high), half_turns]),
    )
    nothing = np.zeros(len(low), dtype=np.intp)
    empty = np.zeros(0), np.zeros((0, 7)), np.zeros((0, 17))
    found = Found(where, low, high, column, ends, nothing, nothing, *empty)
    return found.of(np.lexsort((low, column, where)))


def _paired(row: Columns, k: Columns, row_end: Columns, k_end: Columns) -> Columns:
    """For each beginning the end that comes next, round the circle; both sorted by row, as many of each in a row."""
    if not len(row):
        return k_end
    start = np.flatnonzero(np.concatenate([[True], row[1:] != row[:-1]]))
    count = np.diff(np.append(start, len(row)))
    late = k_end[start] < k[start]  # the first end belongs to what began before the circle was opened
    place = np.arange(len(row)) - np.repeat(start, count)
    return np.asarray(k_end[np.repeat(start, count) + (place + np.repeat(late, count)) % np.repeat(count, count)])


def sense(solver: Solver, plan: FamilyMember) -> float:
    """1 or -1: how the last joint turns with the tip; 0 where the free axis is not the last joint's, or there is none.

    Arms whose branches have no names are left to the search: their columns change along the value.
    """
    if solver.free_axis is None or plan.family.by_elimination or not isinstance(plan.solver, _core.Solver):
        return 0.0
    if solver.chain.prismatic.any() or solver.dof != 6 or len(plan.parameters) != 1:
        return 0.0
    home = np.zeros(solver.dof)
    # The last joint's twist in the tip.
    J = solver.chain.jacobian(home)[:, -1].reshape(2, 3) @ solver.chain.fk(home)[:3, :3]
    direction, at = np.array(solver.free_axis.direction), np.array(solver.free_axis.at)
    way = 1.0 if J[1] @ direction > 0.0 else -1.0
    off = np.abs([(J[0] - way * np.cross(at, direction)) / solver.chain.size, J[1] - way * direction]).max()
    return way if off <= tolerances.DEFAULT.reach else 0.0


def last_axis_intervals(solver: Solver, way: float, T: Array, limits: Array) -> tuple[Found, Columns]:
    """The intervals of poses (m, 4, 4) inside limits (n, 2), without samples; and the poses that it does not decide.

    These are poses with a singular solution, beside which there may be others.

    Args:
        solver: with the free axis.
        way: of :func:`sense`.
        T: (m, 4, 4) m.
        limits: (n, 2) rad, infinite where there is none.
    """
    bounds = Bounds(limits)
    solutions = solve(solver, T, redundancy=np.zeros(len(T)))
    singular = (solutions.valid & (solutions.singular != 0)).any(axis=-1)
    kept = solutions.valid & ~singular[:, None]
    kept &= bounds.inside(slice(solver.dof - 1), solutions.q[..., :-1]).all(axis=-1)
    pose, column = np.nonzero(kept)
    last = solver.dof - 1
    if bounds.matter[last]:
        middle = way * (bounds.middle[last] - solutions.q[pose, column, last])
        low = wrapped(middle - bounds.half[last])
        high = low + 2.0 * bounds.half[last]
        both = [End("limit", solver.joint_names[last], upper=upper) for upper in (way < 0.0, way > 0.0)]
    else:
        low, high = np.full(len(pose), -np.pi), np.full(len(pose), np.pi)
        both = [End("none")] * 2
    ends = np.tile(np.array(both), (len(pose), 1))
    nothing = np.zeros(len(pose), dtype=np.intp)
    empty = np.zeros(0), np.zeros((0, solver.dof)), np.zeros((0, 17))
    found = Found(pose, low, high, column, ends, nothing, nothing, *empty)
    return found, np.flatnonzero(singular)
