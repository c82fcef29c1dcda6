"""Reasons why an arm has no solver, with hints."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations, islice
from typing import Any

from urdf_ik._core import Solver
from urdf_ik.errors import ArgumentError, ChainError, UnsupportedArm, printable
from urdf_ik.ik import families
from urdf_ik.ik.families import FamilyMember, RedundantMember, coupled
from urdf_ik.ik.families.registry import MOST_JOINTS
from urdf_ik.kinematics.chain import Chain, CoupledChain, dependent_joints, kinds_of
from urdf_ik.kinematics.chain.free_axis import FreeAxis
from urdf_ik.kinematics.structure import Structure, analyse
from urdf_ik.support import inputs
from urdf_ik.support.text import quoted

_MOST_TRIED = 40
"""Choices of joints to lock that are tried for an error's way out."""
_WHOLE = 7
"""Joints of a chain that is solved whole."""


def check_given(name: str, chain: Chain, given: Any) -> tuple[str, ...]:
    """Names of joints that may be the redundancy parameters of an arm.

    Raises:
        ChainError: one is no joint of the chain; the error lists those that are.
        ArgumentError: no names, the same joint twice, or more of them than a pose leaves free.
        UnsupportedArm: joints mimic others.
    """
    needed = "names of joints"
    joints = inputs.items(given, "redundancy", needed)
    if any(not isinstance(each, str) for each in joints):
        raise ArgumentError(f"redundancy={quoted(given)} given; {needed} are needed")
    if unknown := [each for each in joints if each not in chain.joint_names]:
        raise ChainError(
            f"{quoted(unknown[0])} cannot be the redundancy parameter: it is not among the movable joints from "
            f"{quoted(chain.base)} to {quoted(chain.tip)}",
            chain.joint_names,
        )
    if len(set(joints)) < len(joints):
        raise ArgumentError(f"redundancy={quoted(joints)} given; each joint can be named once")
    if joints and isinstance(chain, CoupledChain):
        raise UnsupportedArm(f"{name}: joints mimic others, and none of them can be the redundancy parameter")
    if len(joints) > max(chain.n - 6, 0):
        raise ArgumentError(
            f"{name}: redundancy={quoted(joints)} given, and its {chain.n} joints leave {max(chain.n - 6, 0)} values "
            "free"
        )
    return joints


def check_free_axis(name: str, chain: Chain, axis: FreeAxis, plan: FamilyMember | None, task: str) -> None:
    """That the tip of an arm may turn about an axis.

    Args:
        name: of the arm.
        chain: its joints.
        axis: the axis.
        plan: how its poses are solved.
        task: what its joints control.

    Raises:
        ArgumentError: it is no axis, or a joint in the arm's middle is given.
        ArgumentError: the arm controls less than any pose, which leaves nothing to choose about a rotation.
    """
    inputs.kind(axis, "rotation", "free_axis", "an axis, as Arm.with_free_axis makes it,")
    if task != "pose":
        raise ArgumentError(
            f"{name}: its {chain.n} joints control the task {task!r}, which leaves rotations free as it is: "
            f"arm.ik(target, task={task!r}); only an arm that controls whole poses takes a free axis"
        )
    if plan is not None and chain.n < 6:
        raise ArgumentError(
            f"{name}: its {chain.n} joints do not reach every pose, and another rotation about {axis} is out of reach "
            "as a rule; only arms with six joints or more take a free axis"
        )
    if plan is not None and not isinstance(plan.solver, Solver):
        joint = plan.parameters[0].joint if isinstance(plan, RedundantMember) else None
        raise ArgumentError(
            f"{name}: {joint} is given, a joint in the middle, and such an arm takes no free axis; name an end joint, "
            "or none: arm.with_redundancy(...)"
        )


def unsupported(name: str, chain: Chain, structure: Structure) -> UnsupportedArm:
    """The error for an arm without a solver."""
    if isinstance(chain, CoupledChain):
        return UnsupportedArm(
            f"{name}: {coupled.why_not(chain)}; joints that mimic others: "
            f"{', '.join(map(str, chain.followers))}; independent: {', '.join(chain.joint_names)}; {_way_out(chain)}"
        )
    if chain.n == 0:
        return UnsupportedArm(f"{name}: no joint moves between {quoted(chain.base)} and {quoted(chain.tip)}")
    same = dependent_joints(chain)
    if same:
        return UnsupportedArm(
            f"{name}: the joints are redundant, and a pose has a continuum of solutions or none: at every joint vector "
            f"each of {', '.join(same)} moves the tip as the others of these do together. Hold one of them at a value "
            f"[rad or m], as in urdf_ik.load(..., locked={{{quoted(same[-1])}: 0.0}}). {structure}"
        )
    if chain.n == 6:
        return UnsupportedArm(
            f"{name}: no solver for two slides three joints apart ({kinds_of(chain)}) without a "
            "spherical wrist at either end; one of them held at a value, as in "
            f"urdf_ik.load(..., locked={{name: 0.0}}), leaves five joints that are solved. {structure}"
        )
    if chain.n <= 7:
        return UnsupportedArm(f"{name}: no solver for this arm yet. {structure}")
    if chain.n <= MOST_JOINTS:
        return UnsupportedArm(
            f"{name}: no solver for any six of its {chain.n} joints ({', '.join(chain.joint_names)}), the others given "
            f"one by one; {_way_out(chain)}"
        )
    held = _locked(chain.joint_names[: chain.n - MOST_JOINTS])
    return UnsupportedArm(
        f"{name}: {chain.n} joints from {quoted(chain.base)} to {quoted(chain.tip)} ({', '.join(chain.joint_names)}); "
        f"at most {MOST_JOINTS} are solved: hold {chain.n - MOST_JOINTS} or more of them, each at a value [rad or m], "
        f"as in {held}{_shorter(chain)}"
    )


def _way_out(chain: Chain) -> str:
    """Which joints to lock, so that the others are solved: as few as possible, those that drive others first."""
    drivers = [name for name in dict.fromkeys(each.driver for each in chain.followers) if name in chain.joint_names]
    names = [*drivers, *(name for name in chain.joint_names if name not in drivers)]
    choices = (held for count in (1, 2) for held in combinations(names, count) if chain.n - count >= 2)
    for held in islice(choices, _MOST_TRIED):
        rest = chain.lock(dict.fromkeys(held, 0.0))
        if families.choose(analyse(rest), rest) is not None:
            others = "joint is" if len(held) == 1 else "joints are"
            return f"it is solved where {len(held)} {others} locked at a value [rad or m], as in {_locked(held)}"
    return f"lock joints at a value [rad or m], as in {_locked(names[:1])}{_shorter(chain)}"


def _locked(names: Sequence[str]) -> str:
    held = ", ".join(f"{quoted(name)}: 0.0" for name in names)
    typed = " ".join(f"--lock {printable(name)}=0" for name in names)
    return f"urdf_ik.load(..., locked={{{held}}}) ({typed})"


def _shorter(chain: Chain) -> str:
    """The longest part of a chain with at most seven joints, in words."""
    above = {joint.child: joint for joint in chain.tree}
    link, count = chain.tip, 0
    while link != chain.base and link in above:
        moves = above[link].column is not None
        if count + moves > _WHOLE:
            return f"; or take the last {count} joints alone, with base={quoted(link)}"
        link, count = above[link].parent, count + moves
    return ""
