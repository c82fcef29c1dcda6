"""Five revolute joints, completed to six: a sixth axis that stays at zero, or turns about the direction aimed.

The arm of six has a family of its own, with closed form or elimination; its solutions are verified, and polished, on
the five joints as written.
"""

from collections.abc import Callable
from dataclasses import replace
from functools import partial

import numpy as np

from urdf_ik._core import Solver
from urdf_ik.ik.families.parts.explanations import off_by
from urdf_ik.ik.families.parts.family import FamilyMember, columns, self_motion
from urdf_ik.ik.families.parts.written import AXIS, POSE, Aim, Numbers, written
from urdf_ik.kinematics.chain import Chain, is_redundant, kinds_of
from urdf_ik.kinematics.chain.free_axis import FreeAxis
from urdf_ik.kinematics.chain.redundancy import FREE_AXIS, Redundancy
from urdf_ik.kinematics.structure import Structure, analyse
from urdf_ik.support.angles import amount
from urdf_ik.typing import Array

Choose = Callable[[Structure, Chain], FamilyMember | None]

# Where the added axis stands to axis 5 [rad]: never parallel to axis 4, where that is square to axis 5.
_OBLIQUE = 1.05


def prepare_completed(structure: Structure, chain: Chain, choose: Choose) -> FamilyMember | None:
    """The plan for poses of five joints with at most three slides; None for other arms."""
    if chain.n != 5 or chain.prismatic.sum() > 3 or is_redundant(chain):
        return None
    before = structure.triple(1, "parallel") is not None
    crossing = structure.triple(2, "parallel") is not None
    rng = np.random.default_rng(3)
    side = np.cross(chain.H[0 if before else 4], rng.normal(size=3))
    h = np.cos(_OBLIQUE) * chain.H[0 if before else 4] + np.sin(_OBLIQUE) * side / np.linalg.norm(side)
    away = np.zeros(3) if crossing else 0.2 * chain.size * rng.normal(size=3)
    if before:
        whole, at = _with_axis_before(chain, h, chain.points[0] + away), 1
    else:
        whole, at = with_axis_behind(chain, h, chain.points[4] + away), 0
    return _plan(chain, whole, at, Aim(), choose, kinds_of(chain), "that must stay at zero")


def prepare_aimed(chain: Chain, aimed: Array, choose: Choose) -> FamilyMember | None:
    """The plan for the tip's position and the direction of its axis ``aimed`` (3,)."""
    whole = with_axis_behind(chain, chain.R_tip @ aimed, chain.points[-1] + chain.P[-1])
    return _plan(chain, whole, 0, Aim(AXIS, aimed), choose, "5R position and axis", "about the direction")


def with_axis_behind(chain: Chain, h: Array, point: Array) -> Chain:
    """The chain with one more revolute joint behind its last, along ``h`` (3,) through ``point`` (3,) at q = 0."""
    tip = chain.P.sum(axis=0)
    last = chain.points[-1]
    return _extended(chain, np.vstack([chain.H, h]), np.vstack([chain.P[:-1], point - last, tip - point]), behind=True)


def _with_axis_before(chain: Chain, h: Array, point: Array) -> Chain:
    steps = np.vstack([point, chain.points[0] - point, chain.P[1:]])
    return _extended(chain, np.vstack([h, chain.H]), steps, behind=False)


def _extended(chain: Chain, H: Array, P: Array, *, behind: bool) -> Chain:
    def grown(values: tuple[str, ...], value: str) -> tuple[str, ...]:
        return (*values, value) if behind else (value, *values)

    turn = np.array([[-np.inf, np.inf]])
    return replace(
        chain,
        joint_names=grown(chain.joint_names, ""),
        joint_types=grown(chain.joint_types, "continuous"),
        H=H,
        P=P,
        limits=np.vstack([chain.limits, turn] if behind else [turn, chain.limits]),
    )


def _plan(chain: Chain, whole: Chain, at: int, aim: Aim, choose: Choose, name: str, role: str) -> FamilyMember | None:
    six = choose(analyse(whole), whole)
    if six is None:
        return None
    count = len(six.branches)

    most = 8 if aim.kind == POSE else count
    return FamilyMember(
        family=six.family,
        name=f"{name} (six joints with an added axis: {six.name})",
        reason=f"with a sixth axis {role}, {six.reason}",
        method=f"With a sixth axis {role}: {six.method[0].lower()}{six.method[1:]}; verified on the five joints",
        branches=columns(most),
        imperfection=six.imperfection,
        why=partial(off_by, chain, aim=aim),
        solver=Solver(Numbers(kind="completed", written=written(chain, aim), six=six.solver.arm, at=at, columns=most)),
    )


def prepare_free(chain: Chain, plan: FamilyMember, axis: FreeAxis) -> FamilyMember:
    """The plan of an arm that ``plan`` solves for whole poses, with one parameter more, which comes first."""
    parameter = Redundancy(FREE_AXIS, str(axis), (-np.pi, np.pi), 0.0, "rad")
    arm = Numbers(
        kind="axis free",
        motion=axis.motion,
        value=parameter.default,
        solver=plan.solver.arm,
        turns=True,
        last=True,  # the motion is behind the target
    )

    def value_of(Q: Array, T: Array) -> Array:
        reached = chain.fk(Q)
        return np.hstack([axis.angle(np.linalg.inv(T) @ reached)[:, None], plan.value_of(Q, reached)])

    def why(T: Array, values: Array) -> str:
        turned = plan.explain(T @ axis.rotation(values[0]), values[1:])
        return f"turned by {amount(values[0], form='.6g')} about {axis}: {turned}"

    # Curves of six joints and the rotation: a seventh joint behind the tip turns it back to the target.
    direction, point = (chain.R_tip @ np.array(each) for each in (axis.direction, axis.at))
    alone = not plan.parameters and chain.axes is chain
    return replace(
        plan,
        name=f"{plan.name}, rotation about {axis.name} free",
        method=f"The target is turned about {axis}, by a value that is given. {plan.method}",
        solver=Solver(arm),
        parameters=(parameter, *plan.parameters),
        self_motion=self_motion(with_axis_behind(chain, -direction, chain.P.sum(axis=0) + point), 6) if alone else None,
        value_of=value_of,
        why=why,
    )
