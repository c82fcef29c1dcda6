"""Draw an arm, the branches of a pose, joint limits, the workspace or a path.

Branches of a pose stand side by side or overlaid. Limits show all turns of the solutions. A path shows each joint in
all branches along it, limits and contacts, and the plan. Without a pose it is the arm's example, without --output a
window. The workspace of two turning joints is exact; any other is one layer of a map.

Examples:
    urdf-ik plot zyyzyz_6r branches -o all_branches.png
    urdf-ik plot planar_2r workspace --q 0.5,-1 -o two_link_workspace.png
    urdf-ik plot zyyzyz_6r path --poses seam.csv -o path.png
    urdf-ik plot srs_7r intervals -o intervals.png
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, ClassVar

import numpy as np
from numpy.typing import NDArray
from typer import Argument, Option

from urdf_ik.arm import Arm
from urdf_ik.cell import World
from urdf_ik.cli import console, options
from urdf_ik.cli.arm_options import ArmOptions, angles_of, read_world
from urdf_ik.cli.console import Angles
from urdf_ik.cli.options import Value
from urdf_ik.cli.path_options import PathOptions, followed
from urdf_ik.cli.progress import Progress
from urdf_ik.cli.solutions.targets import Target
from urdf_ik.errors import ArgumentError
from urdf_ik.support.text import quoted

if TYPE_CHECKING:
    from matplotlib.figure import Figure


class Picture(StrEnum):
    """The pictures."""

    ARM = "arm"
    BRANCHES = "branches"
    OVERLAY = "overlay"
    LIMITS = "limits"
    WORKSPACE = "workspace"
    SLIDERS = "sliders"
    PATH = "path"
    INTERVALS = "intervals"


@dataclass(frozen=True)
class Layer:
    """Options of a layer of a workspace, as typed."""

    GROUP: ClassVar[str] = "Workspace"
    map: options.Map = None
    axis: Annotated[str, Option(metavar="x|y|z", help="Axis across which a layer lies.")] = "z"
    at: Annotated[float, Option(metavar="M", help="Place of the layer on that axis [m].")] = 0.0
    show: options.Shown = Value.REACH


def command(
    *,
    picture: Annotated[
        Picture,
        Argument(metavar="[WHAT]", help="arm, branches, overlay, limits, workspace, sliders, path or intervals."),
    ] = Picture.ARM,
    typed: options.PoseOptions,
    seed: options.Seed = 0,
    shapes: Annotated[bool, Option(help="The shapes of the links, too, meshes among them.")] = False,
    layer: Layer,
    path: PathOptions,
    chosen: ArmOptions,
    degrees: options.Degrees = False,
    output: Annotated[
        Path | None,
        Option(
            "--output",
            "-o",
            metavar="FILE",
            help="PNG, SVG or PDF. Default: a window.",
            show_default=False,
            rich_help_panel=options.OUTPUT,
        ),
    ] = None,
) -> None:
    """Write the picture, or open a window and wait until it is closed.

    Raises:
        ArgumentError: there is no display, or the file cannot be written.
    """
    from urdf_ik.cli.solutions import targets
    from urdf_ik.show import plot
    from urdf_ik.show.plot.slider_panel import require_display

    chosen.apart_from(typed)
    arm = chosen.load(degrees)
    angles = angles_of(arm, degrees)
    if output is None:
        require_display()
    elif output.suffix.lower() not in plot.SUFFIXES:
        raise ArgumentError(f"{output}: pictures are written as {', '.join(plot.SUFFIXES)}; name the file so")
    held = None
    if picture is Picture.PATH:
        figure = plot.path(followed(arm, angles, typed, path, chosen).plan)
    else:
        target = targets.target(arm, typed, None, seed, angles)
        if len(target.poses) > 1:
            given = f"{len(target.poses)} are given; 'plot {{ROBOT}} path' draws a way through them"
            raise console.usage(f"{picture.value} shows one pose, and {given}", "--poses")
        vector = _vector(arm, typed, angles)
        if picture is Picture.SLIDERS:
            # The object that the sliders belong to must live as long as the window.
            held = plot.sliders(arm, vector, window=output is None)
            figure = held.figure
        elif picture is Picture.ARM:
            figure = plot.arm(arm, vector, shapes=shapes)
        elif picture is Picture.WORKSPACE:
            figure = _workspace(arm, vector, layer)
        else:
            world = read_world(path.settings["world"], chosen)
            figure = _of_pose(arm, target, picture, shapes, degrees, world)
    if output is None:
        plot.show(figure)
    else:
        plot.save(figure, output)


def _vector(arm: Arm, typed: options.PoseOptions, angles: Angles) -> NDArray[np.float64] | None:
    """The joint vector that was typed; None where a pose was, or nothing."""
    vectors = console.joint_vectors(typed.q, "--q", arm.joint_names) if typed.q else None
    return None if vectors is None else angles.typed(vectors[0])


def _of_pose(arm: Arm, target: Target, picture: Picture, shapes: bool, degrees: bool, world: World | None) -> Figure:
    """A picture of a pose's solutions."""
    from urdf_ik.show import plot

    if picture is Picture.INTERVALS:
        return plot.intervals(arm.intervals(target.poses[0]), degrees=degrees)
    solutions = arm.ik(target.poses[0], redundancy=None if target.redundancy is None else target.redundancy[0])
    if picture is Picture.LIMITS:
        return plot.limits(solutions)
    return plot.branches(solutions, overlaid=picture is Picture.OVERLAY, shapes=shapes, world=world)


def _workspace(arm: Arm, q: NDArray[np.float64] | None, layer: Layer) -> Figure:
    from urdf_ik.maps import workspaces
    from urdf_ik.maps.grid import AXES
    from urdf_ik.show import plot
    from urdf_ik.show.plot.slider_panel import is_two_links

    if layer.map is not None:
        found = workspaces.opened(layer.map)
        workspaces.require_map_of(found.about, arm)
        return plot.workspace_slice(found, layer.axis, layer.at, layer.show.value)
    if is_two_links(arm):
        return plot.planar_workspace(workspaces.planar(arm), q)
    if layer.axis not in tuple(AXES):
        raise console.usage(f"no axis is called {quoted(layer.axis)}; there are x, y and z", "--axis")
    grid = workspaces.grid_of(arm, arm.chain.size / 30.0, None)
    k = AXES.index(layer.axis)
    if not grid.lower[k] <= layer.at <= grid.upper[k]:
        raise console.usage(
            f"{layer.axis} = {layer.at:g} m is out of reach, from {grid.lower[k]:g} to {grid.upper[k]:g} m", "--at"
        )
    bounds = np.array([grid.lower, grid.upper])
    bounds[:, k] = layer.at - 0.5 * grid.voxel, layer.at + 0.5 * grid.voxel
    with Progress("solving poses", "solving") as progress:
        found = workspaces.workspace(
            arm,
            grid.voxel,
            bounds=bounds,
            manipulability=layer.show is Value.MANIPULABILITY,
            margin=layer.show is Value.MARGIN,
            progress=progress.tick,
        )
    return plot.workspace_slice(found, layer.axis, layer.at, layer.show.value)
