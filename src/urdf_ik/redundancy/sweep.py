"""All solutions of one pose along the redundancy parameter, and the intervals in which there are any.

A grid of values is solved at once; where something happens between two neighbours, the place is closed in upon with
ever finer grids. What is narrower than the first grid's step (a 256th of the range: 0.025 rad of a full turn) may be
missed: an interval with solutions or without.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from urdf_ik.angles import TURN
from urdf_ik.errors import ArgumentError, PoseError
from urdf_ik.poses import check_poses

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import ArrayLike, NDArray

    from urdf_ik.chain.redundancy import Redundancy
    from urdf_ik.families.parts.family import RedundantPlan
    from urdf_ik.solutions import IKSolutions
    from urdf_ik.solutions.solved_arm import SolvingArm

    Array = NDArray[np.float64]

GRID = 256
"""Values on the first grid."""
FINER, FINEST = 17, 1e-10
"""Values on each finer grid, and the step [rad or m] at which the search ends."""


@dataclass(frozen=True)
class Sweep:
    """Solutions of one pose along the redundancy parameter.

    Attributes:
        solutions: those at n values, (n, B, 7); ``solutions.redundancy`` holds the values.
        intervals: (k, 2) rad or m, where there are solutions, lowest first, edges included to 1e-9. One that passes
            half a turn goes on beyond pi; one that is the whole circle is (-pi, pi).
        parameter: what the values mean.

    Example:
        >>> import urdf_ik
        >>> arm = urdf_ik.load("srs_7r")
        >>> sweep = arm.sweep(arm.fk([0.3, 0.5, -0.4, 0.9, 0.2, -0.6, 0.1]), n=16)
        >>> sweep.parameter.kind, sweep.solutions.redundancy.shape
        ('swivel', (16,))
    """

    solutions: IKSolutions
    intervals: Array
    parameter: Redundancy

    @property
    def redundancy(self) -> Array:
        """(n,) rad or m, the values."""
        return np.asarray(self.solutions.redundancy)

    def __str__(self) -> str:
        unit = self.parameter.unit
        where = ", ".join(f"{low:.4f} to {high:.4f} {unit}" for low, high in self.intervals) or "no value"
        found = f"{self.solutions.count.sum()} at {len(self.redundancy)} values"
        return f"{self.parameter}; solutions at {where}; {found}"


def sweep(arm: SolvingArm, parameter: Redundancy, T: Any, n: int, within_limits: bool, threads: int) -> Sweep:
    """See :meth:`urdf_ik.Arm.sweep`."""
    target = check_poses(T)
    if target.ndim != 2:
        raise PoseError(f"an array of shape {target.shape} given; sweep takes a single pose (4, 4)")
    if n < 1:
        raise ArgumentError(f"a sweep over {n} values asked for; at least one is needed")

    def solve(values: Array) -> IKSolutions:
        solutions: IKSolutions = arm.ik(target, redundancy=values, threads=threads)
        return solutions.within_limits() if within_limits else solutions

    low, high = span(arm, parameter, target[None])

    def solved(values: Array) -> NDArray[np.bool_]:
        return np.asarray(solve(values).count > 0)

    intervals = _intervals(solved, low, high, parameter.round)
    values = _spread(intervals if len(intervals) else np.array([[low, high]]), n, parameter.round)
    return Sweep(solve(parameter.wrapped(values)), intervals, parameter)


def explanation(arm: SolvingArm, plan: RedundantPlan, T: Array, value: ArrayLike | None) -> str:
    """Why the pose ``T`` (4, 4) has no solution at a value of the parameter (None: its default), and where it has."""
    parameter = plan.parameter
    at = parameter.default if value is None else float(parameter.check(value))
    found = sweep(arm, parameter, T, 1, within_limits=False, threads=1).intervals
    places = ", ".join(f"{low:.4f} to {high:.4f} {parameter.unit}" for low, high in found)
    why = plan.explain_at(T, np.array([at]))
    return f"{why}; " + (f"there are solutions at {places}" if places else "nor at other values")


def span(arm: SolvingArm, parameter: Redundancy, T: Array) -> tuple[float, float]:
    """Least and greatest value that is tried for poses (m, 4, 4)."""
    if parameter.round:
        return -np.pi, np.pi
    low, high = parameter.range
    if np.isfinite(high - low):
        return low, high
    reach = float(np.linalg.norm(T[:, :3, 3] - arm.chain.P[0], axis=1).max()) + arm.chain.size
    return max(low, -reach), min(high, reach)


def _intervals(solved: Callable[[Array], NDArray[np.bool_]], low: float, high: float, is_round: bool) -> Array:
    """(k, 2) where ``solved`` holds; see :class:`Sweep`."""
    grid = np.linspace(low, high, GRID, endpoint=not is_round)
    step = grid[1] - grid[0]
    good = np.atleast_1d(solved(grid))
    if good.all():
        return np.array([[low, high]])
    if not good.any():
        return np.empty((0, 2))
    neighbour = np.roll(good, 1) if is_round else np.concatenate([[False], good[:-1]])
    starts = np.flatnonzero(good & ~neighbour)
    neighbour = np.roll(good, -1) if is_round else np.concatenate([good[1:], [False]])
    ends = np.flatnonzero(good & ~neighbour)
    if is_round and ends[0] < starts[0]:
        ends = np.roll(ends, -1)
    lower = _edges(solved, grid[starts], -step, low if not is_round else -np.inf)
    upper = _edges(solved, grid[ends], step, high if not is_round else np.inf)
    upper = np.where(upper < lower, upper + TURN, upper) if is_round else upper
    return np.column_stack([lower, upper])


def _edges(solved: Callable[[Array], NDArray[np.bool_]], inside: Array, step: float, end: float) -> Array:
    """The last value where ``solved`` holds, from one (k,) where it does towards ``inside + step`` where not."""
    at_end = inside == end
    shares = np.linspace(0.0, 1.0, FINER)
    while abs(step) > FINEST:
        tried = inside[:, None] + step * shares
        good = solved(tried.ravel()).reshape(tried.shape)
        good[:, 0] = True
        # The first place where it ceases to hold.
        last = np.where(good.all(axis=1), FINER - 2, np.argmin(good, axis=1) - 1)
        inside = np.where(at_end, inside, tried[np.arange(len(inside)), last])
        step /= FINER - 1
    return inside


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
