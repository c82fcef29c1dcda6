"""The joint vector of an arm with seven joints that is nearest to a reference, over all values of its parameter."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from urdf_ik.errors import JointVectorError
from urdf_ik.guards import inputs
from urdf_ik.poses import as_pose_array
from urdf_ik.redundancy.finding import intervals
from urdf_ik.solutions import select

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from urdf_ik.families.parts.family import RedundantPlan
    from urdf_ik.solutions import IKSolutions
    from urdf_ik.solutions.select import Metric
    from urdf_ik.solutions.solved_arm import SolvingArm


def nearest(
    arm: SolvingArm,
    plan: RedundantPlan,
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

    The distance is that to the +-2 pi images (with ``within_limits`` those inside the limits). Of a pose that has no
    solution inside the limits, what is least far outside them is looked at, and dropped with its reason.
    """
    within_limits, threads = inputs.flag(within_limits, "within_limits"), inputs.threads(threads)
    target = as_pose_array(T)
    shape = target.shape[:-2]
    select.measure(arm, metric, weights, within)
    reference = arm.chain.check(q_ref)
    try:
        each = np.broadcast_to(reference, (*shape, arm.dof)).reshape(-1, arm.dof)
    except ValueError:
        raise JointVectorError(
            f"q_ref of shape {reference.shape} and poses of shape {shape} given: one joint vector, or one a pose"
        ) from None
    stack = target.reshape(-1, 4, 4)
    values = np.full(len(stack), np.nan)
    for limited in (True, False) if within_limits else (False,):
        open_ = np.flatnonzero(np.isnan(values))
        found = intervals(arm, plan, stack[open_], within_limits=limited, world=None, threads=threads)
        values[open_] = found.nearest_values(
            each[open_], metric=metric, weights=weights, within=within, within_limits=within_limits
        )
    known = np.where(np.isnan(values), plan.parameter.default, plan.parameter.wrapped(values)).reshape(shape)
    solutions: IKSolutions = arm.ik(target, redundancy=known, threads=threads)
    near = each.reshape(*shape, arm.dof)
    return solutions.nearest(near, weights, metric=metric, within=within, within_limits=within_limits)
