"""Local minima of what joint vectors miss of targets, by Newton's method on all starts at once.

The misfit of a joint vector is half of ``place^2 |p - p*|^2 / size^2 + turn^2 angle^2``. Its Hessian is exact: the
second derivative of the tip's place by joints i <= j is w_i x v_j, with the columns v, w of the geometric Jacobian.
Directions of negative curvature are followed downhill, and joints at their limits rest while the misfit falls beyond
them (Nocedal and Wright, Numerical Optimization, 2006, chapters 3, 16 and 18).
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from urdf_ik.kinematics.chain import Chain
from urdf_ik.typing import Array

_LONGEST = 0.6
"""Longest step of a round [rad, share of size]."""
_CURVED = 1e-11
"""Curvatures below this share of the greatest one count as this share."""
_SETTLED = 1e-12
"""Projected gradient below which a start has arrived."""
_LOOSE = 1e-7
"""Projected gradient that a minimum may have left after the last round."""
_NEAR = 0.1
"""Longest step of a round from near a minimum [rad, share of size]."""
_MISSED = 1e-12
"""Share of the size, rad: what is missed by less is reached."""
_FLAT = 1e-6
"""Negative curvature that rounding may leave of a minimum."""
_RANK = 1e-7
"""Share of the greatest singular value below which a constraint counts as dependent."""


@dataclass(frozen=True, eq=False)
class Wanted:
    """Targets (m) for the tip, one for each joint vector.

    Attributes:
        chain: the arm.
        place: (m, 3) m.
        matrix: (m, 3, 3): ``constant - sum(matrix * R)`` is 2 - 2 cos of the angle that the rotation R misses.
        constant: 3 - 1 for whole rotations (``matrix`` is the rotation), 2 for directions (``matrix`` is 2 d a').
    """

    chain: Chain
    place: Array
    matrix: Array
    constant: float

    def __getitem__(self, index: Any) -> "Wanted":
        return replace(self, place=self.place[index], matrix=self.matrix[index])

    @property
    def unit(self) -> Array:
        """(n,) rad, or the arm's size for joints that slide."""
        return np.where(self.chain.prismatic, self.chain.size, 1.0)


@dataclass(frozen=True, eq=False)
class _Seen:
    """Errors and derivatives at joint vectors, joints in ``Wanted.unit``.

    Attributes:
        off: (m, 3) of the place [share of size].
        v: (m, 3, k) its derivatives by the axes.
        w: (m, 3, k) directions of the axes that turn.
        A: (m, 3, 3) the tip's rotation times the transposed matrix.
        cosine: (m,) of the angle.
        gain: (k, n) by how much each axis moves for a joint's unit.
    """

    off: Array
    v: Array
    w: Array
    A: Array
    cosine: Array
    gain: Array

    @property
    def linear(self) -> Array:
        """(m, 3, n) derivatives of the place."""
        return self.v @ self.gain

    @property
    def angular(self) -> Array:
        """(m, 3, n) angular velocities."""
        return self.w @ self.gain

    @property
    def skew(self) -> Array:
        """(m, 3) half the gradient of the chord by rotations of the tip in the base: a unit axis times sine."""
        return _skew(self.A)

    def second(self, rows: Array, columns: Array) -> Array:
        """(m, n, n) of the sums of ``rows`` (m, 3, k) times ``columns`` (m, 3, k), axis i before axis j."""
        upper = np.triu(np.swapaxes(rows, 1, 2) @ columns)
        whole = upper + np.swapaxes(np.triu(upper, 1), 1, 2)
        return np.asarray(self.gain.T @ whole @ self.gain)

    def place_second(self, along: Array) -> Array:
        """(m, n, n) second derivatives of the place along vectors (m, 3)."""
        return self.second(np.cross(along[:, :, None], self.w, axis=1), self.v)

    def chord_second(self) -> Array:
        """(m, n, n) second derivatives of the chord."""
        trace = np.trace(self.A, axis1=1, axis2=2)[:, None, None]
        return self.second(self.w, trace * self.w - self.A @ self.w)


def _skew(A: Array) -> Array:
    return np.stack([A[:, 1, 2] - A[:, 2, 1], A[:, 2, 0] - A[:, 0, 2], A[:, 0, 1] - A[:, 1, 0]], -1)


def angle_missed(R: Array, matrix: Array, constant: float) -> Array:
    """(m,) rad that rotations R (m, 3, 3) miss of ``Wanted.matrix`` (m, 3, 3) with its constant."""
    A = R @ np.swapaxes(matrix, 1, 2)
    return np.asarray(np.arctan2(np.linalg.norm(_skew(A), axis=1), np.trace(A, axis1=1, axis2=2) - (constant - 2.0)))


def _seen(wanted: Wanted, q: Array) -> _Seen:
    chain, axes = wanted.chain, wanted.chain.axes
    coupled: Any = chain
    x = q if axes is chain else coupled.spread(q)
    gain = np.diag(wanted.unit) if axes is chain else coupled.gain * wanted.unit
    T, J = axes.fk(x), axes.jacobian(x)
    A = T[:, :3, :3] @ np.swapaxes(wanted.matrix, 1, 2)
    return _Seen(
        off=(T[:, :3, 3] - wanted.place) / chain.size,
        v=J[:, :3] / chain.size,
        w=J[:, 3:],
        A=A,
        cosine=0.5 * (np.trace(A, axis1=1, axis2=2) - wanted.constant + 2.0),
        gain=gain,
    )


def _misfit(seen: _Seen, place: float, turn: float) -> tuple[Array, Array, Array]:
    """The misfit (m,), its gradient (m, n) and its Hessian (m, n, n)."""
    off, linear = seen.off, seen.linear
    value = 0.5 * place**2 * (off * off).sum(-1)
    slope = place**2 * np.einsum("mi,mij->mj", off, linear)
    curve = place**2 * (np.swapaxes(linear, 1, 2) @ linear + seen.place_second(off))
    if turn:
        # From sine and cosine together: the cosine alone knows no angle below 1e-8.
        angle = np.arctan2(np.linalg.norm(seen.skew, axis=1), 2.0 * seen.cosine)
        cosine, sine = np.cos(angle), np.maximum(np.sin(angle), 1e-6)
        small = angle < 1e-3
        first = np.where(small, 1.0 + angle**2 / 6.0, angle / sine)
        then = np.where(small, 1.0 / 6.0, 0.5 * (sine - angle * cosine) / sine**3)
        rotated = np.einsum("mi,mij->mj", seen.skew, seen.angular)
        value = value + 0.5 * turn**2 * angle**2
        slope = slope - 0.5 * turn**2 * first[:, None] * rotated
        bent = first[:, None, None] * seen.chord_second() + then[:, None, None] * rotated[:, :, None] * rotated[:, None]
        curve = curve + 0.5 * turn**2 * bent
    return value, slope, curve


def descended(wanted: Wanted, q: Array, bounds: Array, place: float, turn: float, rounds: int) -> Array:
    """Local minima (m, n) of the misfit inside bounds (n, 2), downhill from ``q`` (m, n)."""
    unit, q = wanted.unit, q.copy()
    low, high = bounds.T
    todo = np.arange(len(q))
    damping = np.full(len(q), 1e-3)
    # One part alone falls to zero, and near a fold its gradient does so much sooner.
    settled = _SETTLED * (1.0 + place**2) if place and turn else _SETTLED * 1e-6
    value, slope, curve = _misfit(_seen(wanted, q), place, turn)
    for _ in range(rounds):
        here = q[todo]
        rests = ((here <= low) & (slope > 0.0)) | ((here >= high) & (slope < 0.0))
        slope_free = np.where(rests, 0.0, slope)
        moving = np.abs(slope_free).max(axis=1) > settled
        if not moving.all():
            if not moving.any():
                break
            todo, here, rests = todo[moving], here[moving], rests[moving]
            value, slope, curve, slope_free = value[moving], slope[moving], curve[moving], slope_free[moving]
            damping = damping[moving]
        step = -_solved(curve, slope_free, rests, damping)
        step *= np.minimum(1.0, _LONGEST / np.maximum(np.abs(step).max(axis=1, keepdims=True), 1e-300))
        tried = np.clip(here + step * unit, low, high)
        new, new_slope, new_curve = _misfit(_seen(wanted[todo], tried), place, turn)
        better = new <= value
        q[todo[better]] = tried[better]
        value = np.where(better, new, value)
        slope = np.where(better[:, None], new_slope, slope)
        curve = np.where(better[:, None, None], new_curve, curve)
        # What no step improves any more has arrived, to rounding.
        damping = np.where(better, 0.05 * damping, 20.0 * np.maximum(damping, 1e-9))
        stuck = damping > 1e9
        if stuck.any():
            todo, damping = todo[~stuck], damping[~stuck]
            value, slope, curve = value[~stuck], slope[~stuck], curve[~stuck]
            if not len(todo):
                break
    return q


def _solved(curve: Array, slope: Array, rests: NDArray[np.bool_], damping: Array) -> Array:
    """Newton's steps (m, n): curvatures count by their size, and joints that rest have none."""
    free = ~rests
    masked = np.where(free[:, :, None] & free[:, None, :], curve, 0.0)
    masked[:, range(curve.shape[1]), range(curve.shape[1])] += rests
    values, vectors = np.linalg.eigh(masked)
    size = np.abs(values)
    most = size.max(axis=1, keepdims=True)
    size = np.maximum(size, _CURVED * most) + damping[:, None] * np.minimum(1.0, most) + 1e-300
    along = np.einsum("mij,mi->mj", vectors, slope)
    return np.where(rests, 0.0, np.einsum("mij,mj->mi", vectors, along / size))


def constrained(
    wanted: Wanted, q: Array, bounds: Array, first: str, rounds: int = 40
) -> tuple[Array, NDArray[np.bool_]]:
    """Minima of the other part of the misfit among joint vectors that miss nothing of the ``first`` part.

    Newton's method on the conditions of Karush, Kuhn and Tucker from near such a minimum; joints at their limits stay.

    Args:
        wanted: the targets.
        q: (m, n), near minima.
        bounds: (n, 2).
        first: 'position' or 'orientation'.
        rounds: of Newton's method.

    Returns:
        The joint vectors, and whether each is a minimum that misses nothing of the first part.
    """
    unit, q = wanted.unit, q.copy()
    low, high = bounds.T
    rests = (q <= low) | (q >= high)
    good = np.zeros(len(q), dtype=np.bool_)
    todo, pulled = np.arange(len(q)), np.full(len(q), np.inf)
    for _ in range(rounds):
        here, still = q[todo], rests[todo]
        off, slope, curve_of = _parts(_seen(wanted[todo], here), first)
        J = np.where(still[:, None], 0.0, off[1])
        U, s, Vt = np.linalg.svd(J, full_matrices=False)
        kept = s > _RANK * np.maximum(s[:, :1], 1e-12)
        inverse = np.where(kept, 1.0 / np.where(kept, s, 1.0), 0.0)
        Vt = np.where(kept[:, :, None], Vt, 0.0)
        force = -np.einsum("mij,mj->mi", U, inverse * np.einsum("mij,mj->mi", Vt, slope))
        pushed = slope + np.einsum("mij,mi->mj", off[1], force)
        curve = curve_of(force)
        normal = -np.einsum("mji,mj->mi", Vt, inverse * np.einsum("mij,mi->mj", U, off[0]))
        tangent = np.eye(q.shape[1]) - np.swapaxes(Vt, 1, 2) @ Vt
        tangent = np.where(still[:, None] | still[:, :, None], 0.0, tangent)
        values, vectors = np.linalg.eigh(tangent @ curve @ tangent)
        pull = np.einsum("mij,mj->mi", tangent, slope)
        # On the joints that move it has arrived. Those that the misfit draws away from their limits move again.
        least, last = np.abs(pull).max(axis=1), pulled[todo]
        pulled[todo] = least
        settled = (np.abs(off[0]).max(axis=1) < _MISSED) & (
            (least < _SETTLED) | (least < _LOOSE) & (least >= 0.5 * last)
        )
        drawn = still & np.where(here <= low, pushed < -_LOOSE, pushed > _LOOSE) & settled[:, None]
        done = settled & ~drawn.any(axis=1)
        good[todo[done]] = values[done, 0] > -_FLAT
        pull = pull + np.einsum("mij,mj->mi", tangent, np.einsum("mij,mj->mi", curve, normal))
        flat = np.abs(values) <= _CURVED * np.abs(values).max(axis=1, keepdims=True)
        along = np.where(flat, 0.0, np.einsum("mij,mi->mj", vectors, pull) / np.where(flat, 1.0, np.abs(values)))
        step = normal - np.einsum("mij,mj->mi", tangent, np.einsum("mij,mj->mi", vectors, along))
        step *= np.minimum(1.0, _NEAR / np.maximum(np.abs(step).max(axis=1, keepdims=True), 1e-300))
        moved = np.clip(here + step * unit, low, high)
        q[todo[~done]] = moved[~done]
        rests[todo] = ((moved <= low) | (moved >= high)) & ~drawn
        todo = todo[~done]
        if not len(todo):
            break
    return q, good


def _parts(seen: _Seen, first: str) -> tuple[tuple[Array, Array], Array, Callable[[Array], Array]]:
    """The first part's error and its derivatives, the other part's gradient, and the Lagrangian's Hessian."""
    if first == "position":
        slope = -0.5 * np.einsum("mi,mij->mj", seen.skew, seen.angular)
        return (seen.off, seen.linear), slope, lambda force: 0.5 * seen.chord_second() + seen.place_second(force)
    linear = seen.linear
    J = 0.5 * (np.trace(seen.A, axis1=1, axis2=2)[:, None, None] * seen.angular - seen.A @ seen.angular)
    curve = np.swapaxes(linear, 1, 2) @ linear + seen.place_second(seen.off)

    def curve_of(force: Array) -> Array:
        # Of products of small rotations: half the cross product of their vectors.
        return np.asarray(curve + seen.second(0.5 * np.cross(force[:, :, None], seen.w, axis=1), seen.w))

    return (-0.5 * seen.skew, J), np.einsum("mi,mij->mj", seen.off, linear), curve_of
