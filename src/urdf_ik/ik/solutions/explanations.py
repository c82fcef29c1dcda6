"""Texts about solutions: the reason why a pose has none, and a table."""

from __future__ import annotations

import numpy as np

from urdf_ik.ik.solutions import limits
from urdf_ik.ik.solutions.solution import KeptSolutions, Step
from urdf_ik.support import inputs
from urdf_ik.support.text import aligned, quoted

_MOST_ROWS = 32


def explanation(solutions: KeptSolutions) -> str:
    """Why a single pose has no solution; '' where it has one."""
    if solutions.count:
        return ""
    while solutions.step is not None and not solutions.step.parent.count:
        solutions = solutions.step.parent
    step = solutions.step
    if step is None:
        at = solutions.redundancy
        return str(solutions.solver.why_none(solutions.solver, solutions.poses, at))
    found = "1 solution reaches" if step.parent.count == 1 else f"{step.parent.count} solutions reach"
    if step.how == "within":
        inside = " inside the joint limits" if {"limits", "turns"} & set(step.parent.filters) else ""
        return f"{found} the pose{inside}, none as near to the reference as asked; {_too_far(step)}"
    if step.how != "collision":
        return f"{found} the pose, none inside the joint limits; {_out_of_limits(step.parent, step.amount)}"
    inside = " inside the joint limits" if {"limits", "turns"} & set(step.parent.filters) else ""
    near = f" or comes within {step.amount:g} m of one" if step.amount else ""
    return f"{found} the pose{inside}, and every one is in collision{near}{_touching(step)}"


def table(solutions: KeptSolutions, degrees: bool = False) -> str:
    """The solutions of a single pose, a line each; a batch in one sentence."""
    degrees = inputs.flag(degrees, "degrees")
    name = solutions.solver.name
    how = f" ({', '.join(solutions.filters)})" if solutions.filters else ""
    if solutions.shape:
        count = solutions.count
        return f"{name}: {count.size} poses, {np.count_nonzero(count)} of them solved, {count.sum()} solutions{how}"
    at = parameters_in_words(solutions, degrees)
    if not solutions.count:
        return f"{name}: no solution{at}{how}: {explanation(solutions)}"
    kinds = solutions.solver.chain.joint_types
    angle = "deg" if degrees else "rad"
    scale = np.array([np.rad2deg(1.0) if degrees and kind != "prismatic" else 1.0 for kind in kinds])
    rows = [["#", "branch", *(f"q{i + 1} [{'m' if k == 'prismatic' else angle}]" for i, k in enumerate(kinds)), ""]]
    shown = list(solutions)
    for one in shown[:_MOST_ROWS]:
        values = [f"{x:.{2 if s != 1.0 else 4}f}" for x, s in zip(one.q * scale, scale, strict=True)]
        flag = f"singular: {one.singular.name}".lower() if one.singular else ""
        rows.append([str(one.index), one.branch, *values, flag])
    lines = [f"{name}: {len(shown)} solution{'s' if len(shown) != 1 else ''}{at}{how}"]
    lines += aligned(rows, left=(1, len(rows[0]) - 1))
    if len(shown) > _MOST_ROWS:
        lines.append(f"... and {len(shown) - _MOST_ROWS} more")
    return "\n".join(lines)


def parameters_in_words(solutions: KeptSolutions, degrees: bool = False) -> str:
    """At which values of its redundancy parameters a single pose was solved, such as ' at joint_7 = 0.5000 rad'."""
    if solutions.redundancy is None or solutions.shape:
        return ""
    parts = []
    for parameter, value in zip(solutions.solver.parameters, np.atleast_1d(solutions.redundancy) + 0.0, strict=True):
        turned = degrees and parameter.unit == "rad"
        shown = f"{np.rad2deg(value):.2f} deg" if turned else f"{value:.4f} {parameter.unit}"
        parts.append(f"{parameter.label} = {shown}")
    return f" at {', '.join(parts)}"


def _touching(step: Step) -> str:
    """What touches what in the first of the solutions before; '' where that is over, since a world can be changed."""
    assert step.model is not None
    first = next(iter(step.parent))
    nearest = step.model.nearest_pair(first.q)
    if nearest.distance > step.amount:
        return ""
    return f"; in the first, {first.branch}, these are {' and '.join(map(quoted, nearest.links))}"


def _too_far(step: Step) -> str:
    """The solution before that is least far beyond what is allowed, and the joint that is furthest beyond."""
    assert step.apart is not None and step.within is not None
    solver, apart = step.parent.solver, np.abs(step.apart)
    best = int(np.nanargmin((apart - step.within).max(axis=-1)))
    i = int(np.argmax(apart[best] - step.within))
    far, unit = f"{apart[best, i]:.4g}", "rad" if step.parent.rotary[i] else "m"
    return (
        f"the closest, {step.parent.names[best]}, has {quoted(solver.joint_names[i])} {far} {unit} from it, where "
        f"{step.within[i]:.4g} is allowed"
    )


def _out_of_limits(solutions: KeptSolutions, tol: float) -> str:
    """The solution that is least far outside the limits, and its joints that are."""
    solver = solutions.solver
    turning = solver.chain.image_turns * ("turns" not in solutions.filters)
    image, out = limits.excess(solutions.to_array(), solver.limits, turning, tol)
    best = int(np.argmin(np.abs(out).max(axis=-1)))
    parts = []
    for i in np.flatnonzero(out[best]):
        unit = "rad" if solutions.rotary[i] else "m"
        side, limit = ("upper", solver.limits[i, 1]) if out[best, i] > 0.0 else ("lower", solver.limits[i, 0])
        margin = f", with a margin of {-tol:g} {unit}" if tol < 0.0 else ""
        parts.append(
            f"{quoted(solver.joint_names[i])} at {image[best, i]:.4f} {unit}, {abs(out[best, i]):.4g} {unit} beyond "
            f"its {side} limit of {limit:.4f} {unit}{margin}"
        )
    return f"the closest, {list(solutions)[best].branch}, has {' and '.join(parts)}"
