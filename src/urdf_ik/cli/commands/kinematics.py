"""The commands ``fk`` and ``dh``."""

import sys
from enum import StrEnum
from pathlib import Path

import numpy as np

from urdf_ik.arm import Arm
from urdf_ik.cli import console, options, tables
from urdf_ik.cli.arm_options import ArmOptions
from urdf_ik.cli.console import Angles
from urdf_ik.cli.options import Format
from urdf_ik.typing import Array


def fk(
    *,
    q: list[str],
    chosen: ArmOptions,
    degrees: bool = False,
    pendant: bool = False,
    printed_as: Format | None = None,
    output: Path | None = None,
) -> None:
    """Forward kinematics: the tip's pose in the base, for each joint vector.

    Examples:
        urdf-ik fk zyyzyz_6r --q 0.1,-0.2,0.3,0,0.5,0
        urdf-ik fk ur5 --q vectors.csv --degrees --format csv
        urdf-ik fk ur5 --q 0,-1,1,0,1,0 -f json | urdf-ik ik ur5 --poses -

    Options (Poses):
        q (Q1,Q2,...|FILE): Joint vectors, rad or m: typed, of a csv, json, npy or npz, or -; repeatable.
    """
    from urdf_ik.model.poses import to_quat_xyzw, to_rpy
    from urdf_ik.paths.waypoints import POSE_COLUMNS

    chosen_format = options.format_for(printed_as, output, terminal=options.is_terminal(sys.stdout))
    arm, angles = chosen.loaded(degrees, options.PoseOptions(q=q), pendant)
    vectors = angles.typed_vectors(console.joint_vectors(q, "--q", arm.joint_names))
    poses, shown = arm.fk(vectors), angles.vectors(vectors)
    quats, rpy = to_quat_xyzw(poses), angles.angle(to_rpy(poses))
    places = poses[:, :3, 3]
    parts = (
        {"q": shown[k], "pose": poses[k], "xyz": places[k], "quat_xyzw": quats[k], "rpy": rpy[k]}
        for k in range(len(poses))
    )
    facts = {"robot": arm.name, "base": arm.base, "tip": arm.tip, "joints": arm.joint_names}
    names = np.array(arm.joint_names, dtype=np.str_)
    # `urdf-ik ik --poses` finds the pose by its columns' names
    rows = [[*arm.joint_names, *POSE_COLUMNS], *np.hstack([shown, places, quats]).tolist()]
    console.emit(
        chosen_format,
        {**facts, "units": {"angle": angles.unit, "length": "m"}, "poses": list(parts)},
        lambda: _text(arm, poses, quats, rpy, angles),
        output,
        rows=lambda: rows,
        arrays=lambda: {"q": shown, "poses": poses, "joint_names": names, "angle_unit": np.array(angles.unit)},
        about=f"{len(poses)} pose{'s' * (len(poses) != 1)}; {angles.unit}, m",
    )


def _text(arm: Arm, poses: Array, quats: Array, rpy: Array, angles: Angles) -> str:
    """One pose in all its forms, or a table of several."""
    head = f"{arm.name}: pose{'s' * (len(poses) > 1)} of {arm.tip} in {arm.base}"
    if len(poses) > 1:
        header = ["#", "x [m]", "y [m]", "z [m]", "qx", "qy", "qz", "qw"]
        numbers = np.hstack([poses[:, :3, 3], quats])
        return tables.render(head, "", tables.grid(header, [[i, *tables.numbers(x, 6)] for i, x in enumerate(numbers)]))
    matrix = ["  ".join(f"{x:>10}" for x in tables.numbers(row, 6)) for row in poses[0]]
    last = f"roll, pitch, yaw ({', '.join(tables.numbers(rpy[0], 6))}) {angles.unit}"
    return tables.render(head, "", matrix, "", tables.pose_lines(poses[0], 6), last)


DHFormat = StrEnum("DHFormat", ["TABLE", "CSV", "URDF"])


def dh(
    *,
    convention: str | None = None,
    snap: float | None = None,
    chosen: ArmOptions,
    degrees: bool = False,
    printed_as: DHFormat | None = None,
    output: Path | None = None,
) -> None:
    """Denavit-Hartenberg table of an arm, or an arm from a table (CSV).

    Examples:
        urdf-ik dh dh_6r --convention modified
        urdf-ik dh ur5 --degrees -o ur5.csv
        urdf-ik dh ur5 --degrees -f csv
        urdf-ik dh ur5.csv -o my_ur5.urdf

    Positional:
        robot (FILE): URDF file, a catalogue name, - for a URDF on stdin, or a table: .csv.

    Options:
        convention (standard|modified): Convention of the printed table, and of a table file that does not name its
            own. Default: the table's own, standard for a URDF.
        snap (TOLERANCE): Make neighbouring axes exactly parallel, or exactly meet, that are off by less than this
            [rad, or share of the arm's size]. Default: the URDF as written.
    """
    from urdf_ik.kinematics.dh import DHTable, files

    notes: list[str] = []
    if Path(chosen.robot).suffix.lower() == ".csv":
        if snap is not None:
            raise console.usage("a table has no axes to snap; the option is for URDFs", "--snap")
        chosen.require_only(("base", "tip"), f"{chosen.robot} is a table")
        table = DHTable.read(chosen.robot, convention, degrees=degrees)
        if convention not in (None, table.convention):
            table = DHTable.from_chain(table.chain(), convention, name=table.name)
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
        text = table.to_csv(degrees=degrees)
    console.write(text, output)
    if output is not None:
        turned = degrees and kind is not DHFormat.URDF
        console.say(f"{output}: {table.n} joints; {'deg' if turned else 'rad'}, m")
