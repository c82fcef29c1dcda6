"""What every report of this room can do: be read as text, JSON, HTML and JUnit XML."""

from __future__ import annotations

from dataclasses import asdict
from html import escape
from typing import TYPE_CHECKING, Any

from urdf_ik.errors import escaped, printable
from urdf_ik.support.text import json_text, plain

if TYPE_CHECKING:
    from collections.abc import Iterable

_SHORT_LINES = 4


class Written:
    """A frozen record that is written as plain values and as JSON."""

    def to_dict(self) -> dict[str, Any]:
        """Plain lists, numbers and text; numbers that are not finite are the text 'inf', '-inf' or 'nan'."""
        out: dict[str, Any] = plain(asdict(self))  # type: ignore[call-overload]
        return out

    def to_json(self) -> str:
        """:meth:`to_dict` as strict JSON."""
        return json_text(self.to_dict())


class Report(Written):
    """A verdict with the lines that led to it."""

    @property
    def passed(self) -> bool:
        """Whether all is well."""
        raise NotImplementedError

    def title(self) -> str:
        """What was checked."""
        raise NotImplementedError

    def lines(self) -> tuple[str, ...]:
        """What was found, a line each."""
        raise NotImplementedError

    def verdict(self) -> str:
        """The last line."""
        raise NotImplementedError

    def to_dict(self) -> dict[str, Any]:
        """Plain lists, numbers and text, ``passed`` first."""
        return {"passed": self.passed, **super().to_dict()}

    def __str__(self) -> str:
        return escaped("\n".join([self.title(), *(f"  {line}" for line in self.lines()), self.verdict()]))

    def __repr__(self) -> str:
        lines = self.lines()
        more = len(lines) - _SHORT_LINES
        shown = [*lines[:_SHORT_LINES], f"and {more} lines more: print it"] if more > 1 else lines
        if more == 1:
            shown = [*lines[: _SHORT_LINES - 1], "and 2 lines more: print it"]
        return printable_lines([f"<{type(self).__name__} {self.verdict()}>", *(f"  {line}" for line in shown)])

    def _repr_html_(self) -> str:
        colour = "#2e7d32" if self.passed else "#c62828"
        items = "".join(f"<li>{escape(printable(line, 1000))}</li>" for line in self.lines())
        head = f"<p><b>{escape(self.title())}</b><br/>"
        return f'<div>{head}<span style="color:{colour}">{escape(self.verdict())}</span></p><ul>{items}</ul></div>'


def printable_lines(lines: Iterable[str]) -> str:
    """Lines of text, each cut to 200 characters.

    Example:
        >>> printable_lines(["one", "two"])
        'one\\ntwo'
    """
    return "\n".join(printable(line, 200) for line in lines)
