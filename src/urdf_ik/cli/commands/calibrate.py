"""The command ``calibrate``."""

from __future__ import annotations

from enum import StrEnum
from pathlib import Path
from typing import Annotated, Any

import typer
from typer import Option

from urdf_ik.cli import console, options
from urdf_ik.cli.arm_options import ArmOptions, angles_of
from urdf_ik.cli.console import Angles
from urdf_ik.cli.options import ReportFormat
from urdf_ik.cli.progress import Progress
from urdf_ik.support import files
from urdf_ik.support.text import Section

Kind = StrEnum("Kind", ["POSE", "POSITION", "DISTANCE", "PLANE"])
Fit = StrEnum("Fit", ["ORIGINS", "OFFSETS", "EVERYTHING"])
Loss = StrEnum("Loss", ["SOFT_L1", "HUBER", "CAUCHY", "LINEAR"])


def _option(name: str, text: str, metavar: str | None = None, *, group: str = "Measurements") -> Any:
    return Option(name, metavar=metavar, help=text, show_default=False, rich_help_panel=group)


def calibrate(
    *,
    chosen: ArmOptions,
    measured: Annotated[Path | None, _option("--measured", "CSV with a header, .npz or JSON.", "FILE")] = None,
    kind: Annotated[Kind | None, _option("--kind", "Default: as the columns say.")] = None,
    fit_base: Annotated[bool, _option("--fit-base", "Fit the base's pose in the measuring frame too.")] = False,
    fit_marker: Annotated[bool, _option("--fit-marker", "Fit the marker's pose in the tip too.")] = False,
    fit: Annotated[
        Fit, _option("--fit", "Origins of moving joints (default), joint offsets alone, or fixed joints too.")
    ] = Fit.ORIGINS,
    loss: Annotated[
        Loss, _option("--loss", "linear keeps outliers; the others find them. Default: soft_l1.")
    ] = Loss.SOFT_L1,
    ur_kinematics: Annotated[
        Path | None, _option("--ur-kinematics", "Take over Universal Robots' YAML instead.", "FILE")
    ] = None,
    output: Annotated[Path | None, options.output("The new URDF.")] = None,
    report: Annotated[
        Path | None, _option("--report", "A page with a picture (HTML).", "FILE", group=options.OUTPUT)
    ] = None,
    write_ur_kinematics: Annotated[
        Path | None,
        _option("--write-ur-kinematics", "Write Universal Robots' YAML.", "FILE", group=options.OUTPUT),
    ] = None,
    next_poses: Annotated[int, Option("--next", metavar="N", min=0, help="Name N poses to measure next.")] = 0,
    seed: options.Seed = 0,
    time_limit: options.TimeLimit = None,
    degrees: options.Degrees = False,
    printed_as: options.TextFormat = ReportFormat.TABLE,
) -> None:
    """Calibrate an arm: fit its URDF to measurements, or take over a vendor's calibration.

    Each row of the measurements holds every joint under its name [rad or m], and what was measured: a pose (x,y,z
    and qw,qx,qy,qz or roll,pitch,yaw or rx,ry,rz), a position (x,y,z), a distance from a fixed point (distance), or
    nothing more, where the tip touched a plane. The new URDF keeps names, meshes and comments. The report says
    which numbers the measurements cannot tell apart, which measurements are outliers, and how well unseen
    measurements fit.

    Examples:
        urdf-ik calibrate my_arm.urdf --measured poses.csv -o calibrated.urdf
        urdf-ik calibrate my_arm.urdf --measured tracker.csv --fit-base --fit-marker --report report.html -o new.urdf
        urdf-ik calibrate my_arm.urdf --measured poses.csv --next 10 --json
        urdf-ik calibrate ur5e.urdf --ur-kinematics calibration.yaml -o calibrated.urdf
    """
    from urdf_ik import calibration

    if (measured is None) == (ur_kinematics is None):
        raise typer.BadParameter("give either --measured FILE or --ur-kinematics FILE")
    for path in (output, report, write_ur_kinematics):
        if path is not None:
            files.writable(path)
    arm = chosen.load(degrees)
    if ur_kinematics is not None:
        console.write(calibration.with_ur_kinematics(arm, calibration.read_ur_kinematics(ur_kinematics)), output)
        return
    assert measured is not None
    measurements = calibration.read_measurements(arm, measured, kind=kind, degrees=degrees)
    with Progress("fitting") as progress:
        found = calibration.calibrate(
            arm,
            measurements,
            fit=fit,
            base=fit_base,
            marker=fit_marker,
            loss=loss,
            seed=seed,
            time_limit=time_limit,
            progress=progress.tick,
        )
    best = calibration.best_poses(found, next_poses, seed=seed) if next_poses else None
    if output is not None:
        found.write(output)
    if report is not None:
        files.write(report, found.to_html().encode())
    if write_ur_kinematics is not None:
        files.write(write_ur_kinematics, calibration.ur_kinematics(found.arm).to_yaml().encode())
    data = found.to_dict()
    if best is not None:
        data["next"] = {"q": best.q.tolist(), "gains": best.gains.tolist(), "unchecked": best.unchecked}
    rest = "" if best is None else _poses(arm.joint_names, best, angles_of(arm, degrees))
    console.emit(data, lambda: f"{found}\n{rest}", printed_as)


def _poses(names: tuple[str, ...], best: Any, angles: Angles) -> str:
    """The poses to measure next as a table."""
    columns = zip(angles.shown(best.q), best.gains, strict=True)
    rows = tuple((*(f"{value:.4f}" for value in row), f"{gain:.3f}") for row, gain in columns)
    remarks = (f"contacts not checked: {best.unchecked}",) if best.unchecked else ()
    return f"{Section('poses to measure next', (*names, 'gain'), rows, remarks)}\n"
