"""List the arms that have names, with the family and the joints of those that are here.

There are bundled arms, those of example-robot-data, and those of robot_descriptions, which downloads a model at its
first use.

Examples:
    urdf-ik robots
    urdf-ik robots ur --all
"""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Annotated

from typer import Argument, Option

from urdf_ik.cli import console, options, tables
from urdf_ik.cli.options import ReportFormat
from urdf_ik.errors import ChainError, UrdfIkError
from urdf_ik.model import catalogue, downloads

_WIDTH, _LEAST_WORDS = 79, 12
_SHORT = {"example-robot-data": "robot-data", "robot_descriptions": "descriptions"}


def command(
    *,
    word: Annotated[str, Argument(metavar="[WORD]", help="Only names that contain this.")] = "",
    everything: Annotated[
        bool, Option("--all", help="Also the arms of robot_descriptions that are not downloaded.")
    ] = False,
    printed_as: options.TextFormat = ReportFormat.TABLE,
) -> None:
    """Print the list."""
    write = as_json if printed_as is ReportFormat.JSON else as_text
    console.write(write(listed(word, everything)), None)


@dataclass(frozen=True)
class Robot:
    """An arm that has a name.

    Attributes:
        name: argument of ``load``.
        source: 'bundled', 'example-robot-data' or 'robot_descriptions'.
        here: whether it can be loaded without a download or an installation.
        joints: number of its joints; its package's number where it is not here; None if unknown.
        family: how it is solved, '' where it is not here or no solver takes it.
        note: its description, or why it is not solved.
    """

    name: str
    source: str
    here: bool
    joints: int | None
    family: str
    note: str


def listed(word: str = "", everything: bool = False) -> list[Robot]:
    """The robots whose name holds ``word``; those of robot_descriptions that are not here only on demand.

    Example:
        >>> [robot.family for robot in listed("puma_560")]
        ['6R spherical wrist, 2||3 and 1x2']
    """
    more = [name for name in downloads.names() if everything or downloads.is_here(name)]
    return [_robot(name) for name in (*catalogue.names(), *more) if word in name]


def as_text(robots: list[Robot]) -> str:
    """A table, and how to get more."""
    header = ["name", "joints", "family", "here", "from"]
    sources = [_SHORT.get(robot.source, robot.source) for robot in robots]
    taken = sum(max(map(len, column)) for column in ([*(robot.name for robot in robots), ""], [*sources, ""])) + 18
    words = max(_WIDTH - taken, _LEAST_WORDS)
    rows = []
    for robot, source in zip(robots, sources, strict=True):
        what = robot.family or robot.note
        short = what if len(what) <= words else f"{what[: words - 3]}..."
        joints = "-" if robot.joints is None else robot.joints
        rows.append([robot.name, joints, short, "yes" if robot.here else "no", source])
    table = tables.grid(header, rows, left=["name", "family", "from"])
    more = len(downloads.names())
    rest = f"robot_descriptions has {more} arms: --all lists them" if more else f"more: {downloads.INSTALL}"
    return tables.render(*([table] if rows else ["no robot has such a name"]), "", rest)


def as_json(robots: list[Robot]) -> str:
    """The same as data."""
    return console.json_text({"robots": [asdict(robot) for robot in robots]})


def _robot(name: str) -> Robot:
    here = catalogue.is_here(name)
    source = "bundled" if name in catalogue.BUNDLED else "example-robot-data"
    if name not in catalogue.names():
        source = "robot_descriptions"
    note = catalogue.BUNDLED.get(name, "") or (downloads.describe(name) if source == "robot_descriptions" else "")
    if not here:
        joints = downloads.joints_of(name) if source == "robot_descriptions" else None
        return Robot(name, source, False, joints, "", note)
    from urdf_ik.arm import load

    try:
        arm = load(name)
    except ChainError:
        return Robot(name, source, True, None, "", "several chains: urdf-ik info --chains")
    except UrdfIkError as error:
        return Robot(name, source, True, None, "", str(error))
    return Robot(name, source, True, arm.dof, arm.structure.family, note)
