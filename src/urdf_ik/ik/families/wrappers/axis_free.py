"""An arm whose tip may turn freely about an axis: its solver for whole poses, applied to the turned target.

The angle v is a redundancy parameter that is given with each target, T' = T R(v). It is not a joint's value, so the
joint vectors are those of the arm, and one plan serves every value.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from urdf_ik._core import SelfMotion, Solver
from urdf_ik.ik.families.parts.family import FamilyMember, RedundantMember
from urdf_ik.ik.families.parts.free_arm import FreeArm
from urdf_ik.ik.families.parts.written import written
from urdf_ik.ik.families.wrappers.axis_added import with_axis_behind
from urdf_ik.kinematics.chain import Chain
from urdf_ik.kinematics.chain.free_axis import FreeAxis
from urdf_ik.kinematics.chain.redundancy import free_axis
from urdf_ik.typing import Array


@dataclass(frozen=True, kw_only=True, eq=False)
class AxisFree:
    """An arm whose targets are turned about an axis of the tip: ``GivenJoint`` of the core, behind the target.

    Attributes:
        motion: (3, 3, 4) the rotation is their sum times (1, cos, sin) of its angle.
        value: rad, the angle where no other is given.
        solver: the arm for whole poses: the dataclass of its solver.
        turns: whether the parameter is an angle.
        last: whether the motion stands behind the target.
    """

    kind: ClassVar = "axis free"
    motion: Array
    value: float
    solver: Any
    turns: bool = True
    last: bool = True


def prepare(chain: Chain, plan: FamilyMember, axis: FreeAxis) -> RedundantMember:
    """The plan of an arm that ``plan`` solves for whole poses, with one parameter more, which comes first."""
    parameter = free_axis(axis)
    arm = AxisFree(motion=axis.motion, value=parameter.default, solver=plan.solver.arm)
    own = plan.parameters if isinstance(plan, RedundantMember) else ()

    def value_of(Q: Array, T: Array) -> Array:
        reached = chain.fk(Q)
        angle = axis.angle(np.linalg.inv(T) @ reached)[:, None]
        return np.hstack([angle, plan.value_of(Q, reached)]) if isinstance(plan, RedundantMember) else angle

    def explain_at(T: Array, at: Array) -> str:
        turned = T @ axis.rotation(at[0])
        why = plan.explain_at(turned, at[1:]) if isinstance(plan, RedundantMember) else plan.explain(turned)
        return f"turned by {at[0]:.6g} rad about {axis}: {why}"

    return RedundantMember(
        family=plan.family,
        name=f"{plan.name}, rotation about {axis.name} free",
        reason=plan.reason,
        method=f"The target is turned about {axis}, by a value that is given. {plan.method}",
        branches=plan.branches,
        imperfection=plan.imperfection,
        error=plan.error,
        solver=Solver(arm),
        parameters=(parameter, *own),
        self_motion=None if own or chain.axes is not chain else _self_motion(chain, axis),
        value_of=value_of,
        explain=plan.explain,
        explain_at=explain_at,
        swivel=plan.swivel if isinstance(plan, RedundantMember) else None,
    )


def _self_motion(chain: Chain, axis: FreeAxis) -> SelfMotion:
    """The curves of six joints and the rotation: a seventh joint behind the tip that turns it back to the target."""
    direction, at = (chain.R_tip @ np.array(each) for each in (axis.direction, axis.at))
    whole = with_axis_behind(chain, -direction, chain.P.sum(axis=0) + at)
    return SelfMotion(FreeArm(written=written(whole), given=6))
