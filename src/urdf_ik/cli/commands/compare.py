"""Compare arms, or URDFs of one arm (another tool, a calibrated copy).

It compares structure, frames, limits, shapes, reach, the number of solutions for the same poses and the joint values
branch by branch, and says how far B's tool is off when B gets A's joint vectors. What is the same to rounding is called
the same.

An option is for all arms; with a letter it is for one of them: --tip tool0, or --tip B=flange.

Examples:
    urdf-ik compare zyyzyz_6r puma_560
    urdf-ik compare zyyzyz_6r my_arm.urdf --exit-code --tolerance-mm 0.5
    urdf-ik compare zyyzyz_6r my_arm.urdf --tip B=tool0 -n 100
    urdf-ik compare ur5 ur10 puma_560 -n 20
"""

from __future__ import annotations

import string
from pathlib import Path
from typing import Annotated, Any

import typer

from urdf_ik.cli import options
from urdf_ik.cli.arm_options import angles_of
from urdf_ik.cli.commands.verify import Degrees, Ignored, Millimetres
from urdf_ik.cli.errors import Status
from urdf_ik.cli.options import ReportFormat
from urdf_ik.cli.several_arms import SeveralArms
from urdf_ik.verify.comparison import Comparison
from urdf_ik.verify.many_arms import ManyArms

TimeLimit = Annotated[
    float | None,
    typer.Option("--time-limit", metavar="S", min=0.0, help="How long the table of the poses given may take."),
]
ExitCode = Annotated[bool, typer.Option("--exit-code", help="End with status 1 where arms differ.")]


def command(
    *,
    arms: SeveralArms,
    given: options.PoseOptions,
    n: options.Random = 200,
    seed: options.Seed = 0,
    tolerance_mm: Millimetres = None,
    tolerance_deg: Degrees = None,
    ignore: Ignored = None,
    exit_code: ExitCode = False,
    time_limit: TimeLimit = None,
    printed_as: options.TextFormat = ReportFormat.TABLE,
) -> None:
    """Print the comparison."""
    from urdf_ik.cli import console
    from urdf_ik.cli.progress import Progress
    from urdf_ik.cli.solutions import targets
    from urdf_ik.support.text import json_text
    from urdf_ik.verify import comparison, many_arms

    chosen = arms.each()
    for each in chosen:
        each.apart_from(given)
    loaded = [each.load() for each in chosen]
    own = targets.own_poses(loaded[0], given, angles_of(loaded[0], False))
    with Progress("comparing", "solving") as progress:
        found = [
            comparison.compare(
                loaded[0],
                other,
                n=n,
                seed=seed,
                poses=own,
                tolerance_mm=tolerance_mm,
                tolerance_deg=tolerance_deg,
                ignore=ignore or (),
                progress=progress.tick,
            )  # fmt: skip
            for other in loaded[1:]
        ]
    many = None
    if own is not None:
        with Progress("comparing", "solving") as progress:
            many = many_arms.compare_many(
                {_called(k, arms.robots): arm for k, arm in enumerate(loaded)}, own, time_limit=time_limit,
                progress=progress.tick,
            )  # fmt: skip
    if printed_as is ReportFormat.JSON:
        whole = {"comparisons": [each.to_dict() for each in found], "poses": None if many is None else many.to_dict()}
        console.write(found[0].to_json() if len(found) == 1 and many is None else json_text(whole), None)
    else:
        console.write(as_text(found, many), None)
    if exit_code and not all(each.same for each in found):
        raise typer.Exit(Status.FAILED)


def as_text(found: list[Comparison], many: ManyArms | None) -> str:
    """The tables of every comparison, and of the poses that were given."""
    from urdf_ik.cli import tables

    parts: list[Any] = []
    for report in [*found, *([] if many is None else [many])]:
        parts += [""] * bool(parts) + [report.title()]
        for section in report.sections():
            parts += ["", section.title]
            if section.rows:
                parts.append(tables.grid(section.header, section.rows, left=section.left))
            parts += section.remarks
        parts += ["", *report.lines(), report.verdict()]
    return tables.render(*parts)


def _called(k: int, robots: list[str]) -> str:
    return f"{string.ascii_uppercase[k]} {Path(robots[k]).name}"
