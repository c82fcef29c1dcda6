"""Base classes of the reports: output as text, JSON and HTML."""

from __future__ import annotations

from dataclasses import asdict
from typing import Any

from urdf_ik.errors import escaped
from urdf_ik.support.display import html_of, short
from urdf_ik.support.text import Section, json_text, plain


def outcome(passed: bool, differs: bool) -> str:
    """How a check ended: with no fault, with some, or, without one so far, before it had looked at everything.

    Example:
        >>> outcome(False, False)
        'NOT ENDED'
    """
    return "PASSED" if passed else "FAILED" if differs else "NOT ENDED"


class Written:
    """A frozen record that is written as plain values and as JSON."""

    def to_dict(self) -> dict[str, Any]:
        """Plain lists, numbers and text; numbers that are not finite are the text 'inf', '-inf' or 'nan'.

        Example:
            >>> import urdf_ik
            >>> arm = urdf_ik.load("planar_2r")
            >>> urdf_ik.compare_many([arm], arm.fk([[0.3, -0.5]])).to_dict()["poses"]
            1
        """
        out: dict[str, Any] = plain(asdict(self))  # type: ignore[call-overload]
        return out

    def to_json(self) -> str:
        """:meth:`to_dict` as strict JSON.

        Example:
            >>> import urdf_ik
            >>> arm = urdf_ik.load("planar_2r")
            >>> urdf_ik.compare_many([arm], arm.fk([[0.3, -0.5]])).to_json()[0]
            '{'
        """
        return json_text(self.to_dict())


class Report(Written):
    """A verdict with the tables and lines that led to it."""

    @property
    def passed(self) -> bool:
        """Whether the check passed."""
        raise NotImplementedError

    def title(self) -> str:
        """The title: the subject of the check."""
        raise NotImplementedError

    def sections(self) -> tuple[Section, ...]:
        """The tables; none for a report of lines alone.

        Example:
            >>> import urdf_ik
            >>> arm = urdf_ik.load("planar_2r")
            >>> urdf_ik.freeze(arm).verify(arm).sections()
            ()
        """
        return ()

    def lines(self) -> tuple[str, ...]:
        """The findings, a line each."""
        raise NotImplementedError

    def verdict(self) -> str:
        """The last line."""
        raise NotImplementedError

    def to_dict(self) -> dict[str, Any]:
        """Plain lists, numbers and text, ``passed`` first.

        Example:
            >>> import urdf_ik
            >>> arm = urdf_ik.load("planar_2r")
            >>> urdf_ik.freeze(arm).verify(arm).to_dict()["passed"]
            True
        """
        return {"passed": self.passed, **super().to_dict()}

    def __str__(self) -> str:
        tables = [str(section) if section.title else f"\n{str(section).strip()}" for section in self.sections()]
        if tables:
            return escaped("\n".join([self.title(), *tables, "", *self.lines(), self.verdict()]))
        return escaped("\n".join([self.title(), *(f"  {line}" for line in self.lines()), self.verdict()]))

    def __repr__(self) -> str:
        return short(f"{type(self).__name__} {self.verdict()}", self.lines())

    def _repr_html_(self) -> str:
        sections = (*self.sections(), Section("", remarks=self.lines()))
        return html_of(self.title(), self.verdict(), self.passed, sections)
