"""Forward kinematics: the tip's pose in the base, for each joint vector.

Examples:
    urdf-ik fk zyyzyz_6r --q 0.1,-0.2,0.3,0,0.5,0
    urdf-ik fk ur5 --q vectors.csv --degrees --format csv
    urdf-ik fk ur5 --q 0,-1,1,0,1,0 -f json | urdf-ik ik ur5 --poses -
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Mapping
from typing import Annotated, Any

import numpy as np
from typer import Option

from urdf_ik.arm import Arm
from urdf_ik.cli import console, options, tables
from urdf_ik.cli.arm_options import ArmOptions, angles_of
from urdf_ik.cli.console import Angles
from urdf_ik.cli.options import Format
from urdf_ik.cli.prompt.completion import data_files
from urdf_ik.typing import Array


def command(
    *,
    q: Annotated[
        list[str],
        Option(
            metavar="Q1,Q2,...|FILE",
            help="Joint vectors, rad or m: typed, of a csv, json, npy or npz, or -; repeatable.",
            autocompletion=data_files,
            rich_help_panel=options.POSES,
        ),
    ],
    chosen: ArmOptions,
    degrees: options.Degrees = False,
    printed_as: options.DataFormat = None,
    output: options.Output = None,
) -> None:
    """Write the poses of the joint vectors that are typed, or that a file holds.

    Raises:
        typer.BadParameter: there are none, or they do not fit the arm.
        UrdfIkError: there is no such arm.
    """
    chosen_format = options.format_for(printed_as, output, terminal=options.is_terminal(sys.stdout))
    for text in q:
        chosen.without_stdin(text, "--q")
    arm = chosen.load(degrees)
    angles = angles_of(arm, degrees)
    vectors = angles.typed(console.joint_vectors(q, "--q", arm.joint_names))
    if chosen_format is Format.TABLE:
        console.write(as_text(arm, vectors, angles, to_file=output is not None), output)
    else:
        console.write(DATA[chosen_format](arm, vectors, angles), output)
        if output is not None:
            console.say_written(output, f"{len(vectors)} pose{'s' * (len(vectors) != 1)}", angles.unit)


def as_json(arm: Arm, q: Array, angles: Angles) -> str:
    """One object a joint vector, with its pose as matrix, quaternion and roll, pitch, yaw."""
    from urdf_ik.model.poses import to_quat_xyzw, to_rpy

    poses = arm.fk(q)
    rows = zip(angles.shown(q), poses, to_quat_xyzw(poses), angles.angle(to_rpy(poses)), strict=True)
    return console.json_text(
        {
            "robot": arm.name,
            "base": arm.base,
            "tip": arm.tip,
            "joints": arm.joint_names,
            "units": {"angle": angles.unit, "length": "m"},
            "poses": [
                {"q": vector, "pose": pose, "xyz": pose[:3, 3], "quat_xyzw": quat, "rpy": rpy}
                for vector, pose, quat, rpy in rows
            ],
        }
    )


def as_csv(arm: Arm, q: Array, angles: Angles) -> str:
    """Joint values, position and quaternion; ``urdf-ik ik --poses`` finds the pose by its columns' names."""
    from urdf_ik.paths.waypoint_files import POSE_COLUMNS

    rows = np.hstack([angles.shown(q), _positions_and_quaternions(arm.fk(q))])
    return console.csv_text([*arm.joint_names, *POSE_COLUMNS], rows.tolist())


def as_npz(arm: Arm, q: Array, angles: Angles) -> bytes:
    """Arrays ``q`` (N, n) and ``poses`` (N, 4, 4)."""
    return console.npz_bytes(
        {
            "q": angles.shown(q),
            "poses": arm.fk(q),
            "joint_names": np.array(arm.joint_names, dtype=np.str_),
            "angle_unit": np.array(angles.unit),
        }
    )


def as_text(arm: Arm, q: Array, angles: Angles, to_file: bool) -> str:
    """A matrix for one joint vector, a table for more."""
    from urdf_ik.model.poses import to_rpy

    poses = arm.fk(q)
    if len(poses) == 1:
        T = poses[0]
        rpy = ", ".join(tables.number(float(x), 6) for x in angles.angle(to_rpy(T)))
        lines = [f"{arm.name}: pose of {arm.tip} in {arm.base}", "", tables.matrix(T), ""]
        return tables.render(*lines, tables.pose_line(T, 6), f"roll, pitch, yaw ({rpy}) {angles.unit}", to_file=to_file)
    rows = [
        [i, *(tables.number(x, 6) for x in row)] for i, row in enumerate(_positions_and_quaternions(poses).tolist())
    ]
    table = tables.grid(["#", "x [m]", "y [m]", "z [m]", "qx", "qy", "qz", "qw"], rows)
    return tables.render(f"{arm.name}: poses of {arm.tip} in {arm.base}", "", table, to_file=to_file)


DATA: Mapping[str, Callable[[Arm, Array, Angles], str | bytes]] = {"json": as_json, "csv": as_csv, "npz": as_npz}


def _positions_and_quaternions(poses: Array) -> Any:
    from urdf_ik.model.poses import to_quat_xyzw

    return np.hstack([poses[:, :3, 3], to_quat_xyzw(poses)])
