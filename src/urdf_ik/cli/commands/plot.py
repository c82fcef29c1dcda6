"""What ``urdf-ik plot`` draws, and where it goes."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from urdf_ik.cli import console, targets
from urdf_ik.cli.chosen_arm import angles_of
from urdf_ik.cli.options import Picture
from urdf_ik.cli.paths import followed
from urdf_ik.cli.progress import Progress
from urdf_ik.errors import ArgumentError
from urdf_ik.maps import workspaces
from urdf_ik.maps.workspaces.grid import AXES, grid_of
from urdf_ik.maps.workspaces.question import require_map_of
from urdf_ik.show import plot
from urdf_ik.show.plot.slider_panel import is_two_links, require_display
from urdf_ik.support.text import quoted

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from numpy.typing import NDArray

    from urdf_ik.arm import Arm
    from urdf_ik.cli.chosen_arm import ChosenArm, TypedPath
    from urdf_ik.cli.console import Angles
    from urdf_ik.ik.solutions import IKSolutions


@dataclass(frozen=True)
class Asked:
    """The options as typed."""

    target: targets.Asked
    path: TypedPath
    shapes: bool
    map: Path | None
    axis: str
    at: float
    value: str


def run(chosen: ChosenArm, degrees: bool, what: Picture, asked: Asked, output: Path | None) -> None:
    """Write the picture, or open a window and wait until it is closed.

    Raises:
        ArgumentError: there is no display, or the file cannot be written.
    """
    arm = chosen.load()
    angles = angles_of(arm, degrees)
    if what is not Picture.PATH and asked.path.waypoints is not None:
        raise console.usage(f"{what.value} is no picture of a path; `urdf-ik plot ROBOT path` is", "--waypoints")
    if output is None:
        require_display()
    elif output.suffix.lower() not in plot.SUFFIXES:
        raise ArgumentError(f"{output}: pictures are written as {', '.join(plot.SUFFIXES)}; name the file so")
    q = None
    if asked.target.q:
        q = angles.typed(console.numbers(asked.target.q[0], "--q", arm.joint_names))
    if what is Picture.SLIDERS:
        # The object that the sliders belong to must live as long as the window.
        held = plot.sliders(arm, q, window=output is None)
        figure = held.figure
    elif what is Picture.ARM:
        figure = plot.arm(arm, q, shapes=asked.shapes)
    elif what is Picture.PATH:
        figure = plot.path(followed(arm, angles, asked.path, chosen).plan)
    elif what is Picture.INTERVALS:
        figure = plot.intervals(arm.intervals(targets.target(arm, asked.target, angles).poses[0]), degrees=degrees)
    elif what is Picture.WORKSPACE:
        figure = _workspace(arm, q, asked)
    else:
        solutions = _solutions(arm, angles, asked)
        if what is Picture.LIMITS:
            figure = plot.limits(solutions)
        else:
            figure = plot.branches(solutions, overlaid=what is Picture.OVERLAY, shapes=asked.shapes)
    if output is None:
        plot.show(figure)
    else:
        plot.save(figure, output)


def _solutions(arm: Arm, angles: Angles, asked: Asked) -> IKSolutions:
    target = targets.target(arm, asked.target, angles)
    at = None if target.redundancy is None else target.redundancy[0]
    return arm.ik(target.poses[0], redundancy=at)


def _workspace(arm: Arm, q: NDArray[np.float64] | None, asked: Asked) -> Figure:
    if asked.map is not None:
        found = workspaces.opened(asked.map)
        require_map_of(found.about, arm)
        return plot.workspace_slice(found, asked.axis, asked.at, asked.value)
    if is_two_links(arm):
        return plot.planar_workspace(workspaces.planar(arm), q)
    if asked.axis not in tuple(AXES):
        raise console.usage(f"no axis is called {quoted(asked.axis)}; there are x, y and z", "--axis")
    grid = grid_of(arm, arm.chain.size / 30.0, None)
    k = AXES.index(asked.axis)
    if not grid.lower[k] <= asked.at <= grid.upper[k]:
        raise console.usage(
            f"{asked.axis} = {asked.at:g} m is out of reach, from {grid.lower[k]:g} to {grid.upper[k]:g} m", "--at"
        )
    bounds = np.array([grid.lower, grid.upper])
    bounds[:, k] = asked.at - 0.5 * grid.voxel, asked.at + 0.5 * grid.voxel
    with Progress("solving poses", "solving") as progress:
        found = workspaces.workspace(
            arm,
            grid.voxel,
            bounds=bounds,
            manipulability=asked.value == "manipulability",
            margin=asked.value == "margin",
            progress=progress.tick,
        )
    return plot.workspace_slice(found, asked.axis, asked.at, asked.value)
