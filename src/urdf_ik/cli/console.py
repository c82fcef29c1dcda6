"""What the command line reads and writes: numbers, arrays of poses and joint vectors, and its output."""

from __future__ import annotations

import csv
import io
import json
import sys
import zipfile
import zlib
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import typer

from urdf_ik import text as texts
from urdf_ik.text import quoted

if TYPE_CHECKING:
    from numpy.typing import NDArray

STDIN = "-"
POSE_COLUMNS = ("x", "y", "z", "qx", "qy", "qz", "qw")
POSES_ACCEPTED = (
    "accepted: 4x4 matrices or x,y,z,qx,qy,qz,qw, as .npy or .npz (array 'poses', 'T' or the only one) of shape "
    '(4, 4), (N, 4, 4), (N, 16) or (N, 7); as JSON of these shapes or {"poses": [...]}; as CSV with 16 columns '
    "(row by row) or 7, with or without a header line"
)

# What NumPy raises on a .npy or .npz file that is cut short or scrambled.
_DAMAGED = (ValueError, EOFError, OSError, KeyError, NotImplementedError, zipfile.BadZipFile, zlib.error)


@dataclass(frozen=True)
class Angles:
    """Conversion between the radians of the package and what the user reads and types.

    Attributes:
        degrees: angles are shown and typed in degrees.
        turning: (n,) true for joints whose value is an angle (not prismatic).
    """

    degrees: bool
    turning: NDArray[np.bool_]

    @property
    def unit(self) -> str:
        """'deg' or 'rad'."""
        return "deg" if self.degrees else "rad"

    def angle(self, value: Any) -> Any:
        """Angles in rad, as shown."""
        return np.rad2deg(value) if self.degrees else value

    def shown(self, q: NDArray[np.float64]) -> NDArray[np.float64]:
        """Joint vectors (..., n) in rad or m, as shown."""
        return np.where(self.turning, np.rad2deg(q), q) if self.degrees else q

    def typed(self, q: NDArray[np.float64]) -> NDArray[np.float64]:
        """Joint vectors (..., n) as typed, in rad or m."""
        return np.where(self.turning, np.deg2rad(q), q) if self.degrees else q


def usage(message: str, option: str | None = None) -> typer.BadParameter:
    """The exception that ends the program with status 2 and ``message``."""
    return typer.BadParameter(message, param_hint=option)


def numbers(text: str, option: str, names: Sequence[str]) -> NDArray[np.float64]:
    """Numbers typed as ``0.1,0.2,0.3``, one for each of ``names``.

    Raises:
        typer.BadParameter: a value is no finite number, or there are too many or too few.
    """
    parts = text.replace(",", " ").split()
    out = []
    for part in parts:
        try:
            out.append(float(part))
        except ValueError:
            raise usage(f"{quoted(part)} in {quoted(text)} is no number; give {','.join(names)}", option) from None
    if len(out) != len(names):
        raise usage(f"{quoted(text)} holds {len(out)} values, {len(names)} are needed: {','.join(names)}", option)
    if not np.isfinite(out).all():
        raise usage(f"{quoted(text)} holds a value that is not finite", option)
    return np.array(out)


def read_poses(source: str, option: str) -> NDArray[np.float64]:
    """Poses (N, 4, 4) from a file, or from standard input for ``-``.

    Raises:
        typer.BadParameter: the file cannot be read, or holds no poses in an accepted form.
    """
    from urdf_ik.poses import pose

    values = _load(source, option, ("poses", "T", "pose"), POSE_COLUMNS, POSES_ACCEPTED)
    if values.shape[-2:] == (4, 4) or values.shape[-1:] == (16,):
        poses = values.reshape(-1, 4, 4)
    elif values.shape[-1:] == (7,):
        flat = values.reshape(-1, 7)
        poses = pose(flat[:, :3], quat_xyzw=flat[:, 3:])
    else:
        raise usage(f"{place(source)} holds numbers of shape {values.shape}; {POSES_ACCEPTED}", option)
    if not len(poses):
        raise usage(f"{place(source)} holds no poses; {POSES_ACCEPTED}", option)
    return np.ascontiguousarray(poses)


def read_joint_vectors(source: str, option: str, joint_names: Sequence[str]) -> NDArray[np.float64]:
    """Joint vectors (N, n) as typed, from a file, or from standard input for ``-``.

    Raises:
        typer.BadParameter: the file cannot be read, or holds no joint vectors in an accepted form.
    """
    n = len(joint_names)
    accepted = (
        f"accepted: {n} values each ({', '.join(joint_names)}), as .npy or .npz (array 'q' or the only one) or JSON "
        f'of shape ({n},) or (N, {n}), JSON {{"q": [...]}}, CSV with {n} columns or a header with the joints\' names'
    )
    values = _load(source, option, ("q",), joint_names, accepted)
    if not values.size or values.shape[-1] != n:
        raise usage(f"{place(source)} holds numbers of shape {values.shape}; {accepted}", option)
    return values.reshape(-1, n)


def write(text: str | bytes, output: Path | None) -> None:
    """Write to ``output``, or to standard output.

    Raises:
        typer.BadParameter: the file cannot be written.
    """
    data = text.encode(_encoding(), "backslashreplace") if isinstance(text, str) else text
    if output is None:
        if sys.stdout is None:  # closed by the caller, who wants the status only
            return
        sys.stdout.flush()
        rest = memoryview(data)
        while rest:  # under PYTHONUNBUFFERED a write may take only a part
            rest = rest[sys.stdout.buffer.write(rest) :]
        sys.stdout.buffer.flush()
        return
    try:
        output.write_bytes(data)
    except OSError as error:
        raise usage(f"cannot write {output}: {error.strerror}", "--output") from None


def csv_text(header: Sequence[str], rows: Iterable[Sequence[Any]]) -> str:
    """RFC 4180 text with one header line; floats keep every digit."""
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow(header)
    writer.writerows(rows)
    return out.getvalue()


def json_text(value: Any) -> str:
    """JSON text of an answer; numbers that it does not have (infinities, NaN) become null."""
    return texts.json_text(value, nulls=True)


def npz_bytes(arrays: dict[str, Any]) -> bytes:
    """The bytes of a compressed ``.npz`` file."""
    out = io.BytesIO()
    np.savez_compressed(out, allow_pickle=False, **arrays)
    return out.getvalue()


def _encoding() -> str:
    return getattr(sys.stdout, "encoding", None) or "utf-8"


def place(source: str) -> str:
    """What a message calls the place that was read."""
    return "standard input" if source == STDIN else source


def _load(source: str, option: str, keys: Sequence[str], columns: Sequence[str], accepted: str) -> NDArray[np.float64]:
    """Numbers from a file of any accepted format; the content decides, not the file's name.

    ``keys`` name the array inside .npz and JSON; ``columns`` are picked from a CSV whose header has them.
    """
    try:
        data = _stdin(option) if source == STDIN else Path(source).read_bytes()
    except OSError as error:
        raise usage(f"cannot read {source}: {error.strerror}", option) from None
    if not data.strip():
        raise usage(f"{place(source)} is empty; {accepted}", option)
    try:
        if data.startswith((b"\x93NUMPY", b"PK")):
            return _from_numpy(data, keys)
        text = data.decode("utf-8-sig")
        if text.lstrip().startswith(("[", "{")):
            return _floats(_from_json(json.loads(text), keys))
        return _from_csv(text, columns)
    except UnicodeDecodeError:
        problem = "is neither text nor a .npy or .npz file"
    except RecursionError:
        problem = "is nested too deeply"
    except ValueError as error:
        problem = f"cannot be read: {error}"
    raise usage(f"{place(source)} {problem}; {accepted}", option)


def _stdin(option: str) -> bytes:
    if sys.stdin is None:
        raise usage("standard input is closed", option)
    return sys.stdin.buffer.read()


def _floats(value: Any) -> NDArray[np.float64]:
    odd = [leaf for leaf in _leaves(value) if isinstance(leaf, bool) or not isinstance(leaf, int | float)]
    if odd:
        raise ValueError(f"{json.dumps(odd[0])} is no number")
    try:
        return np.array(value, dtype=np.float64)
    except (ValueError, OverflowError):
        raise ValueError("its rows have different lengths, or a number is too large") from None


def _leaves(value: Any) -> Iterator[Any]:
    if isinstance(value, list):
        for item in value:
            yield from _leaves(item)
    else:
        yield value


def _from_numpy(data: bytes, keys: Sequence[str]) -> NDArray[np.float64]:
    try:
        loaded = np.load(io.BytesIO(data), allow_pickle=False)
        arrays = {"": loaded} if isinstance(loaded, np.ndarray) else dict(loaded)
    except _DAMAGED:
        raise ValueError("it is damaged, or holds Python objects instead of numbers") from None
    chosen = next((key for key in keys if key in arrays), next(iter(arrays)) if len(arrays) == 1 else None)
    if chosen is None:
        raise ValueError(f"of its arrays ({', '.join(arrays) or 'there are none'}) none is {' or '.join(keys)}")
    array = arrays[chosen]
    if array.dtype.kind not in "fiu":
        raise ValueError(f"its array has the type {array.dtype}, which is no real number")
    return np.asarray(array, dtype=np.float64)


def _from_json(value: Any, keys: Sequence[str]) -> Any:
    """The numbers of a JSON value: bare lists, or objects that hold them under one of ``keys`` (or 'poses')."""
    if isinstance(value, dict):
        for key in (*keys, "poses"):
            if key in value:
                return _from_json(value[key], keys)
        raise ValueError(f"its JSON object has no {' or '.join(repr(key) for key in keys)}, only {', '.join(value)}")
    if isinstance(value, list) and value and isinstance(value[0], dict):
        return [_from_json(item, keys) for item in value]
    return value


def _from_csv(text: str, columns: Sequence[str]) -> NDArray[np.float64]:
    lines = [line for line in text.splitlines() if line.strip() and not line.lstrip().startswith("#")]
    if not lines:
        raise ValueError("it holds nothing but comments")
    delimiter = next((mark for mark in ",;\t" if mark in lines[0]), " ")
    rows = [[cell.strip() for cell in row] for row in csv.reader(lines, delimiter=delimiter, skipinitialspace=True)]
    if delimiter == " ":
        rows = [[cell for cell in row if cell] for row in rows]
    header: list[str] = [] if any(map(_is_number, rows[0])) else rows.pop(0)
    width = len(header) if header else len(rows[0])
    picked = [header.index(name) for name in columns] if set(columns) <= set(header) else range(width)
    return np.array([_csv_row(row, picked, width) for row in rows]).reshape(-1, len(picked))


def _csv_row(row: Sequence[str], picked: Sequence[int], width: int) -> list[float]:
    if len(row) != width:
        raise ValueError(f"the line {quoted(','.join(row))} has {len(row)} values, the first line has {width}")
    bad = next((row[i] for i in picked if not _is_number(row[i])), None)
    if bad is not None:
        raise ValueError(f"{quoted(bad)} in the line {quoted(','.join(row))} is no number")
    return [float(row[i]) for i in picked]


def _is_number(cell: str) -> bool:
    try:
        float(cell)
    except ValueError:
        return False
    return True
