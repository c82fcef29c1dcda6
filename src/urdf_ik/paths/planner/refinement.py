"""Bisection of motions whose tip strays too far from the straight segment while the joints move linearly.

In the middle of the segment the arm is solved anew, and the solution nearest to the middle of the motion is taken. Each
half is then a motion of its own, cut again where it strays too far. Every piece is proven in the end, so that no jump
to another branch passes.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from urdf_ik.ik.pose_solving import solve
from urdf_ik.ik.redundancy.values import nearest_values
from urdf_ik.ik.solver import Solver
from urdf_ik.paths.planner.joint_steps import Joints
from urdf_ik.paths.planner.straightness import Tolerance, keeps_straight
from urdf_ik.paths.waypoints import interpolated, twists
from urdf_ik.support.angles import shortest
from urdf_ik.typing import Array

Ints = NDArray[np.int64]
Mask = NDArray[np.bool_]

DEEPEST = 8
"""How often a segment is cut in halves."""
WIDEST = 0.5 * np.pi
"""rad: the greatest step of a joint that may be one motion."""


class Pieces(NamedTuple):
    """Pieces of motions.

    Attributes:
        motion: (k,) the motion that each one belongs to.
        start: (k,) share of the segment at which it begins.
        end: (k,) share at which it ends.
        q: (k, n) rad or m, where it begins.
        dq: (k, n) rad or m, how the joints move.
        value: (k, 2) of the redundancy parameter at both ends.
    """

    motion: Ints
    start: Array
    end: Array
    q: Array
    dq: Array
    value: Array

    def some(self, which: Mask) -> Pieces:
        """Those that are chosen."""
        parts: list[Any] = [part[which] for part in self]
        return Pieces(*parts)

    def with_more(self, others: Pieces) -> Pieces:
        """These and others."""
        parts: list[Any] = [np.concatenate(pair) for pair in zip(self, others, strict=True)]
        return Pieces(*parts)


def bisected(
    solver: Solver, joints: Joints, q: Array, dq: Array, value: Array, T0: Array, T1: Array, tolerance: Tolerance
) -> tuple[Mask, list[tuple[Array, Array]]]:
    """Joint vectors between the ends of motions, so that every piece keeps to the straight segment.

    Args:
        solver: the arm's solver.
        joints: how its joints turn.
        q: (k, n) rad or m, where the motions begin.
        dq: (k, n) rad or m, how the joints move.
        value: (k, 2) of the redundancy parameter at both ends; ignored for an arm without one.
        T0: (k, 4, 4) m, poses of q.
        T1: (k, 4, 4) m, poses of q + dq.
        tolerance: from the segments.

    Returns:
        (k,) whether it could be done, and for each motion the shares and the joint vectors in between.
    """
    turns = twists(T0, T1)[:, 3:]
    done = np.ones(len(q), dtype=np.bool_)
    found: list[list[tuple[float, Array]]] = [[] for _ in q]
    pieces = Pieces(np.arange(len(q)), np.zeros(len(q)), np.ones(len(q)), q, dq, value)
    for depth in range(DEEPEST):
        pieces = pieces.some(done[pieces.motion])
        if not len(pieces.motion):
            break
        at = pieces.motion
        share = 0.5 * (pieces.start + pieces.end)
        middle = interpolated(T0[at], T1[at], share, turns[at])
        between = pieces.value[:, 0] + 0.5 * _value_steps(solver, pieces.value)
        wanted = pieces.q + 0.5 * pieces.dq
        values = nearest_values(solver, wanted, middle) if len(solver.parameters) > 1 else between
        solutions = solve(solver, middle) if solver.parameter is None else solve(solver, middle, redundancy=values)
        off = joints.step(wanted[:, None], solutions.q)
        apart = np.where(solutions.valid, np.abs(off).max(axis=2), np.inf)
        column = np.argmin(apart, axis=1)
        c = wanted + off[np.arange(len(at)), column]
        good = np.isfinite(apart[np.arange(len(at)), column])
        with np.errstate(invalid="ignore"):  # NaN where there is no solution
            halves = np.maximum(np.abs(c - pieces.q).max(axis=1), np.abs(pieces.q + pieces.dq - c).max(axis=1))
            good &= halves <= WIDEST
        done[at[~good]] = False
        for k in np.flatnonzero(good):
            found[at[k]].append((float(share[k]), c[k]))
        left = Pieces(at, pieces.start, share, pieces.q, c - pieces.q, np.column_stack([pieces.value[:, 0], between]))
        right = Pieces(
            at, share, pieces.end, c, pieces.q + pieces.dq - c, np.column_stack([between, pieces.value[:, 1]])
        )
        both = left.with_more(right).some(np.tile(good, 2))
        straight = _straight(solver, both, T0, T1, turns, tolerance)
        pieces = both.some(~straight)
        if depth == DEEPEST - 1:
            done[pieces.motion] = False
    ordered = []
    for each in found:
        each.sort(key=lambda pair: pair[0])
        ordered.append((np.array([s for s, _ in each]), np.array([x for _, x in each]).reshape(-1, solver.dof)))
    return done, ordered


def _value_steps(solver: Solver, value: Array) -> Array:
    """From the first to the second of values (k, 2) of the redundancy parameter; the short way round."""
    steps: Array = value[:, 1] - value[:, 0]
    return shortest(steps) if solver.parameter is not None and solver.parameter.round else steps


def _straight(solver: Solver, pieces: Pieces, T0: Array, T1: Array, turns: Array, tolerance: Tolerance) -> Mask:
    """Which pieces keep to their part of the segment."""
    at = pieces.motion
    ends = np.empty((2 * len(at), 4, 4))
    ends[0::2] = interpolated(T0[at], T1[at], pieces.start, turns[at])
    ends[1::2] = interpolated(T0[at], T1[at], pieces.end, turns[at])
    turn = np.zeros((max(2 * len(at) - 1, 0), 3))
    turn[0::2] = (pieces.end - pieces.start)[:, None] * turns[at]
    first = 2 * np.arange(len(at))
    return keeps_straight(solver.chain, pieces.q, pieces.dq, ends, first, turn, tolerance, solver.free_axis)
