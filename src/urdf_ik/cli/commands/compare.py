"""What ``urdf-ik compare`` prints."""

from __future__ import annotations

from typing import TYPE_CHECKING

from urdf_ik.cli import tables

if TYPE_CHECKING:
    from rich.table import Table

    from urdf_ik.verify.comparison.report import Comparison


def as_text(comparison: Comparison) -> str:
    """The comparison's tables."""
    parts: list[Table | str] = []
    for section in comparison.sections():
        parts += [""] * bool(parts) + [section.title]
        if section.rows:
            parts.append(tables.grid(section.header, section.rows, left=section.left))
        parts += section.remarks
    return tables.render(*parts)
