"""Tables for people: rich where the terminal can show it, plain ASCII everywhere else."""

from __future__ import annotations

import io
import os
import shutil
import sys
from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from urdf_ik.cli.console import Coloured
from urdf_ik.cli.options import is_terminal
from urdf_ik.errors import escaped

if TYPE_CHECKING:
    from rich.table import Table
    from rich.text import Text

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
        table.add_row(*[_cell(value) for value in row])
    return table


def number(value: float, digits: int = 4) -> str:
    """A number of fixed digits, without the sign of a zero."""
    text = f"{value:.{digits}f}"
    return text.lstrip("-") if float(text) == 0.0 else text


def matrix(T: NDArray[np.float64]) -> str:
    """A pose as four lines."""
    return "\n".join("  ".join(f"{number(float(x), 6):>10}" for x in row) for row in T)


def pose_line(T: NDArray[np.float64], digits: int = 4) -> str:
    """A pose as position and quaternion on one line."""
    from urdf_ik.model.poses import to_quat_xyzw

    xyz = ", ".join(number(float(x), digits) for x in T[:3, 3])
    quat = ", ".join(number(float(x), digits) for x in to_quat_xyzw(T))
    return f"position ({xyz}) m\nquaternion xyzw ({quat})"


def folded(lead: str, parts: Sequence[str], comma: str = ", ", width: int = 79) -> list[str]:
    """Parts joined over as many lines as they take, indented under the lead."""
    lines, line = [], lead
    for i, part in enumerate(parts):
        text = part + (comma if i + 1 < len(parts) else "")
        if len(line) + len(text.rstrip()) > width and line.strip():
            lines.append(line.rstrip())
            line = " " * len(lead)
        line += text
    return [*lines, line]


def _cell(value: Any) -> Text:
    from rich.text import Text

    text = escaped(str(value))
    return Text(text, style=_STYLES.get(text, ""))
