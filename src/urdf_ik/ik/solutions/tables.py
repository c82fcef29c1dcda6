"""Solutions as text, as tables of pandas and xarray, and as HTML for a notebook."""

from collections.abc import Sequence
from html import escape
from typing import Any

import numpy as np
from numpy.typing import NDArray

from urdf_ik.ik.solutions import limits
from urdf_ik.ik.solutions.solution import KeptSolutions, Singular, Step
from urdf_ik.kinematics import velocity
from urdf_ik.kinematics.chain import Chain
from urdf_ik.support import extras
from urdf_ik.support.angles import amount, shown
from urdf_ik.support.palette import colours
from urdf_ik.support.report import Markup
from urdf_ik.support.report import table as html_table
from urdf_ik.support.text import aligned, quoted
from urdf_ik.typing import Array

_MOST_ROWS = 32


def explanation(solutions: KeptSolutions) -> str:
    """Why a single pose has no solution; '' where it has one."""
    if solutions.count:
        return ""
    while solutions.step is not None and not solutions.step.parent.count:
        solutions = solutions.step.parent
    step = solutions.step
    if step is None:
        return str(solutions.arm.explain(solutions.poses, solutions._redundancy))
    filters = set(step.parent.filters)  # a configuration may be that of an image outside
    bounded = "limits" in filters or ("turns" in filters and "configuration" not in filters)
    inside = " inside the joint limits" if bounded else ""
    found = "1 solution reaches" if step.parent.count == 1 else f"{step.parent.count} solutions reach"
    if step.how == "within":
        return f"{found} the pose{inside}, none as near to the reference as asked; {_too_far(step)}"
    if step.how == "configuration":
        written, vendor = step.model
        there = dict.fromkeys(each for each in step.parent.configuration(vendor).tolist() if each)
        shown = ", ".join(list(there)[:_MOST_ROWS])
        return f"{found} the pose, none with the configuration {written} of {vendor}; there are {shown}"
    if step.how != "collision":
        parameters = solutions.solver.parameters
        here = f" at this value of {quoted(parameters[0].joint)}" if len(parameters) == 1 else ""
        others = "; `urdf-ik explain`, or arm.intervals(T), lists the values with solutions inside them" if here else ""
        outside = _out_of_limits(step.parent, step.amount)
        return f"{found} the pose{here}, none inside the joint limits; {outside}{others}"
    near = f" or comes within {step.amount:g} m of one" if step.amount else ""
    return f"{found} the pose{inside}, and every one is in collision{near}{_touching(step)}"


def table(solutions: KeptSolutions, degrees: bool = False) -> str:
    """The solutions of a single pose, a line each; a batch in one sentence."""
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
        at = f"{np.rad2deg(value):.2f} deg" if turned else amount(value, parameter.unit, ".4f")
        parts.append(f"{parameter.label} = {at}")
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
    unit = "rad" if step.parent.rotary[i] else "m"
    return (
        f"the closest, {step.parent.names[best]}, has {quoted(solver.joint_names[i])} {amount(apart[best, i], unit)} "
        f"from it, where {shown(step.within[i], unit):.4g} is allowed"
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
        margin = f", with a margin of {amount(-tol, unit, 'g')}" if tol < 0.0 else ""
        parts.append(
            f"{quoted(solver.joint_names[i])} at {amount(image[best, i], unit, '.4f')}, "
            f"{amount(abs(out[best, i]), unit)} beyond its {side} limit of {amount(limit, unit, '.4f')}{margin}"
        )
    return f"the closest, {list(solutions)[best].branch}, has {' and '.join(parts)}"


_WIDTH, _HEIGHT, _EDGE = 260, 200, 12


def to_frame(solutions: Any, contacts: bool = True) -> Any:
    """See :meth:`urdf_ik.IKSolutions.to_frame`."""
    try:
        import pandas
    except ImportError:
        raise extras.missing("to_frame() needs pandas", "tables") from None
    solver, places = solutions.solver, np.argwhere(solutions.valid)
    at, q = tuple(places.T), solutions.q[solutions.valid]
    columns: dict[str, Any] = {"arm": [solver.name] * len(q)}
    columns["pose"] = np.ravel_multi_index(at[:-1], solutions.shape) if solutions.shape else np.zeros(len(q), np.intp)
    if len(solutions.shape) > 1:
        columns |= {f"pose_{k}": places[:, k] for k in range(len(solutions.shape))}
    if (parameters := solutions.redundancy) is not None:
        values = parameters[at[:-1]].reshape(len(q), -1) if solutions.shape else np.tile(parameters, (len(q), 1))
        names = ["redundancy"] if values.shape[1] == 1 else [f"redundancy_{k + 1}" for k in range(values.shape[1])]
        columns |= dict(zip(names, values.T, strict=True))
    columns["branch"] = solutions.names[at]
    columns |= {f"q{k + 1}": q[:, k] for k in range(solver.dof)}
    columns["within_limits"] = _within(solutions)[at]
    columns["limit_margin"] = limits.margin(q, solver.limits)
    columns["manipulability"] = velocity.manipulability(solver.chain, q)
    bodies = solver.arm.cell.in_world(None)
    touching = bodies.in_collision(q) if contacts and bodies.has_geometry else [pandas.NA] * len(q)
    columns["contact"] = pandas.array(touching, dtype="boolean")
    columns["status"] = solutions.status[at[:-1]]
    columns["singular"] = [str(Singular(int(flags)).name or "") if flags else "" for flags in solutions.singular[at]]
    frame = pandas.DataFrame(columns)
    kinds = solver.chain.joint_types
    frame.attrs |= {
        "arm": solver.name,
        "base": solver.chain.base,
        "tip": solver.chain.tip,
        "joints": {f"q{k + 1}": name for k, name in enumerate(solver.joint_names)},
        "units": {f"q{k + 1}": "m" if kind == "prismatic" else "rad" for k, kind in enumerate(kinds)},
        "redundancy": [str(parameter) for parameter in solver.parameters],
        "contacts": bodies.unchecked if contacts else "not asked for",
    }
    return frame


def html(solutions: Any) -> str:
    """A table of the solutions and a small picture of them; of a batch, the number of solutions of its poses."""
    solver = solutions.solver
    title = f"{solver.name}: {solver.chain.base} to {solver.chain.tip}"
    if solutions.valid.ndim > 1:
        counts = solutions.valid.sum(axis=-1)
        lines = f"{counts.size} poses, {int((counts > 0).sum())} solved, {int(counts.sum())} solutions"
        return f"<div><p><b>{escape(title)}</b><br/>{lines}</p></div>"
    places = np.flatnonzero(solutions.valid)
    if not len(places):
        return f"<div><p><b>{escape(title)}</b><br/>no solution: {escape(solutions.explain())}</p></div>"
    within, names = _within(solutions), solutions.names
    shades = colours(len(solutions.branches))
    rows = []
    for k, place in enumerate(places[:_MOST_ROWS]):
        singular = solutions.singular[place]
        values = [f"{value:.4f}" for value in solutions.q[place]]
        flags = str(Singular(int(singular)).name or "").lower().replace("|", ", ") if singular else "-"
        dot = Markup(f'<span style="color:{_css(shades[place])}">&#9679;</span>')
        rows.append([dot, str(k), names[place], *values, "yes" if within[place] else "no", flags])
    header = ["", "#", "branch", *solver.joint_names, "in limits", "singular"]
    rest = f"<p>and {len(places) - _MOST_ROWS} more</p>" if len(places) > _MOST_ROWS else ""
    drawn = places[:_MOST_ROWS]
    picture = stick_picture(solver.chain, solutions.q[drawn], [shades[place] for place in drawn])
    count = f"{len(places)} solution{'' if len(places) == 1 else 's'}{escape(parameters_in_words(solutions))}"
    checked = "free of collisions" if "collision" in solutions.filters else "collisions: s.collision_free()"
    return f"<div><p><b>{escape(title)}</b><br/>{count}; {checked}</p>{picture}{html_table(header, rows)}{rest}</div>"


def stick_picture(chain: Chain, q: Array, shades: Sequence[tuple[float, float, float]]) -> str:
    """Stick figures (k, n) from the side as SVG, seen along the horizontal direction in which they are widest."""
    points = stick(chain, q)
    flat = points.reshape(-1, 3)
    sideways = flat[:, :2] - flat[:, :2].mean(axis=0)
    across = np.linalg.svd(sideways, full_matrices=False)[2][0] if np.ptp(sideways) > 0.0 else np.array([1.0, 0.0])
    seen = np.stack([points[..., :2] @ across, points[..., 2]], axis=-1)
    low, high = seen.min(axis=(0, 1)), seen.max(axis=(0, 1))
    scale = min((_WIDTH - 2 * _EDGE) / max(high[0] - low[0], 1e-9), (_HEIGHT - 2 * _EDGE) / max(high[1] - low[1], 1e-9))
    at = _EDGE + (seen - low) * scale
    at[..., 1] = _HEIGHT - at[..., 1]
    lines = "".join(
        f'<polyline points="{" ".join(f"{x:.1f},{y:.1f}" for x, y in figure)}" fill="none" stroke="{_css(shade)}" '
        'stroke-width="3" stroke-linejoin="round" opacity="0.8"/>'
        for figure, shade in zip(at, shades, strict=True)
    )
    return f'<svg width="{_WIDTH}" height="{_HEIGHT}" role="img" aria-label="the arm from the side">{lines}</svg>'


def stick(chain: Chain, q: Array) -> Array:
    """(..., k, 3) m, the frames' origins of the chain's links at ``q`` (..., n), base to tip."""
    poses = chain.link_poses(q)
    return np.stack([poses[link][..., :3, 3] for link in chain.links], axis=-2)


def _css(shade: tuple[float, float, float]) -> str:
    return "#" + "".join(f"{round(255 * part):02x}" for part in shade)


def _within(solutions: Any) -> NDArray[np.bool_]:
    """(..., B) whether a solution, or an image of it, lies inside the joint limits."""
    return np.asarray(solutions.within_limits().valid)
