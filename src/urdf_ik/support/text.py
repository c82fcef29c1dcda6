"""Text of reports and messages: quoted values, aligned tables, strict JSON."""

import json
import math
from collections.abc import Collection, Iterable, Sequence
from dataclasses import dataclass
from itertools import islice
from typing import Any

from urdf_ik.errors import MOST_OF_A_NAME, escaped, printable

_MOST_COMPARED = 1000
"""Greatest number of names that a misspelt name is compared with."""


def quoted(value: object, most: int = MOST_OF_A_NAME) -> str:
    """A value in a message: its ``repr`` on one line, cut after ``most`` characters."""
    return printable(" ".join(repr(value).split()), most)


def counted(count: int, noun: str) -> str:
    """'1 pose', '2 poses'."""
    return f"{count} {noun}{'s' * (count != 1)}"


def nearest(name: object, names: Iterable[str], n: int = 3, cutoff: float = 0.6) -> list[str]:
    """The entries of ``names`` most similar to ``name``, the most similar first.

    Only the first characters of long names and the first of many names are compared, which bounds the work.
    """
    import difflib

    cut = {each[:MOST_OF_A_NAME]: each for each in reversed(list(islice(names, _MOST_COMPARED)))}
    return [cut[each] for each in difflib.get_close_matches(str(name)[:MOST_OF_A_NAME], cut, n, cutoff)]


def meant(name: object, names: Iterable[str]) -> str:
    """'; did you mean A or B?' with the names nearest to a misspelt one; '' where none is near."""
    close = nearest(name, names)
    return f"; did you mean {' or '.join(map(quoted, close))}?" if close else ""


def aligned(rows: Sequence[Sequence[str]], *, left: Collection[int] = (), rule: bool = False) -> list[str]:
    """Rows of cells as lines with columns of equal width, two blanks between them.

    Args:
        rows: texts, all rows of the same length; the header is the first one.
        left: indices of the columns that are aligned to the left.
        rule: whether a line of hyphens stands below the first row.
    """
    rows = [[escaped(cell).replace("\n", "\\n") for cell in row] for row in rows]
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    ruled = [rows[0], ["-" * width for width in widths], *rows[1:]] if rule else rows
    return [
        "  ".join(
            cell.ljust(width) if k in left else cell.rjust(width)
            for k, (cell, width) in enumerate(zip(row, widths, strict=True))
        ).rstrip()
        for row in ruled
    ]


@dataclass(frozen=True)
class Section:
    """A table with a line above it and lines below it.

    Attributes:
        title: what the table shows.
        header: names of the columns.
        rows: texts, one a column; without rows there is no table.
        remarks: lines below the table.
        left: names of the columns that are aligned to the left.
    """

    title: str
    header: tuple[str, ...] = ()
    rows: tuple[tuple[str, ...], ...] = ()
    remarks: tuple[str, ...] = ()
    left: tuple[str, ...] = ()

    def __str__(self) -> str:
        lines = [self.title]
        if self.rows:
            left = [k for k, name in enumerate(self.header) if name in self.left]
            lines += aligned([self.header, *self.rows], left=left, rule=True)
        return escaped("\n".join([*lines, *self.remarks]))


def plain(value: Any, *, nulls: bool = False) -> Any:
    """``value`` as what JSON can hold: tuples and arrays as lists, numbers that are not finite as text.

    Args:
        value: numbers, text, arrays, and lists, tuples and dictionaries of these.
        nulls: numbers that are not finite become null instead of the text 'inf' or 'nan'.
    """
    if isinstance(value, dict):
        return {key: plain(each, nulls=nulls) for key, each in value.items()}
    if hasattr(value, "tolist"):  # NumPy's arrays and numbers
        return plain(value.tolist(), nulls=nulls)
    if isinstance(value, list | tuple):
        return [plain(each, nulls=nulls) for each in value]
    if isinstance(value, float) and not math.isfinite(value):
        return None if nulls else str(value)
    return value


def json_text(value: Any, *, nulls: bool = False) -> str:
    """Strict JSON with a line for every list of plain values; see :func:`plain`."""
    return _json_lines(plain(value, nulls=nulls), "\n") + "\n"


def _json_lines(value: Any, newline: str) -> str:
    items = list(value.values()) if isinstance(value, dict) else value if isinstance(value, list) else []
    if not items or (isinstance(value, list) and not any(isinstance(item, dict | list) for item in items)):
        return json.dumps(value, allow_nan=False)
    inner = newline + "  "
    texts = [_json_lines(item, inner) for item in items]
    if isinstance(value, list):
        return "[" + inner + ("," + inner).join(texts) + newline + "]"
    members = [f"{json.dumps(key)}: {text}" for key, text in zip(value, texts, strict=True)]
    return "{" + inner + ("," + inner).join(members) + newline + "}"
