"""Compare two arms, or two URDFs of one arm (another tool, a calibrated copy).

It compares structure, frames, limits, reach, the number of solutions for the same poses and the joint values branch by
branch, and says how far B's tool is off when B gets A's joint vectors.

An option is for both arms; with a letter it is for one of them: --tip tool0, or --tip B=flange.

Examples:
    urdf-ik compare zyyzyz_6r puma_560
    urdf-ik compare zyyzyz_6r my_arm.urdf --tip B=tool0 -n 100
    urdf-ik compare planar_2r planar_2r_unit -f json
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from urdf_ik.cli import console, options, tables
from urdf_ik.cli.options import ReportFormat
from urdf_ik.cli.progress import Progress
from urdf_ik.cli.several_arms import SeveralArms

if TYPE_CHECKING:
    from rich.table import Table

    from urdf_ik.verify.comparison.report import Comparison


def command(
    *,
    arms: SeveralArms,
    n: options.Poses = 200,
    seed: options.Seed = 0,
    printed_as: options.TextFormat = ReportFormat.TABLE,
) -> None:
    """Print the comparison."""
    from urdf_ik.verify import comparison

    a, b = (each.load() for each in arms.each(most=2))
    with Progress("comparing", "solving") as progress:
        found = comparison.compare(a, b, n=n, seed=seed, progress=progress.tick)
    console.write(found.to_json() if printed_as is ReportFormat.JSON else as_text(found), None)


def as_text(comparison: Comparison) -> str:
    """The comparison's tables."""
    parts: list[Table | str] = []
    for section in comparison.sections():
        parts += [""] * bool(parts) + [section.title]
        if section.rows:
            parts.append(tables.grid(section.header, section.rows, left=section.left))
        parts += section.remarks
    return tables.render(*parts)
