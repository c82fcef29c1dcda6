"""Report: the result of a cross-check, one row a property, each with its worst case."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass, fields
from typing import Any

from urdf_ik.errors import ArgumentError, printable
from urdf_ik.support.text import Section, quoted
from urdf_ik.verify import reports
from urdf_ik.verify.reports import outcome

_HEADER = ("property", "worst", "tolerance", "unit", "checked", "result")


@dataclass(frozen=True)
class Row:
    """One property of an arm, held against Pinocchio.

    Attributes:
        name: the property.
        unit: unit of ``worst`` and ``tolerance``.
        worst: the worst value found, infinite where something was missing or not a number; a number of cases for the
            properties that are counted.
        tolerance: the most that is accepted; where it depends on the pose, that of the worst one.
        passed: whether every value was accepted.
        checked: how many values were compared.
        index: number of the pose in which the worst value, or the first counted case, was found; None where there is
            no such pose.
        q: joint vector (n,) [rad or m] at which it was found.
        detail: branch, link or joint that it belongs to, or what was missing.
    """

    name: str
    unit: str
    worst: float
    tolerance: float
    passed: bool
    checked: int
    index: int | None = None
    q: tuple[float, ...] | None = None
    detail: str = ""

    def cells(self) -> tuple[str, ...]:
        """The row of a table, under property, worst, tolerance, unit, checked and result.

        Example:
            >>> Row("forward kinematics, position", "m", 2e-16, 1e-9, passed=True, checked=200).cells()
            ('forward kinematics, position', '2e-16', '1e-09', 'm', '200', 'passed')
        """
        result = "passed" if self.passed else "FAILED"
        return self.name, f"{self.worst:.2g}", f"{self.tolerance:.2g}", self.unit, str(self.checked), result

    def place(self) -> str:
        """Where the worst value was found, in words.

        Example:
            >>> Row("forward kinematics, position", "m", 2e-3, 1e-9, False, 200, index=7, q=(0.1, 0.2)).place()
            'pose 7, q = [0.1, 0.2]'
        """
        parts = [
            "" if self.index is None else f"pose {self.index}",
            self.detail,
            "" if self.q is None else f"q = [{', '.join(map(repr, self.q))}]",
        ]
        return ", ".join(filter(None, parts))


@dataclass(frozen=True, repr=False)
class Report(reports.Report):
    """An arm of this package against Pinocchio.

    Attributes:
        robot: the robot's name.
        base: base link.
        tip: tip link.
        joint_names: joints of a joint vector, base to tip.
        n: number of random poses.
        seed: seed of the joint vectors that made them.
        reference: name and version of the reference.
        rows: one a property.
        skipped: (property, reason) of what could not be checked.
        unlooked: what the time limit left out; '' where every pose was checked.

    Example:
        >>> import urdf_ik
        >>> from urdf_ik.verify import crosscheck
        >>> report = crosscheck.check(urdf_ik.load("planar_2r"), n=5)
        >>> report.passed, report.skipped
        (True, ())
    """

    robot: str
    base: str
    tip: str
    joint_names: tuple[str, ...]
    n: int
    seed: int
    reference: str
    rows: tuple[Row, ...]
    skipped: tuple[tuple[str, str], ...] = ()
    unlooked: str = ""

    @property
    def passed(self) -> bool:
        """Whether every property that was checked holds for all poses; ``skipped`` says what was not checked."""
        return not self.failed and not self.unlooked

    @property
    def failed(self) -> tuple[Row, ...]:
        """The rows that did not pass."""
        return tuple(row for row in self.rows if not row.passed)

    def row(self, name: str) -> Row:
        """The row of a property.

        Raises:
            ArgumentError: there is no such row; the message lists the rows.

        Example:
            >>> import urdf_ik
            >>> from urdf_ik.verify import crosscheck
            >>> row = crosscheck.check(urdf_ik.load("planar_2r"), n=5).row("solutions, position")
            >>> row.passed, row.unit
            (True, 'm')
        """
        for row in self.rows:
            if isinstance(name, str) and row.name == name:
                return row
        raise ArgumentError(f"no row {quoted(name)}; rows: {', '.join(row.name for row in self.rows)}")

    @classmethod
    def from_dict(cls, data: Mapping[str, Any]) -> Report:
        """The report that :meth:`to_dict` wrote.

        Raises:
            ArgumentError: it is none.

        Example:
            >>> import urdf_ik
            >>> from urdf_ik.verify import crosscheck
            >>> report = crosscheck.check(urdf_ik.load("planar_2r"), n=5)
            >>> Report.from_dict(report.to_dict()) == report
            True
        """
        try:
            return cls._of(data)
        except Exception as error:  # of whatever was not written by ``to_dict``
            reason = printable(f"{type(error).__name__} {error}", 200)
            raise ArgumentError(f"this is no report that to_dict() or to_json() wrote: {reason}") from None

    @classmethod
    def _of(cls, data: Mapping[str, Any]) -> Report:
        own = {field.name: data[field.name] for field in fields(cls)}
        own["joint_names"] = tuple(own["joint_names"])
        own["skipped"] = tuple((name, reason) for name, reason in own["skipped"])
        own["rows"] = tuple(
            Row(
                **{
                    **row,
                    "worst": float(row["worst"]),
                    "tolerance": float(row["tolerance"]),
                    "q": None if row["q"] is None else tuple(float(value) for value in row["q"]),
                }
            )
            for row in own["rows"]
        )
        return cls(**own)

    @classmethod
    def from_json(cls, text: str) -> Report:
        """The report that :meth:`to_json` wrote.

        Raises:
            ArgumentError: it is none.

        Example:
            >>> import urdf_ik
            >>> from urdf_ik.verify import crosscheck
            >>> report = crosscheck.check(urdf_ik.load("planar_2r"), n=5)
            >>> Report.from_json(report.to_json()) == report
            True
        """
        try:
            data = json.loads(text)
        except Exception as error:  # the same
            raise ArgumentError(f"this is no report that to_json() wrote: {printable(error, 200)}") from None
        return cls.from_dict(data)

    def title(self) -> str:
        """The title: the arm and the reference.

        Example:
            >>> import urdf_ik
            >>> from urdf_ik.verify import crosscheck
            >>> crosscheck.check(urdf_ik.load("planar_2r"), n=5).title().split(", against")[0]
            'planar_2r, base_link to tool0: 5 random poses, seed 0'
        """
        poses = "1 random pose" if self.n == 1 else f"{self.n} random poses"
        return f"{self.robot}, {self.base} to {self.tip}: {poses}, seed {self.seed}, against {self.reference}"

    def sections(self) -> tuple[Section, ...]:
        """A table with a row a property.

        Example:
            >>> import urdf_ik
            >>> from urdf_ik.verify import crosscheck
            >>> crosscheck.check(urdf_ik.load("planar_2r"), n=5).sections()[0].rows[0][0]
            'joints and limits'
        """
        rows = tuple(row.cells() for row in self.rows)
        return (Section("", _HEADER, rows, left=("property", "unit", "result")),)

    def lines(self) -> tuple[str, ...]:
        """What was not checked, where each failure is, and how to replay it.

        Example:
            >>> import urdf_ik
            >>> from urdf_ik.verify import crosscheck
            >>> crosscheck.check(urdf_ik.load("planar_2r"), n=5).lines()
            ()
        """
        lines = [f"not checked: {name}: {reason}" for name, reason in self.skipped]
        lines += [f"FAILED {row.name}: {row.place() or 'nowhere in particular'}" for row in self.failed]
        at = next((row.index for row in self.failed if row.index is not None), None)
        if at is not None:
            lines.append(
                f"replay: q, T = urdf_ik.verify.crosscheck.replay(arm, seed={self.seed}, index={at})"
            )
        return tuple(lines)

    def verdict(self) -> str:
        """The last line: how many properties hold.

        Example:
            >>> import urdf_ik
            >>> from urdf_ik.verify import crosscheck
            >>> crosscheck.check(urdf_ik.load("planar_2r"), n=5).verdict().split(":")[0]
            'PASSED'
        """
        held = sum(row.passed for row in self.rows)
        left_out = f"; {self.unlooked}" if self.unlooked else ""
        return f"{outcome(self.passed, bool(self.failed))}: {held} of {len(self.rows)} properties hold{left_out}"
