"""Tables of numbers from files: CSV with or without a header, JSON, and NumPy's own formats; the content decides."""

import csv
import io
import json
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from urdf_ik.errors import ArgumentError, printable
from urdf_ik.support import files
from urdf_ik.typing import Array


class Table(NamedTuple):
    """A CSV: its name, the header (None if the first line holds a number) and its line, each row's line and texts."""

    name: str
    header: list[str] | None
    first: int
    lines: list[int]
    cells: list[list[str]]

    def numbers(self, columns: Sequence[str], header: Sequence[str]) -> Array:
        """(k, c) the columns asked for, each of them in ``header``, as finite numbers."""
        picked = [(column, header.index(column)) for column in columns]
        out = np.empty((len(self.cells), len(picked)))
        for k, (line, row) in enumerate(zip(self.lines, self.cells, strict=True)):
            where = f"{self.name}, line {line}"
            if len(row) != len(header):
                raise ArgumentError(f"{where}: {len(row)} values; {len(header)} are needed, as in the first line")
            for j, (column, place) in enumerate(picked):
                out[k, j] = number(row[place])
                if not np.isfinite(out[k, j]):
                    raise ArgumentError(f"{where}, column {column}: {row[place]!r} is no finite number")
        return out


def read_table(source: Any, keys: Sequence[str], element: str, accepted: str) -> tuple[str, Array | Table]:
    """The name of a file in messages, and its numbers.

    Args:
        source: a path, or a file open for reading.
        keys: what the array may be called in an .npz file or a JSON object.
        element: what the messages call one entry of a list, such as 'waypoint'.
        accepted: a sentence that describes valid contents.
    """
    name, data = files.name_of(source), files.read(source)
    try:
        if not data.strip():
            raise ValueError(" is empty")
        if data.startswith((b"\x93NUMPY", b"PK")):
            return name, _from_numpy(data, keys)
        text = data.decode("utf-8-sig")
        if text.lstrip().startswith(("[", "{")):
            return name, _from_json(text, keys, element)
        header, lines, cells = csv_rows(text, element)
    except UnicodeDecodeError:
        raise ArgumentError(f"{name} is neither text nor a .npy or .npz file; {accepted}") from None
    except json.JSONDecodeError as failure:
        raise ArgumentError(f"{name}, line {failure.lineno}: {failure.msg}; {accepted}") from None
    except ValueError as failure:
        raise ArgumentError(f"{name}{failure}; {accepted}") from None
    return name, Table(name, header, lines[0], lines[1:] if header else lines, cells)


def csv_rows(text: str, element: str) -> tuple[list[str] | None, list[int], list[list[str]]]:
    """The header of a CSV, the line numbers of header and rows, and the rows; lines that begin with '#' are remarks.

    Commas, semicolons, tabs or blanks separate the cells. The message of a ValueError follows the file's name.
    """
    numbered = [(k, line) for k, line in enumerate(text.splitlines(), 1) if line.strip()[:1] not in ("", "#")]
    if not numbered:
        raise ValueError(" holds nothing but comments")
    mark = next((mark for mark in ",;\t" if mark in numbered[0][1]), " ")
    reader = csv.reader((line for _, line in numbered), delimiter=mark, skipinitialspace=True)
    lines: list[int] = []
    cells: list[list[str]] = []
    try:
        for row in reader:
            lines.append(numbered[reader.line_num - 1][0])
            cells.append([cell.strip() for cell in row if cell.strip() or mark != " "])
    except csv.Error as failure:
        raise ValueError(f", line {numbered[max(reader.line_num, 1) - 1][0]}: {failure}") from None
    if not all(np.isnan(number(cell)) for cell in cells[0]):
        return None, lines, cells
    if len(cells) == 1:
        raise ValueError(f", line {lines[0]}: a header, and no {element} after it")
    return cells[0], lines, cells[1:]


def number(cell: str) -> float:
    """The number in a cell, NaN where there is none."""
    try:
        return float(cell)
    except ValueError:
        return np.nan


def _from_numpy(data: bytes, keys: Sequence[str]) -> Array:
    try:
        loaded = np.load(io.BytesIO(data), allow_pickle=False)
        arrays = {"": loaded} if isinstance(loaded, np.ndarray) else dict(loaded)
    except Exception:  # NumPy, zip, zlib and Python's tokenizer each have their own errors for damaged bytes
        raise ValueError(" is damaged, or holds Python objects instead of numbers") from None
    key = next((key for key in keys if key in arrays), next(iter(arrays)) if len(arrays) == 1 else None)
    if key is None:
        raise ValueError(f" holds {', '.join(arrays) or 'nothing'}, and no array {' or '.join(keys)}")
    if arrays[key].dtype.kind not in "fiu":
        raise ValueError(f": its array has the type {arrays[key].dtype}, which is no real number")
    return np.asarray(arrays[key], dtype=np.float64)


def _from_json(text: str, keys: Sequence[str], element: str) -> Array:
    value = _member(json.loads(text), keys, "")
    if not isinstance(value, list):
        return np.array(_numbers(value, ""))
    arrays: list[Array] = []
    for k, entry in enumerate(value):
        where = f", {element} {k}"
        arrays.append(_numbers(_member(entry, keys, where), where))
        if arrays[k].shape != arrays[0].shape:
            raise ValueError(f"{where}: {printable(json.dumps(entry))} is of another shape than the first")
    return np.array(arrays)


def _member(value: Any, keys: Sequence[str], where: str) -> Any:
    """What an object holds under one of the keys; anything else as it is."""
    if not isinstance(value, dict):
        return value
    for key in keys:
        if key in value:
            return value[key]
    raise ValueError(f"{where}: the JSON object has {', '.join(value) or 'nothing'}, and no {' or '.join(keys)}")


def _numbers(value: Any, where: str) -> Array:
    """A number, or lists of numbers, as an array."""
    level = [value]
    while level:
        if odd := [part for part in level if isinstance(part, bool) or not isinstance(part, int | float | list)]:
            raise ValueError(f"{where}: {printable(json.dumps(odd[0]))} is no number")
        level = [part for parts in level if isinstance(parts, list) for part in parts]
    try:
        return np.array(value, dtype=np.float64)
    except (ValueError, OverflowError) as failure:
        raise ValueError(f"{where}: {printable(json.dumps(value))}: {failure}") from None
