"""Seven joints that are singular everywhere once either end joint is held: a joint in the middle is given instead.

If two neighbouring joints share an axis, the first of them is given and the second one takes its value back: the six
others are the same arm for every value. For any other joint in the middle they are a different arm for every value, and
solutions are searched.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from urdf_ik._core import SelfMotion, Solver
from urdf_ik.ik.families import sampled
from urdf_ik.ik.families.parts.family import FamilyMember, RedundantMember
from urdf_ik.ik.families.parts.free_arm import FreeArm
from urdf_ik.ik.families.parts.written import written
from urdf_ik.ik.families.wrappers.one_given import OneGiven
from urdf_ik.kinematics.chain import Chain, is_redundant, kinds_of, typical_stretch
from urdf_ik.kinematics.chain import sampled as sampled_vectors
from urdf_ik.kinematics.chain.redundancy import locked_joint
from urdf_ik.kinematics.structure import Structure, analyse
from urdf_ik.support.text import quoted
from urdf_ik.support.tolerances import DEFAULT
from urdf_ik.typing import Array

Choose = Callable[[Structure, Chain], FamilyMember | None]

# If the Jacobian without an end joint nearly loses rank everywhere (smallest singular value below _POOR, lengths as
# shares of the size), a joint in the middle is held if its smallest singular value is _BETTER times as large.
_POOR, _BETTER = 1e-3, 30.0


def prepare(chain: Chain, six: Sequence[Choose]) -> RedundantMember | None:
    """The plan of seven joints that holds one in the middle; None where an end joint will do.

    Args:
        chain: seven joints.
        six: each takes six joints, the cheaper ones first.
    """
    ends = max(typical_stretch(_without(chain, k)) for k in (0, 6))
    if ends >= _POOR:
        return None
    for k in range(6):
        if _is_shared(chain, k) and not is_redundant(rest := _without(chain, k)):
            relations = analyse(rest)
            plan = next((plan for each in six if (plan := each(relations, rest)) is not None), None)
            if plan is not None:
                return _held(chain, k, plan)
    k = freest(chain)
    if ends >= DEFAULT.singular and typical_stretch(_without(chain, k)) < _BETTER * ends:
        return None
    return sampled.prepare_held(chain, k)


def freest(chain: Chain) -> int:
    """The joint without which the six others move the tip best, in as many ways as the seven do."""
    J = chain.jacobian(sampled_vectors(chain))
    J[:, :3] /= chain.size
    J[:, :, chain.prismatic] *= chain.size
    rank = int((np.median(np.linalg.svd(J, compute_uv=False), axis=0) > DEFAULT.singular).sum())
    left = [np.linalg.svd(np.delete(J, k, axis=2), compute_uv=False)[:, rank - 1] for k in range(chain.n)]
    return int(np.argmax(np.median(left, axis=1)))


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


def _held(chain: Chain, k: int, plan: FamilyMember) -> RedundantMember:
    """The plan that gives joint ``k``, by that of the others with it at zero."""
    parameter, twin = locked_joint(chain, k), chain.joint_names[k + 1]
    still = np.zeros((3, 3, 4))
    still[0, :, :3] = np.eye(3)
    arm = OneGiven(
        motion=still,
        turns=not bool(chain.prismatic[k]),
        last=False,
        value=parameter.default,
        solver=plan.solver.arm,
        before=k,
        opposite=bool(chain.H[k] @ chain.H[k + 1] < 0.0),
    )

    def explain_at(T: Array, at: Array) -> str:
        return f"with {quoted(parameter.joint)} at {at[0]:.6g} {parameter.unit}, or at any other: {plan.explain(T)}"

    return RedundantMember(
        family=plan.family,
        name=f"{kinds_of(chain)}, joint {k + 1} given: {plan.name}",
        reason=f"joints {k + 1} and {k + 2} have one axis; with joint {k + 1} given, of the six others {plan.reason}",
        method=f"Joint {k + 1} ({parameter.joint}) is given, {twin} takes its value back. {plan.method}",
        branches=plan.branches,
        imperfection=plan.imperfection,
        error=plan.error,
        solver=Solver(arm),
        parameters=(parameter,),
        self_motion=SelfMotion(FreeArm(written=written(chain), given=k)),
        value_of=lambda Q, T: parameter.wrapped(Q[:, k : k + 1]),
        explain=lambda T: explain_at(T, np.array([parameter.default])),
        explain_at=explain_at,
    )
