"""The command ``compare``."""

from __future__ import annotations

import string
from pathlib import Path
from typing import Annotated, Any

import typer
from typer import Option

from urdf_ik.cli import console, options
from urdf_ik.cli.arm_options import SeveralArms, angles_of
from urdf_ik.cli.console import Status
from urdf_ik.cli.options import ReportFormat
from urdf_ik.cli.progress import Progress


def compare(
    *,
    arms: SeveralArms,
    typed: options.PoseOptions,
    n: options.Random = 200,
    seed: options.Seed = 0,
    tolerance_mm: options.Millimetres = None,
    tolerance_deg: options.DegreesOfTolerance = None,
    ignore: options.Ignored = None,
    exit_code: Annotated[bool, Option("--exit-code", help="End with status 1 where arms differ.")] = False,
    time_limit: Annotated[
        float | None, Option(metavar="S", min=0.0, help="How long the table of the typed poses may take.")
    ] = None,
    printed_as: options.TextFormat = ReportFormat.TABLE,
) -> None:
    """Compare arms, or URDFs of one arm (another tool, a calibrated copy).

    It compares structure, frames, limits, shapes, reach, the number of solutions for the same poses and the joint
    values branch by branch, and says how far B's tool is off when B gets A's joint vectors. What is the same to
    rounding is called the same.

    An option is for all arms; with a letter it is for one of them: --tip tool0, or --tip B=flange.

    Examples:
        urdf-ik compare zyyzyz_6r puma_560
        urdf-ik compare zyyzyz_6r my_arm.urdf --exit-code --tolerance-mm 0.5
        urdf-ik compare zyyzyz_6r my_arm.urdf --tip B=tool0 -n 100
        urdf-ik compare ur5 ur10 puma_560 -n 20
    """
    from urdf_ik.cli import targets
    from urdf_ik.verify import comparison, many_arms

    chosen = arms.each()
    for each in chosen:
        each.apart_from(typed)
    loaded = [each.load() for each in chosen]
    target = targets.given(loaded[0], typed, angles_of(loaded[0], False))
    own = None if target is None else target.poses
    with Progress("comparing") as progress:
        tolerances: dict[str, Any] = {
            "tolerance_mm": tolerance_mm,
            "tolerance_deg": tolerance_deg,
            "ignore": ignore or (),
        }
        found = [
            comparison.compare(loaded[0], other, n=n, seed=seed, poses=own, **tolerances, progress=progress.tick)
            for other in loaded[1:]
        ]
        many = None
        if own is not None:
            names = (
                f"{letter} {Path(name).name}" for letter, name in zip(string.ascii_uppercase, arms.robots, strict=False)
            )
            by_name = dict(zip(names, loaded, strict=True))
            many = many_arms.compare_many(by_name, own, time_limit=time_limit, progress=progress.tick)
    whole = {"comparisons": [each.to_dict() for each in found], "poses": None if many is None else many.to_dict()}
    reports = [*found, *([] if many is None else [many])]
    data = found[0].to_json() if len(reports) == 1 else whole
    console.emit(data, lambda: "\n".join(f"{each}\n" for each in reports), printed_as)
    if exit_code and not all(each.same for each in found):
        raise typer.Exit(Status.FAILED)
