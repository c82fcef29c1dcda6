"""How objects show: a few lines at a prompt, tables in a notebook."""

from collections.abc import Iterable, Sequence
from html import escape

from urdf_ik.errors import printable
from urdf_ik.support.text import Section

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
