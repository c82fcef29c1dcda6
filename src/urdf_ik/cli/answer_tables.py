"""Solutions as tables for people."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from urdf_ik.cli import tables
from urdf_ik.cli.answers import CheckedSolutions, redundancy_shown
from urdf_ik.cli.console import Angles

if TYPE_CHECKING:
    from rich.table import Table

SUMMARY_ABOVE = 20
"""A table shows the solutions of at most this many poses."""


def text_of(answer: CheckedSolutions, angles: Angles, note: str, *, to_file: bool) -> str:
    """The solutions of a few poses, or a summary of many."""
    arm = answer.arm
    head = [f"{arm.name}: {arm.base} to {arm.tip}, {arm.structure.family}", *tables.folded(note)]
    head += [] if arm.redundancy is None else tables.folded(f"redundancy: {arm.redundancy}")
    head += tables.folded(f"self-collision was not checked: {answer.unchecked}") if answer.unchecked else []
    head += tables.folded(f"errors were not measured: {answer.unmeasured}") if answer.unmeasured else []
    if len(answer.poses) > SUMMARY_ABOVE:
        return tables.render(*head, "", *_summary(answer, angles), to_file=to_file)
    named = zip(arm.joint_names, angles.units, strict=True)
    legend = "joints: " + ", ".join(f"q{i} {name} [{unit}]" for i, (name, unit) in enumerate(named, 1))
    parts: list[Table | str] = [*head, *tables.folded(legend, further=" " * 8)]
    for i, pose in enumerate(answer.poses):
        count = int(answer.counts[i])
        heading = f"{count} solution{'s' * (count != 1)}" if count else "no solution"
        heading += _redundancy(answer, angles, i)
        lines = tables.pose_lines(pose)
        lines[0] = lines[0] if len(answer.poses) == 1 else f"pose {i}: {lines[0]}"
        parts += ["", *lines, f"{heading}:", "", *_solutions(answer, angles, i)]
    return tables.render(*parts, to_file=to_file)


def _redundancy(answer: CheckedSolutions, angles: Angles, pose: int) -> str:
    """The value of each redundancy parameter in words."""
    at, arm = answer.solutions.redundancy, answer.arm
    if at is None:
        return ""
    values = np.atleast_1d(redundancy_shown(arm, at[pose], angles)) + 0.0
    parts = [
        f"{parameter.label} {float(x):.4f} {angles.unit if parameter.unit == 'rad' else 'm'}"
        for parameter, x in zip(arm.solver.parameters, values, strict=True)
    ]
    return f" at {', '.join(parts)}"


def _solutions(answer: CheckedSolutions, angles: Angles, pose: int) -> list[Table | str]:
    """Every solution of one pose: branch, joint values, checks; in two tables where one would be too wide."""
    places = answer.places(pose)
    if not len(places):
        return [answer.explanation(pose)]
    names, cells = _branch_columns([answer.solutions.names[pose, b] for b in places])
    q = angles.shown(answer.solutions.q[pose])
    values = [[str(k + 1), *cells[k], *tables.numbers(q[b], 2 if angles.degrees else 4)] for k, b in enumerate(places)]
    header = ["#", *names, *(f"q{i + 1}" for i in range(q.shape[-1]))]
    check_header, checks = _check_columns(answer, angles, pose)
    both = tables.grid([*header, *check_header], [v + c for v, c in zip(values, checks, strict=True)], left=names)
    notes: list[Table | str] = []
    for k, b in enumerate(places, 1):
        if pairs := answer.hits.get((pose, int(b))):
            notes.append(f"{k} hits: {', '.join(f'{first} - {second}' for first, second in pairs)}")
    if answer.distances is not None:
        notes += ["", *(_distance_line(answer, angles, pose, int(b)) for b in places)]
    notes = ["", *notes] if notes and notes[0] else notes
    if tables.fits(both):
        return [both, *notes]
    numbered = [[str(k), *row] for k, row in enumerate(checks, 1)]
    return [tables.grid(header, values, left=names), "", tables.grid(["#", *check_header], numbered), *notes]


def _distance_line(answer: CheckedSolutions, angles: Angles, pose: int, column: int) -> str:
    """How far a solution is from the reference, and the joint that has the longest way."""
    assert answer.distances is not None
    far, apart = answer.distances, np.abs(answer.distances.joints[pose, column])
    k = int(np.argmax(apart))
    distance = f"{far.each[pose, column]:.4g} {far.unit} ({far.metric})"
    return f"from --nearest: {distance}; farthest joint: q{k + 1}, {apart[k]:.4g} {angles.units[k]}"


def _summary(answer: CheckedSolutions, angles: Angles) -> list[Table | str]:
    """Many poses in a few lines: how many were solved, how many solutions they have, the worst error."""
    counts = answer.counts
    solved, total = int((counts > 0).sum()), int(counts.sum())
    lines = [f"{len(counts)} poses, {solved} solved, {len(counts) - solved} without a solution, {total} solutions"]
    within, turned = int(answer.within.sum()), int(answer.turned.sum())
    lines.append(f"within limits: {within} of {total} solutions, {turned} more by whole turns")
    if answer.free is not None:
        lines.append(f"free of self-collision: {int(answer.free.sum())} of {total} solutions")
    singular = int(((answer.solutions.singular != 0) & answer.solutions.valid).sum())
    lines.append(f"singular: {singular} of {total} solutions")
    if answer.errors is not None and total:
        position, rotation = (np.nanmax(error) for error in answer.errors)
        worst = f"{position:.1e} m, {angles.angle(rotation):.1e} {angles.unit}"
        lines.append(f"worst error as Pinocchio measures it: {worst}")
    if answer.distances is not None and total:
        far = answer.distances
        where = np.unravel_index(int(np.nanargmax(far.each)), far.each.shape)[0]
        lines.append(f"farthest from --nearest ({far.metric}): {np.nanmax(far.each):.4g} {far.unit}, pose {where}")
    if solved < len(counts):
        first = int(np.flatnonzero(counts == 0)[0])
        lines.append(f"first pose without a solution: {first}: {answer.explanation(first)}")
    numbers, poses = np.unique(counts, return_counts=True)
    rows = [[c, p, "#" * max(1, round(40 * p / poses.max()))] for c, p in zip(numbers, poses, strict=True)]
    return [*lines, "", tables.grid(["solutions", "poses", "share"], rows, left=["share"])]


def _check_columns(answer: CheckedSolutions, angles: Angles, pose: int) -> tuple[list[str], list[list[Any]]]:
    header = ["in limits"]
    header += [] if answer.free is None else ["collision"]
    header += ["singular"]
    header += [] if answer.errors is None else ["error [m]", f"error [{angles.unit}]"]
    rows = []
    for b in answer.places(pose):
        row = ["yes" if answer.within[pose, b] else "by turns" if answer.turned[pose, b] else "no"]
        if answer.free is not None:
            row.append("free" if answer.free[pose, b] else "hits")
        row.append(", ".join(answer.flags(pose, b)) or "-")
        if answer.errors is not None:
            position, rotation = answer.errors
            row += [f"{position[pose, b]:.1e}", f"{angles.angle(rotation[pose, b]):.1e}"]
        rows.append(row)
    return header, rows


def _branch_columns(branches: Sequence[str]) -> tuple[list[str], list[list[str]]]:
    """Names like 'shoulder front, elbow up' as columns 'shoulder' and 'elbow'; other names as one column."""
    parts = [[part.partition(" ")[::2] for part in name.split(", ")] for name in branches]
    heads = [tuple(head for head, _ in each) for each in parts]
    if len(set(heads)) == 1 and all(value for each in parts for _, value in each):
        return list(heads[0]), [[value for _, value in each] for each in parts]
    return ["branch"], [[name] for name in branches]
