"""What ``urdf-ik fk`` prints: the tip's poses for joint vectors."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from urdf_ik.cli import console, tables
from urdf_ik.cli.chosen_arm import angles_of
from urdf_ik.cli.options import Format
from urdf_ik.model.poses import to_quat_xyzw, to_rpy

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from urdf_ik.arm import Arm
    from urdf_ik.cli.chosen_arm import ChosenArm
    from urdf_ik.cli.console import Angles

    Array = NDArray[np.float64]


def run(
    chosen: ChosenArm, typed: Sequence[str], file: str | None, degrees: bool, printed_as: Format, output: Path | None
) -> None:
    """Write the poses for the joint vectors that were typed or that ``file`` holds.

    Raises:
        typer.BadParameter: there are none, or they do not fit the arm.
        UrdfIkError: there is no such arm.
    """
    if bool(typed) == (file is not None):
        raise console.usage("give joint vectors with --q or with --file, and not with both", "--q")
    chosen.without_stdin(file, "--file")
    arm = chosen.load()
    angles = angles_of(arm, degrees)
    if file is not None:
        q = console.read_joint_vectors(file, "--file", arm.joint_names)
    else:
        q = np.array([console.numbers(text, "--q", arm.joint_names) for text in typed])
    q = angles.typed(q)
    if printed_as is Format.TABLE:
        console.write(as_text(arm, q, angles, to_file=output is not None), output)
    else:
        console.write(DATA[printed_as](arm, q, angles), output)


def as_json(arm: Arm, q: Array, angles: Angles) -> str:
    """One object a joint vector, with its pose as matrix, quaternion and roll, pitch, yaw."""
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
    return np.hstack([poses[:, :3, 3], to_quat_xyzw(poses)])
