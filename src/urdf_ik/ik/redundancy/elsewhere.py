"""Values of the redundancy parameters at which poses have solutions inside the joint limits."""

from typing import Any

import numpy as np

from urdf_ik.ik.closest import closest
from urdf_ik.ik.pose_solving import solve
from urdf_ik.ik.redundancy.interval_search import intervals
from urdf_ik.ik.solutions import IKSolutions, limits
from urdf_ik.ik.solver import Solver
from urdf_ik.ik.task import Task
from urdf_ik.typing import Array, Threads

_REACHED = 1e-9
"""m, rad: what a searched joint vector may miss."""


def _found(solver: Solver, T: Array, threads: Threads) -> Array:
    """(m, k) values at which poses (m, 4, 4) have a solution far from the joint limits; NaN where none was found.

    One parameter that has intervals: the best value of all of them. Else the best of the joint vectors that a search
    inside the limits finds.
    """
    member = solver.redundant_member
    out = np.full((len(T), len(member.parameters)), np.nan)
    if len(member.parameters) == 1 and member.self_motion is not None:
        best = intervals(solver, T, threads=threads).best("limits")
        there = np.asarray(best.count) > 0
        out[there, 0] = np.asarray(best.redundancy)[there]
        return out
    axis = solver.free_axis
    if axis is not None and any(axis.at):
        return out
    asked = solver.asked if axis is None else Task("position and axis", axis.direction)
    found = closest(solver, T, task=asked, within_limits=True)
    good = (found.error.position < _REACHED) & (found.error.rotation < _REACHED)
    score = np.where(good, limits.margin(found.q, solver.limits), -np.inf)
    column = score.argmax(axis=1)
    rows = np.flatnonzero(np.isfinite(score.max(axis=1)))
    if len(rows):
        out[rows] = member.value_of(found.q[rows, column[rows]], T[rows])
    return out


def values_inside(solver: Solver, T: Any, threads: Threads = 1) -> Array:
    """Values at which poses have solutions inside the joint limits: the defaults, or else others.

    Args:
        solver: of an arm with redundancy parameters.
        T: (..., 4, 4) poses, or targets of the arm's task.
        threads: number of threads that share the work, or 'auto'.

    Returns:
        (...) of one parameter, (..., k) of k of them: what ``ik`` takes as ``redundancy``. The defaults, too, where no
        value was found.

    Raises:
        PoseError: a target is no pose.
        UnsupportedArm: the arm has no redundancy parameter.
    """
    member = solver.redundant_member
    solutions: IKSolutions = solve(solver, T, threads=threads)
    lacking = np.asarray(solutions.within_limits().count) == 0
    values = np.tile(member.defaults, (*lacking.shape, 1))
    if lacking.any():
        other = _found(solver, np.asarray(solutions.poses)[lacking].reshape(-1, 4, 4), threads)
        values[lacking] = np.where(np.isnan(other), values[lacking], other)
    return values[..., 0] if len(member.parameters) == 1 else values
