"""The commands ``freeze`` and ``verify``, which write and read lock files."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Annotated

import typer
from typer import Argument, Option

from urdf_ik.arm import Arm
from urdf_ik.cli import console, options
from urdf_ik.cli.arm_options import ArmOptions, angles_of
from urdf_ik.cli.console import Status
from urdf_ik.cli.options import ReportFormat
from urdf_ik.cli.progress import Progress
from urdf_ik.errors import ChainError, message
from urdf_ik.support import files
from urdf_ik.verify import baselines
from urdf_ik.verify.baselines import Baseline
from urdf_ik.verify.differences import Tolerance, ignored


def freeze(
    *,
    lock_file: Annotated[
        Path | None, Argument(metavar="LOCK", help="The lock file to write, such as arm.lock.json.")
    ] = None,
    output: Annotated[Path | None, options.output("The same; commit the file.")] = None,
    typed: options.PoseOptions,
    collisions: options.Collisions = None,
    time_limit: options.TimeLimit = None,
    chosen: ArmOptions,
    printed_as: options.TextFormat = ReportFormat.TABLE,
) -> None:
    """Freeze an arm: write its answers of today to a lock file for version control.

    The lock file holds joints, axes, limits, shapes, Pinocchio's poses and every solution of 50 poses, as text of
    at most 200 kB. Poses of yours are kept as well. Contacts are kept where all shapes can be read; --collisions
    makes it an error where they cannot. `urdf-ik verify` says later what is different. The status is 1 when the
    time limit left poses out.

    Examples:
        urdf-ik freeze ur5 ur5.lock.json
        urdf-ik freeze my_arm.urdf --tip tool0 --poses stations.csv -o my_arm.lock.json

    Raises:
        typer.BadParameter: no lock file is named, or two.
        typer.Exit: the time limit left poses out.
    """
    from urdf_ik.cli import targets

    chosen.apart_from(typed)
    file = output or lock_file
    if file is None or (lock_file is not None and output is not None):
        wanted = f"name the lock file: urdf-ik freeze {chosen.robot} arm.lock.json (--lock holds a joint)"
        raise console.usage("name the lock file once" if file else wanted, "LOCK")
    files.writable(file)
    arm = chosen.load()
    target = targets.given(arm, typed, angles_of(arm, False))
    with Progress("solving poses") as progress:
        lock = baselines.freeze(
            arm,
            None if target is None else target.poses,
            collisions=collisions is None or ("require" if collisions else False),
            time_limit=time_limit,
            progress=progress.tick,
        )
    lock.save(file)
    about = {"robot": arm.name, "base": arm.base, "tip": arm.tip, "poses": len(lock.poses), "file": str(file)}
    console.emit(about | {"unlooked": lock.unlooked}, lambda: f"{repr(lock)[1:-1]}, in {file}\n", printed_as)
    if lock.unlooked:
        raise typer.Exit(Status.FAILED)


def verify(
    *,
    chosen: ArmOptions,
    lock_file: Annotated[Path, Argument(metavar="LOCK", help="The lock file that `urdf-ik freeze` wrote.")],
    tolerance_mm: options.Millimetres = None,
    tolerance_deg: options.DegreesOfTolerance = None,
    ignore: options.Ignored = None,
    update: Annotated[bool, Option("--update", help="Then write the lock file anew; the status is 0.")] = False,
    time_limit: options.TimeLimit = None,
    printed_as: options.TextFormat = ReportFormat.TABLE,
) -> None:
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
    Tolerance.read(tolerance_mm, tolerance_deg)
    ignored(ignore or ())
    lock = Baseline.load(lock_file)
    try:
        arm = _loaded(chosen, lock)
    except ChainError as error:
        if chosen.base is not None or chosen.tip is not None or chosen.chain is not None:
            raise
        text = f"FAILED: {lock.arm.base} to {lock.arm.tip} of the lock is gone: {error}"
        console.write(message(text) + "\n", None)
        raise typer.Exit(Status.FAILED) from None
    with Progress("comparing poses") as progress:
        found = lock.verify(
            arm,
            tolerance_mm=tolerance_mm,
            tolerance_deg=tolerance_deg,
            ignore=ignore or (),
            time_limit=time_limit,
            progress=progress.tick,
        )
    console.emit(found.to_json(), lambda: f"{found}\n", printed_as)
    if update:
        own = [pose.matrix for pose in lock.poses if pose.kind == "own"]
        baselines.freeze(arm, own or None).save(lock_file)
        typer.echo(f"updated: {lock_file}", err=True)
    elif not found.passed:
        raise typer.Exit(Status.FAILED)


def _loaded(chosen: ArmOptions, lock: Baseline) -> Arm:
    """The arm, its base, tip and held joints those of the lock where no option names them."""
    held = [f"{name}={value!r}" for name, value in lock.arm.locked] if chosen.lock is None else chosen.lock
    if chosen.chain is None and chosen.srdf is None:
        base = lock.arm.base if chosen.base is None else chosen.base
        tip = lock.arm.tip if chosen.tip is None else chosen.tip
        chosen = replace(chosen, base=base, tip=tip)
    return replace(chosen, lock=held or None).load()
