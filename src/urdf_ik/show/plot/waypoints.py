"""The picture of a path: what each joint could do along it, what it must not, and what the plan does."""

import math
from typing import Any, NamedTuple

import numpy as np
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from numpy.typing import NDArray

from urdf_ik.ik.solutions import limits as joint_limits
from urdf_ik.paths.planned_motion import Plan
from urdf_ik.show.plot import axes as draw
from urdf_ik.support.angles import TURN
from urdf_ik.typing import Array

Mask = NDArray[np.bool_]

MOST = 600
"""Waypoints at which all solutions are drawn at most."""
JUMP = 0.7, 0.2
"""rad, and m of a joint that slides: a longer step between waypoints is drawn as no line."""
_ROOM = 0.06
"""Share of a joint's range that is drawn beyond its limits."""
_WIDE, _HIGH, _COLUMNS = 5.2, 1.9, 2
"""Inches of a panel, and panels side by side."""
_FORBIDDEN, _CONTACT = "0.87", "tab:red"


class _Background(NamedTuple):
    """All solutions at some waypoints.

    Attributes:
        at: (w,) numbers of the waypoints.
        q: (w, B, n) rad or m, NaN where there is no solution.
        inside: (w, B) whether some image is inside the limits of every joint.
        free: (w, B) whether that image touches nothing; true where that was not asked.
    """

    at: NDArray[np.intp]
    q: Array
    inside: Mask
    free: Mask

    @property
    def closed(self) -> Mask:
        """(w,) whether no solution is of use."""
        return np.asarray(~(self.inside & self.free).any(axis=1))


def path(plan: Plan, *, degrees: bool = True) -> Figure:
    """A path joint by joint: all solutions of its waypoints as thin lines, the plan over them.

    Grey is outside the limits. A solution that the limits of some joint forbid is drawn faintly, one in contact in
    red, where the plan was asked to stay clear of contacts. Where there is no plan, waypoints without a solution of use
    are shaded, and dotted lines mark where each start branch ends. Of an arm with a redundancy parameter only the plan
    is drawn.

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
    arm = plan.solver.arm
    found = None if plan.solver.parameters else background(plan)
    rows = math.ceil(arm.dof / _COLUMNS)
    columns = min(_COLUMNS, arm.dof)
    size = (_WIDE * columns, _HIGH * rows + 0.8 + 0.055 * len(arm.structure.branches))
    figure = draw.Picture(figsize=size, layout="constrained")
    panels = figure.subplots(rows, columns, squeeze=False, sharex=True)
    shades = list(draw.colours(arm.structure.branches).values())
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
    count = len(plan.poses)
    at = np.unique(np.linspace(0, count - 1, min(count, MOST)).round().astype(np.intp))
    solutions = plan.solver.arm.ik(plan.poses[at])
    within = solutions.within_limits()
    free = np.ones(within.valid.shape, dtype=np.bool_)
    if plan.obstacles is not None and within.valid.any():
        free[within.valid] = plan.obstacles.free(within.q[within.valid])
    return _Background(at, solutions.q, within.valid, free)


def _panel(
    axes: Any, plan: Plan, found: _Background | None, joint: int, shades: list[Any], scale: float, ends: Array
) -> None:
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
    if found is not None:
        lines, colours, widths = _curves(plan, found, joint, shades)
        seen = (lines[..., 1].max(axis=1) >= bottom) & (lines[..., 1].min(axis=1) <= top)
        drawn = list(lines[seen] * [1.0, scale])
        axes.add_collection(LineCollection(drawn, colors=colours[seen], linewidths=widths[seen]))
        if len(found.at) == 1:
            axes.plot(np.zeros(len(shades)), scale * found.q[0, :, joint], ".", color="0.4", markersize=4)
    if plan.found:
        _plan(axes, plan, scale * plan.motion[:, joint])
    else:
        for k in [] if found is None else found.at[found.closed]:
            axes.axvspan(k - 0.5, k + 0.5, color=_CONTACT, alpha=0.16, linewidth=0, zorder=0)
        for stop in plan.stops:
            axes.axvline(max(stop.waypoint - 1, 0), color="0.2", linestyle=(0, (1, 2)), linewidth=1.0, zorder=4)
    axes.tick_params(labelsize=7)
    axes.locator_params(axis="y", nbins=5)


def _curves(plan: Plan, found: _Background, joint: int, shades: list[Any]) -> tuple[Array, Array, Array]:
    """Pieces (k, 2, 2) of the solutions' curves between neighbouring waypoints, turns included; colours and widths."""
    turning = ~plan.solver.chain.prismatic
    steps = np.diff(found.q, axis=0)
    steps[..., turning] -= TURN * np.round(steps[..., turning] / TURN)
    with np.errstate(invalid="ignore"):  # nothing is known of the way where a joint jumps
        near = (np.abs(steps) < np.where(turning, *JUMP)).all(axis=-1)
    c, w = np.nonzero(near.T)
    start = found.q[w, c, joint]
    ends = np.stack([start, start + steps[w, c, joint]], axis=-1)
    contact, of_use = found.inside & ~found.free, found.inside & found.free
    colour = np.array([(*shade[:3], 0.9) for shade in shades])[c]
    colour[~(of_use[w, c] & of_use[w + 1, c]), 3] = 0.25
    colour[contact[w, c] | contact[w + 1, c]] = (0.84, 0.15, 0.16, 0.6)
    turns = TURN * np.arange(-4, 5) if turning[joint] else np.zeros(1)
    places = np.stack([found.at[w], found.at[w + 1]], axis=-1)
    pieces = np.stack([np.stack([places, ends + turn], axis=-1) for turn in turns], axis=1)
    # Branches often share a joint's values: later ones are thinner, so that they hide nothing.
    width = np.linspace(min(0.8 + 0.45 * len(shades), 4.0), 0.8, len(shades))[c]
    each = np.repeat(np.arange(len(c)), len(turns))
    return pieces.reshape(-1, 2, 2), colour[each], width[each]


def _plan(axes: Any, plan: Plan, values: Array) -> None:
    """The plan's curve, broken where it changes its branch."""
    place = plan.place
    cuts = [int(np.searchsorted(place, change.waypoint - 1e-9)) for change in plan.changes]
    for k in cuts:
        axes.axvline(0.5 * (place[k - 1] + place[k]), color="black", linestyle=":", linewidth=1.0, zorder=4)
    for part in np.split(np.arange(len(place)), sorted(set(cuts))):
        axes.plot(place[part], values[part], color="white", linewidth=3.6, zorder=5)
        axes.plot(place[part], values[part], color="black", linewidth=1.8, zorder=6)
    axes.plot(place[[0, -1]], values[[0, -1]], "o", color="black", markersize=3.5, zorder=6)


def _title(plan: Plan) -> str:
    name, count = draw.words(plan.solver.name), len(plan.poses)
    if not plan.found:
        return f"{name}: no plan along {count} waypoints"
    changes = f", {len(plan.changes)} reconfigurations" if plan.changes else ""
    return f"{name}: {count} waypoints, cost {plan.cost:.4g} [rad, m or s]{changes}"


def _legend(plan: Plan, found: _Background | None, shades: list[Any]) -> list[Any]:
    """What the lines and shades mean, of those that are there."""
    handles: list[Any] = []
    if plan.found:
        handles.append(Line2D([], [], color="black", linewidth=1.8, label="the plan"))
    if plan.changes:
        handles.append(Line2D([], [], color="black", linestyle=":", label="change of branch"))
    names, stops = plan.solver.structure.branches, {stop.branch: stop for stop in plan.stops}
    for k in [] if found is None else np.flatnonzero(~np.isnan(found.q[..., 0]).all(axis=0)):
        ends = f": ends before {stop.waypoint} ({stop.cause})" if (stop := stops.get(names[k])) else ""
        handles.append(Line2D([], [], color=shades[k], linewidth=1.2, label=draw.words(names[k] + ends)))
    others = [f"{stop.branch}: {stop.cause} at {stop.waypoint}" for stop in plan.stops if stop.branch not in names]
    handles += [Line2D([], [], color="0.2", linestyle=":", label=draw.words(text)) for text in others]
    if found is not None and (found.inside & ~found.free).any():
        handles.append(Line2D([], [], color=_CONTACT, linewidth=1.2, label="in contact"))
    if np.isfinite(joint_limits.bounded(plan.solver.limits)).any():
        handles.append(Patch(color=_FORBIDDEN, label="outside the limits"))
    if found is not None and not plan.found and found.closed.any():
        handles.append(Patch(color=_CONTACT, alpha=0.16, label="no solution of use"))
    return handles
