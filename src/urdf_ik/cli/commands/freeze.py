"""Freeze an arm: write its answers of today to a lock file for version control.

The lock file holds joints, axes, limits, shapes, Pinocchio's poses and every solution of 50 poses, as text of at most
200 kB. Poses of yours are kept as well. Contacts are kept where all shapes can be read; --collisions makes it an error
where they cannot. `urdf-ik verify` says later what is different.

Examples:
    urdf-ik freeze ur5 -o ur5.lock.json
    urdf-ik freeze my_arm.urdf --tip tool0 --poses stations.csv -o my_arm.lock.json
"""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from urdf_ik.cli import options
from urdf_ik.cli.arm_options import ArmOptions, angles_of
from urdf_ik.cli.options import ReportFormat

LockFile = Annotated[
    Path,
    typer.Option(
        "--output",
        "-o",
        metavar="FILE",
        help="The lock file, such as arm.lock.json; commit it.",
        rich_help_panel=options.OUTPUT,
    ),
]


def command(
    *,
    output: LockFile,
    given: options.PoseOptions,
    collisions: options.Collisions = None,
    chosen: ArmOptions,
    printed_as: options.TextFormat = ReportFormat.TABLE,
) -> None:
    """Write the lock file."""
    from urdf_ik.cli import console
    from urdf_ik.cli.solutions import targets
    from urdf_ik.support import files
    from urdf_ik.verify.baselines import freeze

    chosen.apart_from(given)
    files.writable(output)
    arm = chosen.load()
    own = targets.own_poses(arm, given, angles_of(arm, False))
    wanted: bool | str = collisions is None or ("require" if collisions else False)
    lock = freeze(arm, own, collisions=wanted)
    lock.save(output)
    if printed_as is ReportFormat.JSON:
        about = {"robot": arm.name, "base": arm.base, "tip": arm.tip, "poses": len(lock.poses), "file": str(output)}
        console.write(console.json_text(about), None)
    else:
        console.write(f"{repr(lock)[1:-1]}, in {output}\n", None)
