"""``ik_nearest``: the solution nearest to a joint vector, over all redundancy parameters or in a target region."""

from __future__ import annotations

from typing import Any

from numpy.typing import ArrayLike

from urdf_ik.errors import ArgumentError
from urdf_ik.ik.families import RedundantMember
from urdf_ik.ik.pose_solving import solve
from urdf_ik.ik.redundancy import Region, region_search
from urdf_ik.ik.redundancy import nearest as along_parameter
from urdf_ik.ik.representatives import near_each
from urdf_ik.ik.solutions import IKSolutions
from urdf_ik.ik.solutions.distances import Metric
from urdf_ik.ik.solver import Solver
from urdf_ik.support import inputs


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
    threads: inputs.Threads = 1,
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
            :mod:`urdf_ik.ik.redundancy.region_search`; so it is for an arm with several redundancy parameters.
        threads: number of threads that share the work, or 'auto'.

    Returns:
        One column a pose; of a continuum what ``ik`` gives near ``q_ref``, its free joint there. With seven
        joints, ``redundancy`` holds the values of the parameter, of all in :meth:`intervals`, to 1e-8.

    Raises:
        PoseError: a target is not a pose.
        ArgumentError: ``q_ref`` or an option does not fit.
        UnsupportedArm: no solver takes this arm.

    Example:
        >>> import urdf_ik
        >>> arm = urdf_ik.load("zyyzyz_6r")
        >>> q = [0.3, -0.5, 0.8, 0.4, 0.7, -0.2]
        >>> arm.ik_nearest(arm.fk(q), q).q.round(6).tolist()
        [[0.3, -0.5, 0.8, 0.4, 0.7, -0.2]]
    """
    options: Any = {"metric": metric, "weights": weights, "within": within, "within_limits": within_limits}
    if region is not None or len(solver.parameters) > 1:
        solver.require_member()
        if solver.targets is not None:
            raise ArgumentError(f"{solver.name}: a region is one of poses, not of the task {solver.task!r}")
        if region is not None and solver.free_axis is not None:
            raise ArgumentError(f"{solver.name}: {solver.free_axis} is free; a region has rotation=pi for that")
        return region_search.nearest(solver, T, q_ref, region, threads=threads, **options)
    if isinstance(solver.member, RedundantMember):
        return along_parameter.nearest(solver, T, q_ref, threads=threads, **options)
    reference = solver.chain.check(q_ref)
    near = reference if reference.ndim == 1 else None
    solutions = solve(solver, T, near, threads=threads)
    solutions = near_each(solutions, reference) if near is None else solutions
    return solutions.nearest(reference, **options)
