"""Waypoints from files: CSV with named columns, JSON, and NumPy's own formats; and files that plans are written to."""

from __future__ import annotations

import csv
import io
import json
import zipfile
import zlib
from pathlib import Path
from typing import IO, TYPE_CHECKING, Any

import numpy as np

from urdf_ik import inputs
from urdf_ik.errors import PathError, PoseError
from urdf_ik.motion.waypoints import read
from urdf_ik.poses import pose
from urdf_ik.text import printable, quoted

if TYPE_CHECKING:
    import os
    from collections.abc import Sequence

    from numpy.typing import NDArray

    Array = NDArray[np.float64]

POSITION = ("x", "y", "z")
ORIENTATIONS = {
    "quat_wxyz": ("qw", "qx", "qy", "qz"),
    "rpy": ("roll", "pitch", "yaw"),
    "rotvec": ("rx", "ry", "rz"),
}
"""Columns of an orientation, and what ``pose`` calls it. The header says which is which, so they stand in any order."""
KEYS = ("poses", "waypoints", "T", "pose")
"""What an array of waypoints may be called in an .npz file or a JSON object."""
ACCEPTED = (
    "accepted: CSV with a header that names x,y,z [m] and one of qw,qx,qy,qz or roll,pitch,yaw [rad] or rx,ry,rz "
    "[rad, axis times angle], or with 16 numbers a line (4x4, row by row); JSON, .npy or .npz with matrices (m, 4, 4)"
)
LENGTH = 0.02
"""By what a quaternion's length may differ from 1: more is no rounding, but another order of columns or a mistake."""
# What NumPy raises on a .npy or .npz file that is cut short or scrambled.
_DAMAGED = (ValueError, EOFError, OSError, KeyError, NotImplementedError, zipfile.BadZipFile, zlib.error)


def read_waypoints(source: str | os.PathLike[str] | IO[bytes], *, degrees: bool = False) -> Array:
    r"""Waypoints (m, 4, 4) from a file; its content decides what it is, not its name.

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
        PathError: the file cannot be read, or holds no waypoints; the message names the line, the column and the
            value, and what would be valid.

    Example:
        >>> import io
        >>> import urdf_ik
        >>> urdf_ik.read_waypoints(io.BytesIO(b"x,y,z,qw,qx,qy,qz\n0.5,0,0.2,0,0,1,0\n")).shape
        (1, 4, 4)
    """
    name, data = _bytes(source)
    if not data.strip():
        raise PathError(f"{name} is empty; {ACCEPTED}")
    if data.startswith((b"\x93NUMPY", b"PK")):
        return _checked(name, _from_numpy(name, data))
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError:
        raise PathError(f"{name} is neither text nor a .npy or .npz file; {ACCEPTED}") from None
    if text.lstrip().startswith(("[", "{")):
        return _checked(name, _from_json(name, text))
    return _from_csv(name, text, degrees)


def writable(path: str | os.PathLike[str]) -> Path:
    """A file that can be written.

    Raises:
        PathError: it is a folder, or in a folder that is not there.
    """
    file = inputs.path(path, "path", PathError)
    if not file.parent.is_dir():
        raise PathError(f"{printable(file, 200)} cannot be written: there is no folder {printable(file.parent, 200)}")
    if file.is_dir():
        raise PathError(f"{file} cannot be written: it is a folder")
    return file


def _bytes(source: Any) -> tuple[str, bytes]:
    """What messages call the file, and what it holds."""
    if hasattr(source, "read"):
        data = source.read()
        return str(getattr(source, "name", "the file")).strip("<>"), data.encode() if isinstance(data, str) else data
    try:
        return str(source), Path(source).read_bytes()
    except OSError as error:
        raise PathError(f"cannot read {source}: {error.strerror}") from None


def _checked(name: str, values: Array) -> Array:
    """Numbers as waypoints."""
    if values.ndim == 2 and values.shape[1] == 16:
        values = values.reshape(-1, 4, 4)
    if values.shape[-2:] != (4, 4) or values.ndim not in (2, 3):
        raise PathError(f"{name} holds numbers of shape {values.shape}; {ACCEPTED}")
    try:
        return read(values)
    except (PathError, PoseError) as error:
        raise PathError(f"{name}: {error}") from None


def _from_numpy(name: str, data: bytes) -> Array:
    try:
        loaded = np.load(io.BytesIO(data), allow_pickle=False)
        arrays = {"": loaded} if isinstance(loaded, np.ndarray) else dict(loaded)
    except _DAMAGED:
        raise PathError(f"{name} is damaged, or holds Python objects instead of numbers; {ACCEPTED}") from None
    key = next((key for key in KEYS if key in arrays), next(iter(arrays)) if len(arrays) == 1 else None)
    if key is None:
        raise PathError(f"{name} holds {', '.join(arrays) or 'nothing'}, and no array {' or '.join(KEYS[:3])}")
    if arrays[key].dtype.kind not in "fiu":
        raise PathError(f"{name}: its array has the type {arrays[key].dtype}, which is no real number")
    return np.asarray(arrays[key], dtype=np.float64)


def _from_json(name: str, text: str) -> Array:
    try:
        value = json.loads(text)
    except json.JSONDecodeError as error:
        raise PathError(f"{name}, line {error.lineno}: {error.msg}; {ACCEPTED}") from None
    except RecursionError:
        raise PathError(f"{name} is nested too deeply; {ACCEPTED}") from None
    value = _held(name, value)
    if isinstance(value, list):
        value = [_held(f"{name}, waypoint {k}", each) for k, each in enumerate(value)]
    try:
        return np.array(value, dtype=np.float64)
    except (TypeError, ValueError, OverflowError):
        for k, each in enumerate(value if isinstance(value, list) else []):
            try:
                shape = np.shape(np.array(each, dtype=np.float64))
            except (TypeError, ValueError, OverflowError):
                shape = ()
            if shape not in ((4, 4), (16,)):
                shown = json.dumps(each)
                raise PathError(
                    f"{name}, waypoint {k}: {shown[:60]}{' ...' * (len(shown) > 60)} is no 4x4 matrix of numbers"
                ) from None
        raise PathError(f"{name} holds no matrices of numbers; {ACCEPTED}") from None


def _held(name: str, value: Any) -> Any:
    """What an object holds under one of ``KEYS``; anything else as it is."""
    if not isinstance(value, dict):
        return value
    for key in KEYS:
        if key in value:
            return value[key]
    raise PathError(f"{name}: the JSON object has {', '.join(value) or 'nothing'}, and no {' or '.join(KEYS)}")


def _from_csv(name: str, text: str, degrees: bool) -> Array:
    numbered = [
        (number, line)
        for number, line in enumerate(text.splitlines(), start=1)
        if line.strip() and not line.lstrip().startswith("#")
    ]
    if not numbered:
        raise PathError(f"{name} holds nothing but comments; {ACCEPTED}")
    lines = [number for number, _ in numbered]
    mark = next((mark for mark in ",;\t" if mark in numbered[0][1]), " ")
    rows = [[cell.strip() for cell in row] for row in csv.reader((line for _, line in numbered), delimiter=mark)]
    if mark == " ":
        rows = [[cell for cell in row if cell] for row in rows]
    header = None if any(map(_is_number, rows[0])) else [cell.strip().lower() for cell in rows[0]]
    if header is None:
        header = [str(k) for k in range(1, 17)]
        if len(rows[0]) != 16:
            raise PathError(
                f"{name}, line {lines[0]}: {len(rows[0])} numbers and no header; a first line such as "
                "x,y,z,qw,qx,qy,qz must say what they are"
            )
        matrices = _numbers(name, lines, rows, header, header).reshape(-1, 4, 4)
        try:
            return read(matrices)
        except PoseError as error:
            line = lines[error.index[0]] if error.index else lines[0]
            raise PathError(f"{name}, line {line}: {error}") from None
    if len(rows) == 1:
        raise PathError(f"{name}, line {lines[0]}: a header, and no waypoint after it")
    kind = _orientation(name, lines[0], header)
    columns = (*POSITION, *ORIENTATIONS[kind])
    values = _numbers(name, lines[1:], rows[1:], header, columns)
    if kind == "quat_wxyz":
        lengths = np.linalg.norm(values[:, 3:], axis=1)
        for k in np.flatnonzero(np.abs(lengths - 1.0) > LENGTH)[:1]:
            raise PathError(
                f"{name}, line {lines[1 + k]}: the quaternion {','.join(ORIENTATIONS[kind])} = "
                f"{','.join(f'{x:g}' for x in values[k, 3:])} has the length {lengths[k]:.4g}; a rotation has 1"
            )
    elif degrees:
        values[:, 3:] = np.deg2rad(values[:, 3:])
    return read(pose(values[:, :3], **{kind: values[:, 3:]}))


def _orientation(name: str, line: int, header: Sequence[str]) -> str:
    """What ``pose`` calls the orientation that a header names."""
    doubled = sorted({column for column in header if header.count(column) > 1})
    if doubled:
        raise PathError(f"{name}, line {line}: the header names {', '.join(doubled)} twice")
    there = [kind for kind, columns in ORIENTATIONS.items() if set(columns) <= set(header)]
    missing = [column for column in POSITION if column not in header]
    if missing or len(there) != 1:
        choices = " or ".join(",".join(columns) for columns in ORIENTATIONS.values())
        problem = (
            f"no column {' and '.join(missing)}" if missing
            else f"{'more than one orientation' if there else 'no orientation'}: one of {choices} is needed"
        )  # fmt: skip
        raise PathError(f"{name}, line {line}: the header {','.join(header)} has {problem}")
    return there[0]


def _numbers(
    name: str, lines: Sequence[int], rows: Sequence[Sequence[str]], header: Sequence[str], columns: Sequence[str]
) -> Array:
    """(k, c) the columns asked for, as finite numbers."""
    picked = [(column, header.index(column)) for column in columns]
    out = np.empty((len(rows), len(picked)))
    for k, (line, row) in enumerate(zip(lines, rows, strict=True)):
        if len(row) != len(header):
            raise PathError(f"{name}, line {line}: {len(row)} values; {len(header)} are needed, as in the first line")
        for j, (column, place) in enumerate(picked):
            if not _is_number(row[place]) or not np.isfinite(float(row[place])):
                raise PathError(f"{name}, line {line}, column {column}: {quoted(row[place])} is no finite number")
            out[k, j] = float(row[place])
    return out


def _is_number(cell: str) -> bool:
    try:
        float(cell)
    except ValueError:
        return False
    return True
