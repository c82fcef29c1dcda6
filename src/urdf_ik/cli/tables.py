"""Tables for people: rich where the terminal can show it, plain ASCII everywhere else."""

from __future__ import annotations

import io
import os
import shutil
import sys
import textwrap
from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Any

from urdf_ik.cli.console import Coloured
from urdf_ik.cli.options import is_terminal
from urdf_ik.errors import escaped
from urdf_ik.typing import Array

if TYPE_CHECKING:
    from rich.table import Table

_PIPE_WIDTH = 120
_PLAIN = "    \n    \n -- \n    \n    \n    \n    \n    \n"
_STYLES = {"yes": "green", "no": "red", "free": "green", "hits": "red", "FAIL": "red"}


def render(*parts: Table | str, to_file: bool = False) -> str:
    """Text of tables and lines of text, coloured for a terminal that takes colour; never cut off at its edge."""
    from rich import box
    from rich.console import Console
    from rich.table import Table

    live = is_terminal(sys.stdout) and not to_file
    width = shutil.get_terminal_size((_PIPE_WIDTH, 24)).columns
    out = io.StringIO()
    colour = live and "NO_COLOR" not in os.environ and os.environ.get("TERM") != "dumb"
    console = Console(file=out, width=width, force_terminal=colour, no_color=not colour, highlight=False, markup=False)
    for part in parts:
        if isinstance(part, Table):
            part.box = box.SIMPLE_HEAD if live and console.encoding.startswith("utf") else box.Box(_PLAIN, ascii=True)
            console.width = max(width, needed_width(part))
            console.print(part)
        else:
            out.write(escaped(part) + "\n")
    lines = out.getvalue().split("\n")
    return Coloured("\n".join(line if colour else line.rstrip() for line in lines))


def needed_width(table: Table) -> int:
    """Columns of text that the table takes without wrapping."""
    from rich.console import Console
    from rich.measure import Measurement

    wide = Console(width=10_000, file=io.StringIO())
    return Measurement.get(wide, wide.options, table).maximum


def fits(table: Table) -> bool:
    """Whether the table can be shown without wrapping."""
    return needed_width(table) <= shutil.get_terminal_size((_PIPE_WIDTH, 24)).columns


def grid(header: Sequence[str], rows: Iterable[Sequence[Any]], *, left: Sequence[str] = ()) -> Table:
    """A table of texts; columns are right-aligned but for those named in ``left``."""
    from rich import box
    from rich.table import Table
    from rich.text import Text

    table = Table(box=box.Box(_PLAIN, ascii=True), pad_edge=False, padding=(0, 1, 0, 0), show_edge=False)
    for name in header:
        table.add_column(Text(escaped(name)), justify="left" if name in left else "right", no_wrap=True)
    for row in rows:
        cells = [escaped(str(value)) for value in row]
        table.add_row(*[Text(cell, style=_STYLES.get(cell, "")) for cell in cells])
    return table


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
    return textwrap.wrap(
        text, 79, initial_indent=indent, subsequent_indent=further, break_long_words=False, break_on_hyphens=False
    )


def facts(rows: Iterable[tuple[str, str]], width: int = 15) -> list[str]:
    """Lines of a name and a text, which is folded beside it."""
    return [line for name, text in rows for line in folded(f"{name:<{width - 1}} {text}", "", " " * width)]
