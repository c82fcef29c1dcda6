"""The command ``fk``."""

from __future__ import annotations

import sys
from typing import Annotated

import numpy as np
from typer import Option

from urdf_ik.arm import Arm
from urdf_ik.cli import console, options, tables
from urdf_ik.cli.arm_options import ArmOptions, angles_of
from urdf_ik.cli.console import Angles
from urdf_ik.cli.options import Format
from urdf_ik.typing import Array


def fk(
    *,
    q: Annotated[
        list[str],
        Option(
            metavar="Q1,Q2,...|FILE",
            help="Joint vectors, rad or m: typed, of a csv, json, npy or npz, or -; repeatable.",
            rich_help_panel=options.POSES,
        ),
    ],
    chosen: ArmOptions,
    degrees: options.Degrees = False,
    printed_as: options.DataFormat = None,
    output: options.Output = None,
) -> None:
    """Forward kinematics: the tip's pose in the base, for each joint vector.

    Examples:
        urdf-ik fk zyyzyz_6r --q 0.1,-0.2,0.3,0,0.5,0
        urdf-ik fk ur5 --q vectors.csv --degrees --format csv
        urdf-ik fk ur5 --q 0,-1,1,0,1,0 -f json | urdf-ik ik ur5 --poses -

    Raises:
        typer.BadParameter: there are none, or they do not fit the arm.
        UrdfIkError: there is no such arm.
    """
    chosen_format = options.format_for(printed_as, output, terminal=options.is_terminal(sys.stdout))
    chosen.apart_from(options.PoseOptions(q=q))
    arm = chosen.load(degrees)
    angles = angles_of(arm, degrees)
    vectors = angles.typed(console.joint_vectors(q, "--q", arm.joint_names))
    console.write(_written(arm, vectors, angles, chosen_format, to_file=output is not None), output)
    if output is not None and chosen_format is not Format.TABLE:
        console.say_written(output, f"{len(vectors)} pose{'s' * (len(vectors) != 1)}", angles.unit)


def _written(arm: Arm, q: Array, angles: Angles, kind: Format, *, to_file: bool) -> str | bytes:
    """The poses of joint vectors (N, n) in a format."""
    from urdf_ik.model.poses import to_quat_xyzw, to_rpy
    from urdf_ik.paths.waypoint_files import POSE_COLUMNS

    poses, shown = arm.fk(q), angles.shown(q)
    quats, rpy = to_quat_xyzw(poses), angles.angle(to_rpy(poses))
    rows = np.hstack([poses[:, :3, 3], quats])
    if kind is Format.JSON:
        facts = {"robot": arm.name, "base": arm.base, "tip": arm.tip, "joints": arm.joint_names}
        each = [
            {"q": shown[k], "pose": poses[k], "xyz": poses[k, :3, 3], "quat_xyzw": quats[k], "rpy": rpy[k]}
            for k in range(len(q))
        ]
        return console.json_text({**facts, "units": {"angle": angles.unit, "length": "m"}, "poses": each})
    if kind is Format.CSV:  # `urdf-ik ik --poses` finds the pose by its columns' names
        return console.csv_text([*arm.joint_names, *POSE_COLUMNS], np.hstack([shown, rows]).tolist())
    if kind is Format.NPZ:
        names = np.array(arm.joint_names, dtype=np.str_)
        return console.npz_bytes(
            {"q": shown, "poses": poses, "joint_names": names, "angle_unit": np.array(angles.unit)}
        )
    head = f"{arm.name}: pose{'s' * (len(q) > 1)} of {arm.tip} in {arm.base}"
    if len(q) > 1:
        header = ["#", "x [m]", "y [m]", "z [m]", "qx", "qy", "qz", "qw"]
        table = tables.grid(header, [[i, *tables.numbers(row, 6)] for i, row in enumerate(rows)])
        return tables.render(head, "", table, to_file=to_file)
    matrix = ["  ".join(f"{x:>10}" for x in tables.numbers(row, 6)) for row in poses[0]]
    last = f"roll, pitch, yaw ({', '.join(tables.numbers(rpy[0], 6))}) {angles.unit}"
    return tables.render(head, "", *matrix, "", *tables.pose_lines(poses[0], 6), last, to_file=to_file)
