"""The command ``calibrate``."""

from enum import StrEnum
from pathlib import Path

from urdf_ik.cli import console
from urdf_ik.cli.arm_options import ArmOptions
from urdf_ik.cli.console import Progress
from urdf_ik.cli.options import ReportFormat
from urdf_ik.support import files
from urdf_ik.support.text import Section

Fit = StrEnum("Fit", ["ORIGINS", "OFFSETS", "EVERYTHING"])


def calibrate(
    *,
    chosen: ArmOptions,
    measured: Path,
    fit_base: bool = False,
    fit_marker: bool = False,
    fit: Fit = Fit.ORIGINS,
    output: Path | None = None,
    report: Path | None = None,
    next_poses: int = 0,
    seed: int = 0,
    time_limit: float | None = None,
    degrees: bool = False,
    printed_as: ReportFormat = ReportFormat.TABLE,
) -> None:
    """Calibrate an arm: fit its URDF to measurements.

    Each row of the measurements holds every joint under its name [rad or m], and what was measured: a pose (x,y,z
    and qw,qx,qy,qz or roll,pitch,yaw or rx,ry,rz) or a position (x,y,z). The new URDF keeps names, meshes and
    comments. The report says which numbers the measurements cannot tell apart, which measurements are outliers, and
    how well unseen measurements fit.

    Examples:
        urdf-ik calibrate my_arm.urdf --measured poses.csv -o calibrated.urdf
        urdf-ik calibrate my_arm.urdf --measured tracker.csv --fit-base --fit-marker --report report.html -o new.urdf
        urdf-ik calibrate my_arm.urdf --measured poses.csv --next 10 --json

    Options:
        next_poses (--next N): Name N poses to measure next.

    Options (Measurements):
        measured (FILE): CSV with a header, .npz or JSON.
        fit_base: Fit the base's pose in the measuring frame too.
        fit_marker: Fit the marker's pose in the tip too.
        fit: Origins of moving joints (default), joint offsets alone, or fixed joints too.

    Options (Output):
        output (-o FILE): The new URDF.
        report (FILE): A page with the tables (HTML).
    """
    from urdf_ik import calibration

    for path in filter(None, (output, report)):
        files.writable(path)
    arm, angles = chosen.loaded(degrees)
    measurements = calibration.read_measurements(arm, measured, degrees=degrees)
    with Progress("fitting") as progress:
        found = calibration.calibrate(
            arm,
            measurements,
            fit=fit,
            base=fit_base,
            marker=fit_marker,
            seed=seed,
            time_limit=time_limit,
            progress=progress.tick,
        )
    if output is not None:
        found.write(output)
    if report is not None:
        files.write(report, found.to_html().encode())
    data, text = found.to_dict(), f"{found}\n"
    if next_poses:
        best, gains, unchecked = calibration.best_poses(found, next_poses, seed=seed)
        data["next"] = {"q": best, "gains": gains, "unchecked": unchecked}
        rows = zip(angles.shown(best), gains, strict=True)
        cells = tuple((*(f"{value:.4f}" for value in q), f"{gain:.3f}") for q, gain in rows)
        remarks = (f"contacts not checked: {unchecked}",) if unchecked else ()
        text += f"{Section('poses to measure next', (*arm.joint_names, 'gain'), cells, remarks)}\n"
    console.emit(printed_as, data, lambda: text)
