"""The picture of what a pose leaves free: the intervals of the redundancy parameter, branch by branch."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.collections import LineCollection
from matplotlib.lines import Line2D

from urdf_ik.ik.redundancy import Intervals
from urdf_ik.ik.redundancy.curves import CAUSES
from urdf_ik.ik.solutions import limits
from urdf_ik.show.plot import axes as draw

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_WIDTH, _ROW, _LEAST = 8.0, 0.32, 2.4
# Of what ends an interval, after Okabe and Ito: the colour-blind tell them apart.
_COLOURS = {
    "limit": "#0072b2",
    "fold": "#d55e00",
    "reach": "#000000",
    "contact": "#cc79a7",
    "singularity": "#e69f00",
    "range": "#009e73",
    "none": "#999999",
}


def intervals(found: Intervals, *, degrees: bool = True) -> Figure:
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
        inmost, _ = limits.image_inmost(q, arm.limits, ~arm.chain.prismatic)
        margin = np.clip(np.nan_to_num(limits.margin(inmost, arm.limits)), 0.0, 1.0)
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
