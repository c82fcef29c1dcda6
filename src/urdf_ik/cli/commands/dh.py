"""The command ``dh``."""

from __future__ import annotations

from enum import StrEnum
from pathlib import Path
from typing import Annotated

from typer import Argument, Option

from urdf_ik.cli import console, options, tables
from urdf_ik.cli.arm_options import ArmOptions
from urdf_ik.kinematics.dh import DHTable

_TABLE_FILES = (".csv", ".json")


DHFormat = StrEnum("DHFormat", ["TABLE", "JSON", "CSV", "URDF"])


def dh(
    *,
    robot: Annotated[
        str,
        Argument(metavar="FILE", help="URDF file, a catalogue name, - for a URDF on stdin, or a table: .csv or .json."),
    ],
    convention: Annotated[
        str | None,
        Option(
            metavar="standard|modified",
            help="Convention of the printed table, and of a table file that does not name its own. "
            "Default: the table's own, standard for a URDF.",
        ),
    ] = None,
    snap: Annotated[
        float | None,
        Option(
            metavar="TOLERANCE",
            min=0.0,
            help="Make neighbouring axes exactly parallel, or exactly meet, that are off by less than this [rad, or "
            "share of the arm's size]. Default: the URDF as written.",
        ),
    ] = None,
    chosen: ArmOptions,
    degrees: options.Degrees = False,
    printed_as: Annotated[
        DHFormat | None,
        Option(
            "--format",
            "-f",
            help="Default: by the name of --output, else table.",
            show_default=False,
            rich_help_panel=options.OUTPUT,
        ),
    ] = None,
    output: options.Output = None,
) -> None:
    """Denavit-Hartenberg table of an arm, or an arm from a table (CSV or JSON).

    Examples:
        urdf-ik dh dh_6r --convention modified
        urdf-ik dh ur5 --degrees -o ur5.csv
        urdf-ik dh ur5 --degrees -f csv
        urdf-ik dh ur5.csv -o my_ur5.urdf

    Raises:
        typer.BadParameter: options that do not go together, or a file that cannot be written.
        UrdfError: an invalid table.
    """
    from urdf_ik.kinematics.dh import DHTable

    notes: list[str] = []
    if Path(robot).suffix.lower() in _TABLE_FILES:
        if snap is not None:
            raise console.usage("a table has no axes to snap; the option is for URDFs", "--snap")
        chosen.require_only(("base", "tip"), f"{robot} is a table")
        table = DHTable.read(robot, convention, degrees=degrees)
        table = table.converted(convention or table.convention)
        base, tip = chosen.base or "base_link", chosen.tip or "tool0"
    else:
        arm = chosen.load(degrees)
        base, tip = arm.base, arm.tip
        table = DHTable.from_chain(arm.chain, convention or "standard", snap=snap, name=arm.name)
        off = table.deviation(arm.chain)
        notes.append(f"{base} to {tip}; poses differ from the URDF's by {off:.1e} (rad, share of the arm's size)")
    suffix = "" if output is None else output.suffix.lstrip(".").lower()
    chosen_format = printed_as or (DHFormat(suffix) if suffix in tuple(DHFormat) else DHFormat.TABLE)
    if chosen_format is DHFormat.TABLE:
        text = _as_table(table, notes, degrees, to_file=output is not None)
    elif chosen_format is DHFormat.URDF:
        text = table.to_urdf(base, tip)
    else:
        text = (table.to_csv if chosen_format is DHFormat.CSV else table.to_json)(degrees=degrees)
    console.write(text, output)
    if output is not None:
        turned = degrees and chosen_format is not DHFormat.URDF
        console.say_written(output, f"{table.n} joints", "deg" if turned else "rad")


def _as_table(table: DHTable, notes: list[str], degrees: bool, *, to_file: bool) -> str:
    from urdf_ik.kinematics.dh import files

    header, rows = files.cells(table, degrees)
    grid = tables.grid(header, rows, left=["joint", "type"])
    title = f"{table.name}: {table.convention} Denavit-Hartenberg table"
    return tables.render(title, "", grid, "", *files.frames(table, degrees), *notes, to_file=to_file)
