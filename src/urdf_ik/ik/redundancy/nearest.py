"""The joint vector nearest to a reference, over all values of one redundancy parameter."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from urdf_ik.errors import ArgumentError
from urdf_ik.ik.pose_solving import solve
from urdf_ik.ik.redundancy.interval_search import intervals
from urdf_ik.ik.redundancy.values import nearest_values
from urdf_ik.ik.representatives import near_each
from urdf_ik.ik.solutions import IKSolutions, distances
from urdf_ik.ik.solutions.distances import Metric
from urdf_ik.ik.solver import Solver
from urdf_ik.model.poses import as_pose_array
from urdf_ik.support import inputs
from urdf_ik.typing import Array


def nearest(
    solver: Solver,
    T: Any,
    q_ref: ArrayLike,
    *,
    metric: Metric,
    weights: ArrayLike | None,
    within: ArrayLike | None,
    within_limits: bool,
    threads: inputs.Threads,
) -> IKSolutions:
    """See :meth:`urdf_ik.Arm.ik_nearest`.

    The distance is that to the +-2 pi images (with ``within_limits`` those inside the limits). Of a pose that has no
    solution inside the limits, what is least far outside them is looked at, and dropped with its reason.
    """
    parameter = solver.redundant_member.parameter
    within_limits, threads = inputs.flag(within_limits, "within_limits"), inputs.threads(threads)
    target = as_pose_array(T)
    shape = target.shape[:-2]
    measure = distances.measure(solver, metric, weights, within)
    reference = solver.chain.check(q_ref)
    try:
        each = np.broadcast_to(reference, (*shape, solver.dof)).reshape(-1, solver.dof)
    except ValueError:
        raise ArgumentError(
            f"q_ref of shape {reference.shape} and poses of shape {shape} given: one joint vector, or one a pose"
        ) from None
    stack = target.reshape(-1, 4, 4)
    values = np.full(len(stack), np.nan)
    for limited in (True, False) if within_limits else (False,):
        open_ = np.flatnonzero(np.isnan(values))
        found = intervals(solver, stack[open_], within_limits=limited, world=None, threads=threads)
        values[open_] = found.nearest_values(
            each[open_], metric=metric, weights=weights, within=within, within_limits=within_limits
        )
    near = each.reshape(*shape, solver.dof)

    def nearest_at(values: Array) -> IKSolutions:
        at = parameter.wrapped(values).reshape(shape)
        found: IKSolutions = near_each(solve(solver, target, redundancy=at, threads=threads), near)
        return found.nearest(near, weights, metric=metric, within=within, within_limits=within_limits)

    def distance(found: IKSolutions) -> Array:
        apart = measure.distance(found.difference(near))[..., 0]
        return np.where(np.isnan(apart), np.inf, apart).reshape(-1)

    values = np.where(np.isnan(values), parameter.default, values)
    best = nearest_at(values)
    # Where solutions are a surface, or lie at one value, no interval may pass the reference: its value is tried, too.
    own = nearest_values(solver, each, stack)[:, 0]
    better = distance(nearest_at(own)) < distance(best)
    return nearest_at(np.where(better, own, values)) if better.any() else best
