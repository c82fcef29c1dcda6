"""``Solver``: a chain with its family and compiled solver, how one is prepared, and why an arm has none."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import combinations, islice
from typing import Any

from numpy.typing import ArrayLike

from urdf_ik import _core
from urdf_ik.errors import ArgumentError, ChainError, UnsupportedArm, printable
from urdf_ik.ik import families
from urdf_ik.ik.families import FamilyMember, axis_added, coupled
from urdf_ik.ik.families.registry import MOST_JOINTS
from urdf_ik.ik.task import NUMBERS, POSE, Task
from urdf_ik.ik.tasks import Control, Targets, control_of
from urdf_ik.kinematics.chain import Chain, CoupledChain, dependent_joints, kinds_of
from urdf_ik.kinematics.chain.free_axis import FreeAxis
from urdf_ik.kinematics.chain.redundancy import Redundancy
from urdf_ik.kinematics.structure import Structure, analyse
from urdf_ik.support.read_only import frozen
from urdf_ik.support.text import quoted
from urdf_ik.typing import Array

_MOST_TRIED = 40
"""Choices of joints to lock that are tried for an error's hint."""


@dataclass(frozen=True, eq=False)
class Solver:
    """A chain, its family, and the compiled solver that serves it; :func:`prepare` makes it.

    Attributes:
        name: the robot's name, for messages.
        chain: screw axes of the joints from base to tip.
        structure: how the axes lie to each other, and how the arm is solved.
        control: what the joints control of the tip.
        task: what a target is; 'pose' unless another one was asked for, a :class:`urdf_ik.Task` included.
        targets: what reads targets of a planar task; None for poses, of which ``asked`` counts.
        member: the arm as a member of its family; None where no solver takes it.
        core: the compiled solver; None where no solver takes the arm.
        single: the compiled solver where targets are poses: it takes a single pose without detours.
        branches: names of the columns of a pose's solutions.
        free_axis: a line in the tip about which it may be turned.
        chosen: names of joints whose values are redundancy parameters because the user chose them.
        velocity_limits: (n,) rad/s or m/s, the URDF's; infinite where it gives none.
        asked: the part of the poses that counts, where targets are poses.
        arm: the :class:`urdf_ik.Arm` that the solver belongs to, which has the cell; None until an arm takes it.
    """

    name: str
    chain: Chain
    structure: Structure
    control: Control
    task: str
    targets: Targets | None
    member: FamilyMember | None
    core: _core.Solver | None
    single: _core.Solver | None
    branches: tuple[str, ...]
    free_axis: FreeAxis | None
    chosen: tuple[str, ...]
    velocity_limits: Array
    asked: Task = POSE
    arm: Any = None  # of a room above, where its class is

    @property
    def joint_names(self) -> tuple[str, ...]:
        """See :attr:`urdf_ik.Arm.joint_names`."""
        return self.chain.joint_names

    @property
    def dof(self) -> int:
        """See :attr:`urdf_ik.Arm.dof`."""
        return self.chain.n

    @property
    def limits(self) -> Array:
        """See :attr:`urdf_ik.Arm.limits`."""
        return self.chain.limits

    @property
    def parameters(self) -> tuple[Redundancy, ...]:
        """Every redundancy parameter, in the order in which solving takes their values; () for most arms."""
        return () if self.member is None else self.member.parameters

    @property
    def parameter(self) -> Redundancy | None:
        """The first redundancy parameter; None where a pose leaves nothing free."""
        return self.parameters[0] if self.parameters else None

    @property
    def redundant_member(self) -> FamilyMember:
        """The member of a family with a redundancy parameter."""
        if (member := self.require_member()).parameters:
            return member
        raise UnsupportedArm(
            f"{self.name}: {self.dof} joints ({', '.join(self.joint_names)}) leave nothing free in a pose; only arms "
            "with seven, or with a free axis (Arm.with_free_axis), have a redundancy parameter"
        )

    @cached_property
    def fixed(self) -> "Solver":
        """This solver without a free axis: the rotation about it counts."""
        return self if self.free_axis is None else self.again(free_axis=None)

    def require_member(self) -> FamilyMember:
        """The arm as a member of its family."""
        if self.member is None:
            raise unsupported(self.name, self.chain, self.structure)
        return self.member

    @property
    def settings(self) -> dict[str, Any]:
        """What :func:`prepare` makes this solver from."""
        names = ("name", "chain", "velocity_limits", "free_axis", "chosen")
        return {"task": self.asked if self.asked != POSE else self.task} | {name: getattr(self, name) for name in names}

    def again(self, **changed: Any) -> "Solver":
        """This solver with other settings: those of :func:`prepare`. It belongs to no arm, but keeps the cell."""
        return replace(prepare(**{**self.settings, **changed}), arm=self.arm)

    def __reduce__(self) -> tuple[Any, ...]:
        # The compiled part is prepared again. An arm that has this solver makes it.
        if self.arm is not None and self.arm.solver is self:
            return getattr, (self.arm, "solver")
        return _remade, (self.arm, self.settings)


def _remade(arm: Any, settings: dict[str, Any]) -> Solver:
    """A solver as it was before it was pickled or copied."""
    return replace(prepare(**settings), arm=arm)


def prepare(
    name: str,
    chain: Chain,
    velocity_limits: Array,
    task: str | Task = "pose",
    free_axis: FreeAxis | None = None,
    chosen: Sequence[str] = (),
) -> Solver:
    """Analyse a chain and prepare its solver.

    Args:
        name: of the robot, for messages.
        chain: the joints from base to tip.
        velocity_limits: (n,) rad/s or m/s.
        task: what targets are; see :meth:`urdf_ik.Arm.ik`.
        free_axis: a line in the tip about which it may be turned; see :meth:`urdf_ik.Arm.with_free_axis`.
        chosen: names of joints whose values are redundancy parameters; see :meth:`urdf_ik.Arm.with_redundancy`.
    """
    joints = _checked_choice(name, chain, chosen)
    made: Any = _core.prepared(lambda: _prepare(name, chain, velocity_limits, task, free_axis, joints))
    solver: Solver = made
    return solver


def _prepare(
    name: str,
    chain: Chain,
    velocity_limits: Array,
    task: str | Task,
    free_axis: FreeAxis | None,
    chosen: tuple[str, ...],
) -> Solver:
    control, structure = control_of(chain), analyse(chain)
    asked, task = (task, task.components) if isinstance(task, Task) else (POSE, task)
    targets = None if task == "pose" or asked != POSE else Targets(name, chain, control, task)
    if asked != POSE:
        from urdf_ik.ik.task_members import member as member_for  # not needed by whole poses

        _check_numbers(name, chain, control, asked)
        member: FamilyMember | None = member_for(chain, asked, lambda: families.choose(structure, chain, chosen))
    else:
        member = targets.plan(structure) if targets else families.choose(structure, chain, chosen)
    if member is None and chosen:
        raise UnsupportedArm(f"{name}: no solver for the other joints with {', '.join(chosen)} given")
    if free_axis is not None:
        _check_free_axis(name, chain, free_axis, member, control.task if targets is None else task)
        member = None if member is None else axis_added.prepare_free(chain, member, free_axis)
    if member is not None:
        structure = replace(
            structure,
            family=member.name,
            reason=member.reason,
            method=member.method,
            branches=member.branches,
            imperfection=member.imperfection,
            error=member.error,
            is_general=member.family.by_elimination and chain.n == 6,
            by_quadratics=member.by_quadratics,
        )
    core = None if member is None else member.solver
    return Solver(
        name=name,
        chain=chain,
        structure=structure,
        control=control,
        task=task,
        targets=targets,
        member=member,
        core=core,
        single=core if targets is None and asked == POSE else None,
        branches=() if member is None else member.branches,
        free_axis=free_axis,
        chosen=chosen,
        velocity_limits=frozen(velocity_limits),
        asked=asked,
    )


def with_free_axis(solver: Solver, axis: Any, at: ArrayLike | None) -> Solver:
    """A solver whose tip may turn about an axis; see :meth:`urdf_ik.Arm.with_free_axis`."""
    free = FreeAxis.read(axis, at)
    if solver.free_axis is not None:
        raise ArgumentError(f"{solver.name} may already turn about {solver.free_axis}; only one axis can be free")
    made = solver.again(free_axis=free)
    solver.require_member()
    made.__dict__["fixed"] = solver
    return made


def fixed_tip(solver: Solver) -> str:
    """The tip, to which a tool can be fixed."""
    if solver.free_axis is None:
        return solver.chain.tip
    raise ArgumentError(
        f"{solver.name}: {solver.free_axis} is free, and a tool would move the tip away from it; mount the tool first, "
        "then say which of its axes is free: arm.with_tool(...).with_free_axis(...)"
    )


def _checked_choice(name: str, chain: Chain, chosen: Sequence[str]) -> tuple[str, ...]:
    """Names of joints that may be the redundancy parameters of an arm."""
    joints = tuple(chosen)
    if unknown := [joint for joint in joints if joint not in chain.joint_names]:
        raise ChainError(
            f"{quoted(unknown[0])} cannot be the redundancy parameter: it is not among the movable joints from "
            f"{quoted(chain.base)} to {quoted(chain.tip)}",
            chain.joint_names,
        )
    if len(set(joints)) < len(joints):
        raise ArgumentError(f"redundancy={joints} given; each joint can be named once")
    if joints and isinstance(chain, CoupledChain):
        raise UnsupportedArm(f"{name}: joints mimic others, and none of them can be the redundancy parameter")
    free = max(chain.n - 6, 0)
    if len(joints) > free:
        raise ArgumentError(f"{name}: redundancy={joints} given, and its {chain.n} joints leave {free} values free")
    return joints


def _check_numbers(name: str, chain: Chain, control: Control, asked: Task) -> None:
    """Refuse a task with more numbers than an arm has joints, with what can be asked instead."""
    needed = NUMBERS[asked.components]
    if chain.n < needed and asked.components != "pose":
        own = "" if control.task == "pose" else f", or the task {control.task!r}"
        typed = f"--task {asked.components.replace(' ', '-')} --closest"
        raise ArgumentError(
            f"{name}: its {chain.n} joints do not control {asked.components!r}, which has {needed} numbers; give the "
            f"whole pose{own}, or ask for the nearest posture: arm.ik_closest(T, task=...) ({typed})"
        )


def _check_free_axis(name: str, chain: Chain, axis: FreeAxis, plan: FamilyMember | None, task: str) -> None:
    """Refuse an axis about which the tip cannot turn freely, with what to do instead."""
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
    if plan is not None and not isinstance(plan.solver, _core.Solver):
        joint = plan.parameters[0].joint
        raise ArgumentError(
            f"{name}: {joint} is given, a joint in the middle, and such an arm takes no free axis; name an end joint, "
            "or none: arm.with_redundancy(...)"
        )


def unsupported(name: str, chain: Chain, structure: Structure) -> UnsupportedArm:
    """The error for an arm without a solver."""
    if isinstance(chain, CoupledChain):
        return UnsupportedArm(
            f"{name}: {coupled.why_not(chain)}; joints that mimic others: "
            f"{', '.join(map(str, chain.followers))}; independent: {', '.join(chain.joint_names)}; {_hint(chain)}"
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
            f"one by one; {_hint(chain)}"
        )
    locked = _locked(chain.joint_names[: chain.n - MOST_JOINTS])
    return UnsupportedArm(
        f"{name}: {chain.n} joints from {quoted(chain.base)} to {quoted(chain.tip)} ({', '.join(chain.joint_names)}); "
        f"at most {MOST_JOINTS} are solved: hold {chain.n - MOST_JOINTS} or more of them, each at a value [rad or m], "
        f"as in {locked}"
    )


def _hint(chain: Chain) -> str:
    """Which joints to lock, so that the others are solved: as few as possible, those that drive others first."""
    drivers = [
        name for name in dict.fromkeys(follower.driver for follower in chain.followers) if name in chain.joint_names
    ]
    names = [*drivers, *(name for name in chain.joint_names if name not in drivers)]
    choices = (locked for count in (1, 2) for locked in combinations(names, count) if chain.n - count >= 2)
    for locked in islice(choices, _MOST_TRIED):
        rest = chain.lock(dict.fromkeys(locked, 0.0))
        if families.choose(analyse(rest), rest) is not None:
            verb = "joint is" if len(locked) == 1 else "joints are"
            return f"it is solved where {len(locked)} {verb} locked at a value [rad or m], as in {_locked(locked)}"
    return f"lock joints at a value [rad or m], as in {_locked(names[:1])}"


def _locked(names: Sequence[str]) -> str:
    values = ", ".join(f"{quoted(name)}: 0.0" for name in names)
    typed = " ".join(f"--lock {printable(name)}=0" for name in names)
    return f"urdf_ik.load(..., locked={{{values}}}) ({typed})"
