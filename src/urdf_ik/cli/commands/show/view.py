"""Show an arm in the browser: every solution of a target to drag, sliders for the joints.

One pose is where the target begins. With more poses it also shows a plan to play along their path, or where each branch
ends; with --world, obstacles. Ctrl-C ends it.

Examples:
    urdf-ik view ur5
    urdf-ik view my_arm.urdf --tip tool0 --mesh-root meshes --port 9000
    urdf-ik view panda -o panda.html
    urdf-ik view zyyzyz_6r --poses seam.csv --world cell.urdf
"""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import numpy as np
import typer
from numpy.typing import NDArray
from typer import Option

from urdf_ik.cli import console, interrupts, options
from urdf_ik.cli.arm_options import ArmOptions, angles_of, read_world
from urdf_ik.cli.path_options import PathOptions, followed
from urdf_ik.errors import escaped
from urdf_ik.show.viewer import Viewer


def command(
    *,
    typed: options.PoseOptions,
    path: PathOptions,
    chosen: ArmOptions,
    degrees: options.Degrees = False,
    host: Annotated[
        str, Option(metavar="ADDRESS", help="Listen there; 0.0.0.0 lets everybody in the network in.")
    ] = "127.0.0.1",
    port: Annotated[
        int | None,
        Option(metavar="PORT", help="Default: 8080, or the first free one after it.", show_default=False),
    ] = None,
    dark: Annotated[bool, Option("--dark", help="Light on dark.")] = False,
    output: Annotated[
        Path | None,
        Option(
            "--output",
            "-o",
            metavar="FILE",
            help="Write the scene there as one HTML page, and leave.",
            rich_help_panel=options.OUTPUT,
        ),
    ] = None,
) -> None:
    """Show an arm until Ctrl-C, or write its scene to a file; with a plan where there are waypoints.

    Raises:
        MissingPackage: viser is not installed.
        UrdfIkError: the port is in use, or the host is not this machine, or a file cannot be read.
        typer.BadParameter: the file cannot be written.
    """
    from urdf_ik.cli.solutions import targets
    from urdf_ik.show.viewer import Viewer

    chosen.apart_from(typed)
    arm = chosen.load(degrees)
    angles, plan, first = angles_of(arm, degrees), None, None
    given = targets.given(arm, typed, angles)
    world = read_world(path.settings["world"], chosen)
    if given is not None and len(given.poses) == 1:
        first = given.poses[0]
    elif given is not None:
        plan = followed(arm, angles, given, path, chosen).plan
        if not plan.found:
            typer.echo(escaped(f"no plan:\n{plan.explain()}"), err=True)
    if output is not None:
        with Viewer(arm, port=0, plan=plan, world=world, dark=dark) as viewer:
            _begin(viewer, first)
            console.write(viewer.html(scene=True), output)
        return
    roots = chosen.mesh_root or ()
    with Viewer(arm, host=host, port=port, mesh_roots=roots, plan=plan, world=world, dark=dark) as viewer:
        _begin(viewer, first)
        # From the line that shows the address on, not only once it is waited for.
        with interrupts.as_the_usual_end():
            typer.echo(escaped(f"{arm.name}: {viewer.url} (Ctrl-C ends it)"))
            if viewer.message:
                typer.echo(escaped(viewer.message), err=True)
            viewer.wait()


def _begin(viewer: Viewer, first: NDArray[np.float64] | None) -> None:
    """Show the target's first pose."""
    if first is not None:
        viewer.move_target(first)
        viewer.settle()
