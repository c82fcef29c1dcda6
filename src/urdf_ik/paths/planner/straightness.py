"""How far the tip strays from the straight segment between waypoints while the joints move linearly: proven bounds.

Let e(s) be the difference between the tip's position while the joints move by s dq and the point on the segment at the
share s. It vanishes at both ends, and its second derivative is that of the tip's position, at most
sum over joints j <= k of (2 - [j = k]) |dq_j| |dq_k| r_k, where r_k is the greatest distance of the tip from axis k; 1
where joint k slides, 0 where joint j does. A function that is at most E at the ends of a piece of length h and whose
second derivative is at most M is at most E + M h^2 / 8 on it. The same holds for the matrix R_segment(s)^T R(s), whose
second derivative is at most w^2 + w', w being the greatest difference of the two angular velocities and w' that of its
rate; its distance from the identity is 2 sin(angle / 2).

With a free axis of the tip, only a point on it and its direction d count: the same bounds hold, r_k reaching to that
point, for R_segment(s)^T R(s) d, whose distance from d is 2 sin(angle / 2), too. The point moves on the segment along a
curve where it is not the tip's origin: its second derivative, at most the point's distance from the origin times the
square of the segment's rotation, adds to the bound of the position.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from urdf_ik.kinematics.chain import Chain
from urdf_ik.kinematics.chain.free_axis import FreeAxis
from urdf_ik.paths.waypoints import interpolated
from urdf_ik.typing import Array

Mask = NDArray[np.bool_]

PROVEN = 0.25
"""Share of a tolerance that the bound between two samples may take; the samples must keep within the rest."""
MOST_PIECES = 256
"""A motion that needs more samples counts as one that strays."""
_BATCH = 1 << 15


@dataclass(frozen=True)
class Tolerance:
    """How far a motion may stray from the straight segment between two waypoints.

    Attributes:
        position: m.
        rotation: rad.
    """

    position: float
    rotation: float

    def times(self, factor: float) -> Tolerance:
        """A tolerance so many times as large, the rotation at most one radian."""
        return Tolerance(self.position * factor, min(self.rotation * factor, 1.0))


def keeps_straight(
    chain: Chain,
    q: Array,
    dq: Array,
    T: Array,
    at: NDArray[np.intp],
    turns: Array,
    tolerance: Tolerance,
    free: FreeAxis | None = None,
) -> Mask:
    """Whether linear joint motions keep within a tolerance of the straight segments between waypoints.

    Args:
        chain: the arm's joints.
        q: (k, n) rad or m, starts of the motions, at the waypoints ``at``.
        dq: (k, n) rad or m; q + dq are at the waypoints after them.
        T: (m, 4, 4) m, waypoints.
        at: (k,) number of the waypoint that each motion starts at.
        turns: (m - 1, 3) rad, rotation vectors from each waypoint to the next, in base axes.
        tolerance: see :class:`Tolerance`.
        free: a line in the tip about which any rotation will do.

    Returns:
        (k,) true where it is proven.
    """
    lever = 0.0 if free is None else float(np.linalg.norm(free.at))
    position, rotation = curvature(chain, q, dq, np.linalg.norm(turns, axis=1)[at], lever)
    allowed = 2.0 * np.sin(0.5 * tolerance.rotation)
    # Without a sample, the bound may take the whole tolerance.
    straight = (position <= 8.0 * tolerance.position) & (rotation <= 8.0 * allowed)
    share = np.maximum(position / tolerance.position, rotation / allowed) / (8.0 * PROVEN)
    pieces = np.exp2(np.ceil(0.5 * np.log2(np.maximum(share, 1.0)))).clip(2.0)
    undecided, count = ~straight & (pieces <= MOST_PIECES), 2
    while undecided.any():
        here = np.flatnonzero(undecided)
        within = np.concatenate(
            [
                _samples_within(chain, q[k], dq[k], T, at[k], turns, count, tolerance, allowed, free)
                for k in np.array_split(here, 1 + len(here) * count // _BATCH)
            ]
        )
        done = pieces[here] <= count
        straight[here[within & done]] = True
        undecided[here[~within | done]] = False
        count *= 2
    return np.asarray(straight)


def curvature(chain: Chain, q: Array, dq: Array, turn: Array, lever: float = 0.0) -> tuple[Array, Array]:
    """Bounds of the second derivatives, see above: of the position [m] and of the rotation, (k,) each.

    Args:
        chain: the arm's joints.
        q: (k, n) rad or m.
        dq: (k, n) rad or m.
        turn: (k,) rad that the segment turns by.
        lever: m from the tip to the point in it whose position counts.
    """
    axes = chain.axes
    gain = getattr(chain, "gain", None)
    values, steps = (q, np.abs(dq)) if gain is None else (q @ gain.T, np.abs(dq) @ np.abs(gain).T)
    lengths = np.linalg.norm(axes.P[1:], axis=1)
    lengths[-1] += lever
    lengths = lengths + np.where(axes.prismatic, np.abs(values) + steps, 0.0)
    # From each axis to the tip: the steps after it, and the slides.
    reach = np.where(axes.prismatic, 1.0, np.cumsum(lengths[:, ::-1], axis=1)[:, ::-1])
    turning = np.where(axes.prismatic, 0.0, steps)
    before = np.cumsum(turning, axis=1) - turning
    position = (steps * reach * (2.0 * before + turning)).sum(axis=1) + lever * turn * turn
    rate = turning.sum(axis=1) + turn
    return position, rate * rate + (turning * before).sum(axis=1) + turn * rate


def _samples_within(
    chain: Chain,
    q: Array,
    dq: Array,
    T: Array,
    at: NDArray[np.intp],
    turns: Array,
    count: int,
    tolerance: Tolerance,
    allowed: float,
    free: FreeAxis | None,
) -> Mask:
    """Whether the samples at odd multiples of 1 / count keep within 1 - ``PROVEN`` of a tolerance."""
    shares = np.arange(1, count, 2) / count
    real = chain.fk(q[:, None] + shares[:, None] * dq[:, None])
    segments, place = np.unique(at, return_inverse=True)
    ideal = interpolated(T[segments, None], T[segments + 1, None], shares, turns[segments, None])[place]
    left = 1.0 - PROVEN
    if free is None:
        off = real[..., :3, 3] - ideal[..., :3, 3]
        # The Frobenius norm of R - I is sqrt(8) sin(angle / 2), which is sqrt(2) times the distance above.
        turned = np.sqrt(0.5) * (real[..., :3, :3] - ideal[..., :3, :3]).reshape(*off.shape[:-1], 9)
    else:
        off, turned = np.moveaxis((real - ideal)[..., :3, :] @ free.seen, -1, 0)
    return np.asarray(
        (
            (np.einsum("...i,...i", off, off) <= (left * tolerance.position) ** 2)
            & (np.einsum("...i,...i", turned, turned) <= (left * allowed) ** 2)
        ).all(axis=1)
    )
