"""The command ``dh``."""

from enum import StrEnum
from pathlib import Path

from urdf_ik.cli import console, tables
from urdf_ik.cli.arm_options import ArmOptions

_TABLE_FILES = (".csv", ".json")
DHFormat = StrEnum("DHFormat", ["TABLE", "JSON", "CSV", "URDF"])


def dh(
    *,
    convention: str | None = None,
    snap: float | None = None,
    chosen: ArmOptions,
    degrees: bool = False,
    printed_as: DHFormat | None = None,
    output: Path | None = None,
) -> None:
    """Denavit-Hartenberg table of an arm, or an arm from a table (CSV or JSON).

    Examples:
        urdf-ik dh dh_6r --convention modified
        urdf-ik dh ur5 --degrees -o ur5.csv
        urdf-ik dh ur5 --degrees -f csv
        urdf-ik dh ur5.csv -o my_ur5.urdf

    Positional:
        robot (FILE): URDF file, a catalogue name, - for a URDF on stdin, or a table: .csv or .json.

    Options:
        convention (standard|modified): Convention of the printed table, and of a table file that does not name its
            own. Default: the table's own, standard for a URDF.
        snap (TOLERANCE): Make neighbouring axes exactly parallel, or exactly meet, that are off by less than this
            [rad, or share of the arm's size]. Default: the URDF as written.
    """
    from urdf_ik.kinematics.dh import DHTable, files

    notes: list[str] = []
    if Path(chosen.robot).suffix.lower() in _TABLE_FILES:
        if snap is not None:
            raise console.usage("a table has no axes to snap; the option is for URDFs", "--snap")
        chosen.require_only(("base", "tip"), f"{chosen.robot} is a table")
        table = DHTable.read(chosen.robot, convention, degrees=degrees)
        table = table.converted(convention or table.convention)
        base, tip = chosen.base or "base_link", chosen.tip or "tool0"
    else:
        arm = chosen.load(degrees)
        base, tip = arm.base, arm.tip
        table = DHTable.from_chain(arm.chain, convention or "standard", snap=snap, name=arm.name)
        off = table.deviation(arm.chain)
        notes.append(f"{base} to {tip}; poses differ from the URDF's by {off:.1e} of the arm's size, or in its angles")
    suffix = "" if output is None else output.suffix.lstrip(".").lower()
    kind = printed_as or (DHFormat(suffix) if suffix in tuple(DHFormat) else DHFormat.TABLE)
    if kind is DHFormat.URDF:
        text = table.to_urdf(base, tip)
    elif kind is DHFormat.TABLE:
        text = tables.render(files.as_text(table, degrees), notes)
    else:
        text = (table.to_csv if kind is DHFormat.CSV else table.to_json)(degrees=degrees)
    console.write(text, output)
    if output is not None:
        turned = degrees and kind is not DHFormat.URDF
        console.say(f"{output}: {table.n} joints; {'deg' if turned else 'rad'}, m")
