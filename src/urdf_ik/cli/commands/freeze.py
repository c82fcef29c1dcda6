"""Freeze an arm: write its answers of today to a lock file for version control.

The lock file holds joints, axes, limits, shapes, Pinocchio's poses and every solution of 50 poses, as text of at most
200 kB. `urdf-ik verify` says later what is different.

Examples:
    urdf-ik freeze ur5 -o ur5.lock.json
    urdf-ik freeze my_arm.urdf --tip tool0 --poses stations.csv -o my_arm.lock.json
"""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from urdf_ik.cli import options
from urdf_ik.cli.arm_options import ArmOptions

LockFile = Annotated[
    Path, typer.Option("--output", "-o", metavar="FILE", help="The lock file, such as arm.lock.json; commit it.")
]
OwnPoses = Annotated[
    str | None, typer.Option("--poses", metavar="FILE", help=f"Poses of yours, kept as well: {options.POSES_IN_A_FILE}")
]
Contacts = Annotated[
    bool | None,
    typer.Option(
        "--collisions/--no-collisions",
        help="Fail where a collision shape cannot be read, or leave contacts out. Default: keep contacts where all "
        "shapes can be read, and say where they cannot.",
        show_default=False,
    ),
]


def command(
    *,
    output: LockFile,
    poses: OwnPoses = None,
    collisions: Contacts = None,
    chosen: ArmOptions,
) -> None:
    """Write the lock file."""
    from urdf_ik.cli import console
    from urdf_ik.support import files
    from urdf_ik.verify.baselines import freeze

    chosen.without_stdin(poses, "--poses")
    files.writable(output)
    own = None if poses is None else console.read_poses(poses, "--poses")
    wanted: bool | str = collisions is None or ("require" if collisions else False)
    lock = freeze(chosen.load(), own, collisions=wanted)
    lock.save(output)
    console.write(f"{repr(lock)[1:-1]}, in {output}\n", None)
