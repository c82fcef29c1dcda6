"""How a plan shows: a few lines at a prompt, tables in a notebook."""

from __future__ import annotations

from typing import Any

import numpy as np

from urdf_ik.support.display import html_of
from urdf_ik.support.text import Section


def title(plan: Any) -> str:
    """Whose plan it is, whether it was found, and whether contacts were checked."""
    found = f"Plan of {plan.solver.name}: {'found' if plan.found else 'not found'}, {len(plan.poses)} waypoints"
    found = f"{found}, contacts not checked: {plan.unchecked}" if plan.unchecked else found
    return f"{found}, {plan.unlooked}" if plan.unlooked else found


def lines(plan: Any) -> list[str]:
    """What is worth knowing of a plan at a glance, or where each branch stops."""
    if not plan.found:
        return [str(stop) for stop in plan.stops]
    steps = np.abs(np.diff(plan.q, axis=0)).max(axis=0, initial=0.0)
    joint = int(np.argmax(steps))
    return [
        " then ".join(dict.fromkeys(plan.branches)),
        f"cost {plan.cost:.6g}, {len(plan.changes)} reconfigurations",
        f"largest step {steps[joint]:.4g} of {plan.solver.joint_names[joint]}",
        f"{len(plan.motion) - len(plan.q)} waypoints added between those given",
    ]


def html(plan: Any) -> str:
    """The same for a notebook, with each joint's range and the margins, or the reason why each branch stops."""
    if not plan.found:
        stops = tuple((stop.branch, str(stop.waypoint), stop.cause, stop.reason) for stop in plan.stops)
        header: tuple[str, ...] = ("start branch", "before waypoint", "cause", "reason")
        return html_of(title(plan), "no plan", False, [Section("", header, stops)])
    header = ("joint", "unit", "first", "last", "least", "most", "lower limit", "upper limit")
    joints = tuple(
        (name, "m" if kind == "prismatic" else "rad", *(f"{value:.4f}" for value in (q[0], q[-1], q.min(), q.max())),
         *(f"{bound:.4f}" if np.isfinite(bound) else "none" for bound in bounds))
        for name, kind, q, bounds in zip(plan.solver.joint_names, plan.solver.chain.joint_types, plan.q.T,
                                         plan.solver.limits, strict=True)
    )  # fmt: skip
    margins = plan.margins
    rows = tuple(
        (what, f"{values.min():.4g}", str(int(np.argmin(values))))
        for what, values in (("room to a limit [rad or m]", margins.limits), ("clearance [m]", margins.clearance),
                             ("manipulability", margins.manipulability))
        if not np.isnan(values).any()
    )  # fmt: skip
    sections = [
        Section("", remarks=tuple(lines(plan))),
        Section("joints at the waypoints", header, joints),
        Section("margins", ("least", "value", "at waypoint"), rows),
    ]
    return html_of(title(plan), "found" if not plan.unchecked else "found, contacts not checked", True, sections)
