"""The command ``check``."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer
from typer import Option

from urdf_ik.cli import console, options
from urdf_ik.cli.arm_options import ArmOptions
from urdf_ik.cli.console import Status
from urdf_ik.cli.options import ReportFormat
from urdf_ik.cli.progress import Progress
from urdf_ik.verify import check_proof, completeness, crosscheck, folders


def check(
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
    """Check an arm against Pinocchio: kinematics, every solution of random poses, collision.

    The status is 1 when a check failed, or when the time limit left something out.

    With --complete it looks for solutions that the solver missed: the general elimination, and Newton's method from
    random starts where the solver uses the elimination itself, answer the same poses, random ones and some 1e-1 to
    1e-8 rad from a singularity. Every difference is printed. The status is 1 when the solver lacks a solution or
    has one that Pinocchio does not confirm.

    With --proof it checks the solver's own proofs: a search for all complex roots of N poses, in ball arithmetic
    and without code of the solver, accepts or refuses every answer whose status is complete or clustered. It takes
    about half a second a pose and needs python-flint (the extra `proof`).

    ROBOT may be a folder: every URDF in it is checked, and one table shows the result of each.

    Examples:
        urdf-ik check zyyzyz_6r -n 200
        urdf-ik check ur5 --complete -n 80
        urdf-ik check ur5 --proof -n 10
        urdf-ik check my_arm.urdf --tip tool0 --no-collisions --json
        urdf-ik check lab/ --complete -n 2

    Raises:
        typer.BadParameter: options that exclude each other.
        typer.Exit: a check failed.
        UrdfIkError: there is no such arm, or the folder holds no URDF.
    """
    if complete and collisions is not None:
        raise console.usage("--complete compares solutions and nothing else", "--collisions")
    if proof and (complete or collisions is not None):
        raise console.usage("--proof checks proofs and nothing else", "--proof")
    report: Any
    if Path(chosen.robot).is_dir():
        if proof:
            raise console.usage("proofs are checked one arm at a time, and this is a folder", "--proof")
        chosen.require_only(("base", "tip", "mesh_root"), f"{chosen.robot} is a folder")
        with Progress("checking arms") as progress:
            report = folders.check_folder(
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
    else:
        arm = chosen.load()
        with Progress("checking poses") as progress:
            limits: dict[str, Any] = {"time_limit": time_limit, "progress": progress.tick}
            if proof:
                solutions = arm.ik(arm.fk(completeness.planted(arm, n, seed)))
                report = check_proof(arm, solutions, **limits)
            elif complete:
                report = completeness.compare(arm, n=n, seed=seed, **limits)
            else:
                report = crosscheck.check(arm, n=n, seed=seed, collision=collisions, **limits)
    console.emit(report.to_json(), lambda: f"{report}\n", printed_as)
    if not report.passed:
        raise typer.Exit(Status.FAILED)
