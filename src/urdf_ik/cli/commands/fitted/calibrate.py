"""Calibrate an arm: fit its URDF to measurements, or take over a vendor's calibration.

Each row of the measurements holds every joint under its name [rad or m], and what was measured: a pose (x,y,z and
qw,qx,qy,qz or roll,pitch,yaw or rx,ry,rz), a position (x,y,z), a distance from a fixed point (distance), or nothing
more, where the tip touched a plane. The new URDF keeps names, meshes and comments. The report says which numbers the
measurements cannot tell apart, which measurements are outliers, and how well unseen measurements fit.

Examples:
    urdf-ik calibrate my_arm.urdf --measured poses.csv -o calibrated.urdf
    urdf-ik calibrate my_arm.urdf --measured tracker.csv --fit-base --fit-marker --report report.html -o calibrated.urdf
    urdf-ik calibrate my_arm.urdf --measured poses.csv --next 10 --json
    urdf-ik calibrate ur5e.urdf --ur-kinematics calibration.yaml -o calibrated.urdf
"""

from __future__ import annotations

from enum import StrEnum
from pathlib import Path
from typing import Annotated, Any

import typer

from urdf_ik.arm import Arm
from urdf_ik.cli import options
from urdf_ik.cli.arm_options import ArmOptions, angles_of
from urdf_ik.cli.options import ReportFormat


class Kind(StrEnum):
    """What was measured."""

    POSE = "pose"
    POSITION = "position"
    DISTANCE = "distance"
    PLANE = "plane"


class Fit(StrEnum):
    """Which numbers of the URDF are fitted."""

    ORIGINS = "origins"
    OFFSETS = "offsets"
    EVERYTHING = "everything"


class Loss(StrEnum):
    """How much large residuals count."""

    SOFT_L1 = "soft_l1"
    HUBER = "huber"
    CAUCHY = "cauchy"
    LINEAR = "linear"


MEASURED = "Measurements"
Measured = Annotated[
    Path | None,
    typer.Option("--measured", metavar="FILE", help="CSV with a header, .npz or JSON.", rich_help_panel=MEASURED),
]
Measure = Annotated[
    Kind | None,
    typer.Option("--kind", help="Default: as the columns say.", show_default=False, rich_help_panel=MEASURED),
]
Base = Annotated[
    bool, typer.Option("--fit-base", help="Fit the base's pose in the measuring frame too.", rich_help_panel=MEASURED)
]
Marker = Annotated[
    bool, typer.Option("--fit-marker", help="Fit the marker's pose in the tip too.", rich_help_panel=MEASURED)
]
Fitted = Annotated[
    Fit,
    typer.Option(
        "--fit",
        help="Origins of moving joints, joint offsets alone, or fixed joints too.",
        rich_help_panel=MEASURED,
    ),
]
Robust = Annotated[
    Loss, typer.Option("--loss", help="linear keeps outliers; the others find them.", rich_help_panel=MEASURED)
]
Vendor = Annotated[
    Path | None,
    typer.Option(
        "--ur-kinematics", metavar="FILE", help="Take over Universal Robots' YAML instead.", rich_help_panel=MEASURED
    ),
]
NewUrdf = Annotated[
    Path | None,
    typer.Option("--output", "-o", metavar="FILE", help="The new URDF.", rich_help_panel=options.OUTPUT),
]
Page = Annotated[
    Path | None,
    typer.Option("--report", metavar="FILE", help="A page with a picture (HTML).", rich_help_panel=options.OUTPUT),
]
VendorOut = Annotated[
    Path | None,
    typer.Option(
        "--write-ur-kinematics", metavar="FILE", help="Write Universal Robots' YAML.", rich_help_panel=options.OUTPUT
    ),
]
Next = Annotated[
    int,
    typer.Option("--next", metavar="N", min=0, help="Name N poses to measure next.", rich_help_panel=options.OUTPUT),
]


def command(
    *,
    chosen: ArmOptions,
    measured: Measured = None,
    kind: Measure = None,
    fit_base: Base = False,
    fit_marker: Marker = False,
    fit: Fitted = Fit.ORIGINS,
    loss: Robust = Loss.SOFT_L1,
    ur_kinematics: Vendor = None,
    output: NewUrdf = None,
    report: Page = None,
    write_ur_kinematics: VendorOut = None,
    next_poses: Next = 0,
    seed: options.Seed = 0,
    time_limit: options.TimeLimit = None,
    degrees: options.Degrees = False,
    printed_as: options.TextFormat = ReportFormat.TABLE,
) -> None:
    """Print the report, and write the new URDF."""
    from urdf_ik import calibration
    from urdf_ik.cli import console
    from urdf_ik.cli.progress import Progress
    from urdf_ik.support import files

    if (measured is None) == (ur_kinematics is None):
        raise typer.BadParameter("give either --measured FILE or --ur-kinematics FILE")
    for path in (output, report, write_ur_kinematics):
        if path is not None:
            files.writable(path)
    arm = chosen.load(degrees)
    if ur_kinematics is not None:
        text = calibration.with_ur_kinematics(arm, calibration.read_ur_kinematics(ur_kinematics))
        if output is None:
            console.write(text.decode(), None)
        else:
            files.write(output, text)
        return
    assert measured is not None
    given = calibration.read_measurements(arm, measured, kind=kind, degrees=degrees)
    with Progress("fitting", "fitting") as progress:
        found = calibration.calibrate(
            arm, given, fit=fit, base=fit_base, marker=fit_marker, loss=loss, seed=seed, time_limit=time_limit,
            progress=progress.tick,
        )  # fmt: skip
    best = calibration.best_poses(found, next_poses, seed=seed) if next_poses else None
    if output is not None:
        found.write(output)
    if report is not None:
        files.write(report, found.to_html().encode())
    if write_ur_kinematics is not None:
        files.write(write_ur_kinematics, calibration.ur_kinematics(found.arm).to_yaml().encode())
    if printed_as is ReportFormat.JSON:
        whole = found.to_dict()
        if best is not None:
            whole["next"] = {"q": best.q.tolist(), "gains": best.gains.tolist(), "unchecked": best.unchecked}
        console.write(console.json_text(whole), None)
        return
    console.write(f"{found}\n{'' if best is None else _listed(arm, best, degrees)}", None)


def _listed(arm: Arm, best: Any, degrees: bool) -> str:
    from urdf_ik.support.text import Section

    shown = angles_of(arm, degrees).shown(best.q)
    rows = tuple(
        (*(f"{value:.4f}" for value in row), f"{gain:.3f}") for row, gain in zip(shown, best.gains, strict=True)
    )
    remarks = (f"contacts not checked: {best.unchecked}",) if best.unchecked else ()
    return f"{Section('poses to measure next', (*arm.joint_names, 'gain'), rows, remarks)}\n"
