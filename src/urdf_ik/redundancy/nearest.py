"""The joint vector of an arm with seven joints that is nearest to a reference, over all values of its parameter.

The places with the least distance on a grid of values are closed in upon with ever finer grids. A minimum that is
narrower than the first grid's step (a 256th of the range: 0.025 rad of a full turn) may be missed. Intervals inside the
joint limits may be narrower: solutions outside them are followed inwards.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from urdf_ik.errors import JointVectorError
from urdf_ik.poses import as_pose_array
from urdf_ik.redundancy.sweep import FINER, FINEST, GRID, span
from urdf_ik.solutions import limits, select

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import ArrayLike, NDArray

    from urdf_ik.chain.redundancy import Redundancy
    from urdf_ik.solutions import IKSolutions
    from urdf_ik.solutions.select import Measure, Metric
    from urdf_ik.solutions.solved_arm import SolvingArm

    Array = NDArray[np.float64]
    Columns = NDArray[np.intp]

# Places that are closed in upon at the same time.
_PLACES = 8
# What a solution outside the limits costs more than any distance inside them, and one that is too far from the
# reference more than one that is near enough.
_OUTSIDE, _BEYOND = 1e7, 1e5
# A solution that is farther outside the limits, or beyond the bounds, than this [rad, m] is not followed between two
# values of the first grid: it would have to move 20 times as fast as the parameter to come inside there.
_FOLLOWED = 0.5
# Poses whose grids are solved at a time: about 10 MB of solutions.
_AT_ONCE = 32


def nearest(
    arm: SolvingArm,
    parameter: Redundancy,
    T: Any,
    q_ref: ArrayLike,
    *,
    metric: Metric,
    weights: ArrayLike | None,
    within: ArrayLike | None,
    within_limits: bool,
    threads: int,
) -> IKSolutions:
    """See :meth:`urdf_ik.Arm.ik_nearest`.

    The distance is that to the +-2 pi images (with ``within_limits`` those inside the limits), for each value of the
    parameter the least of all branches; where none is near enough or inside, by how much the best one is out. The eight
    lowest places of the first grid and ``q_ref``'s own value are closed in upon until values are 1e-10 apart: a minimum
    may lie at a limit, where a branch ends, or anywhere between.
    """
    measure = select.measure(arm, metric, weights, within)
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
    bounds = arm.limits if within_limits else np.tile([-np.inf, np.inf], (arm.dof, 1))
    for start in range(0, len(stack), _AT_ONCE):
        part = slice(start, start + _AT_ONCE)
        values[part] = _nearest_values(arm, parameter, stack[part], reference[part], bounds, measure, threads)
    found: IKSolutions = arm.ik(target, redundancy=values.reshape(shape), threads=threads)
    near = reference.reshape(*shape, arm.dof)
    return found.nearest(near, weights, metric=metric, within=within, within_limits=within_limits)


def _nearest_values(
    arm: SolvingArm, parameter: Redundancy, T: Array, q_ref: Array, bounds: Array, measure: Measure, threads: int
) -> Array:
    """(m,) values of the parameter at which poses (m, 4, 4) come nearest to joint vectors (m, n)."""
    low, high = span(arm, parameter, T)
    ends = None if parameter.round else (low, high)
    own = arm.nearest_values(q_ref, T)[:, 0]
    own = own if ends is None else np.clip(own, *ends)

    def looked_at(poses: Columns, values: Array) -> tuple[Array, Array]:
        q = arm.ik(T[poses, None], redundancy=values, threads=threads).q
        return q, _costs(arm, q, q_ref[poses, None, None], bounds, measure)

    grid = np.linspace(low, high, GRID, endpoint=not parameter.round)
    step = float(grid[1] - grid[0])
    everywhere, costs = looked_at(np.arange(len(T)), np.broadcast_to(grid, (len(T), GRID)))
    rows, _ = _lowest(costs.min(axis=-1)[:, :, None], parameter.round)
    # The reference's own value is always one of the places.
    starts = np.concatenate([own[:, None], grid[rows]], axis=1)
    poses = np.repeat(np.arange(len(T)), starts.shape[1])
    best, cost = _closed_in(lambda values: looked_at(poses, values)[1].min(axis=-1), starts.ravel(), step, ends)
    chosen = (np.arange(len(T)), np.argmin(cost.reshape(starts.shape), axis=1))
    value, found = best.reshape(starts.shape)[chosen], cost.reshape(starts.shape)[chosen]

    # Where one solution is inside the limits, another that is just outside is not seen, and may come inside between two
    # values of the grid. Where it would be nearer than what was found, it is followed by itself.
    outside = np.where(costs >= _BEYOND, np.minimum(costs - _BEYOND, np.abs(costs - _OUTSIDE)), np.inf)
    nearer = _share(arm, measure, select.difference(everywhere, q_ref[:, None, None], arm.chain.image_turns))
    outside[(outside > _FOLLOWED) | (nearer >= found[:, None, None])] = np.inf
    rows, columns = _lowest(outside, parameter.round)
    poses, places = np.nonzero(np.isfinite(outside[np.arange(len(T))[:, None], rows, columns]))
    if len(poses):
        rows, columns = rows[poses, places], columns[poses, places]
        followed = everywhere[poses, rows, columns][:, None, None]

        def alone(values: Array) -> Array:
            q, cost = looked_at(poses, values)
            away = np.abs(select.difference(q, followed, arm.chain.image_turns)).max(axis=-1)
            column = np.argmin(np.where(np.isnan(away), np.inf, away), axis=-1)[..., None]
            return np.asarray(np.take_along_axis(cost, column, axis=-1)[..., 0])

        for pose, at, cost_there in zip(poses, *_closed_in(alone, grid[rows], step, ends), strict=True):
            if cost_there < found[pose]:
                value[pose], found[pose] = at, cost_there
    return parameter.wrapped(value)


def _costs(arm: SolvingArm, q: Array, q_ref: Array, bounds: Array, measure: Measure) -> Array:
    """(...) of solutions (..., n): the distance of the nearest image inside the bounds, infinite without a solution.

    Where no image is inside, or none is near enough, by how much, above ``_OUTSIDE`` or ``_BEYOND``.
    """
    turning = ~arm.chain.prismatic
    image, inside = limits.image_near(q, q_ref, bounds, turning)
    apart = select.difference(image, q_ref, np.zeros(arm.dof))
    cost = _share(arm, measure, apart)
    if measure.within is not None:
        beyond = measure.beyond(apart)
        cost = np.where(beyond > 0.0, _BEYOND + beyond, cost)
    if not inside.all():
        _, out = limits.excess(q[~inside], bounds, turning)
        cost[~inside] = np.nan_to_num(_OUTSIDE + np.abs(out).max(axis=-1), nan=np.inf)
    return cost


def _share(arm: SolvingArm, measure: Measure, apart: Array) -> Array:
    """The distance (...) as a share of that at which every joint is 1 rad or m away, so that no weights matter here."""
    return measure.distance(apart) / (float(measure.distance(np.ones(arm.dof))) or 1.0)


def _lowest(cost: Array, round_values: bool) -> tuple[Columns, Columns]:
    """Rows and columns (m, _PLACES) of the lowest local minima down the rows of (m, rows, columns)."""
    before, after = np.roll(cost, 1, axis=1), np.roll(cost, -1, axis=1)
    if not round_values:
        before[:, 0], after[:, -1] = np.inf, np.inf
    lowest = np.where((cost <= before) & (cost <= after), cost, np.inf).reshape(len(cost), -1)
    places = np.argsort(lowest, axis=1, kind="stable")[:, :_PLACES]
    rows, columns = np.divmod(places, cost.shape[2])
    return rows, columns


def _closed_in(
    cost: Callable[[Array], Array], starts: Array, step: float, ends: tuple[float, float] | None
) -> tuple[Array, Array]:
    """Values (k,) with the least cost near ``starts`` (k,), and these costs, by ever finer grids.

    Args:
        cost: (k, FINER) values to costs.
        starts: values to begin at.
        step: how far to look at first.
        ends: least and greatest value, or None where the values go round.
    """
    best, least = starts, np.full(len(starts), np.inf)
    around = np.linspace(-1.0, 1.0, FINER)
    every = np.arange(len(starts))
    while step > FINEST:
        tried = best[:, None] + step * around
        tried = tried if ends is None else np.clip(tried, *ends)
        found = cost(tried)
        column = np.argmin(found, axis=1)
        nearer = found[every, column] < least
        best = np.where(nearer, tried[every, column], best)
        least = np.where(nearer, found[every, column], least)
        step *= 2.0 / (FINER - 1)
    return best, least
