"""The commands ``plot`` and ``view``, which draw an arm."""

from contextlib import suppress
from dataclasses import dataclass
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING

import typer

from urdf_ik.arm import Arm
from urdf_ik.cell import World
from urdf_ik.cli import console, options, targets
from urdf_ik.cli.arm_options import ArmOptions, read_world
from urdf_ik.cli.commands.path import PathOptions, followed
from urdf_ik.cli.console import usage
from urdf_ik.cli.options import PoseOptions
from urdf_ik.errors import ArgumentError, escaped
from urdf_ik.typing import Array

if TYPE_CHECKING:
    from matplotlib.figure import Figure


Picture = StrEnum("Picture", ["ARM", "BRANCHES", "LIMITS", "WORKSPACE", "PATH", "INTERVALS"])
_Value = StrEnum("_Value", ["REACH", "SOLUTIONS", "MANIPULABILITY", "MARGIN", "CLEARANCE"])


@dataclass(frozen=True)
class _Layer(options.Record):
    """Options of a layer of a workspace, as typed.

    Options:
        map (PATH): Map from `urdf-ik workspace`, to cut a layer from.
        axis (x|y|z): Axis across which a layer lies.
        at (M): Place of the layer on that axis [m].
        show (VALUE): Value of a layer's voxels: reach, solutions, manipulability, margin, clearance.
    """

    GROUP = "Workspace"
    map: Path | None = None
    axis: str = "z"
    at: float = 0.0
    show: _Value = _Value.REACH


def plot(
    *,
    picture: Picture = Picture.ARM,
    typed: PoseOptions,
    seed: int = 0,
    shapes: bool = False,
    layer: _Layer,
    path: PathOptions,
    chosen: ArmOptions,
    degrees: bool = False,
    output: Path,
) -> None:
    """Draw an arm, the branches of a pose, joint limits, the workspace or a path.

    Branches of a pose stand side by side. Limits show all turns of the solutions. A path shows each
    joint in all branches along it, limits and contacts, and the plan. Without a pose it is the arm's example. The
    workspace of two turning joints is exact; any other is one layer of --map.

    Examples:
        urdf-ik plot zyyzyz_6r branches -o all_branches.png
        urdf-ik plot planar_2r workspace --q 0.5,-1 -o two_link_workspace.png
        urdf-ik plot zyyzyz_6r path --poses seam.csv -o path.png
        urdf-ik plot srs_7r intervals -o intervals.png

    Positional:
        picture ([WHAT]): arm, branches, limits, workspace, path or intervals.

    Options:
        shapes: The shapes of the links, too, meshes among them.
        output (-o FILE): PNG, SVG or PDF.
    """
    from urdf_ik.show import plot as pictures

    arm, angles = chosen.loaded(degrees, typed)
    if output.suffix.lower() not in pictures.SUFFIXES:
        raise ArgumentError(f"{output}: pictures are written as {', '.join(pictures.SUFFIXES)}; name the file so")
    if picture is Picture.PATH:
        figure = pictures.path(followed(arm, angles, typed, path, chosen).plan)
    else:
        target = targets.target(arm, typed, None, seed, angles)
        if (count := len(target.poses)) > 1:
            way = "'plot {ROBOT} path' draws a way through them"
            raise usage(f"{picture.value} shows one pose, and {count} are given; {way}", "--poses")
        q = angles.typed(console.joint_vectors(typed.q, "--q", arm.joint_names)[0]) if typed.q else None
        if picture is Picture.ARM:
            figure = pictures.arm(arm, q, shapes=shapes)
        elif picture is Picture.WORKSPACE:
            figure = _workspace(arm, q, layer)
        else:
            world = read_world(path.settings["world"], chosen)
            figure = _of_pose(arm, target, picture, shapes, degrees, world)
    pictures.save(figure, output)


def _of_pose(
    arm: Arm, target: targets.Target, picture: Picture, shapes: bool, degrees: bool, world: World | None
) -> "Figure":
    """A picture of a pose's solutions."""
    from urdf_ik.show import plot

    if picture is Picture.INTERVALS:
        return plot.intervals(arm.intervals(target.poses[0]), degrees=degrees)
    solutions = arm.ik(target.poses[0], redundancy=None if target.redundancy is None else target.redundancy[0])
    if picture is Picture.LIMITS:
        return plot.limits(solutions)
    return plot.branches(solutions, shapes=shapes, world=world)


def _workspace(arm: Arm, q: Array | None, layer: _Layer) -> "Figure":
    from urdf_ik.maps import workspaces
    from urdf_ik.show import plot
    from urdf_ik.show.plot.axes import is_two_links

    if layer.map is not None:
        found = workspaces.opened(layer.map)
        workspaces.require_map_of(found.about, arm)
        return plot.workspace_slice(found, layer.axis, layer.at, layer.show.value)
    if not is_two_links(arm):
        raise usage("make a map first: urdf-ik workspace ROBOT -o map.npz", "--map")
    return plot.planar_workspace(workspaces.planar(arm), q)


def view(
    *,
    typed: PoseOptions,
    path: PathOptions,
    chosen: ArmOptions,
    degrees: bool = False,
    port: int | None = None,
) -> None:
    """Show an arm in the browser: every solution of a target to drag, sliders for the joints.

    One pose is where the target begins. With more poses it also shows a plan to play along their path, or where each
    branch ends; with --world, obstacles. Ctrl-C ends it.

    Examples:
        urdf-ik view ur5
        urdf-ik view my_arm.urdf --tip tool0 --mesh-root meshes --port 9000
        urdf-ik view zyyzyz_6r --poses seam.csv --world cell.urdf

    Options:
        port (PORT): Default: 8080, or the first free one after it; 0: any free one.
    """
    from urdf_ik.show.viewer import Viewer

    arm, angles = chosen.loaded(degrees, typed)
    plan, first = None, None
    target = targets.given(arm, typed, angles)
    world = read_world(path.settings["world"], chosen)
    if target is not None and len(target.poses) == 1:
        first = target.poses[0]
    elif target is not None:
        plan = followed(arm, angles, target, path, chosen).plan
        if not plan.found:
            console.say(f"no plan:\n{plan.explain()}")
    roots = chosen.mesh_root or ()
    with Viewer(arm, port=port, mesh_roots=roots, plan=plan, world=world) as viewer:
        if first is not None:
            viewer.move_target(first)
            viewer.settle()
        with suppress(KeyboardInterrupt):  # how the user ends it: the status is 0
            typer.echo(escaped(f"{arm.name}: {viewer.url} (Ctrl-C ends it)"))
            if viewer.message:
                console.say(viewer.message)
            viewer.wait()
