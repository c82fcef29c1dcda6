"""The picture of a path: what each joint could do along it, what it must not, and what the plan does."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from matplotlib.collections import LineCollection
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from numpy.typing import NDArray

from urdf_ik.arm import Arm
from urdf_ik.ik.solutions import limits as joint_limits
from urdf_ik.paths.planned_motion import Plan
from urdf_ik.show.plot import axes as draw
from urdf_ik.support.angles import TURN
from urdf_ik.typing import Array

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Mask = NDArray[np.bool_]

VALUES = 16
"""Values of the redundancy parameter at which all solutions are drawn."""
MOST = 600, 100
"""Waypoints at which all solutions are drawn at most: without a redundancy parameter, and with one."""
JUMP = 0.7, 0.2
"""rad, and m of a joint that slides: a longer step between waypoints is drawn as no line."""
_ROOM = 0.06
"""Share of a joint's range that is drawn beyond its limits."""
_WIDE, _HIGH, _COLUMNS = 5.2, 1.9, 2
"""Inches of a panel, and panels side by side."""
_DASHES = 40
"""Dashes and gaps along a path where all of it is in contact."""
_FORBIDDEN, _CONTACT, _REACH = "0.87", "tab:red", "tab:purple"


class _Background(NamedTuple):
    """All solutions at some waypoints.

    Attributes:
        at: (w,) numbers of the waypoints.
        q: (w, c, n) rad or m, NaN where there is no solution.
        branch: (c,) index of each column's branch.
        inside: (w, c) whether some image is inside the limits of every joint.
        free: (w, c) whether that image touches nothing; true where that was not asked.
    """

    at: NDArray[np.intp]
    q: Array
    branch: NDArray[np.intp]
    inside: Mask
    free: Mask

    @property
    def valid(self) -> Mask:
        """(w, c) whether there is a solution."""
        return np.asarray(~np.isnan(self.q[..., 0]))


def path(plan: Plan, *, degrees: bool = True) -> Figure:
    """A path joint by joint: all solutions of its waypoints as thin lines, the plan over them.

    Grey is outside the limits. A solution that the limits of some joint forbid is drawn faintly, one in contact dashed,
    where the plan was asked to stay clear of contacts. Where no solution is left at all, the waypoints are shaded:
    purple out of reach, grey outside the limits, red in contact. Where there is no plan, dotted lines and crosses mark
    where each start branch ends. Of an arm with a redundancy parameter, the solutions at ``VALUES`` of its values are
    drawn, and waypoints are shaded where there is no plan: others of its values may still be free.

    Args:
        plan: of ``arm.follow``, found or not.
        degrees: joints that turn in degrees; else in rad.

    Example:
        >>> import urdf_ik
        >>> arm = urdf_ik.load("scara_rrpr")
        >>> T0, T1 = arm.fk([[0.3, 0.5, 0.1, 0.2], [0.5, 0.7, 0.1, 0.2]])
        >>> figure = urdf_ik.show.plot.path(arm.follow(urdf_ik.line(T0, T1, 5)))
        >>> len(figure.axes)
        4
    """
    arm, found = plan.solver.arm, background(plan)
    rows = math.ceil(arm.dof / _COLUMNS)
    columns = min(_COLUMNS, arm.dof)
    size = (_WIDE * columns, _HIGH * rows + 0.8 + 0.055 * len(arm.structure.branches))
    figure = draw.Picture(figsize=size, layout="constrained")
    panels = figure.subplots(rows, columns, squeeze=False, sharex=True)
    colours = draw.colours(arm.structure.branches)
    shades = [colours[name] for name in arm.structure.branches]
    ranges = joint_limits.drawn(joint_limits.bounded(arm.limits), ~arm.chain.prismatic)
    for joint, axes in enumerate(panels.T.ravel() if rows > 1 else panels.ravel()):
        if joint >= arm.dof:
            axes.set_visible(False)
            continue
        unit = "m" if arm.chain.prismatic[joint] else "deg" if degrees else "rad"
        _panel(axes, plan, found, joint, shades, 180.0 / np.pi if unit == "deg" else 1.0, ranges[joint])
        axes.set_title(f"{draw.words(arm.joint_names[joint])} [{unit}]", fontsize=8, loc="left", pad=3)
    for column in panels.T:
        lowest = [axes for axes in column if axes.get_visible()][-1]
        lowest.set_xlabel("waypoint", fontsize=8)
        lowest.tick_params(labelbottom=True)
    figure.suptitle(_title(plan), fontsize=10)
    handles = _legend(plan, found, shades)
    figure.legend(handles=handles, loc="outside lower center", ncols=3, fontsize=7, frameon=False)
    return figure


def background(plan: Plan) -> _Background:
    """All solutions of a path's waypoints, or of as many as can be drawn, and what forbids them."""
    arm, parameter = plan.solver.arm, plan.solver.parameter
    count = len(plan.poses)
    at = np.unique(np.linspace(0, count - 1, min(count, MOST[parameter is not None])).round().astype(np.intp))
    if parameter is None:
        solutions = arm.ik(plan.poses[at])
        within = solutions.within_limits()
        q, inside, best = solutions.q, within.valid, within.q
        branch = np.arange(q.shape[1])
    else:
        grid = np.linspace(*parameter.range, VALUES, endpoint=not parameter.round)
        solutions = arm.ik(plan.poses[at][:, None], redundancy=_with_others(plan, at, grid))
        within = solutions.within_limits()
        shape = (len(at), -1, arm.dof)
        q, inside, best = solutions.q.reshape(shape), within.valid.reshape(shape[:2]), within.q.reshape(shape)
        branch = np.tile(np.arange(solutions.q.shape[2]), VALUES)
    free = np.ones(inside.shape, dtype=np.bool_)
    if plan.obstacles is not None and inside.any():
        free[inside] = plan.obstacles.free(best[inside])
    return _Background(at, q, branch, inside, free)


def _with_others(plan: Plan, at: NDArray[np.intp], grid: Array) -> Array:
    """Values of the first parameter, with those that the others have along the plan, or by default."""
    arm = plan.solver.arm
    if len(arm.solver.parameters) == 1:
        return grid
    others = np.tile([parameter.default for parameter in arm.solver.parameters], (len(at), 1))
    own = arm.redundancy_of(plan.q[at], plan.poses[at]) if plan.found else others
    values = np.repeat(own[:, None], len(grid), axis=1)
    values[..., 0] = grid
    return np.asarray(values)


def _panel(axes: Any, plan: Plan, found: _Background, joint: int, shades: list[Any], scale: float, ends: Array) -> None:
    """One joint: limits, shaded waypoints, all solutions, and the plan."""
    low, high = ends
    if plan.found:
        low, high = min(low, plan.motion[:, joint].min()), max(high, plan.motion[:, joint].max())
    room = _ROOM * (high - low)
    bottom, top = low - room, high + room
    axes.set(xlim=(-0.01 * len(plan.poses), 1.01 * max(len(plan.poses) - 1, 1)), ylim=(scale * bottom, scale * top))
    for limit, side in zip(joint_limits.bounded(plan.solver.limits)[joint], (bottom, top), strict=True):
        if np.isfinite(limit):
            axes.axhspan(scale * limit, scale * side, color=_FORBIDDEN, linewidth=0, zorder=0)
            axes.axhline(scale * limit, color="0.3", linewidth=1.0, zorder=3)
    for first, last, colour in _closed(plan, found):
        axes.axvspan(first, last, color=colour, alpha=0.16, linewidth=0, zorder=0)
    lines, widths, colours = _curves(plan.solver.arm, found, joint, shades, bottom, top)
    if len(lines):
        lines[..., 1] *= scale
        axes.add_collection(LineCollection(list(lines), colors=colours, linewidths=widths))
    if len(found.at) == 1:
        axes.plot(np.zeros(found.q.shape[1]), scale * found.q[0, :, joint], ".", color="0.4", markersize=4)
    if plan.found:
        _plan(axes, plan, scale * plan.motion[:, joint])
    else:
        _stops(axes, plan, found, joint, shades, scale)
    axes.tick_params(labelsize=7)
    axes.locator_params(axis="y", nbins=5)


def _curves(
    arm: Arm, found: _Background, joint: int, shades: list[Any], bottom: float, top: float
) -> tuple[Array, Array, Array]:
    """Pieces (k, 2, 2) of the solutions' curves between neighbouring waypoints, and the width and colour of each."""
    q, slides = found.q[..., joint], bool(arm.chain.prismatic[joint])
    step = np.diff(q, axis=0)
    if not slides:
        step -= TURN * np.round(step / TURN)
    # Nothing is known of the way between waypoints that are far apart, nor where another joint jumps.
    steps = np.diff(found.q, axis=0)
    turning = ~arm.chain.prismatic
    steps[..., turning] -= TURN * np.round(steps[..., turning] / TURN)
    with np.errstate(invalid="ignore"):
        near = (np.abs(steps) < np.where(turning, JUMP[0], JUMP[1])).all(axis=-1)
    w, c = np.nonzero(near)
    start, move = q[w, c], step[w, c]
    turns = range(-4, 5) if not slides else (0,)
    ok = found.inside & found.free
    contact = (found.inside & ~found.free)[w, c] | (found.inside & ~found.free)[w + 1, c]
    faint = ~(ok[w, c] & ok[w + 1, c])
    # Branches often share a joint's values: later ones are thinner, so that they hide nothing.
    thick = 0.5 if arm.redundancy is not None else np.linspace(min(0.8 + 0.45 * len(shades), 4.0), 0.8, len(shades))
    width = np.broadcast_to(thick, len(shades))[found.branch[c]].copy()
    colour = np.array([(*shade[:3], 0.9) for shade in shades])[found.branch[c]]
    colour[faint & ~contact, 3] = 0.25
    gaps = contact & (w * _DASHES // max(len(found.at), 1) % 2 == 1)
    start, move, w, c, width, colour = (each[~gaps] for each in (start, move, w, c, width, colour))
    pieces, which = [], []
    for turn in turns:
        a = start + turn * TURN
        b = a + move
        seen = np.flatnonzero((np.maximum(a, b) >= bottom) & (np.minimum(a, b) <= top))
        pieces.append(np.stack([np.stack([found.at[w], a], -1), np.stack([found.at[w + 1], b], -1)], 1)[seen])
        which.append(seen)
    chosen = np.concatenate(which)
    # Thick ones first: they lie below.
    order = np.argsort(-width[chosen], kind="stable")
    return np.concatenate(pieces)[order], width[chosen][order], colour[chosen][order]


def _closed(plan: Plan, found: _Background) -> list[tuple[float, float, Any]]:
    """Runs of waypoints at which nothing is left: first and last, and the colour of why."""
    if plan.found:
        return []
    reason = np.where(
        ~found.valid.any(axis=1), 1,
        np.where(~found.inside.any(axis=1), 2, np.where(~(found.inside & found.free).any(axis=1), 3, 0)),
    )  # fmt: skip
    spans = []
    cuts = np.flatnonzero(np.diff(reason)) + 1
    gap = 0.5 * float(np.diff(found.at).max(initial=1))
    for part in np.split(np.arange(len(reason)), cuts):
        if kind := int(reason[part[0]]):
            colour = {1: _REACH, 2: "0.2", 3: _CONTACT}[kind]
            spans.append((float(found.at[part[0]]) - gap, float(found.at[part[-1]]) + gap, colour))
    return spans


def _plan(axes: Any, plan: Plan, values: Array) -> None:
    """The plan's curve, broken where it changes its branch."""
    place = plan.place
    for change in plan.changes:
        k = int(np.searchsorted(place, change.waypoint - 1e-9))
        axes.axvline(0.5 * (place[k - 1] + place[k]), color="black", linestyle=":", linewidth=1.0, zorder=4)
    cuts = [int(np.searchsorted(place, change.waypoint - 1e-9)) for change in plan.changes]
    for part in np.split(np.arange(len(place)), sorted(set(cuts))):
        axes.plot(place[part], values[part], color="white", linewidth=3.6, zorder=5)
        axes.plot(place[part], values[part], color="black", linewidth=1.8, zorder=6)
    axes.plot(place[[0, -1]], values[[0, -1]], "o", color="black", markersize=3.5, zorder=6)


def _stops(axes: Any, plan: Plan, found: _Background, joint: int, shades: list[Any], scale: float) -> None:
    """Where the ways from each start branch end: a line, and a cross on the branch's own curve where it has one."""
    names = plan.solver.structure.branches
    low, high = axes.get_ylim()
    sizes = np.linspace(min(5.0 + 1.2 * len(plan.stops), 12.0), 5.0, len(plan.stops))
    for size, stop in zip(sizes, plan.stops, strict=True):
        column = names.index(stop.branch) if stop.branch in names else None
        colour = "0.2" if column is None else shades[column]
        # What no branch gets past is marked where it is, a branch's end where it still gets to.
        last = stop.waypoint if column is None else max(stop.waypoint - 1, 0)
        axes.axvline(last, color=colour, linestyle=(0, (1, 2)), linewidth=1.0, zorder=4)
        if column is None or plan.solver.parameter is not None:
            continue
        k = int(np.searchsorted(found.at, last))
        turns = TURN * np.arange(-4, 5) * (not plan.solver.chain.prismatic[joint])
        values = scale * (found.q[k, column, joint] + turns)
        values = np.unique(values[(values >= low) & (values <= high)])
        style = {"markeredgecolor": "black", "markeredgewidth": 0.5, "markersize": size, "zorder": 7}
        axes.plot(np.full(len(values), last), values, "X", color=colour, **style)


def _title(plan: Plan) -> str:
    name, count = draw.words(plan.solver.name), len(plan.poses)
    if not plan.found:
        return f"{name}: no plan along {count} waypoints"
    changes = f", {len(plan.changes)} reconfigurations" if plan.changes else ""
    return f"{name}: {count} waypoints, cost {plan.cost:.4g}{changes}"


def _legend(plan: Plan, found: _Background, shades: list[Any]) -> list[Any]:
    """What the lines and shades mean, of those that are there."""
    handles: list[Any] = []
    if plan.found:
        handles.append(Line2D([], [], color="black", linewidth=1.8, label="the plan"))
    if plan.changes:
        handles.append(Line2D([], [], color="black", linestyle=":", label="change of branch"))
    names = plan.solver.structure.branches
    stops = {stop.branch: stop for stop in plan.stops}
    for branch in np.unique(found.branch[found.valid.any(axis=0)]):
        label = names[branch]
        if (stop := stops.get(names[branch])) is not None:
            label += f": ends before {stop.waypoint} ({stop.cause})"
        handles.append(Line2D([], [], color=shades[branch], linewidth=1.2, label=draw.words(label)))
    others = [f"{stop.branch}: {stop.cause} at {stop.waypoint}" for stop in plan.stops if stop.branch not in names]
    handles += [Line2D([], [], color="0.2", linestyle=":", label=draw.words(text)) for text in others]
    if (found.inside & ~found.free).any():
        handles.append(Line2D([], [], color="0.4", linestyle="--", linewidth=1.2, label="in contact"))
    if (found.valid & ~found.inside).any():
        handles.append(Line2D([], [], color="0.5", alpha=0.4, linewidth=1.2, label="some joint is outside its limits"))
    if np.isfinite(joint_limits.bounded(plan.solver.limits)).any():
        handles.append(Patch(color=_FORBIDDEN, label="outside the limits"))
    kinds = {_REACH: "no solution: out of reach", "0.2": "none within the limits", _CONTACT: "all in contact"}
    which = "" if plan.solver.parameter is None else ", at the values drawn"
    closed = dict.fromkeys(colour for *_, colour in _closed(plan, found))
    return [*handles, *(Patch(color=colour, alpha=0.16, label=kinds[colour] + which) for colour in closed)]
