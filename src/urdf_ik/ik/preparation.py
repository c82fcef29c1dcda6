"""From a chain to its solver: the structure of the axes, the family, the compiled solver."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from urdf_ik import _core
from urdf_ik.errors import ArgumentError, UnsupportedArm
from urdf_ik.ik import families
from urdf_ik.ik.explanation import why_none
from urdf_ik.ik.families.wrappers import axis_free
from urdf_ik.ik.refusals import check_free_axis, check_given
from urdf_ik.ik.solver import Solver
from urdf_ik.ik.tasks import TASKS, Targets, control_of
from urdf_ik.kinematics.chain import Chain
from urdf_ik.kinematics.chain.free_axis import FreeAxis
from urdf_ik.kinematics.structure import analyse
from urdf_ik.support.read_only import frozen
from urdf_ik.support.text import quoted

if TYPE_CHECKING:
    from urdf_ik.ik.contacts import Contacts


def prepare(
    name: str,
    chain: Chain,
    velocity_limits: NDArray[np.float64],
    contacts: Contacts,
    task: str = "pose",
    free_axis: FreeAxis | None = None,
    given: Any = (),
) -> Solver:
    """Analyse a chain and prepare its solver.

    Args:
        name: of the robot, for messages.
        chain: the joints from base to tip.
        velocity_limits: (n,) rad/s or m/s.
        contacts: the cell, which answers whether solutions touch anything.
        task: what targets are; see :meth:`urdf_ik.Arm.ik`.
        free_axis: a line in the tip about which it may be turned; see :meth:`urdf_ik.Arm.with_free_axis`.
        given: names of joints whose values are redundancy parameters; see :meth:`urdf_ik.Arm.with_redundancy`.

    Raises:
        ChainError: one of ``given`` is not a joint of the chain.
        ArgumentError: there is no such task, the arm cannot control it, more joints are given than a pose leaves free,
            or the tip cannot turn about ``free_axis``.
        UnsupportedArm: no solver takes this arm with these settings.
    """
    made: Any = _core.prepared(
        lambda: _prepare(name, chain, velocity_limits, contacts, task, free_axis, check_given(name, chain, given))
    )
    solver: Solver = made
    return solver


def _prepare(
    name: str,
    chain: Chain,
    velocity_limits: NDArray[np.float64],
    contacts: Contacts,
    task: str,
    free_axis: FreeAxis | None,
    given: tuple[str, ...],
) -> Solver:
    """See :func:`prepare`."""
    control, structure = control_of(chain), analyse(chain)
    targets = None if check_task(task) == "pose" else Targets(name, chain, control, task)
    member = targets.plan(structure) if targets else families.choose(structure, chain, given)
    if member is None and given:
        raise UnsupportedArm(f"{name}: no solver for the other joints with {', '.join(given)} given")
    if free_axis is not None:
        check_free_axis(name, chain, free_axis, member, control.task if targets is None else task)
        member = None if member is None else axis_free.prepare(chain, member, free_axis)
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
    solver = Solver(
        name=name,
        chain=chain,
        structure=structure,
        control=control,
        task=task,
        targets=targets,
        member=member,
        core=core,
        single=core if targets is None else None,
        branches=() if member is None else member.branches,
        free_axis=free_axis,
        given=given,
        velocity_limits=frozen(velocity_limits),
        contacts=contacts,
        remake=prepare,
        why_none=why_none,
    )
    solver.by_task[task] = solver
    return solver


def check_task(task: Any) -> str:
    """A task's name, as it was given.

    Raises:
        ArgumentError: it is not text.
    """
    if isinstance(task, str):
        return task
    raise ArgumentError(f"task={quoted(task)} given; one of {', '.join(map(repr, TASKS))} is needed")


def with_free_axis(solver: Solver, axis: Any, at: ArrayLike | None) -> Solver:
    """A solver whose tip may turn about an axis; see :meth:`urdf_ik.Arm.with_free_axis`.

    Raises:
        ArgumentError: an invalid axis, or the tip may turn about one already.
        UnsupportedArm: no solver takes this arm.
    """
    free = FreeAxis.read(axis, at)
    if solver.free_axis is not None:
        raise ArgumentError(f"{solver.name} may already turn about {solver.free_axis}; only one axis can be free")
    made = solver.again(free_axis=free)
    solver.require_member()
    made.__dict__["fixed"] = solver
    return made


def fixed_tip(solver: Solver) -> str:
    """The tip, to which a tool can be fixed.

    Raises:
        ArgumentError: the tip may turn about an axis.
    """
    if solver.free_axis is None:
        return solver.chain.tip
    raise ArgumentError(
        f"{solver.name}: {solver.free_axis} is free, and a tool would move the tip away from it; mount the tool first, "
        "then say which of its axes is free: arm.with_tool(...).with_free_axis(...)"
    )


def with_locked(solver: Solver, values: Mapping[str, float]) -> Solver:
    """The solver of the other joints, some joints of the chain being held at values [rad or m]."""
    chain = solver.chain.lock(values)
    kept = [name in chain.joint_names for name in solver.joint_names]
    given = tuple(name for name in solver.given if name in chain.joint_names)
    return solver.again(chain=chain, velocity_limits=solver.velocity_limits[kept], given=given)
