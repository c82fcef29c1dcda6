"""Report: the result of a check as text, JSON and HTML, and the way back from JSON."""

import io
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, fields, is_dataclass
from html import escape
from types import NoneType, UnionType
from typing import Any, ClassVar, Self, Union, get_args, get_origin, get_type_hints

from urdf_ik.errors import ArgumentError, escaped, printable
from urdf_ik.support.text import Section, json_text, plain


class Report:
    """The result of a check; each kind is a frozen dataclass of what was found.

    A kind says whether it is ``faulty``, its ``title``, its ``summary`` and, where it has them, tables and lines.

    Attributes:
        unlooked: what a time limit left out; '' where everything was looked at.
    """

    unlooked: str = ""
    JUDGES: ClassVar[bool] = True
    """Whether its verdict says passed or failed."""

    @property
    def faulty(self) -> bool:
        """Whether something that counts was found."""
        return False

    @property
    def passed(self) -> bool:
        """Whether nothing was found that counts, and nothing was left out for want of time."""
        return not self.faulty and not self.unlooked

    def title(self) -> str:
        """The subject of the check."""
        raise NotImplementedError

    def sections(self) -> tuple[Section, ...]:
        """The tables."""
        return ()

    def lines(self) -> tuple[str, ...]:
        """The findings, a line each."""
        return ()

    def summary(self) -> str:
        """The counts of the last line."""
        raise NotImplementedError

    def verdict(self) -> str:
        """The last line: passed, failed, or no fault so far when the time was over; the counts; what was left out."""
        outcome = "PASSED" if self.passed else "FAILED" if self.faulty else "NOT ENDED"
        parts = "; ".join(part for part in (self.summary(), self.unlooked) if part)
        return f"{outcome}: {parts}" if parts and self.JUDGES else parts or outcome

    def to_dict(self) -> dict[str, Any]:
        """Plain lists, numbers and text, ``passed`` first; numbers that are not finite are 'inf', '-inf' or 'nan'."""
        content: dict[str, Any] = plain(asdict(self))  # type: ignore[call-overload]
        return {"passed": self.passed, **content} if self.JUDGES else content

    def to_json(self) -> str:
        """:meth:`to_dict` as strict JSON."""
        return json_text(self.to_dict())

    @classmethod
    def from_dict(cls, data: Mapping[str, Any]) -> Self:
        """The report that :meth:`to_dict` wrote."""
        try:
            report: Self = from_plain(cls, data)
        except (KeyError, TypeError, ValueError) as error:
            raise ArgumentError(f"this is no {cls.__name__} that to_dict() wrote: {error}") from None
        return report

    def __str__(self) -> str:
        tables = [str(section) if section.title else f"\n{str(section).strip()}" for section in self.sections()]
        lines = ["", *self.lines()] if tables else [f"  {line}" for line in self.lines()]
        return escaped("\n".join([self.title(), *tables, *lines, self.verdict()]))

    def __repr__(self) -> str:
        return short(f"{type(self).__name__} {self.verdict()}", self.lines())

    def _repr_html_(self) -> str:
        return html_of(self.title(), self.verdict(), self.passed, (*self.sections(), Section("", remarks=self.lines())))


def from_plain(kind: Any, value: Any, name: str = "") -> Any:
    """A value of a type from the plain lists, numbers and text that ``plain`` made of it.

    Args:
        kind: a dataclass, a named tuple, a tuple of such, a number, text, or one of these or None.
        value: what JSON holds.
        name: what an error calls the value.
    """
    origin, arguments = get_origin(kind), get_args(kind)
    if origin in (Union, UnionType):
        if value is None and NoneType in arguments or type(value) in arguments:
            return value
        return from_plain(next(each for each in arguments if each is not NoneType), value, name)
    if origin is tuple:
        if not isinstance(value, list | tuple):
            raise TypeError(f"{name} is {value!r}; a list is needed")
        kinds = [arguments[0]] * len(value) if arguments[-1] is Ellipsis else arguments
        if len(kinds) != len(value):
            raise ValueError(f"{name} has {len(value)} entries; {len(kinds)} are needed")
        return tuple(
            from_plain(each, part, f"{name}[{k}]") for k, (each, part) in enumerate(zip(kinds, value, strict=True))
        )
    if is_dataclass(kind):
        if not isinstance(value, Mapping):
            raise TypeError(f"{name} is {value!r}; an object is needed")
        hints = get_type_hints(kind)
        names = [each.name for each in fields(kind)]
        parts = {part: from_plain(hints[part], value[part], f"{name}.{part}") for part in names if part in value}
        make: Any = kind
        return make(**parts)
    if hasattr(kind, "_fields"):
        return kind(*from_plain(tuple[tuple(get_type_hints(kind).values())], value, name))  # type: ignore[misc]
    if kind is float and isinstance(value, int | float | str) and not isinstance(value, bool):
        return float(value)
    if isinstance(kind, type) and not isinstance(value, kind):
        raise TypeError(f"{name} is {value!r}; {kind.__name__} is needed")
    return value


_SHORT_LINES = 4
_GOOD, _BAD = "#2e7d32", "#c62828"


def short(title: str, lines: Sequence[str]) -> str:
    """A text of at most six lines: what a prompt shows."""
    shown = list(lines)
    if len(shown) > _SHORT_LINES + 1:
        shown = [*shown[:_SHORT_LINES], f"and {len(shown) - _SHORT_LINES} lines more: print it"]
    return "\n".join(printable(line, 160) for line in (f"<{title}>", *(f"  {line}" for line in shown)))


def html_of(title: str, verdict: str, well: bool, sections: Iterable[Section]) -> str:
    """A report for a notebook: its title, its verdict, and every section as a table or a list; all of it is escaped."""
    parts = [f'<p><b>{_cell(title)}</b><br/><span style="color:{_GOOD if well else _BAD}">{_cell(verdict)}</span></p>']
    for section in sections:
        parts += [f"<p>{_cell(section.title)}</p>"] if section.title and section.title != verdict else []
        if section.rows:
            parts.append(table(section.header, section.rows))
        if section.remarks:
            parts.append(
                "<ul>" + "".join(f"<li>{_cell(each.removeprefix('- '))}</li>" for each in section.remarks) + "</ul>"
            )
    return f"<div>{''.join(parts)}</div>"


def table(header: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """An HTML table; every cell is escaped, but for :class:`Markup`."""
    head = "".join(f"<th>{_cell(cell)}</th>" for cell in header)
    body = "".join("<tr>" + "".join(f"<td>{_cell(cell)}</td>" for cell in row) + "</tr>" for row in rows)
    return f"<table><thead><tr>{head}</tr></thead><tbody>{body}</tbody></table>"


class Markup(str):
    """Text that is HTML already."""


def _cell(text: str) -> str:
    return text if isinstance(text, Markup) else escape(printable(text, 1000))


def svg_of(figure: Any) -> str:
    """A picture of matplotlib as SVG, without the XML declaration."""
    text = io.StringIO()
    figure.savefig(text, format="svg")
    return text.getvalue()[text.getvalue().index("<svg") :]
