"""Survey: the report on many arms, one row an arm."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

from urdf_ik.errors import printable
from urdf_ik.support.text import Section
from urdf_ik.verify.reports import Report, outcome

PASSED = "passed"
"""Result of a file: every property holds."""
FAILED = "FAILED"
"""Result of a file: a property does not hold."""
REFUSED = "REFUSED"
"""Result of a file: no arm can be read from it."""
NOT_CHECKED = "not checked"
"""Result of a file: no check is for such an arm."""
NOT_AN_ARM = "not an arm"
"""Result of a file: no chain of joints is in it, as in a URDF of obstacles."""
NOT_ENDED = "not ended"
"""Result of a file: the time limit passed during its check, which had found no fault."""
RESULTS = (PASSED, FAILED, REFUSED, NOT_ENDED, NOT_CHECKED, NOT_AN_ARM)

_HEADER = ("file", "joints", "family", "found", "result")


@dataclass(frozen=True)
class Checked:
    """One file, checked.

    Attributes:
        file: its name, as given.
        result: one of ``RESULTS``.
        robot: the robot's name; '' for a file that cannot be read, as are base, tip and family.
        base: base link.
        tip: tip link.
        joints: number of joints from base to tip.
        family: the family that solves the arm.
        found: the figure that the check ends with.
        words: what failed, was left out, or why the arm was not checked; '' for an arm that passed.
        report: the whole report as plain values, or None.
    """

    file: str
    result: str
    robot: str = ""
    base: str = ""
    tip: str = ""
    joints: int = 0
    family: str = ""
    found: str = ""
    words: str = ""
    report: dict[str, Any] | None = field(default=None, repr=False)

    def cells(self) -> tuple[str, ...]:
        """The row of a table, under file, joints, family, found and result; the family's name without its details.

        Example:
            >>> Checked("arm.urdf", PASSED, joints=6, family="6R general", found="2e-16 m").cells()
            ('arm.urdf', '6', '6R general', '2e-16 m', 'passed')
        """
        family = self.family.split(",")[0].split(":")[0]
        return printable(self.file, 200), str(self.joints or ""), family, self.found, self.result


@dataclass(frozen=True, repr=False)
class Survey(Report):
    """Many arms, checked in the same way.

    Attributes:
        question: what was asked of each, as JSON can hold it.
        arms: one a file that was looked at, in the order given.
        unlooked: what the time limit left out; '' where every file was looked at.

    Example:
        >>> from urdf_ik.model import catalogue
        >>> from urdf_ik.verify import surveys
        >>> found = surveys.survey([catalogue.resolve("planar_2r").path], n=5)
        >>> found.arms[0].robot, found.arms[0].joints
        ('planar_2r', 2)
    """

    question: dict[str, Any]
    arms: tuple[Checked, ...]
    unlooked: str = ""

    @property
    def passed(self) -> bool:
        """Whether nothing failed, was refused or left out; what no check is for, and what is no arm, does not count."""
        good = all(each.result in (PASSED, NOT_CHECKED, NOT_AN_ARM) for each in self.arms)
        return good and not self.unlooked

    def count(self, result: str) -> int:
        """Number of arms with that result.

        Example:
            >>> Survey({}, (Checked("arm.urdf", PASSED),)).count(FAILED)
            0
        """
        return sum(each.result == result for each in self.arms)

    def verdict(self) -> str:
        """The last line: how many passed, failed, were refused, not ended, not checked or no arm.

        Example:
            >>> Survey({}, (Checked("a.urdf", PASSED), Checked("b.urdf", REFUSED, words="empty"))).verdict()
            'FAILED: 2 files: 1 passed, 1 refused'
        """
        counts = [(self.count(result), result.lower()) for result in RESULTS]
        parts = ", ".join(f"{count} {word}" for count, word in counts if count)
        ended = outcome(self.passed, bool(self.count(FAILED) or self.count(REFUSED)))
        return f"{ended}: {self.title()}: " + "; ".join(part for part in (parts, self.unlooked) if part)

    def title(self) -> str:
        """The number of files.

        Example:
            >>> Survey({}, (Checked("arm.urdf", PASSED),)).title()
            '1 file'
        """
        return "1 file" if len(self.arms) == 1 else f"{len(self.arms)} files"

    def sections(self) -> tuple[Section, ...]:
        """A table with a row a file.

        Example:
            >>> Survey({}, (Checked("arm.urdf", PASSED),)).sections()[0].rows[0][-1]
            'passed'
        """
        rows = tuple(each.cells() for each in self.arms)
        return (Section("", _HEADER, rows, left=("file", "family", "found", "result")),)

    def lines(self) -> tuple[str, ...]:
        """What failed, or why an arm was not checked.

        Example:
            >>> Survey({}, (Checked("arm.urdf", REFUSED, words="empty"),)).lines()
            ('REFUSED arm.urdf: empty',)
        """
        return tuple(f"{each.result} {printable(each.file, 200)}: {each.words}" for each in self.arms if each.words)
