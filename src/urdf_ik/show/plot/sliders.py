"""Sliders for the joints in a notebook."""

from typing import Any

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import ArrayLike

from urdf_ik.arm import Arm
from urdf_ik.ik.solutions import limits
from urdf_ik.maps import workspaces
from urdf_ik.show import shapes as looks
from urdf_ik.show.plot import axes as draw
from urdf_ik.support import extras

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
    limits.check_inside(first, arm.limits, arm.joint_names, "sliders begin inside them")
    figure = draw.Picture(figsize=_SIZE)
    drawn = limits.drawn(arm.limits, ~slides)
    region = workspaces.planar(arm) if draw.is_two_links(arm) else None
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

    def picture(**values: float) -> Figure:
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
