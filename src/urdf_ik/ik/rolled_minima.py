"""Nearest postures of a yaw, three parallel axes across it, and a roll whose axis misses the tip: SO-101 and its kind.

With the roll held, the arm is that of :mod:`urdf_ik.ik.closed_minima`: an arc of angles of the last link can be
reached, or two, and the misfit is a sinusoid of that angle. Uphill from each end of the arcs there is one maximum of
the fit, a function of the roll alone, which is scanned and then refined by parabolas.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from urdf_ik.ik.closed_minima import Complex, Found, Planar
from urdf_ik.ik.descent import Wanted, constrained
from urdf_ik.ik.minima import EXACT, distinct, missed
from urdf_ik.kinematics.chain import Chain
from urdf_ik.support.angles import TURN
from urdf_ik.typing import Array

_SCANNED = 24
"""Values of the roll at which the fit is computed."""
_WIDTHS = (0.2, 0.06, 0.02, 6e-3, 1.5e-3)
"""rad: half widths of the parabolas, one after the other."""
_SHORT = 0.1
"""Cosine: targets that are missed by less at all rolls of a scan may be reached between them."""
_BESIDE = 0.05
"""Share of the size: tips that miss the roll's axis by more are searched."""
_EXACTLY = 3.0 - 1e-3
"""Trace of the rotation that is missed: above it, a target is nearly reached."""
_NEARLY = 1e-3
"""rad: axes that miss the structure by no more are taken for it."""
_SIDES = np.array([1.0, -1.0])
_ENDS = np.array([1.0, -1.0, 1.0, -1.0])
"""Sides of the arcs' ends, the two near the direction of the wrist first."""
_INWARDS = np.array([1.0, -1.0, -1.0, 1.0])


class _Fit(NamedTuple):
    """Of k targets: the fit (k, 5) uphill from the ends of the arcs, and how the arm is there.

    ``short`` is by how much the cosine of the last link's angle misses what it can be.
    """

    value: Array
    last: Array
    yaw: Array
    to_wrist: Complex
    link: Complex
    short: Array


@dataclass(frozen=True, eq=False)
class Rolled:
    """An arm of this kind.

    Attributes:
        planar: the arm with its tip moved onto the roll's axis.
        offset: (3,) m, of the tip from there, in the frame of ``planar``, at the zero configuration.
        axis: (3,) of the roll in that frame.
    """

    planar: Planar
    offset: Array
    axis: Array

    @classmethod
    def of(cls, chain: Chain) -> Rolled | None:
        """None for other arms."""
        if chain.n != 5 or chain.prismatic.any():
            return None
        h, tip = chain.H[4], chain.P.sum(axis=0)
        offset = tip - chain.points[4]
        offset = offset - (offset @ h) * h
        planar = Planar.of(chain, 4, tip - offset, _NEARLY) if np.linalg.norm(offset) < _BESIDE * chain.size else None
        return None if planar is None else cls(planar, planar.frame @ offset, planar.frame @ h)

    def __call__(self, wanted: Wanted) -> Found:
        """Minima for targets (m), and whether there are any; that they are all is not proven."""
        planar, m = self.planar, len(wanted.place)
        chain, h = planar.chain, self.axis
        place = (wanted.place - chain.points[0]) @ planar.frame.T
        # There the yaw turns by half a turn within a small range of rolls: left to the search.
        near_yaw = np.hypot(place[:, 0], place[:, 1]) < abs(planar.aside) + 1.2 * np.linalg.norm(self.offset)
        G = planar.frame @ wanted.matrix @ (planar.frame @ chain.R_tip).T
        along = (G @ h)[:, :, None] * h
        parts = np.stack([along, G - along, np.cross(h, G)], axis=1)
        owner, side, psi, end, narrow = self._scan(place, parts, _SCANNED)
        if narrow.any():
            finer = self._scan(place[narrow], parts[narrow], 10 * _SCANNED)
            wide, at = ~narrow[owner], np.flatnonzero(narrow)[finer[0]]
            pairs = zip((owner, side, psi, end), (at, *finer[1:]), strict=False)
            owner, side, psi, end = (np.concatenate([a[wide], b]) for a, b in pairs)
        place, parts, row = place[owner], parts[owner], np.arange(len(owner))
        before = psi
        for width in _WIDTHS:
            low, here, high = (
                self._fit(place, parts, _SIDES[side], psi + shift).value[row, end] for shift in (-width, 0.0, width)
            )
            psi = np.where(np.isfinite(here), psi, before)
            inner = np.isfinite(low) & np.isfinite(high) & np.isfinite(here)
            low, here, high = (np.where(inner, each, 0.0) for each in (low, here, high))
            bend = low + high - 2.0 * here
            settled = inner & (bend < 0.0)
            step = np.where(settled, 0.5 * width * (low - high) / np.where(settled, bend, 1.0), 0.0)
            psi, before = psi + np.clip(step, -width, width), psi
        fit = self._fit(place, parts, _SIDES[side], psi)
        # Newton's method for maxima where links are stretched, where the curvature jumps as a maximum leaves an end,
        # and where nearly nothing is missed, so that the angle is no smooth function.
        value = fit.value[row, end]
        there, settled = np.isfinite(value), settled & (np.abs(step) < width) & (value < _EXACTLY)
        last = fit.last[row, end]
        v = fit.to_wrist - np.exp(1j * last) * fit.link
        q = np.concatenate(
            [
                np.column_stack([planar.joints(fit.yaw, np.column_stack([planar.elbows(v, bent), last])), psi])
                for bent in _SIDES
            ]
        )
        edge, keep = np.tile(~settled & there, 2), np.tile(there, 2)
        owner = np.tile(owner, 2)
        if edge.any():
            free = np.full((5, 2), [-np.inf, np.inf])
            q[edge], good = constrained(wanted[owner[edge]], q[edge], free, "position", 12)
            keep[edge] = good
        owner = owner[keep]
        q = _placed(wanted[owner], q[keep])
        q, owner = distinct(wanted, q, owner)
        found = np.zeros(m, dtype=np.bool_)
        reached = missed(wanted[owner], q)[0] < EXACT
        found[owner[reached]] = True
        found &= ~near_yaw
        return q[reached], owner[reached], found

    def _scan(self, place: Array, parts: Array, count: int) -> tuple[Any, ...]:
        """Maxima over rolls: targets, sides, rolls, ends; and targets (m,) that only some rolls reach."""
        roll = np.arange(count) * (TURN / count)
        number, which, index = (each.reshape(-1) for each in np.indices((len(place), 2, count)))
        fit = self._fit(place[number], parts[number], _SIDES[which], roll[index])
        value = fit.value.reshape(-1, 2, count, 5)
        best = np.isfinite(value) & (value >= np.roll(value, 1, 2)) & (value > np.roll(value, -1, 2))
        owner, side, at, end = np.nonzero(best)
        short = fit.short.reshape(-1, 2, count)
        narrow = (short.min(axis=2) < _SHORT) & (short.max(axis=2) > 0.0)
        return owner, side, roll[at], end, narrow.any(axis=1)

    def _fit(self, place: Array, parts: Array, side: Array, roll: Array) -> _Fit:
        planar = self.planar
        c, s = np.cos(roll), np.sin(roll)
        A = parts[:, 0] + c[:, None, None] * parts[:, 1] + s[:, None, None] * parts[:, 2]
        offset = c[:, None] * self.offset + s[:, None] * np.cross(self.axis, self.offset)
        aside, link = planar.aside + offset[:, 1], planar.links[2] + offset[:, 2] + 1j * offset[:, 0]
        room = place[:, 0] ** 2 + place[:, 1] ** 2 - aside**2
        x = np.sqrt(np.maximum(room, 0.0)) * side
        yaw = np.arctan2(place[:, 1], place[:, 0]) - np.arctan2(aside, x)
        w = place[:, 2] + 1j * x - planar.shoulder
        cq, sq = np.cos(yaw), np.sin(yaw)
        cosine = cq * A[:, 0, 0] + sq * A[:, 1, 0] + A[:, 2, 2]
        sine = cq * A[:, 0, 2] + sq * A[:, 1, 2] - A[:, 2, 0]
        best, base = np.arctan2(sine, cosine), np.angle(w) - np.angle(link)
        span, third = np.abs(w)[:, None], np.abs(link)[:, None]
        first, second = np.abs(planar.links[:2])
        ends = span**2 + third**2 - np.array([first - second, first + second]) ** 2
        ends = ends / np.maximum(2.0 * span * third, 1e-300)
        short = np.maximum(np.maximum(-1.0 - ends[:, 0], ends[:, 1] - 1.0), np.where(room > 0.0, -1.0, 0.5 * _SHORT))
        reached = short <= 0.0
        real = np.abs(ends) < 1.0
        angles = np.arccos(np.clip(ends, -1.0, 1.0))
        # A missing end joins the two arcs.
        long = np.where(
            real[:, 0], np.where(real[:, 1], angles[:, 1] - angles[:, 0], TURN - 2.0 * angles[:, 0]), 2.0 * angles[:, 1]
        )
        start = np.repeat(angles, 2, axis=1) * _ENDS
        way = np.mod(_INWARDS * ((best - base)[:, None] - start), TURN)
        start += _INWARDS * np.where(way < np.pi, np.minimum(way, long[:, None]), 0.0)
        last = np.column_stack([base[:, None] + start, best])
        there = np.column_stack([np.repeat(real, 2, axis=1), ~real.any(axis=1)]) & reached[:, None]
        value = (cq * A[:, 1, 1] - sq * A[:, 0, 1])[:, None] + np.hypot(sine, cosine)[:, None] * np.cos(
            last - best[:, None]
        )
        return _Fit(np.where(there, value, -np.inf), last, yaw, w, link, short)


def _placed(wanted: Wanted, q: Array) -> Array:
    """Joint vectors (k, n) moved by the least motion to the positions of targets."""
    for _ in range(2):
        off = wanted.chain.fk(q)[:, :3, 3] - wanted.place
        J = wanted.chain.jacobian(q)[:, :3]
        q = q - (np.swapaxes(J, 1, 2) @ np.linalg.solve(J @ np.swapaxes(J, 1, 2), off[..., None]))[..., 0]
    return q
