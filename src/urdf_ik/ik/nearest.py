"""The solution nearest to a joint vector: of all solutions, over all values of a redundancy parameter, in a region."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from urdf_ik.errors import ArgumentError
from urdf_ik.ik.families import RedundantPlan
from urdf_ik.ik.redundancy import nearest as along_parameter
from urdf_ik.ik.redundancy import region_search
from urdf_ik.ik.representatives import near_each
from urdf_ik.ik.solve import solve

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from urdf_ik.ik.redundancy import Region
    from urdf_ik.ik.solutions import IKSolutions
    from urdf_ik.ik.solutions.distances import Metric
    from urdf_ik.ik.solver import Solver


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
    threads: int = 1,
) -> IKSolutions:
    """See :meth:`urdf_ik.Arm.ik_nearest`."""
    options: Any = {"metric": metric, "weights": weights, "within": within, "within_limits": within_limits}
    if region is not None or len(solver.parameters) > 1:
        solver.require_member()
        if solver.targets is not None:
            raise ArgumentError(f"{solver.name}: a region is one of poses, not of the task {solver.task!r}")
        if region is not None and solver.free_axis is not None:
            raise ArgumentError(f"{solver.name}: {solver.free_axis} is free; a region has rotation=pi for that")
        return region_search.nearest(solver, T, q_ref, region, threads=threads, **options)
    if isinstance(solver.member, RedundantPlan):
        return along_parameter.nearest(solver, T, q_ref, threads=threads, **options)
    reference = solver.chain.check(q_ref)
    near = reference if reference.ndim == 1 else None
    solutions = solve(solver, T, near, threads=threads)
    solutions = near_each(solutions, reference) if near is None else solutions
    return solutions.nearest(reference, **options)
