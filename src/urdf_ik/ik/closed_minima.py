"""Nearest postures in closed form: arms whose tip is placed by three joints, or by a yaw and three parallel axes.

The joints behind turn about axes through the tip. The misfit of a rotation about one axis is a sinusoid of its angle;
with two such axes the least misfit is the angle between the last axis and the direction that the target asks of it, a
sinusoid of the first angle. So a branch of the position has its minima where the sinusoid has them, or at its folds.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from urdf_ik.ik.descent import Wanted, constrained
from urdf_ik.ik.families import few_joints
from urdf_ik.ik.minima import EXACT, distinct, missed, ranked
from urdf_ik.ik.task import POSE, Task
from urdf_ik.kinematics.chain import Chain, least_stretches, sampled
from urdf_ik.support.angles import wrapped
from urdf_ik.support.tolerances import DEFAULT
from urdf_ik.typing import Array

_CONTINUUM = 1e-9
"""Share of the size, amplitude of a sinusoid: below this an angle is free, and a minimum is no point."""
_CONTROL = 1e-3
"""Smallest singular value of the position's Jacobian, at the middle one of sampled joint vectors, that is control."""
_STATUS_BITS = np.uint8(96)
_BESIDE = 0.05
"""Share of the size: tips that miss the roll's axis by more are searched."""
_NEARLY = 1e-3
"""rad: axes that miss the structure by no more are taken for it."""
_GRID = 16
"""Angles of the roll of which the best ones are refined."""
_FINER = ((0.75, 7), (0.125, 5), (0.02, 5), (0.0025, 3))
"""Half widths, as shares of the grid's, and numbers of the angles of which each round of refining takes the best."""
_ROUNDS = 20
"""Newton's rounds from there."""
_NEAR_YAW = 3.5
"""Targets nearer to the first axis than so many offsets: Newton's method decides which rolls lead to minima."""
_OUT = -9.0
"""Below any trace."""
_SIDES: Array = np.array([1.0, -1.0])

Complex = NDArray[np.complex128]
Found = tuple[Array, NDArray[np.intp], NDArray[np.bool_]]
"""Joint vectors (k, n), the target of each (k,), and whether they are all minima of a target (m,)."""


def prepare(chain: Chain, asked: Task) -> "Planar | Placed | Beside | None":
    """What finds the minima of the rotation's misfit, the position first; None where no closed form does."""
    if chain.axes is not chain or not (asked.has_place and asked.has_turn):
        return None
    tip = chain.P.sum(axis=0)
    off = np.linalg.norm(np.cross(tip - chain.points, chain.H), axis=1)
    through = (off < DEFAULT.exact_structure * chain.size) & ~chain.prismatic
    most = 2 if asked == POSE else 1
    for front in (4, 3):
        if front <= chain.n <= 2 + front and chain.n - 3 <= most and through[front:].all():
            found = Planar.of(chain, front, tip) or (Placed.of(chain) if front == 3 else None)
            if found is not None:
                return found
    return Beside.of(chain) if asked == POSE else None


def in_closed_form(closed: Callable[[Wanted], Found], wanted: Wanted) -> tuple[Array, NDArray[np.bool_]]:
    """(m, B, n) minima for targets (m), the best first, padded with NaN, and whether they are proven to be all."""
    q, owner, proven = closed(wanted)
    off = missed(wanted[owner], q)[0] < EXACT
    reached = np.zeros(len(proven), dtype=np.bool_)
    reached[owner[off]] = True
    proven[owner[reached[owner] & ~off]] = False
    free = np.full((q.shape[1], 2), [-np.inf, np.inf])
    return ranked(wanted, q, owner, free, lambda off, angle: (off, angle)), proven


@dataclass(frozen=True, eq=False)
class Placed:
    """An arm whose first three joints place the tip, by the compiled solver ``core``."""

    chain: Chain
    core: Any

    @classmethod
    def of(cls, chain: Chain) -> "Placed | None":
        """None where the three joints do not control the position."""
        three = chain.lock(dict.fromkeys(chain.joint_names[3:], 0.0))
        if float(np.median(least_stretches(three, three.jacobian(sampled(three))[:, :3]))) < _CONTROL:
            return None
        return cls(chain, few_joints.prepare_position(three).solver)

    def __call__(self, wanted: Wanted) -> Found:
        """The minima for targets (m); those out of reach have none here."""
        m = len(wanted.place)
        T = np.tile(np.eye(4), (m, 1, 1))
        T[:, :3, 3] = wanted.place
        q, flags = np.full((m, self.core.branches, 3), np.nan), np.zeros((m, self.core.branches), np.uint8)
        self.core.solve(T, None, q, flags)
        valid = flags & np.uint8(1) > 0
        owner, column = np.nonzero(valid)
        q, free = _turned(self.chain, wanted, q[owner, column], owner)
        proven = valid.any(axis=1) & (flags[:, 0] & _STATUS_BITS == 0)
        proven[owner[free]] = False
        return q, owner, proven


@dataclass(frozen=True, eq=False)
class Planar:
    """A yaw and two or three parallel axes across it, which place the tip.

    Points of the plane are complex numbers z + i x, in the frame x, y = the parallel axes, z = the yaw's axis.

    Attributes:
        chain: the arm.
        frame: (3, 3) its rows in the base.
        signs: (front,) +1 or -1, by the direction of each axis.
        aside: y of the tip [m].
        shoulder: the second axis.
        links: (2,) or (3,) from axis to axis, to the tip, at the zero configuration [m].
    """

    chain: Chain
    frame: Array
    signs: Array
    aside: float
    shoulder: complex
    links: Complex

    @classmethod
    def of(cls, chain: Chain, front: int, tip: Array, tolerance: float = DEFAULT.exact_structure) -> "Planar | None":
        """The arm with a ``tip`` (3,); None where the first ``front`` axes are no yaw and parallel axes across it."""
        H, z, y = chain.H[:front], chain.H[0], chain.H[1]
        across = np.abs(H[1:] @ z).max(), np.linalg.norm(np.cross(H[1:], y), axis=1).max()
        if chain.prismatic[:front].any() or max(across) > tolerance:
            return None
        y = y - (y @ z) * z
        y = y / np.linalg.norm(y)
        frame = np.array([np.cross(y, z), y, z])
        points = np.vstack([chain.points[1:front], tip]) - chain.points[0]
        x, aside, up = frame @ points.T
        plane = up + 1j * x
        links = np.diff(plane)
        if np.abs(links).min() < _CONTINUUM * chain.size:
            return None
        d = float(aside[-1])
        d = 0.0 if abs(d) < DEFAULT.exact_structure * chain.size else d
        return cls(chain, frame, np.concatenate([[1.0], np.sign(H[1:] @ y)]), d, plane[0], links)

    def __call__(self, wanted: Wanted) -> Found:
        """The minima for targets (m)."""
        spot = self.frame @ (wanted.place - self.chain.points[0]).T
        far, tiny = np.hypot(spot[0], spot[1]), _CONTINUUM * self.chain.size
        yaw, w = self.planes(spot[..., None], self.aside, _SIDES)
        span, L = np.abs(w), np.abs(self.links)
        hole = max(2.0 * L.max() - L.sum(), 0.0)
        reached = (span >= hole) & (span <= L.sum())
        near = ~reached.any(axis=1)
        proven = (far > abs(self.aside) + tiny) & (span > tiny).all(axis=1) & (~near | (self.aside == 0.0))
        phi, elbow, best = (self._planes if len(L) == 2 else self._bends)(wanted, w, yaw)
        owner, side, kind = np.nonzero(best & reached[:, :, None])
        last = phi[owner, side, kind]
        v = w[owner, side] - (np.exp(1j * last) * self.links[2] if len(L) == 3 else 0.0)
        angles = self.elbows(v, elbow[kind])
        angles = np.concatenate([angles, last[:, None]], axis=1) if len(L) == 3 else angles
        proven[owner[(np.abs(v) < tiny) | np.isnan(last)]] = False
        # Out of reach the links lie on one line, towards the target or, inside of the hole, all but the longest away
        # from it; the tip is on the target's side of the first axis.
        outside = span > L.sum()
        tip = self.shoulder + w / np.maximum(span, tiny) * np.where(outside, L.sum(), hole)
        where, which = np.nonzero(near[:, None] & (np.imag(tip) * _SIDES > 0.0))
        away = ~outside[where, which, None] & (np.arange(len(L)) != np.argmax(L))
        straight = np.angle(w[where, which, None] * np.where(away, -1.0, 1.0)) - np.angle(self.links)
        owner, side = np.concatenate([owner, where]), np.concatenate([side, which])
        q = self.joints(yaw[owner, side], np.concatenate([angles, straight]))
        q, free = _turned(self.chain, wanted, q, owner)
        proven[owner[free]] = False
        return q, owner, proven

    def planes(self, spot: Array, aside: float | Array, side: Array) -> tuple[Array, Complex]:
        """Yaws that bring the tip to points ``spot`` (3, ...) of the frame, and where these are from the shoulder [m].

        Args:
            spot: m, from the first axis.
            aside: y of the tip [m].
            side: of the first axis, 1 or -1.
        """
        x = np.sqrt(np.maximum(spot[0] ** 2 + spot[1] ** 2 - aside**2, 0.0)) * side
        return np.arctan2(spot[1], spot[0]) - np.arctan2(aside, x), spot[2] + 1j * x - self.shoulder

    def elbows(self, v: Complex, side: Array) -> Array:
        """(k, 2) angles of the first two links that end at v (k,) [m] from the shoulder, by the elbow's side."""
        L, span = np.abs(self.links), np.maximum(np.abs(v), 1e-300)
        bend = np.arccos(np.clip((L[0] ** 2 + span**2 - L[1] ** 2) / (2.0 * L[0] * span), -1.0, 1.0)) * side
        first = np.angle(v) - np.angle(self.links[0]) + bend
        return np.stack([first, np.angle(v - np.exp(1j * first) * self.links[0]) - np.angle(self.links[1])], axis=-1)

    def joints(self, yaw: Array, angles: Array) -> Array:
        """Joint vectors (k, front) of yaws (k,) and of the links' angles (k, front - 1)."""
        return np.concatenate([yaw[:, None], np.diff(angles, axis=1, prepend=0.0)], axis=1) * self.signs

    def _planes(self, wanted: Wanted, w: Complex, yaw: Array) -> tuple[Array, Array, NDArray[np.bool_]]:
        """Two links: both elbows."""
        return np.zeros((*w.shape, 2)), np.array([1.0, -1.0]), np.ones((*w.shape, 2), dtype=np.bool_)

    def _bends(self, wanted: Wanted, w: Complex, yaw: Array) -> tuple[Array, Array, NDArray[np.bool_]]:
        """Angles (m, 2, 6) of the last link, the elbows' signs (6,), and which are minima.

        The best angle with both elbows, and the folds: the angles at which the other two links are stretched or folded.
        """
        K = self.frame @ wanted.matrix @ (self.frame @ self.chain.R_tip).T
        if self.chain.n == 5:
            h = self.frame @ self.chain.H[4]
            K = (K @ h)[:, :, None] * h
        cosine, sine, _ = _about_yaw(K.transpose(1, 2, 0)[..., None], yaw)
        best = np.where(np.hypot(sine, cosine) > _CONTINUUM, np.arctan2(sine, cosine), np.nan)
        base, folds, there, inside = self.folds(w, self.links[2], best)
        inside |= np.isnan(best)
        phi = np.concatenate([best[..., None], best[..., None], base[..., None] + folds], axis=-1)
        return (
            phi,
            np.array([1.0, -1.0, 1.0, 1.0, 1.0, 1.0]),
            np.concatenate([inside[..., None], inside[..., None], there], axis=-1),
        )

    def folds(self, w: Complex, last: Any, best: Array) -> tuple[Array, Array, NDArray[np.bool_], NDArray[np.bool_]]:
        """Where the first two of three links are folded or stretched, the third one's angle is an end of its range.

        Args:
            w: (...) of the tip from the shoulder [m].
            last: the third link, complex.
            best: (...) angles at which the third link misses least of the rotation.

        Returns:
            The angles (...) that point the third link at w, the ends (..., 4) of its range from there, NaN where it
            has none, which of them are minima, and where the best angle is inside the range.
        """
        L, span, third = np.abs(self.links), np.maximum(np.abs(w), 1e-300), np.abs(last)
        base = np.angle(w) - np.angle(last)
        cosines = (span**2 + third**2)[..., None] - np.array([L[0] - L[1], L[0] + L[1]]) ** 2
        cosines /= (2.0 * span * third)[..., None]
        least, most = np.moveaxis(np.arccos(np.clip(cosines, -1.0, 1.0)), -1, 0)
        apart = wrapped(best - base)
        inside = (np.abs(apart) >= least) & (np.abs(apart) <= most)
        folds = np.stack([least, -least, most, -most], axis=-1)
        folds[np.repeat(np.abs(cosines) >= 1.0, 2, axis=-1)] = np.nan
        inwards = np.array([1.0, -1.0, -1.0, 1.0])
        return base, folds, np.sin(folds - apart[..., None]) * inwards > 0.0, inside


@dataclass(frozen=True, eq=False)
class Beside:
    """A yaw, three parallel axes and a roll that misses the tip a little: SO-101 and its kind.

    For an angle of the roll the arm is a planar one, so that the minima are those of a function of the roll alone. They
    are looked for on a grid; nothing proves that these are all.

    Attributes:
        chain: the arm.
        planar: the arm with its tip moved onto the roll's axis.
        sides: (2, 3) m, of the tip from there, in the planar arm's frame: at zero, and a quarter turn of the roll on.
    """

    chain: Chain
    planar: Planar
    sides: Array

    @classmethod
    def of(cls, chain: Chain) -> "Beside | None":
        """None for other arms."""
        if chain.n != 5 or chain.prismatic.any():
            return None
        h, tip = chain.H[4], chain.P.sum(axis=0)
        offset = tip - chain.points[4]
        offset = offset - (offset @ h) * h
        if np.linalg.norm(offset) > _BESIDE * chain.size:
            return None
        moved = replace(chain, P=np.vstack([chain.P[:-1], chain.P[-1] - offset]))
        planar = Planar.of(moved, 4, tip - offset, _NEARLY)
        return None if planar is None else cls(chain, planar, np.array([offset, np.cross(h, offset)]) @ planar.frame.T)

    def __call__(self, wanted: Wanted) -> Found:
        """Minima for targets (m), and whether there are any."""
        planar, count = self.planar, len(wanted.place)
        spot = planar.frame @ (wanted.place - self.chain.points[0]).T
        h = planar.frame @ self.chain.H[4]
        K = planar.frame @ wanted.matrix @ (planar.frame @ self.chain.R_tip).T
        along, across = np.outer(h, h), np.cross(h, np.eye(3))
        K = np.array([K @ (np.eye(3) - along), K @ across, K @ along]).transpose(0, 2, 3, 1)
        rolls = np.linspace(-np.pi, np.pi, _GRID, endpoint=False)
        value, inner, nearest = self.bent(K[..., None, None], spot[..., None, None], rolls[:, None], _SIDES)[:3]
        peak = (value >= np.roll(value, 1, axis=1)) & (value > np.roll(value, -1, axis=1)) & (~inner | nearest)
        owner, place, facing, end = np.nonzero(peak)
        K, to, side = K[..., owner], spot[:, owner], _SIDES[facing]
        roll, settled = self.settled(K, to, rolls[place], side, end)
        row = np.arange(len(roll))
        value, inner, _, phi, yaw, w, last = self.bent(K, to, roll, side)
        phi, inner = phi[row, end], inner[row, end]
        # Beside the first axis the yaw turns by half a turn within a small range of rolls.
        near = np.hypot(spot[0], spot[1]) < abs(planar.aside) + _NEAR_YAW * np.linalg.norm(self.sides[0])
        kept = np.flatnonzero((settled & (value[row, end] > _OUT) | near[owner]) & np.isfinite(phi))
        both = np.concatenate([kept, kept[inner[kept]]])
        bend = np.repeat([1.0, -1.0], [len(kept), len(both) - len(kept)])
        angles = planar.elbows((w - np.exp(1j * phi) * last)[both], bend)
        q = planar.joints(yaw[both], np.concatenate([angles, phi[both, None]], axis=1))
        q, owner = np.concatenate([q, roll[both, None]], axis=1), owner[both]
        order = np.argsort(owner, kind="stable")
        q, owner = q[order], owner[order]
        q, good = constrained(wanted[owner], q, np.full((q.shape[1], 2), [-np.inf, np.inf]), "position", _ROUNDS)
        q, owner = distinct(wanted, q[good], owner[good])
        return q, owner, np.bincount(owner, minlength=count) > 0

    def settled(self, K: Array, to: Array, roll: Array, side: Array, end: NDArray[np.intp]) -> tuple[Array, Array]:
        """The rolls (k,) at the tops beside ``roll`` (k,), and whether these are tops of a smooth function."""
        row = np.arange(len(roll))
        for width, count in _FINER:
            grid = 2.0 * np.pi / _GRID * np.linspace(-width, width, count)
            value = self.bent(K[..., None], to[..., None], roll[:, None] + grid, side[:, None])[0]
            value = value[row[:, None], np.arange(count), end[:, None]]
            top = np.argmax(value, axis=1)
            middle = np.clip(top, 1, count - 2)
            before, here, after = (value[row, middle + k] for k in (-1, 0, 1))
            with np.errstate(invalid="ignore"):
                curve, slope = before - 2.0 * here + after, 0.5 * (before - after)
            smooth = np.isfinite(curve) & (curve < 0.0)
            apex = np.divide(slope, curve, out=np.zeros(len(row)), where=smooth)
            shift = grid[middle] + np.clip(apex, -2.0, 2.0) * (grid[1] - grid[0])
            roll = roll + np.where(smooth, shift, grid[top])
        return roll, smooth & (np.abs(apex) < 1.0)

    def bent(self, K: Array, spot: Array, roll: Array, side: Array) -> tuple[Any, ...]:
        """The best angles of the third link for angles of the roll, on each side of the first axis.

        Args:
            K: (3, 3, 3, ...) times cosine, sine and 1 of the roll: the turn of the links that is asked for.
            spot: (3, ...) of the target from the first axis, in the planar arm's frame [m].
            roll: (...) rad.
            side: (...) 1 or -1.

        Returns:
            For each end (..., 4) of the third link's range the trace of the turn that is missed at the end, where that
            is a maximum, or at the best angle, where that is inside, and -inf elsewhere; where it is the best angle;
            whether that is the nearest end; the third link's angle. Then (...) the yaw, the target from the shoulder
            and the third link.
        """
        planar, c, s = self.planar, np.cos(roll), np.sin(roll)
        x, y, z = (c * first + s * then for first, then in self.sides.T)
        yaw, w = planar.planes(spot, planar.aside + y, side)
        last = planar.links[2] + z + 1j * x
        cosine, sine, rest = _about_yaw(c * K[0] + s * K[1] + K[2], yaw)
        best, most = np.arctan2(sine, cosine), np.hypot(sine, cosine)
        base, ends, there, inside = planar.folds(w, last, best)
        gap = base[..., None] + ends - best[..., None]
        inner = inside[..., None] & ~there
        # Where the yaw or the links do not reach there is no trace, but what they lack leads to where they do.
        L, span, third = np.abs(planar.links[:2]), np.abs(w), np.abs(last)
        lack = np.maximum(np.abs(span - third) - L.sum(), abs(L[0] - L[1]) - span - third)
        lack = np.maximum(lack, np.abs(planar.aside + y) - np.hypot(spot[0], spot[1]))[..., None]
        trace = most[..., None] * np.where(inner, 1.0, np.cos(gap)) + rest[..., None]
        value = np.where(lack > 0.0, _OUT - lack, np.where(there | inner, trace, -np.inf))
        nearest = np.arange(4) == np.argmax(np.nan_to_num(np.cos(gap), nan=-2.0), axis=-1)[..., None]
        phi = np.where(inner, best[..., None], base[..., None] + ends)
        return value, inner, nearest, phi, yaw, w, last


def _about_yaw(K: Array, yaw: Array) -> tuple[Array, Array, Array]:
    """Of the trace of K' Rz(yaw) Ry(phi), K (3, 3, ...): the factors of cosine and sine of phi, and the rest."""
    c, s = np.cos(yaw), np.sin(yaw)
    return c * K[0, 0] + s * K[1, 0] + K[2, 2], c * K[0, 2] + s * K[1, 2] - K[2, 0], c * K[1, 1] - s * K[0, 1]


def _turned(chain: Chain, wanted: Wanted, first: Array, owner: NDArray[np.intp]) -> tuple[Array, NDArray[np.bool_]]:
    """Joint vectors (k, n) with the first joints and the best angles of those behind, and where an angle is free."""
    q = np.concatenate([first, np.zeros((len(first), chain.n - first.shape[1]))], axis=1)
    free = np.zeros(len(q), dtype=np.bool_)
    if first.shape[1] == chain.n:
        return q, free
    D = np.swapaxes(chain.fk(q)[:, :3, :3], 1, 2) @ wanted.matrix[owner]
    D = chain.R_tip @ D @ chain.R_tip.T
    for k in range(first.shape[1], chain.n):
        h = chain.H[k]
        K = D
        if k + 1 < chain.n:
            after = chain.H[k + 1]
            K = (D @ after)[:, :, None] * after
        cosine = np.trace(K, axis1=1, axis2=2) - h @ K @ h
        sine = np.stack([K[:, 2, 1] - K[:, 1, 2], K[:, 0, 2] - K[:, 2, 0], K[:, 1, 0] - K[:, 0, 1]], -1) @ h
        free |= np.hypot(sine, cosine) < _CONTINUUM
        q[:, k] = np.arctan2(sine, cosine)
        if k + 1 < chain.n:
            D = np.stack([few_joints.turned(D[:, :, i], h, -q[:, k]) for i in range(3)], axis=-1)
    return q, free
