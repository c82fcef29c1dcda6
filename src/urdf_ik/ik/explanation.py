"""Explanations of targets without a solution."""

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from urdf_ik.errors import ArgumentError, PoseError
from urdf_ik.ik.pose_solving import solve
from urdf_ik.ik.redundancy.interval_search import intervals
from urdf_ik.ik.solver import Solver
from urdf_ik.kinematics.chain.redundancy import spread
from urdf_ik.support.angles import amount, shown
from urdf_ik.typing import Array


def explain(solver: Solver, T: Any, redundancy: ArrayLike | None = None) -> str:
    """Why the single pose ``T`` (4, 4) has no solution inside the joint limits, with what is out of range.

    '' where it has one, with seven joints at any value of the parameter. Limits are named only where there are
    solutions outside them.

    Args:
        solver: of the arm.
        T: the pose.
        redundancy: the redundancy parameter, (k,) of k of them; default: their defaults.

    Example:
        >>> import urdf_ik
        >>> arm = urdf_ik.load("zyyzyz_6r")
        >>> arm.explain(urdf_ik.pose([0.0, 0.0, 4.0]))
        'wrist centre 2.8 m from the shoulder (axis 2), reach 2.1 m: 0.7 m too far'
        >>> arm.explain(arm.fk([0.3, -0.5, 0.8, 0.4, 0.7, -0.2]))
        ''
    """
    found = solve(solver, T, redundancy=redundancy)
    if not found.shape and found.count:
        why = found.within_limits().explain()
        elsewhere = why and redundancy is None and len(solver.parameters) == 1
        return "" if elsewhere and len(intervals(solver, T)) else why
    return why_none(solver, T, redundancy)


def why_none(solver: Solver, T: Any, redundancy: ArrayLike | None = None) -> str:
    """Why one target has no solution, joint limits aside."""
    member = solver.require_member()
    if solver.targets is not None:
        target = solver.targets.read(T)
        if target.ndim != 1:
            raise PoseError(f"an array of shape {target.shape} given; explain takes a single target")
        whole = solver.targets.poses(target[None])[0]
        return member.why(whole) + in_mm(solver, whole)
    target = solver.asked.read_targets(T)
    if target.ndim != 2:
        raise PoseError(f"an array of shape {target.shape} given; explain takes a single pose (4, 4)")
    return _why_none(solver, target, redundancy) + in_mm(solver, target)


def in_mm(solver: Solver, T: Array) -> str:
    """A question, where a pose is out of reach in m and not in mm."""
    away = float(np.linalg.norm(T[:3, 3] - solver.chain.points[0]))
    if not 10.0 * solver.chain.size < away <= 1000.0 * solver.chain.size:
        return ""
    x, y, z = T[:3, 3] / 1000.0
    return f"; are these mm? Positions are in m, so these would be {x:g}, {y:g}, {z:g}"


def _why_none(solver: Solver, target: Array, redundancy: ArrayLike | None) -> str:
    """Why one pose (4, 4) has no solution."""
    member = solver.require_member()
    if redundancy is None and not member.parameters:
        return member.why(target)
    redundant = solver.redundant_member
    if len(redundant.parameters) == 1 and redundant.self_motion is not None:
        return _along_parameter(solver, target, redundancy)
    _, values = spread(redundant.parameters, target, redundant.defaults if redundancy is None else redundancy)
    if values.ndim != 1:
        raise ArgumentError(
            f"redundancy of shape {values.shape} given; explain takes one value of each of the "
            f"{len(redundant.parameters)} parameters"
        )
    why = redundant.explain(target, np.asarray(values))
    if redundancy is not None:
        return why
    from urdf_ik.ik.redundancy.elsewhere import values_inside

    other = np.atleast_1d(values_inside(solver, target))
    if (other == redundant.defaults).all():
        return f"{why}; no other values were found"
    named = zip(redundant.parameters, other, strict=True)
    return f"{why}; there are solutions at " + ", ".join(f"{p.label} {amount(x, p.unit, '.4f')}" for p, x in named)


def _along_parameter(solver: Solver, T: Array, redundancy: ArrayLike | None) -> str:
    """Why one pose (4, 4) has no solution at a value of the only parameter, and at which values it has."""
    member = solver.redundant_member
    parameter = member.parameters[0]
    value = parameter.check(parameter.default if redundancy is None else redundancy)
    if value.ndim:
        raise ArgumentError(f"redundancy of shape {value.shape} given; explain takes a single value")
    places = ", ".join(
        f"{shown(low, parameter.unit):.4f} to {amount(high, parameter.unit, '.4f')}"
        for low, high in intervals(solver, T, within_limits=False).merged()
    )
    why = member.explain(T, value.reshape(1))
    return f"{why}; " + (f"limits aside there are solutions at {places}" if places else "nor at other values")
