"""Verify an arm against its lock file.

It names the joint, link or limit that is different, by how many mm and degrees, and the solutions that were lost or
gained at which poses. The status is 1 when something is different, or when the time limit left poses out.

Base, tip and held joints are those of the lock file where they are not given. A tool, a free axis or a redundancy
joint has to be given again.

Examples:
    urdf-ik verify my_arm.urdf my_arm.lock.json
    urdf-ik verify my_arm.urdf my_arm.lock.json --tolerance-mm 0.1 --ignore visuals,collisions
    urdf-ik verify my_arm.urdf my_arm.lock.json --update
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Annotated

import typer

from urdf_ik.arm import Arm
from urdf_ik.cli import options
from urdf_ik.cli.arm_options import ArmOptions
from urdf_ik.cli.errors import Status
from urdf_ik.cli.options import ReportFormat
from urdf_ik.verify.baselines import Baseline

LockFile = Annotated[Path, typer.Argument(metavar="LOCK", help="The lock file that `urdf-ik freeze` wrote.")]
Millimetres = Annotated[
    float | None,
    typer.Option("--tolerance-mm", metavar="MM", min=0.0, help="Lengths up to this are the same. Default: 1e-6."),
]
Degrees = Annotated[
    float | None,
    typer.Option("--tolerance-deg", metavar="DEG", min=0.0, help="Angles up to this are the same. Default: 6e-8."),
]
Ignored = Annotated[
    str | None,
    typer.Option("--ignore", metavar="KINDS", help="Does not count: limits, collisions, visuals, names; with commas."),
]
Update = Annotated[bool, typer.Option("--update", help="Then write the lock file anew; the status is 0.")]


def command(
    *,
    chosen: ArmOptions,
    lock_file: LockFile,
    tolerance_mm: Millimetres = None,
    tolerance_deg: Degrees = None,
    ignore: Ignored = None,
    update: Update = False,
    time_limit: options.TimeLimit = None,
    printed_as: options.TextFormat = ReportFormat.TABLE,
) -> None:
    """Print what is different."""
    from urdf_ik.cli import console
    from urdf_ik.cli.progress import Progress
    from urdf_ik.errors import ChainError, message
    from urdf_ik.verify.baselines import Baseline, freeze
    from urdf_ik.verify.differences import Tolerance, ignored

    Tolerance.read(tolerance_mm, tolerance_deg)
    ignored(ignore or ())
    lock = Baseline.load(lock_file)
    try:
        arm = loaded(chosen, lock)
    except ChainError as error:
        if chosen.base is None and chosen.tip is None and chosen.chain is None:
            console.write(
                message(f"FAILED: {lock.arm.base} to {lock.arm.tip} of the lock is gone: {error}") + "\n", None
            )
            raise typer.Exit(Status.FAILED) from None
        raise
    with Progress("comparing poses", "solving") as progress:
        found = lock.verify(
            arm, tolerance_mm=tolerance_mm, tolerance_deg=tolerance_deg, ignore=ignore or (), time_limit=time_limit,
            progress=progress.tick,
        )  # fmt: skip
    console.write(found.to_json() if printed_as is ReportFormat.JSON else f"{found}\n", None)
    if update:
        own = [pose.matrix for pose in lock.poses if pose.kind == "own"]
        anew = freeze(arm, own or None)
        anew.save(lock_file)
        typer.echo(f"updated: {lock_file}", err=True)
    elif not found.passed:
        raise typer.Exit(Status.FAILED)


def loaded(chosen: ArmOptions, lock: Baseline) -> Arm:
    """The arm, its base, tip and held joints those of the lock where they are not given."""
    held = [f"{name}={value!r}" for name, value in lock.arm.locked] if chosen.lock is None else chosen.lock
    if chosen.chain is None and chosen.srdf is None:
        base = lock.arm.base if chosen.base is None else chosen.base
        tip = lock.arm.tip if chosen.tip is None else chosen.tip
        chosen = replace(chosen, base=base, tip=tip)
    return replace(chosen, lock=held or None).load()
