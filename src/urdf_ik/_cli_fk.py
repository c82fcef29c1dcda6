"""What ``urdf-ik fk`` prints: the tip's poses for joint vectors."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from urdf_ik import _cli_io, _cli_views
from urdf_ik._cli_arm import angles_of
from urdf_ik._cli_options import Format
from urdf_ik.poses import to_quat_xyzw, to_rpy

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from urdf_ik._cli_arm import ChosenArm
    from urdf_ik._cli_io import Angles
    from urdf_ik.arm import Arm

    Array = NDArray[np.float64]


def run(
    chosen: ChosenArm, typed: Sequence[str], file: str | None, degrees: bool, format: Format, output: Path | None
) -> None:
    """Write the poses for the joint vectors that were typed or that ``file`` holds.

    Raises:
        typer.BadParameter: there are none, or they do not fit the arm.
        UrdfIkError: there is no such arm.
    """
    if bool(typed) == (file is not None):
        raise _cli_io.usage("give joint vectors with --q or with --file, and not with both", "--q")
    chosen.without_stdin(file, "--file")
    arm = chosen.load()
    angles = angles_of(arm, degrees)
    if file is not None:
        q = _cli_io.read_joint_vectors(file, "--file", arm.joint_names)
    else:
        q = np.array([_cli_io.numbers(text, "--q", arm.joint_names) for text in typed])
    q = angles.typed(q)
    if format is Format.TABLE:
        _cli_io.write(as_text(arm, q, angles, to_file=output is not None), output)
    else:
        _cli_io.write(DATA[format](arm, q, angles), output)


def as_json(arm: Arm, q: Array, angles: Angles) -> str:
    """One object a joint vector, with its pose as matrix, quaternion and roll, pitch, yaw."""
    poses = arm.fk(q)
    rows = zip(angles.shown(q), poses, to_quat_xyzw(poses), angles.angle(to_rpy(poses)), strict=True)
    return _cli_io.json_text(
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
    rows = np.hstack([angles.shown(q), _positions_and_quaternions(arm.fk(q))])
    return _cli_io.csv_text([*arm.joint_names, *_cli_io.POSE_COLUMNS], rows.tolist())


def as_npz(arm: Arm, q: Array, angles: Angles) -> bytes:
    """Arrays ``q`` (N, n) and ``poses`` (N, 4, 4)."""
    return _cli_io.npz_bytes(
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
        rpy = ", ".join(_cli_views.number(float(x), 6) for x in angles.angle(to_rpy(T)))
        lines = [f"{arm.name}: pose of {arm.tip} in {arm.base}", "", _cli_views.matrix(T), ""]
        return _cli_views.render(
            *lines, _cli_views.pose_line(T, 6), f"roll, pitch, yaw ({rpy}) {angles.unit}", to_file=to_file
        )
    rows = [
        [i, *(_cli_views.number(x, 6) for x in row)] for i, row in enumerate(_positions_and_quaternions(poses).tolist())
    ]
    table = _cli_views.grid(["#", "x [m]", "y [m]", "z [m]", "qx", "qy", "qz", "qw"], rows)
    return _cli_views.render(f"{arm.name}: poses of {arm.tip} in {arm.base}", "", table, to_file=to_file)


DATA: Mapping[str, Callable[[Arm, Array, Angles], str | bytes]] = {"json": as_json, "csv": as_csv, "npz": as_npz}


def _positions_and_quaternions(poses: Array) -> Any:
    return np.hstack([poses[:, :3, 3], to_quat_xyzw(poses)])
