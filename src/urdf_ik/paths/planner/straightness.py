"""Proof that the tip stays close to the straight segment between waypoints while the joints move linearly.

Let e(s) be the difference between the tip's position while the joints move by s dq and the point on the segment at the
share s. It vanishes at both ends, and its second derivative is that of the tip's position, at most
sum over joints j <= k of (2 - [j = k]) |dq_j| |dq_k| r_k, where r_k is the greatest distance of the tip from axis k,
or 1 if joint k slides; the term is 0 if joint j slides. A function that is at most E at the ends of a piece of length h
and whose second derivative is at most M is at most E + M h^2 / 8 on it. The same holds for the matrix
R_segment(s)^T R(s), whose second derivative is at most w^2 + w', w being the greatest difference of the two angular
velocities and w' that of its rate; its distance from the identity is 2 sin(angle / 2).

With a free axis of the tip, only a point on it and its direction d count. The bound of the position holds for the
point, and that of the rotation for R_segment(s)^T R(s) d: its distance from d is 2 sin(angle / 2), with the angle
between the two directions. A point that is not the tip's origin moves on a
curve along the segment: its second derivative, at most its distance from the origin times the square of the segment's
rotation, is added to the bound of the position.

A motion that leaves the tolerance is bisected (``bisected``): the arm is solved at the middle of the segment, and the
solution nearest to the middle of the motion is inserted. Every piece is proven in the end, so no jump to another
branch passes.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from urdf_ik.ik.solver import Solver
from urdf_ik.kinematics.chain import Chain
from urdf_ik.paths.planner.nodes import WIDEST_STEP, Joints, chosen, joined, nearest_solutions
from urdf_ik.paths.waypoints import interpolated, twists
from urdf_ik.support.angles import shortest
from urdf_ik.typing import Array

Mask = NDArray[np.bool_]

BETWEEN_SAMPLES = 0.25
"""Fraction of the tolerance left for the bound between samples; the samples must stay within the rest."""
MOST_SAMPLES = 256
"""A motion that needs more samples than this for its proof is rejected."""
MOST_BISECTIONS = 8
"""Most successive bisections of the segment between two waypoints."""
_BATCH = 1 << 15
"""Most poses that are sampled in one call."""


def scaled(tolerance: tuple[float, float], factor: float) -> tuple[float, float]:
    """A tolerance (m, rad) multiplied by a factor, the rotation at most 1 rad."""
    return tolerance[0] * factor, min(tolerance[1] * factor, 1.0)


def keeps_straight(
    solver: Solver,
    q: Array,
    dq: Array,
    T: Array,
    waypoint: NDArray[np.intp],
    turns: Array,
    tolerance: tuple[float, float],
) -> Mask:
    """Whether linear joint motions stay within a tolerance of the straight segments between waypoints.

    Args:
        solver: the arm's solver; the rotation about its free axis does not count.
        q: (k, n) rad or m, starts of the motions.
        dq: (k, n) rad or m; q + dq are solutions of the following waypoints.
        T: (m, 4, 4) m, waypoints.
        waypoint: (k,) number of the waypoint at which each motion starts.
        turns: (m - 1, 3) rad, rotation vectors from each waypoint to the next, in base axes.
        tolerance: of the tip (m, rad).

    Returns:
        (k,) true where it is proven.
    """
    lever = 0.0 if solver.free_axis is None else float(np.linalg.norm(solver.free_axis.at))
    position, rotation = curvature(solver.chain, q, dq, np.linalg.norm(turns, axis=1)[waypoint], lever)
    most, allowed = tolerance[0], 2.0 * np.sin(0.5 * tolerance[1])
    # Without samples the bound may use the whole tolerance.
    straight = (position <= 8.0 * most) & (rotation <= 8.0 * allowed)
    share = np.maximum(position / most, rotation / allowed) / (8.0 * BETWEEN_SAMPLES)
    pieces = np.exp2(np.ceil(0.5 * np.log2(np.maximum(share, 1.0)))).clip(2.0)

    def samples_within(k: NDArray[np.intp], count: int) -> Mask:
        """Whether the samples at odd multiples of 1 / count are within 1 - ``BETWEEN_SAMPLES`` of the tolerance."""
        shares = np.arange(1, count, 2) / count
        real = solver.chain.fk(q[k, None] + shares[:, None] * dq[k, None])
        segments, place = np.unique(waypoint[k], return_inverse=True)
        ideal = interpolated(T[segments, None], T[segments + 1, None], shares, turns[segments, None])[place]
        share = 1.0 - BETWEEN_SAMPLES
        if solver.free_axis is None:
            off = real[..., :3, 3] - ideal[..., :3, 3]
            # The Frobenius norm of R - I is sqrt(8) sin(angle / 2), sqrt(2) times 2 sin(angle / 2).
            turned = np.sqrt(0.5) * (real[..., :3, :3] - ideal[..., :3, :3]).reshape(*off.shape[:-1], 9)
        else:
            off, turned = np.moveaxis((real - ideal)[..., :3, :] @ solver.free_axis.seen, -1, 0)
        near = np.einsum("...i,...i", off, off) <= (share * most) ** 2
        near &= np.einsum("...i,...i", turned, turned) <= (share * allowed) ** 2
        return np.asarray(near.all(axis=1))

    undecided, count = ~straight & (pieces <= MOST_SAMPLES), 2
    while undecided.any():
        here = np.flatnonzero(undecided)
        parts = np.array_split(here, 1 + len(here) * count // _BATCH)
        within = np.concatenate([samples_within(k, count) for k in parts])
        done = pieces[here] <= count
        straight[here[within & done]] = True
        undecided[here[~within | done]] = False
        count *= 2
    return np.asarray(straight)


def curvature(chain: Chain, q: Array, dq: Array, turn: Array, lever: float = 0.0) -> tuple[Array, Array]:
    """Bounds of the second derivatives of position [m] and rotation [rad], (k,) each; see the module.

    Args:
        chain: the arm's joints.
        q: (k, n) rad or m, starts.
        dq: (k, n) rad or m, motions.
        turn: (k,) rad, rotation along the segment.
        lever: distance of the controlled point from the tip's origin [m].
    """
    axes = chain.axes
    gain = getattr(chain, "gain", None)
    values, steps = (q, np.abs(dq)) if gain is None else (q @ gain.T, np.abs(dq) @ np.abs(gain).T)
    lengths = np.linalg.norm(axes.P[1:], axis=1)
    lengths[-1] += lever
    lengths = lengths + np.where(axes.prismatic, np.abs(values) + steps, 0.0)
    # Distance from each axis to the tip: the sum of the offsets and slides after it.
    reach = np.where(axes.prismatic, 1.0, np.cumsum(lengths[:, ::-1], axis=1)[:, ::-1])
    turning = np.where(axes.prismatic, 0.0, steps)
    before = np.cumsum(turning, axis=1) - turning
    position = (steps * reach * (2.0 * before + turning)).sum(axis=1) + lever * turn * turn
    rate = turning.sum(axis=1) + turn
    return position, rate * rate + (turning * before).sum(axis=1) + turn * rate


def bisected(
    solver: Solver,
    joints: Joints,
    q: Array,
    dq: Array,
    value: Array,
    T0: Array,
    T1: Array,
    tolerance: tuple[float, float],
) -> tuple[Mask, list[tuple[Array, Array]]]:
    """Insert joint vectors into motions, so that every piece stays within a tolerance of the straight segment.

    Args:
        solver: the arm's solver.
        joints: the arm's joints.
        q: (k, n) rad or m, starts of the motions.
        dq: (k, n) rad or m, motions.
        value: (k, 2) redundancy parameter at both ends; ignored for an arm without one.
        T0: (k, 4, 4) m, poses of q.
        T1: (k, 4, 4) m, poses of q + dq.
        tolerance: of the tip.

    Returns:
        (k,) whether it succeeded; for each motion the shares of the segment and the joint vectors inserted there.
    """
    turns = twists(T0, T1)[:, 3:]
    done = np.ones(len(q), dtype=np.bool_)
    inserted: list[list[tuple[float, Array]]] = [[] for _ in q]
    pieces = _Pieces(np.arange(len(q)), np.zeros(len(q)), np.ones(len(q)), q, dq, value)
    for depth in range(MOST_BISECTIONS):
        pieces = chosen(pieces, done[pieces.motion])
        if not len(pieces.motion):
            break
        motion = pieces.motion
        share = 0.5 * (pieces.start + pieces.end)
        middle = interpolated(T0[motion], T1[motion], share, turns[motion])
        steps = pieces.value[:, 1] - pieces.value[:, 0]
        if solver.parameter is not None and solver.parameter.round:
            steps = shortest(steps)
        half_value = pieces.value[:, 0] + 0.5 * steps
        wanted = pieces.q + 0.5 * pieces.dq
        values = None if solver.parameter is None else half_value[:, None]
        c, distance = nearest_solutions(solver, joints, middle, wanted, values)
        halves = np.maximum(np.abs(c - pieces.q).max(axis=1), np.abs(pieces.q + pieces.dq - c).max(axis=1))
        good = np.isfinite(distance) & (halves <= WIDEST_STEP)
        done[motion[~good]] = False
        for k in np.flatnonzero(good):
            inserted[motion[k]].append((float(share[k]), c[k]))
        first, last = pieces.value.T
        left = _Pieces(motion, pieces.start, share, pieces.q, c - pieces.q, np.column_stack([first, half_value]))
        right = _Pieces(motion, share, pieces.end, c, pieces.q + pieces.dq - c, np.column_stack([half_value, last]))
        both = chosen(joined((left, right)), np.tile(good, 2))
        pieces = chosen(both, ~_pieces_straight(solver, both, T0, T1, turns, tolerance))
        if depth == MOST_BISECTIONS - 1:
            done[pieces.motion] = False
    ordered = []
    for pairs in inserted:
        pairs.sort(key=lambda pair: pair[0])
        ordered.append((np.array([s for s, _ in pairs]), np.array([x for _, x in pairs]).reshape(-1, solver.dof)))
    return done, ordered


class _Pieces(NamedTuple):
    """Pieces of motions: whose (k,); start and end as shares of the segment; q and dq (k, n); values (k, 2)."""

    motion: NDArray[np.int64]
    start: Array
    end: Array
    q: Array
    dq: Array
    value: Array


def _pieces_straight(
    solver: Solver, pieces: _Pieces, T0: Array, T1: Array, turns: Array, tolerance: tuple[float, float]
) -> Mask:
    """Whether each piece stays within the tolerance of its part of the segment."""
    motion = pieces.motion
    ends = np.empty((2 * len(motion), 4, 4))
    ends[0::2] = interpolated(T0[motion], T1[motion], pieces.start, turns[motion])
    ends[1::2] = interpolated(T0[motion], T1[motion], pieces.end, turns[motion])
    turn = np.zeros((max(2 * len(motion) - 1, 0), 3))
    turn[0::2] = (pieces.end - pieces.start)[:, None] * turns[motion]
    first = 2 * np.arange(len(motion))
    return keeps_straight(solver, pieces.q, pieces.dq, ends, first, turn, tolerance)
