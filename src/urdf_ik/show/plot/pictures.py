"""Pictures of an arm, its branches, limits and workspace."""

import math
import os
import textwrap
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.collections import LineCollection
from matplotlib.lines import Line2D
from numpy.typing import ArrayLike

from urdf_ik.arm import Arm
from urdf_ik.cell import World
from urdf_ik.errors import ArgumentError
from urdf_ik.ik.redundancy import Intervals
from urdf_ik.ik.redundancy.curves import CAUSES
from urdf_ik.ik.solutions import IKSolutions
from urdf_ik.ik.solutions import limits as joint_limits
from urdf_ik.maps.placements import PlacementMap
from urdf_ik.maps.workspaces import PlanarWorkspace, WorkspaceMap, planar
from urdf_ik.show import shapes as looks
from urdf_ik.show.plot import axes as draw
from urdf_ik.support import extras, files, inputs
from urdf_ik.support.angles import TURN

if TYPE_CHECKING:
    from matplotlib.figure import Figure


SUFFIXES = (".png", ".svg", ".pdf")
"""Endings of the files that a picture is written to."""
_COLUMNS = 4
_DPI = 110


def arm(arm: Arm, q: ArrayLike | None = None, *, shapes: bool = True) -> "Figure":
    """The arm at ``q`` (n,) rad or m, as a stick figure and with the shapes of its links, meshes among them.

    Default: zero, or the nearest to it within the limits.

    Raises:
        ArgumentError: ``q`` is no joint vector.

    Example:
        >>> import urdf_ik
        >>> figure = urdf_ik.show.plot.arm(urdf_ik.load("planar_2r"), [0.3, 0.5])
        >>> len(figure.axes)
        1
    """
    at = draw.posture(arm, q)
    figure = draw.Picture(figsize=(5.0, 5.0), layout="constrained")
    bodies = _bodies(figure, arm, shapes)
    triangles = looks.placed(arm, bodies, at)
    points = np.concatenate([looks.stick(arm.chain, at), *(body.reshape(-1, 3) for body in triangles)])
    axes = draw.space(figure.add_subplot(projection="3d"), draw.box(points))
    draw.shapes(axes, triangles)
    draw.stick(axes, arm, at, "0.15")
    draw.frame(axes, arm.fk(at), 0.12 * arm.chain.size)
    axes.set_title(draw.words(arm.name))
    return figure


def branches(solutions: IKSolutions, *, shapes: bool = False, world: World | None = None) -> "Figure":
    """All solutions of a single pose, side by side, each in the colour of its branch, with its name.

    The obstacles of ``world`` are drawn, too; where links touch each other or an obstacle, the name says 'collision'
    and the lines are dashed.

    Raises:
        ArgumentError: there is no solution.
        TypeError: the solutions are those of a batch.

    Example:
        >>> import urdf_ik
        >>> arm = urdf_ik.load("planar_2r")
        >>> figure = urdf_ik.show.plot.branches(arm.ik([0.1, 0.1], task="planar position"))
        >>> len(figure.axes)
        2
    """
    found = list(solutions)
    if not found:
        raise ArgumentError(f"no solution to draw: {solutions.explain()}")
    owner = solutions.arm
    q = np.stack([one.q for one in found])
    around = draw.box(looks.stick(owner.chain, q))
    colours = draw.colours(solutions.branches)
    columns = min(_COLUMNS, len(found))
    rows = math.ceil(len(found) / columns)
    figure = draw.Picture(figsize=(2.7 * columns, 2.9 * rows + 0.4), layout="constrained")
    bodies = _bodies(figure, owner, shapes)
    checked = owner.cell.collisions.has_geometry
    touching = np.atleast_1d(owner.cell.collisions.in_world(world).in_collision(q)) if checked else np.zeros(len(q))
    for k, one in enumerate(found):
        axes = draw.space(figure.add_subplot(rows, columns, k + 1, projection="3d"), around, small=True)
        draw.obstacles(axes, world, around[1])
        # Each has its own: what is asked of an arm with few joints may be less than a pose.
        draw.frame(axes, owner.link_poses(one.q)[owner.tip], 0.12 * owner.chain.size)
        colour = colours[solutions.branches[one.index]]
        draw.shapes(axes, looks.placed(owner, bodies, one.q), colour, 0.35)
        name = one.branch + (", collision" if touching[k] else "")
        line = draw.stick(axes, owner, one.q, colour, label=name)
        if touching[k]:
            line.set_linestyle("--")
        axes.set_title(name.replace(", ", "\n"), fontsize=8, color=colour)
    tips = owner.link_poses(q)[owner.tip]
    target = "pose" if np.allclose(tips, tips[0], rtol=0.0, atol=1e-6) else "position"
    title = f"{draw.words(owner.name)}: {len(found)} solution{'' if len(found) == 1 else 's'} of one {target}"
    figure.suptitle(title, fontsize=10)
    return figure


def limits(solutions: IKSolutions, *, degrees: bool = True) -> "Figure":
    """The joints' limits as bars, with all turns of all solutions of a single pose; a cross where no turn is inside.

    Joints that slide are drawn in m, below those that turn.

    Raises:
        ArgumentError: there is no solution.
        UrdfIkError: the turns are too many for one array.

    Example:
        >>> import urdf_ik
        >>> arm = urdf_ik.load("scara_rrpr")
        >>> figure = urdf_ik.show.plot.limits(arm.ik(arm.fk([0.3, 0.5, 0.1, 0.2])))
        >>> len(figure.axes)
        2
    """
    owner, found = solutions.arm, list(solutions)
    if not found:
        raise ArgumentError(f"no solution to draw: {solutions.explain()}")
    colours = draw.colours(solutions.branches)
    prismatic = owner.chain.prismatic
    # Angles and lengths have no scale in common: joints that slide stand in axes of their own.
    kinds = [(np.flatnonzero(~prismatic), "deg" if degrees else "rad"), (np.flatnonzero(prismatic), "m")]
    kinds = [(joints, unit) for joints, unit in kinds if len(joints)]
    size = (8.0, 0.8 * owner.dof + 0.6 * len(kinds) + 0.27 * math.ceil(len(found) / 2))
    figure = draw.Picture(figsize=size, layout="constrained")
    ratios = [len(joints) for joints, _ in kinds]
    parts = figure.subplots(len(kinds), 1, squeeze=False, height_ratios=ratios)[:, 0]
    shift = np.linspace(-0.32, 0.32, len(found)) if len(found) > 1 else np.zeros(1)
    for axes, (joints, unit) in zip(parts, kinds, strict=True):
        scale = 180.0 / np.pi if unit == "deg" else 1.0
        for row, (lower, upper) in enumerate(joint_limits.bounded(owner.limits[joints])):
            if np.isfinite(lower) and np.isfinite(upper):
                axes.barh(row, scale * (upper - lower), left=scale * lower, height=0.8, color="0.9")
            else:
                axes.axhspan(row - 0.4, row + 0.4, color="0.95")
        for k, one in enumerate(found):
            rows, values, inside = _images(owner, one.q, joints)
            colour, heights = colours[solutions.branches[one.index]], rows + shift[k]
            axes.plot(scale * values[inside], heights[inside], "o", color=colour, markersize=4, label=one.branch)
            axes.plot(scale * values[~inside], heights[~inside], "x", color=colour, markersize=5)
        axes.set_yticks(range(len(joints)), [draw.words(owner.joint_names[i]) for i in joints])
        axes.invert_yaxis()
        axes.use_sticky_edges = False
        axes.margins(x=0.04)
        axes.set_xlabel(f"joint value [{unit}]")
    title = "limits, and the solutions with all their turns (x: none inside)"
    parts[0].set_title(f"{draw.words(owner.name)}: {title}", fontsize=9)
    figure.legend(*parts[0].get_legend_handles_labels(), loc="outside lower center", ncols=2, fontsize=7)
    return figure


def workspace_slice(found: WorkspaceMap, axis: str = "z", at: float = 0.0, what: str = "reach") -> "Figure":
    """One layer of a workspace map; see :meth:`urdf_ik.maps.workspaces.WorkspaceMap.slice`.

    Raises:
        ArgumentError: there is no such layer or value.

    Example:
        >>> import urdf_ik
        >>> found = urdf_ik.maps.workspace(urdf_ik.load("planar_2r"), voxel=0.05, orientations=4)
        >>> figure = urdf_ik.show.plot.workspace_slice(found)
        >>> figure.axes[0].get_xlabel()
        'x [m]'
    """
    from urdf_ik.maps.workspaces import VALUES

    layer = found.slice(axis, at, what)
    figure = draw.Picture(figsize=(5.6, 4.6), layout="constrained")
    axes = figure.add_subplot()
    image = axes.imshow(layer.values.T, origin="lower", extent=layer.extent, cmap="viridis", vmin=0.0)
    figure.colorbar(image, ax=axes, label=VALUES[what])
    axes.set(xlabel=f"{layer.axes[0]} [m]", ylabel=f"{layer.axes[1]} [m]")
    axes.locator_params(nbins=6)
    axes.set_title(f"{draw.words(found.about['robot'])}: {axis} = {layer.at:.3g} m")
    return figure


def placements(found: PlacementMap, what: str = "reached") -> "Figure":
    """The best layer: base positions, each with its best heading; a cross on the best, dots on the targets.

    Args:
        found: the map.
        what: a score, see :data:`urdf_ik.maps.placements.SHOWN`.

    Raises:
        ArgumentError: there is no such score.

    Example:
        >>> import urdf_ik
        >>> arm = urdf_ik.load("zyyzyz_6r")
        >>> found = urdf_ik.maps.placement(arm, arm.fk([0.3] * 6), bounds=[[-1, -1, 0], [1, 1, 0]], step=0.5)
        >>> urdf_ik.show.plot.placements(found, "margin").axes[0].get_xlabel()
        'x [m]'
    """
    from urdf_ik.maps.placements import SHOWN

    best = found.best().pose[:3, 3]
    _, layer = found.grid.layer("z", float(best[2]))
    values = found.values(what)[:, :, layer]
    least = what == "cost"
    filled = np.where(np.isnan(values), np.inf if least else -np.inf, values)
    shown = filled.min(axis=-1) if least else filled.max(axis=-1)
    figure = draw.Picture(figsize=(5.6, 4.6), layout="constrained")
    axes = figure.add_subplot()
    (x0, y0), (x1, y1) = found.grid.lower[:2], found.grid.upper[:2]
    image = axes.imshow(
        np.where(np.isfinite(shown), shown, np.nan).T, origin="lower", extent=(x0, x1, y0, y1), cmap="viridis"
    )
    figure.colorbar(image, ax=axes, label=draw.words(SHOWN[what]))
    axes.plot(*found.targets[:, :2, 3].T, ".", color="tab:red", markersize=2, label="targets")
    axes.plot(best[0], best[1], "x", color="white", markersize=9, markeredgewidth=2, label="best place")
    axes.set(xlabel="x [m]", ylabel="y [m]")
    axes.set_title(f"{draw.words(str(found.about['robot']))}: base at z = {found.grid.coordinates(2)[layer]:.3g} m")
    figure.legend(*axes.get_legend_handles_labels(), loc="outside lower center", ncols=2, fontsize=8, facecolor="0.8")
    return figure


def planar_workspace(region: PlanarWorkspace, q: ArrayLike | None = None) -> "Figure":
    """The regions of both elbows and their overlap, with their boundary, and the arm at ``q`` (2,) rad.

    Example:
        >>> import urdf_ik
        >>> region = urdf_ik.maps.workspaces.planar(urdf_ik.load("planar_2r"))
        >>> figure = urdf_ik.show.plot.planar_workspace(region, [0.3, 0.5])
        >>> len(figure.axes)
        1
    """
    figure = draw.Picture(figsize=(6.4, 5.0), layout="constrained")
    axes = figure.add_subplot()
    draw.regions(axes, region)
    if q is not None:
        draw.two_links(axes, region, inputs.array(q, "q", (2,), unit="rad"))
    figure.legend(*axes.get_legend_handles_labels(), loc="outside lower center", ncols=2, fontsize=8)
    axes.set_title(f"{draw.words(region.name)}: where the tip can be")
    return figure


def save(figure: "Figure", path: str | os.PathLike[str]) -> None:
    """Write a PNG, SVG or PDF file, by the path's ending.

    Raises:
        ArgumentError: the ending is another one, or the file cannot be written.

    Example:
        >>> from pathlib import Path
        >>> import urdf_ik
        >>> urdf_ik.show.plot.save(urdf_ik.show.plot.arm(urdf_ik.load("planar_2r")), "arm.svg")
        >>> Path("arm.svg").is_file()
        True
    """
    target = Path(path)
    if target.suffix.lower() not in SUFFIXES:
        raise ArgumentError(f"{files.name_of(target)}: pictures are written as {', '.join(SUFFIXES)}; name the file so")
    kind = target.suffix.lower()[1:]
    titles = [figure.get_suptitle(), *(axes.get_title() for axes in figure.axes)]
    metadata = {"Title": next(filter(None, titles), "urdf-ik").replace(r"\$", "$")}
    files.write(target, lambda file: figure.savefig(file, format=kind, dpi=_DPI, metadata=metadata))


def _bodies(figure: "Figure", owner: Arm, wanted: bool) -> tuple[looks.Body, ...]:
    """What the links look like, if that is wanted; the picture says how many shapes it lacks, and why the first one."""
    if not wanted:
        return ()
    shapes, missing = looks.bodies(owner)
    if missing:
        count = len(missing)
        words = f"{count} shape{'' if count == 1 else 's'} not drawn; {missing[0]}"
        figure.supxlabel(draw.words(textwrap.shorten(words, 150)), fontsize=6, color="tab:red", wrap=True)
    return shapes


def _images(owner: Arm, q: Any, joints: Any) -> tuple[Any, Any, Any]:
    """Row, value and whether it is inside, (k,) each: every turn inside the limits, or the value itself."""
    bounds = joint_limits.bounded(owner.limits)
    first, last = joint_limits.image_range(q, bounds, ~owner.chain.prismatic)
    rows, values, inside = [], [], []
    for row, i in enumerate(joints):
        within = bool(first[i] <= last[i])
        turns = (first[i] if within else 0.0) + np.arange(last[i] - first[i] + 1.0 if within else 1.0)
        values += list(q[i] + turns * TURN)
        rows += [float(row)] * len(turns)
        inside += [within] * len(turns)
    return np.array(rows), np.array(values), np.array(inside)


_WIDTH, _ROW, _LEAST = 8.0, 0.32, 2.4
# Of what ends an interval, after Okabe and Ito: the colour-blind tell them apart.
_COLOURS = {
    "limit": "#0072b2",
    "fold": "#d55e00",
    "reach": "#000000",
    "singularity": "#e69f00",
    "range": "#009e73",
    "none": "#999999",
}


def intervals(found: Intervals, *, degrees: bool = True) -> "Figure":
    """The intervals of one pose: the parameter across, branches down.

    A bar is an interval; it is dark where the joints are far from their limits, light where they are near. A line at
    each of its ends has the colour of what ends it.

    Args:
        found: of ``arm.intervals``, of a single pose.
        degrees: an angle in degrees; else in rad.

    Example:
        >>> import urdf_ik
        >>> arm = urdf_ik.load("srs_7r")
        >>> figure = urdf_ik.show.plot.intervals(arm.intervals(arm.fk([0.3, 0.5, -0.4, 0.9, 0.2, -0.6, 0.1])))
        >>> len(figure.axes[0].get_yticklabels())
        8
    """
    arm, parameter = found.solver.arm, found.parameter
    names = [name for name in arm.structure.branches if any(each.branch == name for each in found)]
    scale = 180.0 / np.pi if degrees and parameter.unit == "rad" else 1.0
    figure = draw.Picture(figsize=(_WIDTH, max(_LEAST, 1.4 + _ROW * len(names))), layout="constrained")
    axes = figure.subplots()
    for k, each in enumerate(found):
        row, (value, q) = names.index(each.branch), found.samples(k)
        inmost, _ = joint_limits.image_inmost(q, arm.limits, ~arm.chain.prismatic)
        margin = np.clip(np.nan_to_num(joint_limits.margin(inmost, arm.limits)), 0.0, 1.0)
        # Intervals that cross pi are split and continue at -pi.
        for turn in (0.0, 2.0 * np.pi) if parameter.unit == "rad" and each.high > np.pi else (0.0,):
            points = np.stack([scale * (value - turn), np.full(len(value), float(row))], axis=1)
            lines = list(np.stack([points[:-1], points[1:]], axis=1))
            shaded = LineCollection(lines, cmap="Greys", linewidths=9.0, capstyle="butt")
            shaded.set_array(0.5 * (margin[:-1] + margin[1:]))
            shaded.set_clim(-0.35, 1.0)
            axes.add_collection(shaded)
            for end, at in zip(each.ends, (each.low, each.high), strict=True):
                if end.cause != "none":
                    place = scale * (at - turn)
                    axes.plot([place] * 2, [row - 0.38, row + 0.38], color=_COLOURS[end.cause], linewidth=2.2)
    low, high = (-np.pi, np.pi) if parameter.unit == "rad" else parameter.range
    if not np.isfinite(high - low):
        low, high = min(each.low for each in found), max(each.high for each in found)
    axes.set_xlim(scale * low, scale * high)
    axes.set_ylim(len(names) - 0.4, -0.6)
    axes.set_yticks(range(len(names)), [draw.words(name) for name in names], fontsize=8)
    unit = "deg" if scale != 1.0 else parameter.unit
    axes.set_xlabel(f"{draw.words(parameter.label)} [{unit}]", fontsize=9)
    inside = "inside the joint limits" if found.within_limits else "whatever the joint limits"
    axes.set_title(f"{draw.words(arm.name)}: {len(found)} intervals {inside}", fontsize=10)
    causes = [cause for cause in _COLOURS if any(end.cause == cause for each in found for end in each.ends)]
    handles = [Line2D([], [], color=_COLOURS[cause], linewidth=2.2, label=CAUSES[cause]) for cause in causes]
    handles.append(Line2D([], [], color="0.35", linewidth=6, label="solutions; darker: farther from the limits"))
    figure.legend(handles=handles, loc="outside lower center", ncols=3, fontsize=7, frameon=False)
    return figure


_SIZE, _PLACE = (6.4, 5.6), (0.12, 0.1, 0.84, 0.84)
_LEAST = 1e-3
"""Range [deg or m] of a slider whose joint has none."""


def interact(arm: Arm, q: ArrayLike | None = None) -> Any:
    """Sliders in a notebook: the picture drawn anew at every move; two turning joints stand in their workspace.

    Args:
        arm: the arm.
        q: (n,) rad or m within the limits, where the sliders begin; default: zero, or the nearest to it.

    Raises:
        ArgumentError: ``q`` does not fit the arm, or is outside the limits.
        MissingPackage: ipywidgets is not installed.
    """
    try:
        import ipywidgets
    except ImportError:
        raise extras.missing("sliders in a notebook need ipywidgets", "notebooks") from None
    first, slides = draw.posture(arm, q), arm.chain.prismatic
    joint_limits.check_inside(first, arm.limits, arm.joint_names, "sliders begin inside them")
    figure = draw.Picture(figsize=_SIZE)
    drawn = joint_limits.drawn(arm.limits, ~slides)
    region = planar(arm) if draw.is_two_links(arm) else None
    if region is None:
        axes = draw.space(figure.add_axes(_PLACE, projection="3d"), draw.box(looks.surroundings(arm, drawn)))
        line = draw.stick(axes, arm, first, "tab:blue")
    else:
        axes = figure.add_axes(_PLACE)
        draw.regions(axes, region)
        line = draw.two_links(axes, region, first)
        axes.legend(loc="upper left", fontsize=7)
    axes.set_title(draw.words(arm.name))
    scale = np.where(slides, 1.0, 180.0 / np.pi)

    def picture(**values: float) -> "Figure":
        at = np.array(list(values.values())) / scale
        if region is None:
            line.set_data_3d(*looks.stick(arm.chain, at).T)
        else:
            line.set_data(*draw.links(region, at))
        return figure

    # Where a limit is missing, the start is within the slider's ends.
    lower = scale * np.minimum(drawn[:, 0], first)
    upper = np.maximum(scale * np.maximum(drawn[:, 1], first), lower + _LEAST)
    controls = {
        name: ipywidgets.FloatSlider(
            value=scale[i] * first[i],
            min=lower[i],
            max=upper[i],
            step=0.001 if slides[i] else 0.5,
            description=f"{name} [{'m' if slides[i] else '°'}]",
            style={"description_width": "initial"},
        )
        for i, name in enumerate(arm.joint_names)
    }
    return ipywidgets.interactive(picture, **controls)
