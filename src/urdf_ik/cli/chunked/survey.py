"""What ``urdf-ik check FOLDER`` does: every URDF of a folder, one table."""

from __future__ import annotations

from dataclasses import fields
from typing import TYPE_CHECKING

from urdf_ik.cli import console
from urdf_ik.cli.progress import Progress
from urdf_ik.verify import surveys

if TYPE_CHECKING:
    from urdf_ik.cli.chosen_arm import ChosenArm
    from urdf_ik.cli.chunked.places import Places

_OF_ALL = {"robot", "base", "tip", "mesh_root", "degrees", "suffix"}


def run(
    chosen: ChosenArm, n: int, seed: int, complete: bool, collision: bool | None, places: Places, as_json: bool
) -> bool:
    """Print the table; true where nothing failed.

    Raises:
        typer.BadParameter: an option that is one arm's, or places that cannot be.
        UrdfError: the folder holds no URDF.
        JobError: a store that cannot be gone on with, or cannot be written.
        JobError: a scheduler or workers that cannot do the work.
    """
    places.check()
    for each in fields(chosen):
        if each.name not in _OF_ALL and getattr(chosen, each.name):
            option = f"--{each.name.replace('_', '-')}"
            raise console.usage(f"{chosen.robot} is a folder, and {option} is for one arm", option)
    with places.client() as client, Progress("checking arms", "checking") as progress:
        found = surveys.survey(
            chosen.robot,
            n=n,
            seed=seed,
            complete=complete,
            collision=collision,
            base=chosen.base,
            tip=chosen.tip,
            mesh_roots=chosen.mesh_root or (),
            store=places.store,
            client=client,
            progress=progress.tick,
        )
    console.write(found.to_json() if as_json else f"{found}\n", None)
    return found.passed
