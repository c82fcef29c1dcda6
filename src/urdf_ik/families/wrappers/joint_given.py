"""Seven joints, of which the first or the last is the redundancy parameter and the six others have a solver.

Holding an end joint at a value moves the target and leaves the six-joint arm as it is: T' = E1(v)^-1 T for the first
one, and the tip moved back by the last one. One plan therefore serves every value. Holding a joint in the middle
would make another arm of every value, for which everything that is prepared at load would have to be prepared anew.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from urdf_ik._core import Solver
from urdf_ik.chain.free_axis import turning
from urdf_ik.chain.redundancy import locked_joint
from urdf_ik.families.parts.family import Plan, RedundantPlan
from urdf_ik.structure import analyse

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    from urdf_ik.chain import Chain
    from urdf_ik.structure import Structure

    Array = NDArray[np.float64]
    Choose = Callable[[Structure, Chain], Plan | None]


def prepare(chain: Chain, closed_form: Choose, elimination: Choose) -> RedundantPlan | None:
    """The plan that holds the end joint whose six others have the cheaper solver; None where neither has one.

    Args:
        chain: seven joints.
        closed_form: finds the plan of six joints in closed form, or near one.
        elimination: finds the plan of six joints where neither end has a closed form. Eliminations cost the same: it is
            the last joint that is held then, if its six others can be solved.
    """
    ends = [(k, chain.lock({chain.joint_names[k]: 0.0})) for k in (6, 0)]
    plans = [(k, plan) for k, rest in ends if (plan := closed_form(analyse(rest), rest)) is not None]
    if plans:
        return _held(chain, *min(plans, key=lambda entry: _cost(entry[1])))
    others = ((k, elimination(analyse(rest), rest)) for k, rest in ends)
    return next((_held(chain, k, plan) for k, plan in others if plan is not None), None)


def _cost(plan: Plan) -> int:
    """Order of the closed forms: exact ones, exact ones with a quartic, those near an ideal arm."""
    return int(not plan.family.by_quadratics) if plan.is_exact else 2


def _held(chain: Chain, k: int, plan: Plan) -> RedundantPlan:
    parameter = locked_joint(chain, k)
    motion, turns, last = _motion_back(chain, k), not bool(chain.prismatic[k]), k > 0
    values = {"motion": motion, "turns": turns, "last": last, "value": parameter.default, "solver": plan.solver}

    def explain_at(T: Array, at: Array) -> str:
        value = float(at[0])
        back = np.eye(4)
        back[:3] = np.tensordot([1.0, np.cos(value), np.sin(value)] if turns else [1.0, value, 0.0], motion, 1)
        why = plan.explain(T @ back if last else back @ T)
        return f"with {parameter.joint!r} at {value:.6g} {parameter.unit}: {why}"

    return RedundantPlan(
        family=plan.family,
        name=f"7R, joint {k + 1} given: {plan.name}" if turns else f"6R on a slide: {plan.name}",
        reason=f"with joint {k + 1} given, of the six others {plan.reason}",
        method=f"Joint {k + 1} ({parameter.joint}) is given, the six others are solved. {plan.method}",
        branches=plan.branches,
        imperfection=plan.imperfection,
        error=plan.error,
        solver=Solver("one joint given", values),
        parameters=(parameter,),
        value_of=lambda Q, T: parameter.wrapped(Q[:, k : k + 1]),
        explain=lambda T: explain_at(T, np.array([parameter.default])),
        explain_at=explain_at,
    )


def _motion_back(chain: Chain, k: int) -> Array:
    """(3, 3, 4) the inverse of the motion of joint ``k``, in the base's frame or, of the last joint, in the tip's."""
    h, p = chain.H[k], chain.points[k]
    if k:
        h, p = chain.R_tip.T @ h, chain.R_tip.T @ (p - chain.P.sum(axis=0))
    if not chain.prismatic[k]:
        return turning(-h, p)
    motion = np.zeros((3, 3, 4))
    motion[0, :, :3] = np.eye(3)
    motion[1, :, 3] = -h
    return motion
