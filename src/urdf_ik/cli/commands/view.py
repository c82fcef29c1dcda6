"""What ``urdf-ik view`` does: a page in the browser, or the scene as a file."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import typer

from urdf_ik.cli import console
from urdf_ik.viewer import Viewer

if TYPE_CHECKING:
    from urdf_ik.arm import Arm


def run(arm: Arm, host: str, port: int | None, mesh_roots: list[Path] | None, output: Path | None) -> None:
    """Show ``arm`` until Ctrl-C, or write its scene to ``output``.

    Raises:
        MissingPackage: viser is not installed.
        UrdfIkError: the port is in use, or the host is not this machine.
        typer.BadParameter: the file cannot be written.
    """
    if output is not None:
        with Viewer(arm, port=0) as viewer:
            console.write(viewer.html(), output)
        return
    with Viewer(arm, host=host, port=port, mesh_roots=mesh_roots or ()) as viewer:
        typer.echo(f"{arm.name}: {viewer.url} (Ctrl-C ends it)")
        if viewer.message:
            typer.echo(viewer.message, err=True)
        viewer.wait()
