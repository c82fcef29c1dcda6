"""Input and output of the commands: typed numbers, files of joint vectors, standard output, exit statuses."""

import csv
import io
import os
import re
import sys
import time
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from enum import IntEnum
from pathlib import Path
from typing import IO, Any, Self

import numpy as np
import typer
from numpy.typing import NDArray

from urdf_ik.cli.options import is_terminal
from urdf_ik.errors import ArgumentError, escaped
from urdf_ik.support import files
from urdf_ik.support.tables import Table, read_table
from urdf_ik.support.text import json_text
from urdf_ik.typing import Array

STDIN = "-"
_NUMBER = re.compile(r"[-+]?[\d.]+(?:[eE][-+]?\d+)?")
_NUMBER_FILES = (".csv", ".json", ".npy", ".npz", ".txt")


class Status(IntEnum):
    """Exit status."""

    DONE = 0
    FAILED = 1
    USAGE = 2
    URDF = 3
    UNSUPPORTED = 4
    INTERRUPTED = 130
    READER_GONE = 141  # as the shell reports a program that SIGPIPE ended


@dataclass(frozen=True)
class Angles:
    """Conversion between the radians of the package and the unit that the user reads and types.

    Attributes:
        degrees: angles are shown and typed in degrees.
        turning: (n,) true for joints whose value is an angle (not prismatic).
        horizon: share of joint 2 that joint 3 holds in joint vectors as shown and typed: 0, or 1 or -1 where it is
            against the horizon.
    """

    degrees: bool
    turning: NDArray[np.bool_]
    horizon: float = 0.0

    @property
    def unit(self) -> str:
        """'deg' or 'rad'."""
        return "deg" if self.degrees else "rad"

    @property
    def units(self) -> list[str]:
        """The unit of each joint's value."""
        return [self.unit if turning else "m" for turning in self.turning]

    def angle(self, value: Any) -> Any:
        """Angles in rad, as shown."""
        return np.rad2deg(value) if self.degrees else value

    def shown(self, q: Array) -> Array:
        """Joint values, limits or differences (..., n) in rad or m, as shown."""
        return np.where(self.turning, np.rad2deg(q), q) if self.degrees else q

    def typed(self, q: Array) -> Array:
        """Joint values (..., n) as typed, in rad or m."""
        return np.where(self.turning, np.deg2rad(q), q) if self.degrees else q

    def vectors(self, q: Array) -> Array:
        """Joint vectors (..., n) in rad or m, as shown."""
        return self.shown(self._coupled(q, self.horizon))

    def typed_vectors(self, q: Array) -> Array:
        """Joint vectors (..., n) as typed, in rad or m."""
        return self._coupled(self.typed(q), -self.horizon)

    def _coupled(self, q: Array, share: float) -> Array:
        return q + share * q[..., 1:2] * (np.arange(len(self.turning)) == 2) if share else q


def usage(message: str, option: str | None = None) -> typer.BadParameter:
    """The exception that ends the program with status 2 and ``message``."""
    return typer.BadParameter(message, param_hint=option)


def split(text: str) -> list[str]:
    """The parts of a list that is typed with commas or spaces, and brackets or parentheses round it."""
    return re.sub(r"[\[\](),]", " ", text).split()


def numbers(text: str, option: str, names: Sequence[str]) -> Array:
    """Numbers typed as ``0.1,0.2,0.3``, one for each of ``names``."""
    out = []
    for part in split(text):
        try:
            out.append(float(part))
        except ValueError:
            raise usage(f"{part!r} in {text!r} is not a number; give {','.join(names)}", option) from None
    if len(out) != len(names):
        raise usage(f"{text!r} holds {len(out)} values, {len(names)} are needed: {','.join(names)}", option)
    if not np.isfinite(out).all():
        raise usage(f"{text!r} holds a value that is not finite", option)
    return np.array(out)


def joint_vectors(typed: Sequence[str], option: str, joint_names: Sequence[str]) -> Array:
    """Joint vectors (N, n), each typed as numbers, or those of a file or of standard input for ``-``."""
    parts = [
        _read_joint_vectors(text, option, joint_names) if _is_file(text) else numbers(text, option, joint_names)[None]
        for text in typed
    ]
    return np.concatenate(parts)


def _is_file(text: str) -> bool:
    """Whether this names a file, or standard input, and is no list of numbers."""
    typed = all(_NUMBER.fullmatch(part) for part in split(text))
    return text == STDIN or (not typed and (Path(text).suffix.lower() in _NUMBER_FILES or os.path.isfile(text)))


def _read_joint_vectors(source: str, option: str, joint_names: Sequence[str]) -> Array:
    """Joint vectors (N, n) from a file, or from standard input for ``-``."""
    n = len(joint_names)
    accepted = (
        f"accepted: {n} values each ({', '.join(joint_names)}), as .npy or .npz (array 'q' or the only one) or JSON of "
        f'shape ({n},) or (N, {n}), JSON {{"q": [...]}}, CSV with {n} columns or a header with the joints\' names'
    )
    name, content = read_table(opened(source, option), ["q", "poses"], "joint vector", accepted)
    if isinstance(content, Table):
        header = content.header or [str(k) for k in range(1, len(content.cells[0]) + 1)]
        content = content.numbers(joint_names if set(joint_names) <= set(header) else header, header)
    if content.ndim not in (1, 2) or not content.size or content.shape[-1] != n:
        raise ArgumentError(f"{name} holds numbers of shape {content.shape}; {accepted}")
    return content.reshape(-1, n)


def opened(source: str, option: str) -> str | IO[bytes]:
    """A file's name as it is; standard input for ``-``."""
    if source != STDIN:
        return source
    if sys.stdin is None:
        raise usage("standard input is closed", option)
    return sys.stdin.buffer


def box(text: str, option: str) -> Array:
    """The corners (2, 3) of a box as typed, the lower one first."""
    return numbers(text, option, ("x0", "y0", "z0", "x1", "y1", "z1")).reshape(2, 3)


def emit(
    printed_as: str,
    data: Any,
    text: Callable[[], str],
    output: Path | None = None,
    *,
    rows: Callable[[], Iterable[Sequence[Any]]] | None = None,
    arrays: Callable[[], Mapping[str, Any]] | None = None,
    about: str = "",
) -> None:
    """Print an answer, or write it to a file.

    Args:
        printed_as: 'json', 'csv', 'npz', or text for people.
        data: what becomes JSON, or JSON text; or the function that returns it.
        text: its text for people.
        output: the file; None: standard output.
        rows: the header and the rows of a CSV.
        arrays: those of an npz file.
        about: content and units of the data, which standard error gets where they go to a file.
    """
    if printed_as == "json":
        value = data() if callable(data) else data
        write(value if isinstance(value, str) else json_text(value, nulls=True), output)
    elif printed_as == "csv" and rows is not None:
        lines = io.StringIO()
        csv.writer(lines, lineterminator="\n").writerows(rows())
        write(lines.getvalue(), output)
    elif printed_as == "npz" and arrays is not None:
        packed = io.BytesIO()
        np.savez_compressed(packed, allow_pickle=False, **arrays())
        write(packed.getvalue(), output)
    else:
        write(text(), output)
        return
    if output is not None and about:
        say(f"{output}: {about}")


def write(text: str | bytes, output: Path | None = None) -> None:
    """Write to ``output``, or to standard output."""
    if isinstance(text, str):  # a name in a file of unknown origin must not control the terminal
        encoding = getattr(sys.stdout, "encoding", None) or "utf-8"
        data = escaped(text).encode(encoding, "backslashreplace")
    else:
        data = text
    if output is not None:
        files.write(output, data)
    elif sys.stdout is not None:  # None: closed by the caller, who wants the status only
        sys.stdout.flush()
        rest = memoryview(data)
        while rest:  # under PYTHONUNBUFFERED a write may take only a part
            rest = rest[sys.stdout.buffer.write(rest) :]
        sys.stdout.buffer.flush()


def replayed(report: object, *definitions: str) -> str:
    """The text of a report; before its first line that replays something those that define its names."""

    def defined(found: re.Match[str]) -> str:
        return "".join(f"{found[0]}{line}\n" for line in definitions) + found[0]

    return re.sub(r"^ *replay: ", defined, f"{report}\n", count=1, flags=re.MULTILINE)


def conclude(report: Any, printed_as: str, definition: str, output: Path | None = None) -> None:
    """Print the report of a check, and end with status 1 where it has not passed; ``definition``: that of ``arm``."""
    emit(printed_as, report.to_json, lambda: replayed(report, definition), output)
    if not report.passed:
        raise typer.Exit(Status.FAILED)


def say(text: object) -> None:
    """A line on standard error."""
    typer.echo(escaped(str(text)), err=True)


WORD_AFTER, WORD_EVERY, WORD_EVERY_ON_TERMINAL = 2.0, 5.0, 0.2
"""Seconds before the first line, and between lines; on a terminal one line is written again and again."""


class Progress:
    """A line now and then."""

    def __init__(self, what: str) -> None:
        """``what`` heads the line."""
        self._what, self._start, self._on_terminal = what, time.monotonic(), is_terminal(sys.stderr)
        self._next, self._is_shown = self._start + WORD_AFTER, False

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        if self._is_shown and self._on_terminal:
            print("\r\x1b[K", end="", file=sys.stderr, flush=True)

    @property
    def seconds(self) -> float:
        """How long ago this was made [s]."""
        return time.monotonic() - self._start

    def tick(self, done: int, total: int) -> None:
        """Show that ``done`` of ``total`` steps are behind us."""
        self.say(f"{done} of {total}")

    def say(self, words: str) -> None:
        """Show what is done now."""
        if time.monotonic() <= self._next:
            return
        self._next, self._is_shown = time.monotonic() + WORD_EVERY, True
        line = f"{self._what}: {words}, {self.seconds:.0f} s so far"
        if self._on_terminal:
            self._next = time.monotonic() + WORD_EVERY_ON_TERMINAL
            line = f"\r\x1b[K{line[:78]}"
        print(line, end="" if self._on_terminal else "\n", file=sys.stderr, flush=True)
