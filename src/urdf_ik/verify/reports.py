"""Base classes of the reports: output as text, JSON, HTML and JUnit XML."""

from __future__ import annotations

from dataclasses import asdict
from html import escape
from typing import TYPE_CHECKING, Any

from urdf_ik.errors import escaped, printable
from urdf_ik.support.text import Section, json_text, plain

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

_SHORT_LINES = 4
_GOOD, _BAD = "#2e7d32", "#c62828"


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
    """A verdict with the lines that led to it."""

    @property
    def passed(self) -> bool:
        """Whether the check passed."""
        raise NotImplementedError

    def title(self) -> str:
        """The title: the subject of the check."""
        raise NotImplementedError

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
        return escaped("\n".join([self.title(), *(f"  {line}" for line in self.lines()), self.verdict()]))

    def __repr__(self) -> str:
        return short(f"{type(self).__name__} {self.verdict()}", self.lines())

    def _repr_html_(self) -> str:
        return html_of(self.title(), self.verdict(), self.passed, (Section("", remarks=self.lines()),))


def short(title: str, lines: Sequence[str]) -> str:
    """A text of at most six lines: what a prompt shows.

    Example:
        >>> print(short("Report FAILED", ["one", "two"]))
        <Report FAILED>
          one
          two
    """
    shown = list(lines)
    if len(shown) > _SHORT_LINES + 1:
        shown = [*shown[:_SHORT_LINES], f"and {len(shown) - _SHORT_LINES} lines more: print it"]
    return "\n".join(printable(line, 160) for line in (f"<{title}>", *(f"  {line}" for line in shown)))


def html_of(title: str, verdict: str, well: bool, sections: Iterable[Section]) -> str:
    """A report for a notebook: its title, its verdict, and every section as a table or a list; all of it is escaped.

    Example:
        >>> html_of("<arm>", "PASSED", True, [])
        '<div><p><b>&lt;arm&gt;</b><br/><span style="color:#2e7d32">PASSED</span></p></div>'
    """
    parts = [f'<p><b>{_cell(title)}</b><br/><span style="color:{_GOOD if well else _BAD}">{_cell(verdict)}</span></p>']
    for section in sections:
        parts += [f"<p>{_cell(section.title)}</p>"] if section.title and section.title != verdict else []
        if section.rows:
            head = "".join(f"<th>{_cell(each)}</th>" for each in section.header)
            body = "".join(
                "<tr>" + "".join(f"<td>{_cell(each)}</td>" for each in row) + "</tr>" for row in section.rows
            )
            parts.append(f"<table><thead><tr>{head}</tr></thead><tbody>{body}</tbody></table>")
        if section.remarks:
            parts.append(
                "<ul>" + "".join(f"<li>{_cell(each.removeprefix('- '))}</li>" for each in section.remarks) + "</ul>"
            )
    return f"<div>{''.join(parts)}</div>"


def _cell(text: str) -> str:
    return escape(printable(text, 1000))
