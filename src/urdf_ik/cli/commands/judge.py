"""The command ``judge``."""

from __future__ import annotations

from typing import Annotated

import typer
from typer import Option

from urdf_ik.cli import console, options
from urdf_ik.cli.arm_options import ArmOptions
from urdf_ik.cli.console import Status
from urdf_ik.cli.options import ReportFormat
from urdf_ik.cli.progress import Progress


def judge(
    *,
    solver: Annotated[
        str,
        Option(
            metavar="SPEC",
            help="module:function, file.py:function, or process:COMMAND (a line of JSON a pose).",
        ),
    ],
    n: options.Random = 50,
    seed: options.Seed = 0,
    max_error: Annotated[
        float | None, Option(metavar="E", min=0.0, help="Error [m; rad] of a solution. Default: 1e-7.")
    ] = None,
    within_limits: Annotated[
        bool, Option("--within-limits", help="The solver returns only what is inside the limits.")
    ] = False,
    time_limit: options.TimeLimit = None,
    chosen: ArmOptions,
    printed_as: options.TextFormat = ReportFormat.TABLE,
    output: options.Output = None,
) -> None:
    """Judge another solver on an arm: the solutions that it has wrong, misses or doubles.

    It is asked at N poses of each kind: random, round joint angles, tool down, near singularities and at them.
    Pinocchio measures every solution, and each fault comes with the pose to replay. The status is 1 when there is a
    fault.

    A process reads {"T": 4x4} and answers {"q": [[...], ...]}, a line each, in the arm's order of joints.

    Examples:
        urdf-ik judge ur5 --solver my_solver.py:solve
        urdf-ik judge my_arm.urdf --tip tool0 --solver "process:./my_solver" -n 200 --json
    """
    from urdf_ik.verify.judging import TOLERANCE
    from urdf_ik.verify.judging import judge as judged
    from urdf_ik.verify.solvers import SolverProcess, solver_of

    arm = chosen.load()
    solve = solver_of(solver)
    try:
        with Progress("judging poses") as progress:
            found = judged(
                arm,
                solve,
                n=n,
                seed=seed,
                tolerance=TOLERANCE if max_error is None else max_error,
                within_limits=within_limits,
                name=str(getattr(solve, "__name__", solver)),
                time_limit=time_limit,
                progress=progress.tick,
            )
    finally:
        if isinstance(solve, SolverProcess):
            solve.close()
    console.write(found.to_json() if printed_as is ReportFormat.JSON else f"{found}\n", output)
    if not found.passed:
        raise typer.Exit(Status.FAILED)
