"""Nearest postures in closed form: arms whose tip is placed by three joints, or by a yaw and three parallel axes.

The joints behind turn about axes through the tip. The misfit of a rotation about one axis is a sinusoid of its angle;
with two such axes the least misfit is the angle between the last axis and the direction that the target asks of it, a
sinusoid of the first angle. So a branch of the position has its minima where the sinusoid has them, or at its folds.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from urdf_ik.ik.descent import Wanted, constrained, descended
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
_ROUNDS = 20
"""Newton's rounds from a minimum of the arm without the offset."""
_FIRST = 100.0
"""Weight of the position where Newton's method does not lead to a minimum with the exact position at once."""
_NEAR_YAW = 3.5
"""Targets that are nearer to the first axis than so many offsets are searched."""

Complex = NDArray[np.complex128]
Found = tuple[Array, NDArray[np.intp], NDArray[np.bool_]]
"""Joint vectors (k, n), the target of each (k,), and whether they are all minima of a target (m,)."""


def prepare(chain: Chain, asked: Task) -> Planar | Placed | None:
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
    return None


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
    def of(cls, chain: Chain) -> Placed | None:
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
    def of(cls, chain: Chain, front: int, tip: Array, tolerance: float = DEFAULT.exact_structure) -> Planar | None:
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
        X, Y, Z = self.frame @ (wanted.place - self.chain.points[0]).T
        far, tiny = np.hypot(X, Y), _CONTINUUM * self.chain.size
        x = np.sqrt(np.maximum(far**2 - self.aside**2, 0.0))[:, None] * [1.0, -1.0]
        yaw = np.arctan2(Y, X)[:, None] - np.arctan2(self.aside, x)
        w = Z[:, None] + 1j * x - self.shoulder
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
        where, which = np.nonzero(near[:, None] & (np.imag(tip) * x > 0.0))
        away = ~outside[where, which, None] & (np.arange(len(L)) != np.argmax(L))
        straight = np.angle(w[where, which, None] * np.where(away, -1.0, 1.0)) - np.angle(self.links)
        owner, side = np.concatenate([owner, where]), np.concatenate([side, which])
        q = self.joints(yaw[owner, side], np.concatenate([angles, straight]))
        q, free = _turned(self.chain, wanted, q, owner)
        proven[owner[free]] = False
        return q, owner, proven

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
        R = self.frame @ self.chain.R_tip
        K = self.frame @ wanted.matrix @ R.T
        if self.chain.n == 5:
            h = self.frame @ self.chain.H[4]
            K = (K @ h)[:, :, None] * h
        c, s = np.cos(yaw), np.sin(yaw)
        cosine = c * K[:, None, 0, 0] + s * K[:, None, 1, 0] + K[:, None, 2, 2]
        sine = c * K[:, None, 0, 2] + s * K[:, None, 1, 2] - K[:, None, 2, 0]
        best = np.where(np.hypot(sine, cosine) > _CONTINUUM, np.arctan2(sine, cosine), np.nan)
        L, span = np.abs(self.links), np.maximum(np.abs(w), 1e-300)
        base = np.angle(w) - np.angle(self.links[2])
        # Cosines of the last link's angle to w, at which the others are folded and stretched.
        ends = (span**2 + L[2] ** 2)[..., None] - np.array([L[0] - L[1], L[0] + L[1]]) ** 2
        ends /= (2.0 * span * L[2])[..., None]
        least, most = np.moveaxis(np.arccos(np.clip(ends, -1.0, 1.0)), -1, 0)
        apart = np.abs(wrapped(best - base))
        inside = (apart >= least) & (apart <= most) | np.isnan(best)
        inwards = np.array([1.0, -1.0, -1.0, 1.0])
        folds = base[..., None] + np.stack([least, -least, most, -most], axis=-1)
        there = np.repeat(np.abs(ends) < 1.0, 2, axis=-1) & (np.sin(folds - best[..., None]) * inwards > 0.0)
        phi = np.concatenate([best[..., None], best[..., None], folds], axis=-1)
        return (
            phi,
            np.array([1.0, -1.0, 1.0, 1.0, 1.0, 1.0]),
            np.concatenate([inside[..., None], inside[..., None], there], axis=-1),
        )


@dataclass(frozen=True, eq=False)
class Beside:
    """A yaw, three parallel axes and a roll that misses the tip a little: SO-101 and its kind.

    The minima of the arm whose tip is on the roll's axis lead to those of the arm by Newton's method; nothing proves
    that these are all.

    Attributes:
        chain: the arm.
        planar: the arm with its tip moved onto the roll's axis.
        sides: (4, 3) m, of the tip from there, in the tip's frame: as it is, and by quarter turns of the roll.
    """

    chain: Chain
    planar: Planar
    sides: Array

    @classmethod
    def of(cls, chain: Chain) -> Beside | None:
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
        across = np.cross(h, offset)
        return (
            None if planar is None else cls(chain, planar, np.array([offset, across, -offset, -across]) @ chain.R_tip)
        )

    def __call__(self, wanted: Wanted) -> Found:
        """Minima for targets (m), and whether there are any."""
        moved = replace(wanted, chain=self.planar.chain)
        sides = [self.planar(replace(moved, place=wanted.place - wanted.matrix @ side)) for side in self.sides]
        q, owner = (np.concatenate(each) for each in list(zip(*sides, strict=True))[:2])
        order = np.argsort(owner, kind="stable")
        start, owner = q[order], owner[order]
        free = np.full((q.shape[1], 2), [-np.inf, np.inf])
        q, good = constrained(wanted[owner], start, free, "position", _ROUNDS)
        if not good.all():
            rest = wanted[owner[~good]]
            near = descended(rest, start[~good], free, _FIRST, 1.0, _ROUNDS)
            q[~good], good[~good] = constrained(rest, near, free, "position", _ROUNDS)
        q, owner = distinct(wanted, q[good], owner[good])
        there = np.zeros(len(wanted.place), dtype=np.bool_)
        there[owner] = True
        # Beside the first axis the yaw turns by half a turn within a small range of rolls: left to the search.
        away = np.linalg.norm(np.cross(wanted.place - self.chain.points[0], self.chain.H[0]), axis=1)
        return q, owner, there & (away > abs(self.planar.aside) + _NEAR_YAW * np.linalg.norm(self.sides[0]))


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
