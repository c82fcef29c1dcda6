"""Freeze an arm: write its answers of today to a lock file for version control.

The lock file holds joints, axes, limits, shapes, Pinocchio's poses and every solution of 50 poses, as text of at most
200 kB. Poses of yours are kept as well. Contacts are kept where all shapes can be read; --collisions makes it an error
where they cannot. `urdf-ik verify` says later what is different. The status is 1 when the time limit left poses out.

Examples:
    urdf-ik freeze ur5 ur5.lock.json
    urdf-ik freeze my_arm.urdf --tip tool0 --poses stations.csv -o my_arm.lock.json
"""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from urdf_ik.cli import options
from urdf_ik.cli.arm_options import ArmOptions, angles_of
from urdf_ik.cli.options import ReportFormat

Lock = Annotated[Path | None, typer.Argument(metavar="LOCK", help="The lock file to write, such as arm.lock.json.")]
LockFile = Annotated[
    Path | None,
    typer.Option(
        "--output",
        "-o",
        metavar="FILE",
        help="The same; commit the file.",
        rich_help_panel=options.OUTPUT,
    ),
]


def command(
    *,
    lock_file: Lock = None,
    output: LockFile = None,
    given: options.PoseOptions,
    collisions: options.Collisions = None,
    time_limit: options.TimeLimit = None,
    chosen: ArmOptions,
    printed_as: options.TextFormat = ReportFormat.TABLE,
) -> None:
    """Write the lock file.

    Raises:
        typer.BadParameter: no lock file is named, or two.
        typer.Exit: the time limit left poses out.
    """
    from urdf_ik.cli import console
    from urdf_ik.cli.errors import Status
    from urdf_ik.cli.progress import Progress
    from urdf_ik.cli.solutions import targets
    from urdf_ik.support import files
    from urdf_ik.verify.baselines import freeze

    chosen.apart_from(given)
    if (lock_file is None) == (output is None):
        wanted_form = f"urdf-ik freeze {chosen.robot} arm.lock.json"
        problem = "name the lock file once" if output else f"name the lock file: {wanted_form} (--lock holds a joint)"
        raise console.usage(problem, "LOCK")
    output = output or lock_file
    assert output is not None
    files.writable(output)
    arm = chosen.load()
    own = targets.own_poses(arm, given, angles_of(arm, False))
    wanted: bool | str = collisions is None or ("require" if collisions else False)
    with Progress("solving poses", "solving") as progress:
        lock = freeze(arm, own, collisions=wanted, time_limit=time_limit, progress=progress.tick)
    lock.save(output)
    if printed_as is ReportFormat.JSON:
        about = {"robot": arm.name, "base": arm.base, "tip": arm.tip, "poses": len(lock.poses), "file": str(output)}
        about |= {"unlooked": lock.unlooked}
        console.write(console.json_text(about), None)
    else:
        console.write(f"{repr(lock)[1:-1]}, in {output}\n", None)
    if lock.unlooked:
        raise typer.Exit(Status.FAILED)
