"""``Sweep``: all solutions of one pose at evenly spread values of the redundancy parameter.

They rest on :meth:`urdf_ik.Arm.intervals`, which says more: each branch by itself, and what ends it.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from urdf_ik.errors import ArgumentError, PoseError
from urdf_ik.ik.pose_solving import solve
from urdf_ik.ik.redundancy.interval_search import intervals, span
from urdf_ik.ik.redundancy.values import only_parameter
from urdf_ik.ik.solutions import IKSolutions
from urdf_ik.ik.solver import Solver
from urdf_ik.kinematics.chain.redundancy import Redundancy
from urdf_ik.model.poses import check_poses
from urdf_ik.support import inputs
from urdf_ik.support.angles import TURN, amount, shown
from urdf_ik.typing import Array, Threads

# Values that are tried where no curve can be followed.
_GRID = 65


@dataclass(frozen=True)
class Sweep:
    """Solutions of one pose along the redundancy parameter.

    Attributes:
        solutions: the solutions at n values, (n, B, 7); ``solutions.redundancy`` holds the values.
        intervals: (k, 2) rad or m, intervals with solutions, lowest first, ends to 1e-9. An interval across half a
            turn ends beyond pi; the whole circle is (-pi, pi).
        parameter: the redundancy parameter.
    """

    solutions: IKSolutions
    intervals: Array
    parameter: Redundancy

    @property
    def redundancy(self) -> Array:
        """(n,) rad or m, the values."""
        return np.asarray(self.solutions.redundancy)

    def __str__(self) -> str:
        where = _places(self.parameter, self.intervals) or "no value"
        found = f"{self.solutions.count.sum()} at {len(self.redundancy)} values"
        return f"{self.parameter}; solutions at {where}; {found}"


MOST_VALUES = 1_000_000
"""Values of a sweep at most."""


def sweep(
    solver: Solver,
    T: Any,
    n: int = 64,
    *,
    within_limits: bool = False,
    threads: Threads = 1,
) -> Sweep:
    """The solutions of one pose at ``n`` values of the redundancy parameter, and where there are any.

    Args:
        solver: of an arm with one redundancy parameter.
        T: (4, 4) pose of the tip in the base [m], or a ``pinocchio.SE3``.
        n: number of values, shared among the intervals in which there are solutions by their lengths.
        within_limits: only solutions inside the joint limits count.
        threads: number of threads that share the work, or 'auto'.

    Raises:
        PoseError: ``T`` is no pose, or more than one.
        UnsupportedArm: the arm has no redundancy parameter.
        ArgumentError: ``n`` is no number of values.

    Example:
        >>> import urdf_ik
        >>> arm = urdf_ik.load("srs_7r")
        >>> sweep = arm.sweep(arm.fk([0.3, 0.5, -0.4, 0.9, 0.2, -0.6, 0.1]), n=16)
        >>> sweep.solutions.q.shape, sweep.intervals.round(3).tolist()
        ((16, 8, 7), [[-3.142, 3.142]])
    """
    plan = only_parameter(solver, "sweep")
    target = check_poses(T)
    if target.ndim != 2:
        raise PoseError(f"an array of shape {target.shape} given; sweep takes a single pose (4, 4)")
    n = inputs.whole(n, "n", low=1, high=MOST_VALUES)
    parameter = plan.parameters[0]
    low, high = span(solver, parameter, target[None])
    if plan.self_motion is None and len(plan.parameters) == 1:
        found = _on_a_grid(solver, parameter, target, (low, high), within_limits)
    else:
        found = intervals(solver, target, within_limits=within_limits, threads=threads).merged()
    values = parameter.wrapped(_spread(found if len(found) else np.array([[low, high]]), n, parameter.round))
    solutions: IKSolutions = solve(solver, target, redundancy=values, threads=threads)
    return Sweep(solutions.within_limits() if within_limits else solutions, found, parameter)


def explanation(solver: Solver, T: Array, value: ArrayLike | None) -> str:
    """Why the pose ``T`` (4, 4) has no solution at a value of the parameter (None: its default), and where it has."""
    plan = solver.redundant_member
    parameter = plan.parameters[0]
    given = parameter.check(parameter.default if value is None else value)
    if given.ndim:
        raise ArgumentError(f"redundancy of shape {given.shape} given; explain takes a single value")
    at = float(given)
    found = sweep(solver, T, 1).intervals
    places = _places(parameter, found)
    why = plan.explain(T, np.array([at]))
    return f"{why}; " + (f"there are solutions at {places}" if places else "nor at other values")


def _places(parameter: Redundancy, intervals: Array) -> str:
    """Intervals (k, 2) in words."""
    return ", ".join(
        f"{shown(low, parameter.unit):.4f} to {amount(high, parameter.unit, '.4f')}" for low, high in intervals
    )


def _on_a_grid(
    solver: Solver, parameter: Redundancy, T: Array, ends: tuple[float, float], within_limits: bool
) -> Array:
    """(k, 2) from the first to the last of the grid's values in a row at which there are solutions.

    For joints that do not move the tip in every way: what they leave free is no curve that could be followed.
    """
    grid = np.linspace(*ends, _GRID)
    solutions: IKSolutions = solve(solver, T, redundancy=parameter.wrapped(grid))
    good = np.concatenate([[False], (solutions.within_limits() if within_limits else solutions).count > 0, [False]])
    starts, stops = np.flatnonzero(good[1:] & ~good[:-1]), np.flatnonzero(good[:-1] & ~good[1:])
    return np.column_stack([grid[starts], grid[stops - 1]])


def _spread(intervals: Array, n: int, is_round: bool) -> Array:
    """``n`` values in the intervals, evenly by their lengths and lowest first, the ends included where n allows."""
    lengths = intervals[:, 1] - intervals[:, 0]
    if is_round and lengths[0] >= TURN:
        return np.linspace(-np.pi, np.pi, n + 1)[1:]
    if n < 2 * len(intervals):
        return np.asarray(intervals.mean(axis=1)[np.argsort(-lengths, kind="stable")[:n]])
    shares = (n - 2 * len(intervals)) * lengths / max(lengths.sum(), 1e-300)
    counts = 2 + np.floor(shares).astype(np.intp)
    # What rounding left over goes to where most was cut off.
    left = np.argsort(np.floor(shares) - shares, kind="stable")[: n - counts.sum()]
    counts[left] += 1
    return np.concatenate([np.linspace(low, high, k) for (low, high), k in zip(intervals, counts, strict=True)])
