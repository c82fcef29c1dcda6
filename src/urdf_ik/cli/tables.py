"""Tables for people: rich where the terminal can show it, plain ASCII everywhere else."""

from __future__ import annotations

import io
import os
import shutil
import sys
from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from rich import box
from rich.console import Console
from rich.measure import Measurement
from rich.table import Table
from rich.text import Text

from urdf_ik.cli import answers, free_value
from urdf_ik.cli.console import Coloured
from urdf_ik.cli.options import is_terminal
from urdf_ik.errors import escaped

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from urdf_ik.cli.answers import Answer
    from urdf_ik.cli.console import Angles

SUMMARY_ABOVE = 20
_PIPE_WIDTH = 120
_PLAIN = box.Box("    \n    \n -- \n    \n    \n    \n    \n    \n", ascii=True)
_STYLES = {"yes": "green", "no": "red", "free": "green", "hits": "red", "FAIL": "red"}


def render(*parts: Table | str, to_file: bool = False) -> str:
    """Text of tables and lines of text, coloured for a terminal that takes colour; never cut off at its edge."""
    live = is_terminal(sys.stdout) and not to_file
    width = shutil.get_terminal_size((_PIPE_WIDTH, 24)).columns
    out = io.StringIO()
    colour = live and "NO_COLOR" not in os.environ and os.environ.get("TERM") != "dumb"
    console = Console(file=out, width=width, force_terminal=colour, no_color=not colour, highlight=False, markup=False)
    for part in parts:
        if isinstance(part, Table):
            part.box = box.SIMPLE_HEAD if live and console.encoding.startswith("utf") else _PLAIN
            console.width = max(width, needed_width(part))
            console.print(part)
        else:
            out.write(escaped(part) + "\n")
    lines = out.getvalue().split("\n")
    return Coloured("\n".join(line if colour else line.rstrip() for line in lines))


def needed_width(table: Table) -> int:
    """Columns of text that the table takes without wrapping."""
    wide = Console(width=10_000, file=io.StringIO())
    return Measurement.get(wide, wide.options, table).maximum


def fits(table: Table) -> bool:
    """Whether the table can be shown without wrapping."""
    return needed_width(table) <= shutil.get_terminal_size((_PIPE_WIDTH, 24)).columns


def grid(header: Sequence[str], rows: Iterable[Sequence[Any]], *, left: Sequence[str] = ()) -> Table:
    """A table of texts; columns are right-aligned but for those named in ``left``."""
    table = Table(box=_PLAIN, pad_edge=False, padding=(0, 1, 0, 0), show_edge=False)
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


def answer_text(answer: Answer, angles: Angles, note: str, *, to_file: bool) -> str:
    """The solutions of a few poses, or a summary of many."""
    arm = answer.arm
    head = [f"{arm.name}: {arm.base} to {arm.tip}, {arm.structure.family}", *_folded("", note.split(" "), " ")]
    if arm.redundancy is not None:
        head += _folded("", f"redundancy: {arm.redundancy}".split(" "), " ")
    if answer.unchecked:
        head += _folded("", f"self-collision was not checked: {answer.unchecked}".split(" "), " ")
    if len(answer.poses) > SUMMARY_ABOVE:
        return render(*head, "", *summary(answer, angles), to_file=to_file)
    parts: list[Table | str] = [*head, legend(answer, angles)]
    for i, pose in enumerate(answer.poses):
        title = "" if len(answer.poses) == 1 else f"pose {i}: "
        count = int(answer.counts[i])
        found = f"{count} solution{'' if count == 1 else 's'}" if count else "no solution"
        at = answer.solutions.redundancy
        found += "" if at is None else f" at {free_value.line(arm, at[i], angles)}"
        parts += ["", *(f"{title}{pose_line(pose)}".split("\n")), f"{found}:", "", *solutions_of(answer, angles, i)]
    return render(*parts, to_file=to_file)


def solutions_of(answer: Answer, angles: Angles, pose: int) -> list[Table | str]:
    """Every solution of one pose: branch, joint values, checks; in two tables where one would be too wide."""
    places = answer.places(pose)
    if not len(places):
        return [answers.explanation(answer, pose)]
    names, cells = _branch_columns([answer.names[pose, b] for b in places])
    digits = 2 if angles.degrees else 4
    n = len(answer.arm.joint_names)
    q = angles.shown(answer.solutions.q[pose])
    values = [[str(k + 1), *cells[k], *(number(float(x), digits) for x in q[b])] for k, b in enumerate(places)]
    value_header = ["#", *names, *(f"q{i + 1}" for i in range(n))]
    check_header, checks = _check_columns(answer, angles, pose)
    both = grid([*value_header, *check_header], [v + c for v, c in zip(values, checks, strict=True)], left=names)
    pairs = [(k, answer.hits.get((pose, int(b)), ())) for k, b in enumerate(places)]
    hits = [f"{k + 1} hits: {', '.join(f'{one} - {other}' for one, other in some)}" for k, some in pairs if some]
    notes: list[Table | str] = ["", *hits] if hits else []
    if fits(both):
        return [both, *notes]
    numbered = [[str(k + 1), *row] for k, row in enumerate(checks)]
    return [grid(value_header, values, left=names), "", grid(["#", *check_header], numbered), *notes]


def legend(answer: Answer, angles: Angles) -> str:
    """The joint behind each column of joint values, with its unit."""
    units = [angles.unit if turning else "m" for turning in angles.turning]
    named = zip(answer.arm.joint_names, units, strict=True)
    parts = [f"q{i + 1} {name} [{unit}]" for i, (name, unit) in enumerate(named)]
    return "\n".join(_folded("joints: ", parts))


def summary(answer: Answer, angles: Angles) -> list[Table | str]:
    """Many poses in a few lines: how many were solved, how many solutions they have, the worst error."""
    counts = answer.counts
    solved = int((counts > 0).sum())
    total = int(counts.sum())
    lines = [f"{len(counts)} poses, {solved} solved, {len(counts) - solved} without a solution, {total} solutions"]
    within, turned = int(answer.within.sum()), int(answer.turned.sum())
    lines.append(f"within limits: {within} of {total} solutions, {turned} more by whole turns")
    if answer.free is not None:
        lines.append(f"free of self-collision: {int(answer.free.sum())} of {total} solutions")
    singular = int(((answer.singular != 0) & answer.valid).sum())
    lines.append(f"singular: {singular} of {total} solutions")
    if answer.position_error is not None and answer.rotation_error is not None and total:
        position, rotation = np.nanmax(answer.position_error), np.nanmax(answer.rotation_error)
        lines.append(
            f"worst error as Pinocchio measures it: {position:.1e} m, {angles.angle(rotation):.1e} {angles.unit}"
        )
    if solved < len(counts):
        first = int(np.flatnonzero(counts == 0)[0])
        lines.append(f"first pose without a solution: {first}: {answers.explanation(answer, first)}")
    found, poses = np.unique(counts, return_counts=True)
    longest = int(poses.max())
    rows = [[str(c), str(p), "#" * max(1, round(40 * p / longest))] for c, p in zip(found, poses, strict=True)]
    return [*lines, "", grid(["solutions", "poses", "share"], rows, left=["share"])]


def _check_columns(answer: Answer, angles: Angles, pose: int) -> tuple[list[str], list[list[str]]]:
    header = ["in limits"]
    header += [] if answer.free is None else ["collision"]
    header += ["singular"]
    header += [] if answer.position_error is None else ["error [m]", f"error [{angles.unit}]"]
    rows = []
    for b in answer.places(pose):
        row = ["yes" if answer.within[pose, b] else "by turns" if answer.turned[pose, b] else "no"]
        if answer.free is not None:
            row.append("free" if answer.free[pose, b] else "hits")
        row.append(", ".join(answers.flags(answer.singular[pose, b])) or "-")
        if answer.position_error is not None and answer.rotation_error is not None:
            row.append(f"{answer.position_error[pose, b]:.1e}")
            row.append(f"{angles.angle(answer.rotation_error[pose, b]):.1e}")
        rows.append(row)
    return header, rows


def _branch_columns(branches: Sequence[str]) -> tuple[list[str], list[list[str]]]:
    """Names like 'shoulder front, elbow up' as columns 'shoulder' and 'elbow'; other names as one column."""
    split = [[part.partition(" ")[::2] for part in name.split(", ")] for name in branches]
    heads = [tuple(head for head, _ in parts) for parts in split]
    if len(set(heads)) == 1 and all(value for parts in split for _, value in parts):
        return list(heads[0]), [[value for _, value in parts] for parts in split]
    return ["branch"], [[name] for name in branches]


def _folded(lead: str, parts: Sequence[str], comma: str = ", ", width: int = 79) -> list[str]:
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
    text = escaped(str(value))
    return Text(text, style=_STYLES.get(text, ""))
