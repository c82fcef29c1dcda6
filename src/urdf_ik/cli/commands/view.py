"""What ``urdf-ik view`` does: a page in the browser, or the scene as a file."""

from __future__ import annotations

import contextlib
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import typer

from urdf_ik.cli import console
from urdf_ik.cli.chosen_arm import angles_of
from urdf_ik.cli.paths import cell, followed
from urdf_ik.errors import escaped
from urdf_ik.maps import workspaces
from urdf_ik.show.viewer import Viewer

if TYPE_CHECKING:
    from urdf_ik.cli.chosen_arm import ChosenArm, TypedPath


@dataclass(frozen=True)
class Layer:
    """The map to show and its first layer, as typed; None for what was not given."""

    map: Path | None
    axis: str | None
    at: float | None
    what: str

    def show(self, viewer: Viewer) -> None:
        """Show it; nothing where no map was given."""
        if self.map is not None:
            viewer.show_workspace(workspaces.opened(self.map), self.what, self.axis, self.at)
            viewer.settle()
        elif self.axis is not None or self.at is not None:
            raise console.usage("a layer is one of a map: give --map, too", "--axis" if self.axis else "--at")


def run(
    chosen: ChosenArm,
    path: TypedPath,
    layer: Layer,
    degrees: bool,
    host: str,
    port: int | None,
    output: Path | None,
    *,
    dark: bool = False,
) -> None:
    """Show an arm until Ctrl-C, or write its scene to ``output``; with a plan where there are waypoints.

    Raises:
        MissingPackage: viser is not installed.
        UrdfIkError: the port is in use, or the host is not this machine, or a file cannot be read.
        typer.BadParameter: the file cannot be written.
    """
    arm = chosen.load()
    plan, world = None, None
    if path.waypoints is not None:
        found = followed(arm, angles_of(arm, degrees), path, chosen)
        plan, world = found.plan, found.world
        if not plan.found:
            typer.echo(escaped(f"no plan:\n{plan.explain()}"), err=True)
    else:
        world = cell(path.world, chosen)
    if output is not None:
        with Viewer(arm, port=0, plan=plan, world=world, dark=dark) as viewer:
            layer.show(viewer)
            console.write(viewer.html(), output)
        return
    roots = chosen.mesh_root or ()
    with Viewer(arm, host=host, port=port, mesh_roots=roots, plan=plan, world=world, dark=dark) as viewer:
        layer.show(viewer)
        # It ends the page as soon as its address stands there, not only once it is waited for.
        with contextlib.suppress(KeyboardInterrupt):
            typer.echo(escaped(f"{arm.name}: {viewer.url} (Ctrl-C ends it)"))
            if viewer.message:
                typer.echo(escaped(viewer.message), err=True)
            viewer.wait()
