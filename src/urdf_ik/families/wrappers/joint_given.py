"""Seven joints, of which one is the redundancy parameter and the six others have a solver: the first or the last one.

Holding an end joint at a value moves the target and leaves the six-joint arm as it is: T' = E1(v)^-1 T for the first
one, and the tip moved back by the last one. One plan therefore serves every value. Holding a joint in the middle
would make another arm of every value, for which everything that is prepared at load would have to be prepared anew:
that is done only where the six others lose rank everywhere whichever end is held.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from urdf_ik._core import Solver
from urdf_ik.chain import is_redundant, kinds_of, typical_stretch
from urdf_ik.chain import sampled as sampled_vectors
from urdf_ik.chain.redundancy import locked_joint
from urdf_ik.families import sampled
from urdf_ik.families.parts.family import Plan, RedundantPlan
from urdf_ik.structure import analyse
from urdf_ik.tolerances import DEFAULT

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    from urdf_ik.chain import Chain
    from urdf_ik.structure import Structure

    Array = NDArray[np.float64]
    Choose = Callable[[Structure, Chain], Plan | None]


# Where the six others of an end joint all but lose rank everywhere [smallest singular value of the Jacobian, lengths as
# shares of the size], a joint in the middle is held instead if that leaves them so many times better.
_POOR, _BETTER = 1e-3, 30.0


def prepare(chain: Chain, closed_form: Choose, elimination: Choose) -> RedundantPlan:
    """The plan that holds the end joint whose six others have the cheaper solver, or one in the middle if neither has.

    Args:
        chain: seven joints.
        closed_form: finds the plan of six joints in closed form, or near one.
        elimination: finds the plan of six joints where neither end has a closed form. Eliminations cost the same: it is
            the last joint that is held then, if its six others can be solved.
    """
    stretch = {k: typical_stretch(_without(chain, k)) for k in (6, 0)}
    ends = [(k, _without(chain, k)) for k in (6, 0) if stretch[k] >= DEFAULT.singular]
    best = max(stretch.values())
    if best < _POOR:
        middle = _in_the_middle(chain, closed_form, elimination, _BETTER * best)
        if middle is not None:
            return middle
    plans = [(k, plan) for k, rest in ends if (plan := closed_form(analyse(rest), rest)) is not None]
    if plans:
        return _held(chain, *min(plans, key=lambda entry: _cost(entry[1])))
    others = ((k, elimination(analyse(rest), rest)) for k, rest in ends)
    found = next((_held(chain, k, plan) for k, plan in others if plan is not None), None)
    return found or sampled.prepare_held(chain, _freest(chain))


def _in_the_middle(chain: Chain, closed_form: Choose, elimination: Choose, least: float) -> RedundantPlan | None:
    """The plan that holds a joint in the middle; None where it leaves the six others no better than ``least``.

    Two joints with one axis do the same: one of them is given, and the other takes its value back.
    """
    pairs = ((k, rest) for k in range(6) if _is_shared(chain, k) and not is_redundant(rest := _without(chain, k)))
    for k, rest in pairs:
        relations = analyse(rest)
        plan = closed_form(relations, rest) or elimination(relations, rest)
        if plan is not None:
            return _held(chain, k, plan, partner=k + 1)
    k = _freest(chain)
    return None if 0.0 < least > typical_stretch(_without(chain, k)) else sampled.prepare_held(chain, k)


def _without(chain: Chain, k: int) -> Chain:
    return chain.lock({chain.joint_names[k]: 0.0})


def _is_shared(chain: Chain, k: int) -> bool:
    """Whether joints ``k`` and ``k + 1`` turn about one axis, or slide along one direction, to rounding."""
    first, second = chain.H[k : k + 2]
    across = float(np.linalg.norm(np.cross(first, second)))
    if chain.prismatic[k] != chain.prismatic[k + 1] or across > DEFAULT.exact_structure:
        return False
    apart = np.linalg.norm(np.cross(chain.P[k + 1], first))
    return bool(chain.prismatic[k] or apart <= DEFAULT.exact_structure * chain.size)


def _freest(chain: Chain) -> int:
    """The joint without which the six others move the tip best, in as many ways as the seven do."""
    Q = sampled_vectors(chain)
    J = chain.jacobian(Q)
    J[:, :3] /= chain.size
    J[:, :, chain.prismatic] *= chain.size
    rank = int((np.median(np.linalg.svd(J, compute_uv=False), axis=0) > DEFAULT.singular).sum())
    left = [np.linalg.svd(np.delete(J, k, axis=2), compute_uv=False)[:, rank - 1] for k in range(chain.n)]
    return int(np.argmax(np.median(left, axis=1)))


def _cost(plan: Plan) -> int:
    """Order of the closed forms: exact ones, exact ones with a quartic, those near an ideal arm."""
    return int(not plan.family.by_quadratics) if plan.is_exact else 2


def _held(chain: Chain, k: int, plan: Plan, partner: int | None = None) -> RedundantPlan:
    """The plan of seven joints by that of six; ``partner``: the joint with the same axis as joint ``k``."""
    parameter = locked_joint(chain, k)
    turns, last = not bool(chain.prismatic[k]), k == chain.n - 1 and partner is None
    motion = _no_motion() if partner is not None else _motion_back(chain, k)
    values = {"motion": motion, "turns": turns, "last": last, "value": parameter.default, "solver": plan.solver}
    values |= {"at": k, "partner": -1, "opposite": False}
    if partner is not None:
        values |= {"partner": partner, "opposite": bool(chain.H[k] @ chain.H[partner] < 0.0)}

    def explain_at(T: Array, value: float) -> str:
        back = np.eye(4)
        back[:3] = np.tensordot([1.0, np.cos(value), np.sin(value)] if turns else [1.0, value, 0.0], motion, 1)
        why = plan.explain(T @ back if last else back @ T)
        return f"with {parameter.joint!r} at {value:.6g} {parameter.unit}: {why}"

    return RedundantPlan(
        family=plan.family,
        name=f"{_called(chain, k)}: {plan.name}",
        reason=f"with joint {k + 1} given, of the six others {plan.reason}",
        method=f"Joint {k + 1} ({parameter.joint}) is given, the six others are solved. {plan.method}",
        branches=plan.branches,
        imperfection=plan.imperfection,
        error=plan.error,
        solver=Solver("one joint given", values),
        parameter=parameter,
        value_of=lambda Q: parameter.wrapped(Q[:, k]),
        explain=lambda T: explain_at(T, parameter.default),
        explain_at=explain_at,
    )


def _called(chain: Chain, k: int) -> str:
    kinds = kinds_of(chain)
    return "6R on a slide" if kinds == "PRRRRRR" and k == 0 else f"{kinds}, joint {k + 1} given"


def _no_motion() -> Array:
    """What the first part of :func:`_motion_back` is where nothing is to be moved back."""
    motion = np.zeros((3, 3, 4))
    motion[0, :, :3] = np.eye(3)
    return motion


def _motion_back(chain: Chain, k: int) -> Array:
    """(3, 3, 4) the inverse of the motion of joint ``k``, in the base's frame or, of the last joint, in the tip's."""
    h, p = chain.H[k], chain.points[k]
    if k:
        h, p = chain.R_tip.T @ h, chain.R_tip.T @ (p - chain.P.sum(axis=0))
    motion = np.zeros((3, 3, 4))
    if chain.prismatic[k]:
        motion[0, :, :3] = np.eye(3)
        motion[1, :, 3] = -h
        return motion
    x, y, z = h
    along = np.outer(h, h)
    # Rodrigues' formula for the angle's negative.
    across = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    for part, R in zip(motion, (along, np.eye(3) - along, -across), strict=True):
        part[:, :3] = R
        part[:, 3] = -R @ p
    motion[0, :, 3] += p
    return motion
