"""What an arm with seven joints can do while its tip stands still: its nearest joint vector, and all of them.

Both search along the redundancy parameter. A grid of values is solved at once; where something happens between two
neighbours, the place is closed in upon with ever finer grids. What is narrower than the first grid's step (a 256th of
the range: 0.025 rad of a full turn) may be missed: an interval with solutions or without, or a minimum of the distance.
Intervals inside the joint limits may be narrower for ``nearest``, which follows solutions outside them inwards.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from urdf_ik.errors import JointVectorError, PoseError, UrdfIkError
from urdf_ik.poses import as_pose_array, check_poses
from urdf_ik.solutions import IKSolutions, Step, limits

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import ArrayLike, NDArray

    from urdf_ik.arm import Arm
    from urdf_ik.chain.redundancy import Redundancy
    from urdf_ik.families.parts.plan import RedundantPlan

    Array = NDArray[np.float64]

_GRID = 256
# Places that are closed in upon at the same time, values on each finer grid, and the step at which that ends.
_PLACES, _FINER, _FINEST = 8, 17, 1e-10
# What a solution outside the limits costs more than any distance inside them.
_OUTSIDE = 1e6
# Poses whose grids are solved at a time: about 10 MB of solutions.
_AT_ONCE = 32


@dataclass(frozen=True)
class Sweep:
    """Solutions of one pose along the redundancy parameter.

    Attributes:
        solutions: those at n values, (n, B, 7); ``solutions.redundancy`` holds the values.
        intervals: (k, 2) rad or m, where there are solutions, lowest first, edges included to 1e-9. One that passes
            half a turn goes on beyond pi; one that is the whole circle is (-pi, pi).
        parameter: what the values mean.
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


def sweep(arm: Arm, parameter: Redundancy, T: Any, n: int, within_limits: bool, threads: int) -> Sweep:
    """See :meth:`urdf_ik.Arm.sweep`."""
    target = check_poses(T)
    if target.ndim != 2:
        raise PoseError(f"an array of shape {target.shape} given; sweep takes a single pose (4, 4)")
    if n < 1:
        raise UrdfIkError(f"a sweep over {n} values asked for; at least one is needed")

    def solve(values: Array) -> IKSolutions:
        solutions = arm.ik(target, redundancy=values, threads=threads)
        return solutions.within_limits() if within_limits else solutions

    low, high = _span(arm, parameter, target[None])

    def solved(values: Array) -> NDArray[np.bool_]:
        return np.asarray(solve(values).count > 0)

    intervals = _intervals(solved, low, high, parameter.round)
    values = _spread(intervals if len(intervals) else np.array([[low, high]]), n, parameter.round)
    return Sweep(solve(parameter.wrapped(values)), intervals, parameter)


def nearest(arm: Arm, parameter: Redundancy, T: Any, q_ref: ArrayLike, threads: int) -> IKSolutions:
    """See :meth:`urdf_ik.Arm.ik_nearest`.

    The distance is sqrt(sum of squared differences) to the +-2 pi images inside the limits, for each value of the
    parameter the least of all branches; where none is inside, by how much the best of them is out. The eight lowest
    places of the first grid and ``q_ref``'s own value are closed in upon until values are 1e-10 apart: a minimum may
    lie at a limit, where a branch ends, or anywhere between.
    """
    target = as_pose_array(T)
    reference = arm.chain.check(q_ref)
    shape = target.shape[:-2]
    try:
        reference = np.broadcast_to(reference, (*shape, arm.dof)).reshape(-1, arm.dof)
    except ValueError:
        raise JointVectorError(
            f"q_ref of shape {reference.shape} and poses of shape {shape} given: one joint vector, or one a pose"
        ) from None
    stack = target.reshape(-1, 4, 4)
    values = np.empty(len(stack))
    for start in range(0, len(stack), _AT_ONCE):
        part = slice(start, start + _AT_ONCE)
        values[part] = _nearest_values(arm, parameter, stack[part], reference[part], threads)
    found = arm.ik(target, redundancy=values.reshape(shape), threads=threads)
    image, far = _images(arm, found.q, reference.reshape(*shape, 1, arm.dof))
    info = np.where(np.isfinite(far), found.singular << np.uint8(1) | np.uint8(1), np.uint8(0))
    inside = IKSolutions(
        arm, target, image, info, found.branches, None, Step("limits", found, amount=limits.LIMIT_TOLERANCE),
        found.redundancy,
    )  # fmt: skip
    column = np.argmin(far, axis=-1)[..., None]
    return IKSolutions(
        arm,
        target,
        np.take_along_axis(image, column[..., None], axis=-2),
        np.take_along_axis(info, column, axis=-1),
        ("nearest",),
        None,
        Step("nearest", inside, column),
        found.redundancy,
    )


def explanation(arm: Arm, plan: RedundantPlan, T: Array, value: float | None) -> str:
    """Why the pose ``T`` (4, 4) has no solution at a value of the parameter (None: its default), and where it has."""
    parameter = plan.parameter
    at = parameter.default if value is None else float(parameter.check(value))
    found = sweep(arm, parameter, T, 1, within_limits=False, threads=1).intervals
    places = ", ".join(f"{low:.4f} to {high:.4f} {parameter.unit}" for low, high in found)
    return f"{plan.explain_at(T, at)}; " + (f"there are solutions at {places}" if places else "nor at other values")


def _nearest_values(arm: Arm, parameter: Redundancy, T: Array, q_ref: Array, threads: int) -> Array:
    """(m,) values of the parameter at which poses (m, 4, 4) come nearest to joint vectors (m, n)."""
    low, high = _span(arm, parameter, T)
    own = arm.redundancy_of(q_ref)
    own = own if parameter.round else np.clip(own, low, high)

    def far(values: Array) -> Array:
        solutions = arm.ik(T[:, None], redundancy=values, threads=threads)
        _, distances = _images(arm, solutions.q, q_ref[:, None, None])
        outside = np.isinf(distances).all(axis=-1)
        if outside.any():
            _, out = limits.excess(solutions.q[outside], arm.limits, ~arm.chain.prismatic)
            distances[outside] = np.nan_to_num(_OUTSIDE + np.abs(out).max(axis=-1), nan=np.inf)
        return np.asarray(distances.min(axis=-1))

    grid = np.linspace(low, high, _GRID, endpoint=not parameter.round)
    step = grid[1] - grid[0]
    distance = far(np.broadcast_to(grid, (len(T), _GRID)))
    before, after = np.roll(distance, 1, axis=1), np.roll(distance, -1, axis=1)
    if not parameter.round:
        before[:, 0], after[:, -1] = np.inf, np.inf
    lowest = np.where((distance <= before) & (distance <= after), distance, np.inf)
    places = np.argsort(lowest, axis=1, kind="stable")[:, :_PLACES]
    # The reference's own value is always one of the places.
    best = np.concatenate([own[:, None], grid[places]], axis=1)
    least = np.concatenate([far(own[:, None]), np.take_along_axis(distance, places, axis=1)], axis=1)
    around = np.linspace(-1.0, 1.0, _FINER)
    while step > _FINEST:
        tried = best[:, :, None] + step * around
        tried = tried if parameter.round else np.clip(tried, low, high)
        found = far(tried.reshape(len(T), -1)).reshape(tried.shape)
        column = np.argmin(found, axis=2)[:, :, None]
        better = np.take_along_axis(found, column, axis=2)[:, :, 0]
        nearer = better < least
        best = np.where(nearer, np.take_along_axis(tried, column, axis=2)[:, :, 0], best)
        least = np.where(nearer, better, least)
        step *= 2.0 / (_FINER - 1)
    chosen = np.argmin(least, axis=1)[:, None]
    return parameter.wrapped(np.take_along_axis(best, chosen, axis=1)[:, 0])


def _images(arm: Arm, q: Array, q_ref: Array) -> tuple[Array, Array]:
    """The image of each joint vector inside the limits that is nearest to ``q_ref``, NaN where none is inside.

    Returns:
        Images (..., n) and their distances (...), infinite where there is none.
    """
    turning = ~arm.chain.prismatic
    first, last = limits.image_range(q, arm.limits, turning)
    inside = np.asarray((first <= last).all(axis=-1))
    wanted = np.where(turning, np.round((q_ref - q) / limits.TURN), 0.0)
    endless = turning & np.isinf(arm.limits).all(axis=1)
    turns = np.where(endless, wanted, np.clip(wanted, first, np.maximum(first, last)))
    image = np.where(inside[..., None], q + turns * limits.TURN, np.nan)
    distance = np.sqrt(((image - q_ref) ** 2).sum(axis=-1))
    return image, np.where(inside, distance, np.inf)


def _span(arm: Arm, parameter: Redundancy, T: Array) -> tuple[float, float]:
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
    grid = np.linspace(low, high, _GRID, endpoint=not is_round)
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
    upper = np.where(upper < lower, upper + limits.TURN, upper) if is_round else upper
    return np.column_stack([lower, upper])


def _edges(solved: Callable[[Array], NDArray[np.bool_]], inside: Array, step: float, end: float) -> Array:
    """The last value where ``solved`` holds, from one (k,) where it does towards ``inside + step`` where not."""
    at_end = inside == end
    shares = np.linspace(0.0, 1.0, _FINER)
    while abs(step) > _FINEST:
        tried = inside[:, None] + step * shares
        good = solved(tried.ravel()).reshape(tried.shape)
        good[:, 0] = True
        # The first place where it ceases to hold.
        last = np.where(good.all(axis=1), _FINER - 2, np.argmin(good, axis=1) - 1)
        inside = np.where(at_end, inside, tried[np.arange(len(inside)), last])
        step /= _FINER - 1
    return inside


def _spread(intervals: Array, n: int, is_round: bool) -> Array:
    """``n`` values in the intervals, evenly by their lengths and lowest first, the ends included where n allows."""
    lengths = intervals[:, 1] - intervals[:, 0]
    if is_round and lengths[0] >= limits.TURN:
        return np.linspace(-np.pi, np.pi, n + 1)[1:]
    if n < 2 * len(intervals):
        return np.asarray(intervals.mean(axis=1)[np.argsort(-lengths, kind="stable")[:n]])
    shares = (n - 2 * len(intervals)) * lengths / max(lengths.sum(), 1e-300)
    counts = 2 + np.floor(shares).astype(np.intp)
    # What rounding left over goes to where most was cut off.
    left = np.argsort(np.floor(shares) - shares, kind="stable")[: n - counts.sum()]
    counts[left] += 1
    return np.concatenate([np.linspace(low, high, k) for (low, high), k in zip(intervals, counts, strict=True)])
