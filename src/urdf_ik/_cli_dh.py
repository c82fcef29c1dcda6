"""What ``urdf-ik dh`` does: an arm's table, or a table's arm."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from urdf_ik import _cli_io, _cli_views, _dh_files
from urdf_ik._cli_options import DHFormat
from urdf_ik.dh import DHTable

if TYPE_CHECKING:
    from collections.abc import Callable

    from urdf_ik.arm import Arm

_TABLE_FILES = (".csv", ".json")


def run(
    file: str,
    load: Callable[[], Arm],
    links: tuple[str | None, str | None],
    convention: str | None,
    snap: float | None,
    degrees: bool,
    chosen: DHFormat | None,
    output: Path | None,
) -> None:
    """Read ``file`` as a table, or ``load`` it as an arm, and write it in the chosen format.

    Raises:
        typer.BadParameter: options that do not go together, or a file that cannot be written.
        DHError: a table that is none.
    """
    notes: list[str] = []
    if Path(file).suffix.lower() in _TABLE_FILES:
        if snap is not None:
            raise _cli_io.usage("a table has no axes to snap; the option is for URDFs", "--snap")
        table = DHTable.read(file, convention, degrees=degrees)
        table = table.converted(convention or table.convention)
        base, tip = links[0] or "base_link", links[1] or "tool0"
    else:
        arm = load()
        base, tip = arm.base, arm.tip
        table = DHTable.from_chain(arm.chain, convention or "standard", snap=snap, name=arm.name)
        off = table.deviation(arm.chain)
        notes.append(f"{base} to {tip}; poses differ from the URDF's by {off:.1e} (rad, share of the arm's size)")
    suffix = "" if output is None else output.suffix.lstrip(".").lower()
    chosen = chosen or (DHFormat(suffix) if suffix in tuple(DHFormat) else DHFormat.TABLE)
    if chosen is DHFormat.TABLE:
        text = _as_table(table, notes, degrees, to_file=output is not None)
    elif chosen is DHFormat.URDF:
        text = table.to_urdf(base, tip)
    else:
        text = (table.to_csv if chosen is DHFormat.CSV else table.to_json)(degrees=degrees)
    _cli_io.write(text, output)


def _as_table(table: DHTable, notes: list[str], degrees: bool, *, to_file: bool) -> str:
    header, rows = _dh_files.cells(table, degrees)
    grid = _cli_views.grid(header, rows, left=["joint", "type"])
    title = f"{table.name}: {table.convention} Denavit-Hartenberg table"
    return _cli_views.render(title, "", grid, "", *_dh_files.frames(table, degrees), *notes, to_file=to_file)
