"""Check an arm against Pinocchio: kinematics, every solution of random poses, collision.

The status is 1 when a check failed, or when the time limit left something out.

With --complete it looks for solutions that the solver missed: the general elimination, and Newton's method from random
starts where the solver uses the elimination itself, answer the same poses, random ones and some 1e-1 to 1e-8 rad from a
singularity. Every difference is printed. The status is 1 when the solver lacks a solution or has one that Pinocchio
does not confirm.

With --proof it checks the solver's own proofs: a search for all complex roots of N poses, in ball arithmetic and
without code of the solver, accepts or refuses every answer whose status is complete or clustered. It takes about half a
second a pose and needs python-flint: pip install 'urdf-ik[proof]'.

ROBOT may be a folder: every URDF in it is checked, and one table shows the result of each.

Examples:
    urdf-ik check zyyzyz_6r -n 200
    urdf-ik check ur5 --complete -n 80
    urdf-ik check ur5 --proof -n 10
    urdf-ik check my_arm.urdf --tip tool0 --no-collisions --json
    urdf-ik check lab/ --complete -n 2
"""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer
from typer import Option

from urdf_ik.cli import console, options
from urdf_ik.cli.arm_options import ArmOptions
from urdf_ik.cli.errors import Status
from urdf_ik.cli.options import ReportFormat
from urdf_ik.cli.progress import Progress
from urdf_ik.verify import ProofCheck, completeness, crosscheck, folders


def command(
    *,
    n: options.Random = 200,
    seed: options.Seed = 0,
    complete: Annotated[
        bool,
        Option(
            "--complete",
            help="Instead: look for missing solutions in a second way, at N random, N nearly singular, N round poses.",
        ),
    ] = False,
    proof: Annotated[
        bool,
        Option("--proof", help="Instead: check the proofs of N random, N nearly singular and N round poses."),
    ] = False,
    collisions: options.Collisions = None,
    time_limit: options.TimeLimit = None,
    chosen: ArmOptions,
    printed_as: options.TextFormat = ReportFormat.TABLE,
) -> None:
    """Print the report of an arm, or the table of a folder.

    Raises:
        typer.BadParameter: options that exclude each other.
        typer.Exit: a check failed.
        UrdfIkError: there is no such arm, or the folder holds no URDF.
    """
    if complete and collisions is not None:
        raise console.usage("--complete compares solutions and nothing else", "--collisions")
    if proof and (complete or collisions is not None):
        raise console.usage("--proof checks proofs and nothing else", "--proof")
    report: folders.FolderCheck | crosscheck.CrossCheck | completeness.Completeness | ProofCheck
    if Path(chosen.robot).is_dir():
        if proof:
            raise console.usage("proofs are checked one arm at a time, and this is a folder", "--proof")
        report = _folder(chosen, n, seed, complete, collisions, time_limit)
    else:
        if proof:
            report = _proofs(chosen, n, seed, time_limit)
        else:
            report = _report(chosen, n, seed, complete, collisions, time_limit)
    console.write(report.to_json() if printed_as is ReportFormat.JSON else f"{report}\n", None)
    if not report.passed:
        raise typer.Exit(Status.FAILED)


def _report(
    chosen: ArmOptions, n: int, seed: int, complete: bool, collisions: bool | None, time_limit: float | None
) -> crosscheck.CrossCheck | completeness.Completeness:
    from urdf_ik.verify import completeness, crosscheck

    arm = chosen.load()
    if complete:
        with Progress("comparing poses", "solving in two ways") as progress:
            return completeness.compare(arm, n=n, seed=seed, time_limit=time_limit, progress=progress.tick)
    with Progress("checking poses", "checking against Pinocchio") as progress:
        return crosscheck.check(
            arm, n=n, seed=seed, collision=collisions, time_limit=time_limit, progress=progress.tick
        )


def _proofs(chosen: ArmOptions, n: int, seed: int, time_limit: float | None) -> ProofCheck:
    from urdf_ik.verify import check_proof
    from urdf_ik.verify.completeness import planted

    arm = chosen.load()
    solutions = arm.ik(arm.fk(planted(arm, n, seed)))
    with Progress("checking proofs", "checking in ball arithmetic") as progress:
        return check_proof(arm, solutions, time_limit=time_limit, progress=progress.tick)


def _folder(
    chosen: ArmOptions,
    n: int,
    seed: int,
    complete: bool,
    collisions: bool | None,
    time_limit: float | None,
) -> folders.FolderCheck:
    from urdf_ik.verify import folders

    chosen.require_only(("base", "tip", "mesh_root"), f"{chosen.robot} is a folder")
    with Progress("checking arms", "checking") as progress:
        return folders.check_folder(
            chosen.robot,
            n=n,
            seed=seed,
            complete=complete,
            collision=collisions,
            base=chosen.base,
            tip=chosen.tip,
            mesh_roots=chosen.mesh_root or (),
            time_limit=time_limit,
            progress=progress.tick,
        )
