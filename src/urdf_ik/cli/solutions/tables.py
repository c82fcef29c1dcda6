"""Solutions as tables for people."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from urdf_ik.cli import tables
from urdf_ik.cli.console import Angles
from urdf_ik.cli.solutions import checked, redundancy
from urdf_ik.cli.solutions.checked import CheckedSolutions

if TYPE_CHECKING:
    from rich.table import Table

SUMMARY_ABOVE = 20
"""A table shows the solutions of at most this many poses."""


def text_of(answer: CheckedSolutions, angles: Angles, note: str, *, to_file: bool) -> str:
    """The solutions of a few poses, or a summary of many."""
    arm = answer.arm
    head = [f"{arm.name}: {arm.base} to {arm.tip}, {arm.structure.family}", *tables.folded("", note.split(" "), " ")]
    if arm.redundancy is not None:
        head += tables.folded("", f"redundancy: {arm.redundancy}".split(" "), " ")
    if answer.unchecked:
        head += tables.folded("", f"self-collision was not checked: {answer.unchecked}".split(" "), " ")
    if answer.unmeasured:
        head += tables.folded("", f"errors were not measured: {answer.unmeasured}".split(" "), " ")
    if len(answer.poses) > SUMMARY_ABOVE:
        return tables.render(*head, "", *summary(answer, angles), to_file=to_file)
    parts: list[Table | str] = [*head, legend(answer, angles)]
    for i, pose in enumerate(answer.poses):
        title = "" if len(answer.poses) == 1 else f"pose {i}: "
        count = int(answer.counts[i])
        heading = f"{count} solution{'' if count == 1 else 's'}" if count else "no solution"
        at = answer.solutions.redundancy
        heading += "" if at is None else f" at {redundancy.line(arm, at[i], angles)}"
        parts += [
            "",
            *(f"{title}{tables.pose_line(pose)}".split("\n")),
            f"{heading}:",
            "",
            *solutions_of(answer, angles, i),
        ]
    return tables.render(*parts, to_file=to_file)


def counted(answer: CheckedSolutions) -> str:
    """How many solutions of how many poses."""
    total, poses = int(answer.counts.sum()), len(answer.counts)
    return f"{total} solution{'s' * (total != 1)} of {poses} pose{'s' * (poses != 1)}"


def solutions_of(answer: CheckedSolutions, angles: Angles, pose: int) -> list[Table | str]:
    """Every solution of one pose: branch, joint values, checks; in two tables where one would be too wide."""
    places = answer.places(pose)
    if not len(places):
        return [checked.explanation(answer, pose)]
    names, cells = _branch_columns([answer.names[pose, b] for b in places])
    digits = 2 if angles.degrees else 4
    n = len(answer.arm.joint_names)
    q = angles.shown(answer.solutions.q[pose])
    values = [[str(k + 1), *cells[k], *(tables.number(float(x), digits) for x in q[b])] for k, b in enumerate(places)]
    value_header = ["#", *names, *(f"q{i + 1}" for i in range(n))]
    check_header, checks = _check_columns(answer, angles, pose)
    both = tables.grid([*value_header, *check_header], [v + c for v, c in zip(values, checks, strict=True)], left=names)
    pairs = [(k, answer.hits.get((pose, int(b)), ())) for k, b in enumerate(places)]
    hits = [f"{k + 1} hits: {', '.join(f'{one} - {other}' for one, other in some)}" for k, some in pairs if some]
    notes: list[Table | str] = ["", *hits] if hits else []
    if answer.distances is not None:
        notes += ["", *(_distance_line(answer, angles, pose, int(b)) for b in places)]
    if tables.fits(both):
        return [both, *notes]
    numbered = [[str(k + 1), *row] for k, row in enumerate(checks)]
    return [tables.grid(value_header, values, left=names), "", tables.grid(["#", *check_header], numbered), *notes]


def _distance_line(answer: CheckedSolutions, angles: Angles, pose: int, column: int) -> str:
    """How far a solution is from the reference, and the joint that has the longest way."""
    assert answer.distances is not None
    far, apart = answer.distances, np.abs(answer.distances.joints[pose, column])
    k = int(np.argmax(apart))
    unit = angles.unit if angles.turning[k] else "m"
    return (
        f"from --nearest: {far.each[pose, column]:.4g} {far.unit} ({far.metric}); farthest joint: q{k + 1}, "
        f"{apart[k]:.4g} {unit}"
    )


def legend(answer: CheckedSolutions, angles: Angles) -> str:
    """The joint behind each column of joint values, with its unit."""
    units = [angles.unit if turning else "m" for turning in angles.turning]
    named = zip(answer.arm.joint_names, units, strict=True)
    parts = [f"q{i + 1} {name} [{unit}]" for i, (name, unit) in enumerate(named)]
    return "\n".join(tables.folded("joints: ", parts))


def summary(answer: CheckedSolutions, angles: Angles) -> list[Table | str]:
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
    if answer.distances is not None and total:
        far, unit = answer.distances.each, answer.distances.unit
        where = np.unravel_index(int(np.nanargmax(far)), far.shape)[0]
        lines.append(f"farthest from --nearest ({answer.distances.metric}): {np.nanmax(far):.4g} {unit}, pose {where}")
    if solved < len(counts):
        first = int(np.flatnonzero(counts == 0)[0])
        lines.append(f"first pose without a solution: {first}: {checked.explanation(answer, first)}")
    numbers, poses = np.unique(counts, return_counts=True)
    longest = int(poses.max())
    rows = [[str(c), str(p), "#" * max(1, round(40 * p / longest))] for c, p in zip(numbers, poses, strict=True)]
    return [*lines, "", tables.grid(["solutions", "poses", "share"], rows, left=["share"])]


def _check_columns(answer: CheckedSolutions, angles: Angles, pose: int) -> tuple[list[str], list[list[str]]]:
    header = ["in limits"]
    header += [] if answer.free is None else ["collision"]
    header += ["singular"]
    header += [] if answer.position_error is None else ["error [m]", f"error [{angles.unit}]"]
    rows = []
    for b in answer.places(pose):
        row = ["yes" if answer.within[pose, b] else "by turns" if answer.turned[pose, b] else "no"]
        if answer.free is not None:
            row.append("free" if answer.free[pose, b] else "hits")
        row.append(", ".join(checked.flags(answer.singular[pose, b])) or "-")
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
