"""What ``urdf-ik dh`` does: an arm's table, or a table's arm."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from urdf_ik.cli import console, tables
from urdf_ik.cli.options import DHFormat
from urdf_ik.kinematics.dh import DHTable, files

if TYPE_CHECKING:
    from urdf_ik.cli.chosen_arm import ChosenArm

_TABLE_FILES = (".csv", ".json")


def run(
    chosen: ChosenArm,
    convention: str | None,
    snap: float | None,
    degrees: bool,
    chosen_format: DHFormat | None,
    output: Path | None,
) -> None:
    """Read what was ``chosen`` as a table, or load it as an arm, and write it in ``chosen_format``.

    Raises:
        typer.BadParameter: options that do not go together, or a file that cannot be written.
        UrdfError: an invalid table.
    """
    notes: list[str] = []
    if Path(chosen.robot).suffix.lower() in _TABLE_FILES:
        if snap is not None:
            raise console.usage("a table has no axes to snap; the option is for URDFs", "--snap")
        table = DHTable.read(chosen.robot, convention, degrees=degrees)
        table = table.converted(convention or table.convention)
        base, tip = chosen.base or "base_link", chosen.tip or "tool0"
    else:
        arm = chosen.load()
        base, tip = arm.base, arm.tip
        table = DHTable.from_chain(arm.chain, convention or "standard", snap=snap, name=arm.name)
        off = table.deviation(arm.chain)
        notes.append(f"{base} to {tip}; poses differ from the URDF's by {off:.1e} (rad, share of the arm's size)")
    suffix = "" if output is None else output.suffix.lstrip(".").lower()
    chosen_format = chosen_format or (DHFormat(suffix) if suffix in tuple(DHFormat) else DHFormat.TABLE)
    if chosen_format is DHFormat.TABLE:
        text = _as_table(table, notes, degrees, to_file=output is not None)
    elif chosen_format is DHFormat.URDF:
        text = table.to_urdf(base, tip)
    else:
        text = (table.to_csv if chosen_format is DHFormat.CSV else table.to_json)(degrees=degrees)
    console.write(text, output)


def _as_table(table: DHTable, notes: list[str], degrees: bool, *, to_file: bool) -> str:
    header, rows = files.cells(table, degrees)
    grid = tables.grid(header, rows, left=["joint", "type"])
    title = f"{table.name}: {table.convention} Denavit-Hartenberg table"
    return tables.render(title, "", grid, "", *files.frames(table, degrees), *notes, to_file=to_file)
