"""Intervals of the swivel angle in closed form: the joint limits of an S-R-S arm as conditions on it.

Three axes that meet, neighbours at right angles, turn by R = Rz(q1) Rx(+-90) Rz(t2) Rx(+-90) Rz(q3). The last column
and row of R hold, up to signs, cos t2, sin t2 (cos q1, sin q1) and sin t2 (cos q3, sin q3). Shoulder and wrist turn
with the swivel angle s about fixed lines, so that each of these is a + b cos s + c sin s: a joint is at a limit where
such an expression vanishes: at two values at most (Shimizu, Kakuya, Yoon, Kitagaki and Kosuge 2008).
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from urdf_ik.angles import TURN, wrapped
from urdf_ik.chain.redundancy import SWIVEL
from urdf_ik.redundancy.bounds import Bounds
from urdf_ik.redundancy.found import End, Found

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from urdf_ik.families.parts.family import RedundantPlan
    from urdf_ik.solutions.solved_arm import SolvingArm

    Array = NDArray[np.float64]
    Columns = NDArray[np.intp]
    Mask = NDArray[np.bool_]

_AT = TURN / 3.0 * np.array([0.0, 1.0, -1.0])
"""Swivel angles at which the arm is solved: three values fix a, b and c."""
_TRIPLES = (("shoulder", (0, 1, 2)), ("wrist", (4, 5, 6)))
_ELBOW = 3
# Sine of the middle angle below which a triple is so nearly aligned that its curves are followed instead.
_ALIGNED = 1e-6
# Intervals narrower than this [rad] are rounding.
_NARROWEST = 1e-13


def is_closed(plan: RedundantPlan) -> bool:
    """Whether the intervals of an arm have this closed form."""
    if plan.parameter.kind != SWIVEL or not plan.is_exact:
        return False
    values: Any = plan.solver.values
    return all(values.get(name, {}).get("square", False) for name, _ in _TRIPLES)


def intervals(arm: SolvingArm, plan: RedundantPlan, T: Array, limits: Array) -> tuple[Found, Columns]:
    """The intervals of poses (m, 4, 4) inside limits (7, 2), without samples; and the poses that it does not decide.

    These are poses near a singularity of a triple at one of the three values, or at the edge of the elbow's reach.
    """
    solutions = arm.ik(T[:, None], redundancy=np.broadcast_to(_AT, (len(T), 3)))
    q, valid = solutions.q.reshape(len(T), 3, 2, 2, 2, 7), solutions.valid.all(axis=(1, 2))
    open_ = np.flatnonzero(~valid & solutions.valid.any(axis=(1, 2)))
    # Of each elbow the first branch of shoulder and wrist; both flips share the expressions.
    first = q[:, :, 0, :, 0]  # (m, 3, elbow, 7)
    expressions, sign, shifts = [], [], []
    fourier = np.stack([np.ones(3), 2.0 * np.cos(_AT), 2.0 * np.sin(_AT)]) / 3.0
    for name, (j1, j2, j3) in _TRIPLES:
        shift = plan.solver.values[name]["shift"]
        s2, c2 = np.sin(first[..., j2] + shift), np.cos(first[..., j2] + shift)
        samples = np.stack(
            [s2 * np.cos(first[..., j1]), s2 * np.sin(first[..., j1]), c2, s2 * np.cos(first[..., j3]),
             s2 * np.sin(first[..., j3])], axis=-1,
        )  # fmt: skip
        # (m, elbow, 5, 3): a, b and c of each expression.
        expressions.append(np.einsum("ks,mseg->megk", fourier, samples))
        sign.append(np.sign(s2[:, 0]))
        shifts.append(shift)
        open_ = np.union1d(open_, np.flatnonzero(valid & (np.abs(s2) < _ALIGNED).any(axis=(1, 2))))
    found = np.setdiff1d(np.flatnonzero(valid), open_)
    E = np.stack(expressions, axis=2)[found]  # (m, elbow, triple, 5, 3)
    signs = np.stack(sign, axis=2)[found]  # (m, elbow, triple)
    bounds = Bounds(limits)
    breaks = _breaks(E, bounds, np.array(shifts))
    rows = _Rows(E, signs, np.array(shifts), q[found, 0, 0, :, 0, _ELBOW])
    return _assembled(arm, found, rows, bounds, breaks), open_


class _Rows:
    """What the branches of poses are made of.

    Attributes:
        E: (m, elbow, triple, 5, 3) the expressions.
        signs: (m, elbow, triple) of sin t2 where the triple is not flipped.
        shifts: (triple,) rad, t2 less q2.
        elbow: (m, elbow) rad, joint 4.
    """

    def __init__(self, E: Array, signs: Array, shifts: Array, elbow: Array) -> None:
        self.E, self.signs, self.shifts, self.elbow = E, signs, shifts, elbow

    def angles(self, values: Array, t: int, sign: Array) -> tuple[Array, Array, Array]:
        """The three joints [rad] of triple ``t`` from its expressions' values (..., 5) and the sign of sin t2 (...)."""
        x1, y1, c2, x3, y3 = np.moveaxis(values, -1, 0)
        bend = np.arccos(np.clip(c2, -1.0, 1.0))
        return np.arctan2(sign * y1, sign * x1), sign * bend - self.shifts[t], np.arctan2(sign * y3, sign * x3)

    def at_limit(self, bounds: Bounds, i: Columns, b: Columns, at: Array) -> Columns:
        """(k,) which limit branches ``b`` of poses ``i`` are at, at swivel angles (k,): 2 * joint + side."""
        e, wave = b >> 1 & 1, np.stack([np.ones_like(at), np.cos(at), np.sin(at)], axis=-1)
        values = np.einsum("jtgk,jk->jtg", self.E[i, e], wave)
        away = np.full((len(at), 7, 2), np.inf)
        for t, (_, joints) in enumerate(_TRIPLES):
            flipped = (b >> 2 if t == 0 else b) & 1
            angles = self.angles(values[:, t], t, np.where(flipped, -1.0, 1.0) * self.signs[i, e, t])
            for j, angle in zip(joints, angles, strict=True):
                if bounds.matter[j]:
                    away[:, j] = np.abs(wrapped(angle[:, None] - bounds.limits[j]))
        return np.asarray(np.argmin(away.reshape(len(at), 14), axis=1))


def _breaks(E: Array, bounds: Bounds, shifts: Array) -> Array:
    """Swivel angles (m, elbow, 24) at which some joint is at a limit, NaN where it never is."""
    breaks = []
    for t, (_, joints) in enumerate(_TRIPLES):
        for place, j in enumerate(joints):
            if not bounds.matter[j]:
                breaks.append(np.full((*E.shape[:2], 4), np.nan))
                continue
            for limit in bounds.limits[j]:
                if place == 1:
                    breaks.append(_roots(E[:, :, t, 2] - np.array([np.cos(limit + shifts[t]), 0.0, 0.0])))
                else:
                    x, y = (E[:, :, t, 0], E[:, :, t, 1]) if place == 0 else (E[:, :, t, 3], E[:, :, t, 4])
                    breaks.append(_roots(np.sin(limit) * x - np.cos(limit) * y))
    return np.concatenate(breaks, axis=-1)


def _roots(abc: Array) -> Array:
    """Angles (..., 2) where a + b cos s + c sin s vanishes, of (..., 3); NaN where it does not."""
    a, b, c = np.moveaxis(abc, -1, 0)
    with np.errstate(invalid="ignore", divide="ignore"):
        half = np.arccos(-a / np.hypot(b, c))
    middle = np.arctan2(c, b)
    return np.stack([wrapped(middle - half), wrapped(middle + half)], axis=-1)


def _assembled(arm: SolvingArm, pose: Columns, rows: _Rows, bounds: Bounds, breaks: Array) -> Found:
    """The intervals of all branches of the poses."""
    m, K = len(pose), breaks.shape[-1]
    at = np.sort(breaks, axis=-1)  # NaN last
    real = np.isfinite(at)
    # Angles that do not exist stand at the last one that does, as pieces of no width.
    last = np.take_along_axis(at, np.maximum(real.sum(axis=-1) - 1, 0)[..., None], axis=-1)
    at = np.where(real, at, np.where(np.isfinite(last), last, -np.pi))
    after = np.concatenate([at[..., 1:], at[..., :1] + TURN], axis=-1)
    middle = 0.5 * (at + after)  # (m, elbow, K)
    wave = np.stack([np.ones_like(middle), np.cos(middle), np.sin(middle)], axis=-1)
    values = np.einsum("metgk,mepk->metpg", rows.E, wave)
    flipped = []  # by triple and flip: (m, elbow, K)
    for t, (_, joints) in enumerate(_TRIPLES):
        for flip in (1.0, -1.0):
            angles = rows.angles(values[:, :, t], t, (flip * rows.signs[:, :, t])[..., None])
            parts = [bounds.inside(j, angle) for j, angle in zip(joints, angles, strict=True)]
            flipped.append(parts[0] & parts[1] & parts[2])
    shoulder, wrist = np.stack(flipped[:2], axis=1), np.stack(flipped[2:], axis=1)  # (m, flip, elbow, K)
    bent = bounds.inside(_ELBOW, rows.elbow)[:, None, :, None, None]
    inside = (shoulder[:, :, :, None] & wrist.transpose(0, 2, 1, 3)[:, None] & bent).reshape(m, 8, K)

    def of_branches(array: Array) -> Array:
        return np.broadcast_to(array[:, None, :, None], (m, 2, 2, 2, K)).reshape(m, 8, K)

    at, wide = of_branches(at), of_branches(after - at) > _NARROWEST
    # Pieces of no width are what the one before them is.
    inside[..., 0] = np.where(wide[..., 0], inside[..., 0], inside[..., -1])
    for piece in range(1, K):
        inside[..., piece] = np.where(wide[..., piece], inside[..., piece], inside[..., piece - 1])
    i, b, k = np.nonzero(inside & ~np.roll(inside, 1, axis=-1))
    i_end, b_end, k_end = np.nonzero(inside & ~np.roll(inside, -1, axis=-1))
    stop = (_paired(8 * i + b, k, 8 * i_end + b_end, k_end) + 1) % K
    low, high = at[i, b, k], at[i, b, stop]
    table = [End("limit", name, upper=upper) for name in arm.joint_names for upper in (False, True)]
    why = [rows.at_limit(bounds, i, b, each).tolist() for each in (low, high)]
    ends = [(table[x], table[y]) for x, y in zip(*why, strict=True)]
    i_whole, b_whole = np.nonzero(inside.all(axis=-1))
    ends += [(End("none"), End("none"))] * len(i_whole)
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
    ends: Columns = k_end[np.repeat(start, count) + (place + np.repeat(late, count)) % np.repeat(count, count)]
    return ends
