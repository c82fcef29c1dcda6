"""A comparison of two arms for people: tables in mm and degrees."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Sequence

    from urdf_ik.comparison.report import Comparison, LimitChange

_MM = 1000.0


@dataclass(frozen=True)
class Section:
    """A table with a line above it and lines below it.

    Attributes:
        title: what the table shows.
        header: names of the columns.
        rows: texts, one a column; without rows there is no table.
        remarks: lines below the table.
        left: columns that are aligned to the left.
    """

    title: str
    header: tuple[str, ...] = ()
    rows: tuple[tuple[str, ...], ...] = ()
    remarks: tuple[str, ...] = ()
    left: tuple[str, ...] = ()

    def __str__(self) -> str:
        lines = [self.title]
        if self.rows:
            table = [self.header, *self.rows]
            widths = [max(map(len, column)) for column in zip(*table, strict=True)]
            aligned = [
                [
                    cell.ljust(width) if name in self.left else cell.rjust(width)
                    for name, cell, width in zip(self.header, row, widths, strict=True)
                ]
                for row in [self.header, ["-" * width for width in widths], *self.rows]
            ]
            lines += ["  ".join(row).rstrip() for row in aligned]
        return "\n".join([*lines, *self.remarks])


def sections(comparison: Comparison) -> tuple[Section, ...]:
    """Every table that has something to show."""
    made = (_structure, _frames, _limits, _reach, _branches, _tool, _notes)
    return (_sides(comparison), *(section for make in made if (section := make(comparison)) is not None))


def _sides(comparison: Comparison) -> Section:
    named = (("A", comparison.a), ("B", comparison.b))
    return Section("\n".join(f"{letter}: {s.robot}, {s.base} to {s.tip} ({s.source})" for letter, s in named))


def _structure(comparison: Comparison) -> Section:
    facts = comparison.structure
    differ = sum(not fact.same for fact in facts)
    title = f"structure: {'the same' if not differ else f'{differ} of {len(facts)} facts differ'}"
    rows = tuple((fact.what, fact.a, fact.b, "" if fact.same else "differs") for fact in facts)
    return Section(title, ("", "A", "B", " "), rows, left=("", "A", "B", " "))


def _frames(comparison: Comparison) -> Section | None:
    distance, angle = comparison.tip
    tip = f"tip at q = 0: {_mm(distance)} mm and {_deg(angle)} deg apart"
    far = "farthest sampled tip from the base: A {:.4f} m, B {:.4f} m".format(*comparison.farthest)
    rows = tuple(
        (_pair(c.joint, c.joint_b), _deg(c.angle), _mm(c.distance), "flipped" if c.flipped else "")
        for c in comparison.axes
        if c.angle or c.distance
    )
    title = "frames: " + (f"{len(rows)} of {len(comparison.axes)} axes moved" if rows else "no axis moved")
    title = title if comparison.axes else "frames"
    return Section(title, ("joint", "turned [deg]", "moved [mm]", ""), rows, (tip, far), left=("joint", ""))


def _limits(comparison: Comparison) -> Section | None:
    if not comparison.limits:
        return None
    changed = [(change, slides) for change, slides in zip(comparison.limits, comparison.a.prismatic, strict=True)
               if not change.same]  # fmt: skip
    rows = tuple((_pair(c.joint, c.joint_b), *_bounds(c, slides)) for c, slides in changed)
    title = f"limits: {f'{len(rows)} of {len(comparison.limits)} joints differ' if rows else 'the same'}"
    return Section(title, ("joint", "A lower", "A upper", "B lower", "B upper", "unit"), rows, left=("joint", "unit"))


def _reach(comparison: Comparison) -> Section | None:
    rows = []
    for reach in comparison.reach:
        for k, letter in enumerate("AB"):
            rows.append(
                (
                    f"{reach.poses} poses of {reach.made_by}",
                    letter,
                    str(reach.solved[k]),
                    str(reach.within_limits[k]),
                    str(reach.solutions[k]),
                    f"{reach.solutions[k] / reach.poses:.2f}",
                    str(reach.same_number) if k == 0 else "",
                )
            )
    header = ("asked for", "arm", "reached", "within limits", "solutions", "a pose", "equally many in both")
    return Section("reach and solutions", header, tuple(rows), left=("asked for", "arm")) if rows else None


def _branches(comparison: Comparison) -> Section | None:
    if not comparison.branches:
        return None
    slides = comparison.a.prismatic
    units = ["mm" if sliding else "deg" for sliding in slides]
    header = ("branch", "matched by", "poses", "lost", *(f"q{i + 1} [{unit}]" for i, unit in enumerate(units)), "worst")
    rows = tuple(
        (
            branch.branch,
            branch.matched,
            str(branch.poses),
            str(branch.unmatched),
            *(_value(value, sliding) for value, sliding in zip(branch.median, slides, strict=True)),
            _worst(branch.worst, slides),
        )
        for branch in comparison.branches
    )
    title = f"joint differences, branch by branch: medians over {comparison.n} poses of A, and the worst"
    return Section(title, header, rows, left=("branch", "matched by", "worst"))


def _tool(comparison: Comparison) -> Section | None:
    tool = comparison.tool
    if tool is None:
        return None
    rows = (
        ("position [mm]", *map(_mm, tool.position)),
        ("rotation [deg]", *map(_deg, tool.rotation)),
    )
    at = f"worst at q = [{', '.join(f'{value:.6g}' for value in tool.q)}] (rad, m)" if any(tool.position) else ""
    title = f"tool error when A's joint vectors ({tool.joint_vectors}) are used on B"
    return Section(title, ("", "median", "95 %", "worst"), rows, (at,) if at else (), left=("",))


def _notes(comparison: Comparison) -> Section | None:
    return (
        Section("not compared", remarks=tuple(f"- {note}" for note in comparison.notes)) if comparison.notes else None
    )


def _pair(a: str, b: str) -> str:
    return a if a == b else f"{a} / {b}"


def _bounds(change: LimitChange, slides: bool) -> tuple[str, ...]:
    numbers = [_value(value, slides) for value in (*change.a, *change.b)]
    return *numbers, "mm" if slides else "deg"


def _worst(values: Sequence[float], slides: Sequence[bool]) -> str:
    """The joint that is farthest off, with its value."""
    if math.isnan(values[0]):
        return "-"
    k = max(range(len(values)), key=lambda i: values[i])
    return f"q{k + 1} {_value(values[k], slides[k])}" if values[k] else "0"


def _value(value: float, slides: bool) -> str:
    return _mm(value) if slides else _deg(value)


def _mm(value: float) -> str:
    return _number(value * _MM)


def _deg(value: float) -> str:
    return _number(math.degrees(value))


def _number(value: float) -> str:
    """Four digits after the point, fewer for what is exact; rounding errors in the form 1e-13."""
    if math.isnan(value):
        return "-"
    if value == 0.0:
        return "0"
    return f"{value:.4g}" if abs(value) < 1e-3 else f"{value:.4f}".rstrip("0").rstrip(".")
