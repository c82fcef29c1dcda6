"""Names along a plan of an arm whose branches have only numbers: a solution that is followed keeps its number."""

from __future__ import annotations

from dataclasses import replace

from urdf_ik.ik.pose_solving import solve
from urdf_ik.ik.solutions import local_names
from urdf_ik.paths.planned_motion import Plan


def followed(plan: Plan) -> Plan:
    """A plan whose branches keep the number that they have at the first waypoint, or after a change.

    The arm moves from waypoint to waypoint without a jump, so that the number of the first one names the whole way. The
    sign before it is that of the Jacobian's determinant at each waypoint: where it changes, the way crosses a
    singularity. Names that geometry gives stay as they are.

    Example:
        >>> import urdf_ik
        >>> arm = urdf_ik.load("scara_rrpr")
        >>> T0, T1 = arm.fk([[0.3, 0.5, 0.1, 0.2], [0.5, 0.7, 0.1, 0.2]])
        >>> set(followed(arm.follow(urdf_ik.line(T0, T1, 10))).branches)
        {'elbow right'}
    """
    if not local_names.local(plan.solver.structure.branches):
        return plan
    if not plan.found:
        return _with_signed_stops(plan)
    signs = local_names.determinant_signs(plan.solver, plan.q)
    begins = [0, *(change.waypoint for change in plan.changes)]
    names: list[str] = []
    for begin, end in zip(begins, [*begins[1:], len(plan.q)], strict=True):
        for k in range(begin, end):
            own = plan.branches[begin if local_names.is_local(plan.branches[k]) else k]
            sign = 0 if signs is None or not local_names.is_local(own) else int(signs[k])
            names.append(f"{local_names.sign_in_words(sign)}{own}")
    changes = tuple(
        each._replace(before=names[each.waypoint - 1], after=names[each.waypoint]) for each in plan.changes
    )
    others = plan.others
    return replace(
        plan,
        branches=tuple(names),
        changes=changes,
        others=None if others is None else lambda: tuple(followed(each) for each in others()),
    )


def _with_signed_stops(plan: Plan) -> Plan:
    """A path's stops, their branches named as the solutions of its first waypoint are."""
    if plan.solver.parameters:
        return plan
    names = dict(zip(plan.solver.structure.branches, solve(plan.solver, plan.poses[0]).names, strict=True))
    stops = tuple(each._replace(branch=str(names.get(each.branch, each.branch))) for each in plan.stops)
    return replace(plan, stops=stops)
