"""Arms with more than six joints: some joints are given as redundancy parameters, and the six others have a solver.

An end joint that is held at a value only moves the target: T' = E1(v)^-1 T for the first joint, T' = T En(v)^-1 for the
last one. The other joints are the same arm for every value, so one plan serves all values. With a joint in the middle
held, the others are a different arm for every value: see :mod:`urdf_ik.ik.families.wrappers.middle_given`.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from urdf_ik._core import SelfMotion, Solver
from urdf_ik.ik.families.parts.family import FamilyMember, RedundantMember
from urdf_ik.ik.families.parts.free_arm import FreeArm
from urdf_ik.ik.families.parts.written import written
from urdf_ik.ik.families.wrappers import degenerate, middle_given
from urdf_ik.ik.families.wrappers.imperfect import without_boxes
from urdf_ik.ik.families.wrappers.one_given import OneGiven
from urdf_ik.kinematics.chain import Chain, is_redundant, kinds_of
from urdf_ik.kinematics.chain.free_axis import turning
from urdf_ik.kinematics.chain.redundancy import locked_joint
from urdf_ik.kinematics.structure import Structure, analyse
from urdf_ik.support.text import quoted
from urdf_ik.typing import Array

Choose = Callable[[Structure, Chain], FamilyMember | None]

COSTS = ("in closed form", "by a quartic", "in closed form nearby, and refined", "by elimination")
"""How six joints are solved, the cheapest first: 0.3, 1, 10 and 60 us a pose, by the tables of docs/speed.md."""


class Ways(NamedTuple):
    """How the joints that are not given may be solved.

    Attributes:
        seven: takes seven joints by a family of their own.
        six: each takes six joints, the cheaper ones first; a later one is used if no earlier one takes them.
    """

    seven: Choose
    six: Sequence[Choose]


def prepare(chain: Chain, ways: Ways, given: tuple[str, ...] = ()) -> RedundantMember | None:
    """The plan that holds all joints but six; None where no six joints have a solver.

    Args:
        chain: seven joints or more.
        ways: how the others are solved.
        given: names of joints to hold. If too few are named, the end joint whose others have the cheapest solver is
            held too; a joint in the middle only if no end joint is possible.
    """
    if chain.n == 7 and not given and (in_the_middle := degenerate.prepare(chain, ways.six)) is not None:
        return in_the_middle
    for six in ways.six:
        plan = _prepared(chain, ways.seven, six, given, tuple(range(1, chain.n + 1)))
        if isinstance(plan, RedundantMember):
            return plan
    if given:
        return None
    others = (prepare(chain, ways, (name,)) for name in chain.joint_names[1:-1])
    return next((plan for plan in others if plan is not None), None)


def _prepared(
    chain: Chain, seven: Choose, six: Choose, given: tuple[str, ...], numbers: tuple[int, ...]
) -> FamilyMember | None:
    """See :func:`prepare`; the joints are called by ``numbers``."""
    if chain.n == 6:
        return None if given or is_redundant(chain) else six(analyse(chain), chain)
    if chain.n == 7 and not given and (own := seven(analyse(chain), chain)) is not None:
        return own
    last = chain.n - 1
    named = [chain.joint_names.index(name) for name in given]
    middle = next((k for k in named if 0 < k < last), None)
    if middle is not None:
        name, *others = (chain.joint_names[middle], *(n for n in given if n != chain.joint_names[middle]))

        def at(rest: Chain) -> FamilyMember | None:
            return _prepared(rest, seven, six, tuple(others), _without(numbers, middle))

        return middle_given.prepare(chain, middle, numbers[middle], at)
    ends = [k for k in named if k in (0, last)] or [last, 0]
    plans: dict[int, FamilyMember] = {}
    for k in ends:
        name = chain.joint_names[k]
        others = [each for each in given if each != name]
        plan = _prepared(chain.lock({name: 0.0}), seven, six, tuple(others), _without(numbers, k))
        if plan is not None:
            plans[k] = plan
            if plan.family.by_elimination:
                break  # the other end costs the same
    if not plans:
        return None
    k = min(plans, key=lambda end: cost(plans[end]))
    if given:
        why = "as asked"
    elif len(plans) == 2:
        other = last - k
        better = cost(plans[k]) < cost(plans[other])
        theirs = f"those of joint {numbers[other]} {COSTS[cost(plans[other])]}"
        same = f"as those of joint {numbers[other]} would be"
        why = f"whose others are solved {COSTS[cost(plans[k])]}, {theirs if better else same}"
    else:
        why = f"whose others are solved {COSTS[cost(plans[k])]}"
    return _held(chain, k, plans[k], numbers[k], why)


def _without(numbers: tuple[int, ...], k: int) -> tuple[int, ...]:
    return (*numbers[:k], *numbers[k + 1 :])


def cost(plan: FamilyMember) -> int:
    """Index in ``COSTS``: exact closed forms, exact ones with a quartic, those near an ideal arm, eliminations."""
    if plan.family.by_elimination:
        return 3
    return int(not plan.family.by_quadratics) if plan.is_exact else 2


def _held(chain: Chain, k: int, plan: FamilyMember, number: int, why: str) -> RedundantMember:
    parameter = locked_joint(chain, k)
    motion, turns, last = _motion_back(chain, k), not bool(chain.prismatic[k]), k > 0
    arm = OneGiven(
        motion=motion, turns=turns, last=last, value=parameter.default, solver=without_boxes(plan.solver.arm)
    )
    inner = plan if isinstance(plan, RedundantMember) else None

    def value_of(Q: Array, T: Array) -> Array:
        own = parameter.wrapped(Q[:, k : k + 1])
        return own if inner is None else np.hstack([own, inner.value_of(np.delete(Q, k, axis=1), T)])

    def explain_at(T: Array, at: Array) -> str:
        value = float(at[0])
        back = np.eye(4)
        back[:3] = np.tensordot([1.0, np.cos(value), np.sin(value)] if turns else [1.0, value, 0.0], motion, 1)
        moved = T @ back if last else back @ T
        reason = plan.explain(moved) if inner is None else inner.explain_at(moved, at[1:])
        return f"with {quoted(parameter.joint)} at {value:.6g} {parameter.unit}: {reason}"

    parameters = (parameter, *(() if inner is None else inner.parameters))
    defaults = np.array([each.default for each in parameters])
    return RedundantMember(
        family=plan.family,
        name=named(chain, k, number, plan),
        reason=f"with joint {number} given, {why}: {plan.reason}",
        method=f"Joint {number} ({parameter.joint}) is given, {_others(chain.n - 1)} are solved. {plan.method}",
        branches=plan.branches,
        imperfection=plan.imperfection,
        error=plan.error,
        solver=Solver(arm),
        parameters=parameters,
        self_motion=None if inner else SelfMotion(FreeArm(written=written(chain), given=k)),
        value_of=value_of,
        explain=lambda T: explain_at(T, defaults),
        explain_at=explain_at,
    )


def named(chain: Chain, k: int, number: int, plan: FamilyMember) -> str:
    """The name of the plan of a chain whose joint ``k`` is given."""
    if chain.prismatic[k]:
        return f"{kinds_of(chain.lock({chain.joint_names[k]: 0.0}))} on a slide: {plan.name}"
    return f"{kinds_of(chain)}, joint {number} given: {plan.name}"


def _others(count: int) -> str:
    return f"the {('six', 'seven', 'eight')[count - 6]} others"


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
