"""Input and output of the commands: typed numbers, files of poses and joint vectors, standard output."""

from __future__ import annotations

import csv
import io
import os
import re
import sys
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import IO, Any

import numpy as np
import typer
from numpy.typing import NDArray

from urdf_ik.errors import ArgumentError, escaped, printable
from urdf_ik.support import files
from urdf_ik.support import text as texts
from urdf_ik.support.tables import Table, read_table
from urdf_ik.support.text import quoted

STDIN = "-"
_NUMBER = re.compile(r"[-+]?[\d.]+(?:[eE][-+]?\d+)?")
_NUMBER_FILES = (".csv", ".json", ".npy", ".npz", ".txt")


@dataclass(frozen=True)
class Angles:
    """Conversion between the radians of the package and the unit that the user reads and types.

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
        typer.BadParameter: a value is not a finite number, or there are too many or too few.
    """
    parts = text.replace(",", " ").split()
    out = []
    for part in parts:
        try:
            out.append(float(part))
        except ValueError:
            raise usage(f"{quoted(part)} in {quoted(text)} is not a number; give {','.join(names)}", option) from None
    if len(out) != len(names):
        raise usage(f"{quoted(text)} holds {len(out)} values, {len(names)} are needed: {','.join(names)}", option)
    if not np.isfinite(out).all():
        raise usage(f"{quoted(text)} holds a value that is not finite", option)
    return np.array(out)


def read_poses(source: str, option: str, *, degrees: bool = False) -> NDArray[np.float64]:
    """Poses (N, 4, 4) from a file, or from standard input for ``-``; ``degrees``: whether its angles are in degrees.

    Raises:
        typer.BadParameter: standard input is closed.
        ArgumentError: the file cannot be read, or holds no poses in an accepted form.
    """
    from urdf_ik.paths.waypoint_files import read_poses

    return read_poses(opened(source, option), degrees=degrees)


def joint_vectors(typed: Sequence[str], option: str, joint_names: Sequence[str]) -> NDArray[np.float64]:
    """Joint vectors (N, n), each typed as numbers, or those of a file or of standard input for ``-``.

    Raises:
        typer.BadParameter: this is neither, or standard input is closed.
        ArgumentError: the file cannot be read, or holds no joint vectors in an accepted form.
    """
    parts = [
        _read_joint_vectors(text, option, joint_names) if _is_file(text) else numbers(text, option, joint_names)[None]
        for text in typed
    ]
    return np.concatenate(parts)


def _is_file(text: str) -> bool:
    """Whether this names a file, or standard input, and is no list of numbers."""
    typed = all(_NUMBER.fullmatch(part) for part in text.replace(",", " ").split())
    return text == STDIN or (not typed and (Path(text).suffix.lower() in _NUMBER_FILES or os.path.isfile(text)))


def _read_joint_vectors(source: str, option: str, joint_names: Sequence[str]) -> NDArray[np.float64]:
    """Joint vectors (N, n) from a file, or from standard input for ``-``."""
    n = len(joint_names)
    accepted = (
        f"accepted: {n} values each ({', '.join(map(printable, joint_names))}), as .npy or .npz (array 'q' or "
        f'the only one) or JSON of shape ({n},) or (N, {n}), JSON {{"q": [...]}}, CSV with {n} columns or a header '
        "with the joints' names"
    )
    name, held = read_table(opened(source, option), ["q", "poses"], "joint vector", accepted)
    if isinstance(held, Table):
        header = held.header or [str(k) for k in range(1, len(held.cells[0]) + 1)]
        held = held.numbers(joint_names if set(joint_names) <= set(header) else header, header)
    if held.ndim not in (1, 2) or not held.size or held.shape[-1] != n:
        raise ArgumentError(f"{name} holds numbers of shape {held.shape}; {accepted}")
    return held.reshape(-1, n)


class Coloured(str):
    """Text with control sequences of this package only; names from files are escaped in it already."""


def opened(source: str, option: str) -> str | IO[bytes]:
    """A file's name as it is; standard input for ``-``.

    Raises:
        typer.BadParameter: standard input is closed.
    """
    if source != STDIN:
        return source
    if sys.stdin is None:
        raise usage("standard input is closed", option)
    return sys.stdin.buffer


def box(text: str, option: str) -> NDArray[np.float64]:
    """The corners (2, 3) of a box as typed, the lower one first.

    Raises:
        typer.BadParameter: these are not six numbers.
    """
    return numbers(text, option, ("x0", "y0", "z0", "x1", "y1", "z1")).reshape(2, 3)


def write(text: str | bytes, output: Path | None) -> None:
    """Write to ``output``, or to standard output.

    Raises:
        ArgumentError: the file cannot be written.
    """
    # A name in a file of unknown origin must not control the terminal.
    shown = escaped(text) if isinstance(text, str) and not isinstance(text, Coloured) else text
    data = shown.encode(_encoding(), "backslashreplace") if isinstance(shown, str) else shown
    if output is None:
        if sys.stdout is None:  # closed by the caller, who wants the status only
            return
        sys.stdout.flush()
        rest = memoryview(data)
        while rest:  # under PYTHONUNBUFFERED a write may take only a part
            rest = rest[sys.stdout.buffer.write(rest) :]
        sys.stdout.buffer.flush()
        return
    files.write(output, data)


def say_written(file: Path, content: str, angle: str) -> None:
    """Say on standard error what a file holds, and in which units."""
    typer.echo(escaped(f"{file}: {content}; {angle}, m"), err=True)


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
    """Name of an input file, or of standard input, in messages."""
    return files.STDIN if source == STDIN else source
