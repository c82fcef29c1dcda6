"""Lines and tables of plain text for people."""

import re
import shutil
import textwrap
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from urdf_ik.support.text import aligned, plain
from urdf_ik.typing import Array

_PIPE_WIDTH = 120


def render(*parts: str | Sequence[str]) -> str:
    """Text of lines and of tables."""
    return "".join(f"{line}\n" for part in parts for line in ([part] if isinstance(part, str) else part))


def grid(header: Sequence[str], rows: Iterable[Sequence[Any]], *, left: Sequence[str] = ()) -> list[str]:
    """A table of texts; columns are right-aligned but for those named in ``left``."""
    cells = [[str(value) for value in row] for row in rows]
    return aligned([header, *cells], left=[k for k, name in enumerate(header) if name in left], rule=True)


def fits(lines: Sequence[str]) -> bool:
    """Whether a table is no wider than the terminal."""
    return max(map(len, lines)) <= shutil.get_terminal_size((_PIPE_WIDTH, 24)).columns


def number(value: float, digits: int = 4) -> str:
    """A number of fixed digits, without the sign of a zero; '-' for NaN."""
    text = f"{float(value):.{digits}f}"
    return "-" if text == "nan" else text.lstrip("-") if float(text) == 0.0 else text


def numbers(values: Iterable[Any], digits: int = 4) -> list[str]:
    """Numbers of fixed digits."""
    return [number(value, digits) for value in values]


def pose_lines(T: Array, digits: int = 4) -> list[str]:
    """A pose as a line of its position and one of its quaternion."""
    from urdf_ik.model.poses import to_quat_xyzw

    xyz, quat = ", ".join(numbers(T[:3, 3], digits)), ", ".join(numbers(to_quat_xyzw(T), digits))
    return [f"position ({xyz}) m", f"quaternion xyzw ({quat})"]


def folded(text: str, indent: str = "", further: str = "") -> list[str]:
    """Lines of at most 79 columns."""
    fold = textwrap.TextWrapper(79, indent, further, break_long_words=False, break_on_hyphens=False)
    return fold.wrap(text)


def facts(rows: Iterable[tuple[str, str]], width: int = 14) -> list[str]:
    """Lines of a name and a text, which is folded beside it."""
    return [line for name, text in rows for line in folded(f"{name:<{width - 1}} {text}", "", " " * width)]


def outline(data: Mapping[str, Any]) -> list[str]:
    """An answer as lines: its facts, then a table of each list of objects; what they nest is in the JSON alone."""
    lines: list[str] = []
    blocks: list[str] = []
    for key, value in plain(dict(data)).items():
        name = key.replace("_", " ")
        rows = value
        if isinstance(value, dict) and value and all(isinstance(row, dict) for row in value.values()):
            rows = [{name: each, **row} for each, row in value.items()]
        if isinstance(rows, list) and rows and isinstance(rows[0], dict):
            columns = {head: [cell(row.get(head)) for row in rows] for each in rows for head in each}
            columns = {head.replace("_", " "): texts for head, texts in columns.items() if set(texts) != {"-"}}
            words = [head for head, texts in columns.items() if any(re.search("[A-Za-z]{2}|,", text) for text in texts)]
            blocks += ["", *grid([*columns], zip(*columns.values(), strict=True), left=words)]
        elif (text := cell(value)) != "-":
            lines += facts([(name, text)], max(14, len(name) + 2))
    return [*lines, *blocks]


def cell(value: Any) -> str:
    """A value of an answer as text; '-' where there is none, and for what is nested."""
    if isinstance(value, dict):
        return ", ".join(f"{name} {cell(each)}" for name, each in value.items()) or "-"
    if isinstance(value, list):
        return "-" if any(isinstance(each, list | dict) for each in value) else ", ".join(map(cell, value)) or "-"
    if isinstance(value, bool):
        return "yes" if value else "no"
    return "-" if value in (None, "", "nan") else f"{value + 0.0:.6g}" if isinstance(value, float) else str(value)
