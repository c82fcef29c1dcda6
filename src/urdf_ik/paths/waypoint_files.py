"""Files of waypoints: CSV with named columns, JSON, NumPy's formats; and files of plans."""

import os
import warnings
from collections.abc import Callable, Sequence
from typing import IO, Any

import numpy as np

from urdf_ik.errors import ArgumentError, PoseError
from urdf_ik.model.poses import pose
from urdf_ik.paths.waypoints import read
from urdf_ik.support.tables import Table, read_table
from urdf_ik.typing import Array

POSITION = ("x", "y", "z")
ORIENTATIONS = {
    "quat_wxyz": ("qw", "qx", "qy", "qz"),
    "rpy": ("roll", "pitch", "yaw"),
    "rotvec": ("rx", "ry", "rz"),
}
"""Columns of each orientation notation, by the keyword of ``pose``. The header names them, so any order is valid."""
KEYS = ("poses", "waypoints", "T", "pose")
"""Names of an array of waypoints in an .npz file or a JSON object."""
ACCEPTED = (
    "accepted: CSV with a header that names x,y,z [m] and one of qw,qx,qy,qz or roll,pitch,yaw [rad] or rx,ry,rz "
    "[rad, axis times angle], or with 16 numbers a line (4x4, row by row); JSON, .npy or .npz with matrices (m, 4, 4)"
)
LENGTH = 0.02
"""Largest accepted difference of a quaternion's length from 1."""
POSE_COLUMNS = (*POSITION, "qx", "qy", "qz", "qw")
"""Columns of a pose of seven numbers without a header (``bare=True``)."""


def read_waypoints(source: str | os.PathLike[str] | IO[bytes], *, degrees: bool = False) -> Array:
    r"""Waypoints (m, 4, 4) from a file, whose format is recognised by its content.

    Args:
        source: a path, or a file open for reading bytes. CSV: a header names the columns, in any order and among
            others: x, y, z [m] with qw, qx, qy, qz, or with roll, pitch, yaw [rad], or with rx, ry, rz [rad, axis
            times angle]; without a header 16 numbers a line, a 4x4 matrix row by row. JSON: a list of 4x4 matrices,
            or an object that holds it as 'poses', 'waypoints' or 'T'. .npy and .npz: (m, 4, 4), in .npz under one of
            these names or as the only array.
        degrees: whether the angles of a CSV are in degrees instead of rad.

    Returns:
        (m, 4, 4) m, m >= 1.

    Raises:
        ArgumentError: the file cannot be read, or holds no waypoints; the message names the line, the column and the
            value, and what would be valid.

    Example:
        >>> import io
        >>> import urdf_ik
        >>> urdf_ik.read_waypoints(io.BytesIO(b"x,y,z,qw,qx,qy,qz\n0.5,0,0.2,0,0,1,0\n")).shape
        (1, 4, 4)
    """
    name, table = read_table(source, KEYS, "waypoint", ACCEPTED)
    return _from_rows(table, degrees, bare=False) if isinstance(table, Table) else _checked(name, table)


def read_poses(source: str | os.PathLike[str] | IO[bytes], *, degrees: bool = False) -> Array:
    """Poses (m, 4, 4) as :func:`read_waypoints` reads them, or of seven numbers each: ``POSE_COLUMNS``.

    ``degrees``: whether the angles of a CSV are in degrees instead of rad.

    Raises:
        ArgumentError: the file cannot be read, or holds no poses.
    """
    accepted = f"{ACCEPTED}; {','.join(POSE_COLUMNS)} without a header, too"
    name, table = read_table(source, KEYS, "pose", accepted)
    if isinstance(table, Table):
        return _from_rows(table, degrees, bare=True)
    if table.ndim in (1, 2) and table.shape[-1] == len(POSE_COLUMNS):
        rows = np.atleast_2d(table)
        return _posed("quat_wxyz", rows[:, [0, 1, 2, 6, 3, 4, 5]], lambda k: f"{name}, pose {k}")
    return _checked(name, table)


def _checked(name: str, values: Array) -> Array:
    """Numbers as waypoints."""
    if values.ndim == 2 and values.shape[1] == 16:
        values = values.reshape(-1, 4, 4)
    if values.shape[-2:] != (4, 4) or values.ndim not in (2, 3):
        raise ArgumentError(f"{name} holds numbers of shape {values.shape}; {ACCEPTED}")
    try:
        return read(values.reshape(-1, 4, 4))
    except (ArgumentError, PoseError) as error:
        raise ArgumentError(f"{name}: {error}") from None


def _from_rows(rows: Table, degrees: bool, bare: bool) -> Array:
    """Waypoints of a CSV; ``bare``: seven numbers without a header are a pose, too."""
    width = len(rows.cells[0])
    if rows.header is None and not (bare and width == len(POSE_COLUMNS)):
        header = [str(k) for k in range(1, 17)]
        if width != 16:
            raise ArgumentError(
                f"{rows.name}, line {rows.first}: {width} numbers and no header; a first line such as "
                "x,y,z,qw,qx,qy,qz must say what they are"
            )
        matrices = rows.numbers(header, header).reshape(-1, 4, 4)
        try:
            return read(matrices)
        except PoseError as error:
            line = rows.lines[error.index[0]] if error.index else rows.first
            raise ArgumentError(f"{rows.name}, line {line}: {error}") from None
    header = list(POSE_COLUMNS) if rows.header is None else [name.lower() for name in rows.header]
    kind = _orientation(rows.name, rows.first, header)
    values = rows.numbers((*POSITION, *ORIENTATIONS[kind]), header)
    if degrees and kind != "quat_wxyz":
        values[:, 3:] = np.deg2rad(values[:, 3:])
    elif kind != "quat_wxyz" and (most := float(np.abs(values[:, 3:]).max())) > 2.0 * np.pi:
        turns = f"{most:g} is {most / (2.0 * np.pi):.1f} turns"
        hint = f"{rows.name}: angles are read in rad, and {turns}; degrees=True (--degrees) reads degrees"
        warnings.warn(hint, stacklevel=4)
    return _posed(kind, values, lambda k: f"{rows.name}, line {rows.lines[k]}")


def _posed(kind: str, values: Array, where: Callable[[int], str]) -> Array:
    """Poses of positions and orientations (k, 6 or 7); ``where`` says where row k is."""
    if kind == "quat_wxyz":
        lengths = np.linalg.norm(values[:, 3:], axis=1)
        for k in np.flatnonzero(~(np.abs(lengths - 1.0) <= LENGTH))[:1]:
            raise ArgumentError(
                f"{where(int(k))}: the quaternion {','.join(ORIENTATIONS[kind])} = "
                f"{','.join(f'{x:g}' for x in values[k, 3:])} has the length {lengths[k]:.4g}; a rotation has 1"
            )
    orientation: dict[str, Any] = {kind: values[:, 3:]}
    return read(pose(values[:, :3], **orientation))


def _orientation(name: str, line: int, header: Sequence[str]) -> str:
    """What ``pose`` calls the orientation that a header names."""
    doubled = sorted({column for column in header if header.count(column) > 1})
    if doubled:
        raise ArgumentError(f"{name}, line {line}: the header names {', '.join(doubled)} twice")
    there = [kind for kind, columns in ORIENTATIONS.items() if set(columns) <= set(header)]
    missing = [column for column in POSITION if column not in header]
    if missing or len(there) != 1:
        choices = " or ".join(",".join(columns) for columns in ORIENTATIONS.values())
        problem = (
            f"no column {' and '.join(missing)}" if missing
            else f"{'more than one orientation' if there else 'no orientation'}: one of {choices} is needed"
        )  # fmt: skip
        raise ArgumentError(f"{name}, line {line}: the header {','.join(header)} has {problem}")
    return there[0]
