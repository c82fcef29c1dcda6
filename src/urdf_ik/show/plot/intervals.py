"""The picture of what a pose leaves free: the intervals of the redundancy parameter, branch by branch."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.collections import LineCollection
from matplotlib.lines import Line2D

from urdf_ik.ik.redundancy import Intervals
from urdf_ik.ik.redundancy.intervals import ENDS, bars
from urdf_ik.show.plot import axes as draw

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_WIDTH, _ROW, _LEAST = 8.0, 0.32, 2.4


def intervals(found: Intervals, *, degrees: bool = True) -> Figure:
    """The intervals of one pose: the parameter across, branches down.

    A bar is an interval; it is dark where the joints are far from their limits, light where they are near. A line at
    each of its ends has the colour of what ends it.

    Args:
        found: of ``arm.intervals``, of a single pose.
        degrees: an angle in degrees; else in rad.

    Raises:
        ArgumentError: these are the intervals of a batch.

    Example:
        >>> import urdf_ik
        >>> arm = urdf_ik.load("srs_7r")
        >>> figure = urdf_ik.show.plot.intervals(arm.intervals(arm.fk([0.3, 0.5, -0.4, 0.9, 0.2, -0.6, 0.1])))
        >>> len(figure.axes[0].get_yticklabels())
        8
    """
    arm, parameter = found.solver.arm, found.parameter
    names, drawn = bars(found)
    scale = 180.0 / np.pi if degrees and parameter.unit == "rad" else 1.0
    figure = draw.Picture(figsize=(_WIDTH, max(_LEAST, 1.4 + _ROW * len(names))), layout="constrained")
    axes = figure.subplots()
    for bar in drawn:
        points = np.stack([scale * bar.value, np.full(len(bar.value), float(bar.row))], axis=1)
        lines = list(np.stack([points[:-1], points[1:]], axis=1))
        shaded = LineCollection(lines, cmap="Greys", linewidths=9.0, capstyle="butt")
        shaded.set_array(bar.margin)
        shaded.set_clim(-0.35, 1.0)
        axes.add_collection(shaded)
        for at, cause in bar.ends:
            axes.plot([scale * at] * 2, [bar.row - 0.38, bar.row + 0.38], color=ENDS[cause][0], linewidth=2.2)
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
    causes = [cause for cause in ENDS if any(end.cause == cause for each in found for end in each.ends)]
    handles = [Line2D([], [], color=ENDS[cause][0], linewidth=2.2, label=ENDS[cause][1]) for cause in causes]
    handles.append(Line2D([], [], color="0.35", linewidth=6, label="solutions; darker: farther from the limits"))
    figure.legend(handles=handles, loc="outside lower center", ncols=3, fontsize=7, frameon=False)
    return figure
