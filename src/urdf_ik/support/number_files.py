"""Arrays of numbers from files: CSV with or without a header, JSON, and NumPy's own formats; the content decides."""

from __future__ import annotations

import csv
import io
import json
import zipfile
from collections.abc import Callable, Iterator, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from urdf_ik.errors import UrdfIkError, printable
from urdf_ik.support import files
from urdf_ik.support.text import quoted

Array = NDArray[np.float64]
Refused = Callable[[str], UrdfIkError]

MAX_BYTES = 2**28
"""Greatest size of a file, packed and unpacked [bytes]: more than a million poses as text."""


class Wanted(NamedTuple):
    """The numbers that a file must hold.

    Attributes:
        keys: accepted names of the array in an .npz file or a JSON object.
        element: the name of one entry of a list in messages, such as 'waypoint'.
        accepted: a sentence that describes valid contents.
        error: the class of errors.
    """

    keys: Sequence[str]
    element: str
    accepted: str
    error: Refused


class Rows(NamedTuple):
    """A CSV.

    Attributes:
        name: the file's name in messages.
        header: names of its columns; None if its first line holds a number.
        first: the line of the header, or of the first row.
        lines: the line number of each row.
        cells: texts, a list a row, without the header.
        wanted: the numbers that it must hold.
    """

    name: str
    header: list[str] | None
    first: int
    lines: list[int]
    cells: list[list[str]]
    wanted: Wanted

    def numbers(self, columns: Sequence[str], header: Sequence[str]) -> Array:
        """(k, c) the columns asked for, as finite numbers.

        Args:
            columns: names, each of them in ``header``.
            header: what the columns of the file are called.

        Raises:
            UrdfIkError: the error wanted; a line is too short or too long, or a cell is no finite number.
        """
        picked = [(column, header.index(column)) for column in columns]
        out = np.empty((len(self.cells), len(picked)))
        for k, (line, row) in enumerate(zip(self.lines, self.cells, strict=True)):
            where = f"{self.name}, line {line}"
            if len(row) != len(header):
                raise self.wanted.error(f"{where}: {len(row)} values; {len(header)} are needed, as in the first line")
            for j, (column, place) in enumerate(picked):
                if not _is_number(row[place]) or not np.isfinite(float(row[place])):
                    raise self.wanted.error(
                        f"{where}, column {printable(column)}: {quoted(row[place])} is no finite number"
                    )
                out[k, j] = float(row[place])
        return out


def read(source: Any, wanted: Wanted) -> tuple[str, Array | Rows]:
    """Read a file of numbers; return its name in messages, and the numbers.

    Args:
        source: a path, or a file open for reading.
        wanted: the numbers that the file must hold.

    Raises:
        UrdfIkError: the error wanted; the file cannot be read, is too large, or holds no numbers.

    Example:
        >>> import io
        >>> from urdf_ik.errors import ArgumentError
        >>> wanted = Wanted(("T",), "waypoint", "rows of numbers are needed", ArgumentError)
        >>> name, numbers = read(io.BytesIO(b"[[1, 2], [3, 4]]"), wanted)
        >>> numbers.tolist()
        [[1.0, 2.0], [3.0, 4.0]]
    """
    name = files.called(source) if hasattr(source, "read") else files.name_of(source)
    data = files.read(source, MAX_BYTES, wanted.error)
    if not data.strip():
        raise wanted.error(f"{name} is empty; {wanted.accepted}")
    if data.startswith((b"\x93NUMPY", b"PK")):
        return name, _from_numpy(name, data, wanted)
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError:
        raise wanted.error(f"{name} is neither text nor a .npy or .npz file; {wanted.accepted}") from None
    if text.lstrip().startswith(("[", "{")):
        return name, _from_json(name, text, wanted)
    return name, _from_csv(name, text, wanted)


def _from_numpy(name: str, data: bytes, wanted: Wanted) -> Array:
    try:
        if data.startswith(b"PK") and _unpacked(data) > MAX_BYTES:
            raise wanted.error(f"{name} unpacks to more than {MAX_BYTES >> 20} MiB; read it in parts")
        loaded = np.load(io.BytesIO(data), allow_pickle=False)
        arrays = {"": loaded} if isinstance(loaded, np.ndarray) else dict(loaded)
    except UrdfIkError:
        raise
    except Exception:  # NumPy, zip, zlib and Python's tokenizer each have their own ways to say that bytes are damaged
        raise wanted.error(
            f"{name} is damaged, or holds Python objects instead of numbers; {wanted.accepted}"
        ) from None
    key = next((key for key in wanted.keys if key in arrays), next(iter(arrays)) if len(arrays) == 1 else None)
    if key is None:
        held = printable(", ".join(arrays) or "nothing")
        raise wanted.error(f"{name} holds {held}, and no array {' or '.join(wanted.keys)}")
    if arrays[key].dtype.kind not in "fiu":
        raise wanted.error(f"{name}: its array has the type {arrays[key].dtype}, which is no real number")
    return np.asarray(arrays[key], dtype=np.float64)


def _unpacked(data: bytes) -> int:
    with zipfile.ZipFile(io.BytesIO(data)) as archive:
        return sum(each.file_size for each in archive.infolist())


def _from_json(name: str, text: str, wanted: Wanted) -> Array:
    try:
        value = json.loads(text)
        value = _held(name, value, wanted)
        if isinstance(value, list):
            value = [_held(f"{name}, {wanted.element} {k}", each, wanted) for k, each in enumerate(value)]
        entries = list(enumerate(value)) if isinstance(value, list) else [(0, value)]
        for k, each in entries:
            for leaf in _leaves(each):
                if isinstance(leaf, bool) or not isinstance(leaf, int | float):
                    odd = printable(json.dumps(leaf))
                    raise wanted.error(f"{name}, {wanted.element} {k}: {odd} is no number; {wanted.accepted}")
    except json.JSONDecodeError as error:
        raise wanted.error(f"{name}, line {error.lineno}: {error.msg}; {wanted.accepted}") from None
    except RecursionError:
        raise wanted.error(f"{name} is nested too deeply; {wanted.accepted}") from None
    except UrdfIkError:
        raise
    except ValueError as error:  # an integer of more digits than Python reads
        raise wanted.error(f"{name}: {error}; {wanted.accepted}") from None
    try:
        return np.array(value, dtype=np.float64)
    except (ValueError, OverflowError) as error:
        for k, each in entries:
            try:
                same = np.shape(np.array(each, dtype=np.float64)) == np.shape(np.array(value[0], dtype=np.float64))
            except (ValueError, OverflowError):
                same = False
            if not same:
                shown = printable(json.dumps(each))
                raise wanted.error(
                    f"{name}, {wanted.element} {k}: {shown} is of another shape than the first, or too large; "
                    f"{wanted.accepted}"
                ) from None
        raise wanted.error(f"{name}: {error}; {wanted.accepted}") from None


def _held(name: str, value: Any, wanted: Wanted) -> Any:
    """What an object holds under one of the keys; anything else as it is."""
    if not isinstance(value, dict):
        return value
    for key in wanted.keys:
        if key in value:
            return value[key]
    held = printable(", ".join(value) or "nothing")
    raise wanted.error(f"{name}: the JSON object has {held}, and no {' or '.join(wanted.keys)}")


def _leaves(value: Any) -> Iterator[Any]:
    if isinstance(value, list):
        for item in value:
            yield from _leaves(item)
    else:
        yield value


def _from_csv(name: str, text: str, wanted: Wanted) -> Rows:
    numbered = [
        (number, line)
        for number, line in enumerate(text.splitlines(), start=1)
        if line.strip() and not line.lstrip().startswith("#")
    ]
    if not numbered:
        raise wanted.error(f"{name} holds nothing but comments; {wanted.accepted}")
    mark = next((mark for mark in ",;\t" if mark in numbered[0][1]), " ")
    reader = csv.reader((line for _, line in numbered), delimiter=mark, skipinitialspace=True)
    lines: list[int] = []
    cells: list[list[str]] = []
    try:
        for row in reader:
            lines.append(numbered[reader.line_num - 1][0])
            stripped = [cell.strip() for cell in row]
            cells.append([cell for cell in stripped if cell] if mark == " " else stripped)
    except csv.Error as error:
        line = numbered[max(reader.line_num, 1) - 1][0]
        raise wanted.error(f"{name}, line {line}: {error}; {wanted.accepted}") from None
    if any(map(_is_number, cells[0])):
        return Rows(name, None, lines[0], lines, cells, wanted)
    if len(cells) == 1:
        raise wanted.error(f"{name}, line {lines[0]}: a header, and no {wanted.element} after it")
    return Rows(name, cells[0], lines[0], lines[1:], cells[1:], wanted)


def _is_number(cell: str) -> bool:
    try:
        float(cell)
    except ValueError:
        return False
    return True
