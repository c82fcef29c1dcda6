"""The joint vector nearest to a reference, over all values of one redundancy parameter."""

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from urdf_ik.errors import ArgumentError
from urdf_ik.ik.pose_solving import near_each, solve
from urdf_ik.ik.redundancy.interval_search import intervals
from urdf_ik.ik.redundancy.region import Region, nearest_in_region
from urdf_ik.ik.redundancy.values import nearest_values
from urdf_ik.ik.solutions import IKSolutions, distances
from urdf_ik.ik.solutions.distances import Metric
from urdf_ik.ik.solver import Solver
from urdf_ik.ik.task import NUMBERS, POSE
from urdf_ik.model.poses import as_pose_array
from urdf_ik.support import inputs
from urdf_ik.typing import Array, Threads


def _along_parameter(
    solver: Solver,
    T: Any,
    q_ref: ArrayLike,
    *,
    metric: Metric,
    weights: ArrayLike | None,
    within: ArrayLike | None,
    within_limits: bool,
    threads: Threads,
) -> IKSolutions:
    """See :meth:`urdf_ik.Arm.ik_nearest`."""
    parameter = solver.redundant_member.parameters[0]
    threads = inputs.threads(threads)
    target = as_pose_array(T) if solver.asked == POSE else solver.asked.read_targets(T)
    shape = target.shape[:-2]
    measure = distances.measure(solver, metric, weights, within)
    reference = distances.reference(q_ref, solver.joint_names, shape)
    each = np.broadcast_to(reference, (*shape, solver.dof)).reshape(-1, solver.dof)
    stack = target.reshape(-1, 4, 4)
    values = np.full(len(stack), np.nan)
    for limited in (True, False) if within_limits else (False,):
        open_ = np.flatnonzero(np.isnan(values))
        found = intervals(solver, stack[open_], within_limits=limited, threads=threads)
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


def nearest(
    solver: Solver,
    T: Any,
    q_ref: ArrayLike,
    *,
    metric: Metric = "l2",
    weights: ArrayLike | None = None,
    within: ArrayLike | None = None,
    within_limits: bool = True,
    region: Region | None = None,
    threads: Threads = 1,
) -> IKSolutions:
    """The joint vector nearest to ``q_ref``: of all solutions, and over all values of a redundancy parameter.

    Args:
        solver: of the arm.
        T: as in ``ik``.
        q_ref: (n,), or one for each pose (..., n), rad or m.
        metric: 'l2', 'max' or 'time', the distance; see :meth:`IKSolutions.nearest`, also for the next three.
        weights: (n,) of the joints in the distance.
        within: rad or m that no joint may be further away, one number or one a joint.
        within_limits: whether only what lies inside the joint limits counts.
        region: how far the tip may be from ``T``, see :class:`urdf_ik.Region`; the ``poses`` of the answer are
            those that were chosen in it. The optimum is local, see
            :mod:`urdf_ik.ik.redundancy.region`; so it is for an arm with several redundancy parameters, and for a part
            of a pose that a search solves: with another metric than 'l2' only what ``ik`` finds there counts.
        threads: number of threads that share the work, or 'auto'.

    Returns:
        One column a pose; of a continuum what ``ik`` gives near ``q_ref``, its free joint there. With seven
        joints, ``redundancy`` holds the values of the parameter, of all in :meth:`intervals`, to 1e-8.

    Raises:
        PoseError: a target is not a pose.
        ArgumentError: ``q_ref`` or an option does not fit.
        UnsupportedArm: no solver takes this arm.
    """
    options: Any = {"metric": metric, "weights": weights, "within": within, "within_limits": within_limits}
    asked = solver.asked
    searched = asked != POSE and not solver.parameters and NUMBERS[asked.components] < solver.dof
    searched = searched and asked.components != "look at" and metric == "l2"
    if region is not None or len(solver.parameters) > 1 or searched:
        solver.require_member()
        if solver.targets is not None:
            raise ArgumentError(f"{solver.name}: a region is one of poses, not of the task {solver.task!r}")
        if region is not None and solver.free_axis is not None:
            raise ArgumentError(f"{solver.name}: {solver.free_axis} is free; a region has rotation=pi for that")
        return nearest_in_region(solver, T, q_ref, region, threads=threads, **options)
    if solver.parameters:
        return _along_parameter(solver, T, q_ref, threads=threads, **options)
    reference = solver.chain.check(q_ref)
    near = reference if reference.ndim == 1 else None
    solutions = solve(solver, T, near, threads=threads)
    solutions = near_each(solutions, reference) if near is None else solutions
    return solutions.nearest(reference, **options)
