"""Options that several commands share, and records of options: each is declared once."""

from __future__ import annotations

import copy
import functools
import inspect
from collections.abc import Callable
from dataclasses import MISSING, dataclass, fields
from enum import StrEnum
from pathlib import Path
from typing import IO, Annotated, Any, ClassVar, Self, get_args, get_type_hints

import typer
from typer import Option
from typer.models import ArgumentInfo

from urdf_ik.support.inputs import MOST_POSES, MOST_THREADS


class Format(StrEnum):
    """Format of solutions and poses."""

    TABLE = "table"
    JSON = "json"
    CSV = "csv"
    NPZ = "npz"


class ReportFormat(StrEnum):
    """Format of reports."""

    TABLE = "table"
    JSON = "json"


class ReviewFormat(StrEnum):
    """Format of verifications."""

    TABLE = "table"
    JSON = "json"
    GITHUB = "github"
    SARIF = "sarif"
    MARKDOWN = "markdown"


PartOfPose = StrEnum("PartOfPose", ["pose", "position", "position-and-axis", "planar-position", "planar-pose"])
"""What a target fixes of the tip's pose, for arms with few joints; see :mod:`urdf_ik.ik.tasks`."""


# The groups of options in a command's help.
POSES, OBSTACLES, OUTPUT = "Poses", "Obstacles", "Output"

Degrees = Annotated[
    bool,
    Option(
        "--degrees",
        help="All angles in degrees, typed and shown, those of --rpy and --rotvec too.",
        rich_help_panel=OUTPUT,
    ),
]
_BY_NAME = "Default: by the name of --output, else table."
DataFormat = Annotated[
    Format | None, Option("--format", "-f", help=_BY_NAME, show_default=False, rich_help_panel=OUTPUT)
]
TextFormat = Annotated[ReportFormat, Option("--format", "-f", help="How to print it.", rich_help_panel=OUTPUT)]
Json = Annotated[bool, Option("--json", help="The same as --format json.", rich_help_panel=OUTPUT)]
Seed = Annotated[
    int, Option("--seed", metavar="N", min=0, help="Seed of everything that is drawn.", rich_help_panel=POSES)
]
TimeLimit = Annotated[
    float | None,
    Option("--time-limit", metavar="S", min=0.0, help="Longest work; then what it has so far.", rich_help_panel=OUTPUT),
]
Random = Annotated[
    int,
    Option("--random", "-n", metavar="N", min=1, max=MOST_POSES, help="Number of random poses.", rich_help_panel=POSES),
]
Task = Annotated[
    PartOfPose | None,
    Option("--task", help="Part of the pose that counts. Default: all of it.", rich_help_panel=POSES),
]
Redundancy = Annotated[
    str | None,
    Option(
        "--redundancy",
        metavar="V1,V2,...",
        help="Values of the redundancy parameter that `info` names. Default: that of --q, else the arm's.",
        show_default=False,
        rich_help_panel=POSES,
    ),
]
World = Annotated[
    Path | None,
    Option(
        "--world", metavar="FILE", help="Obstacles: the shapes of a URDF of fixed links.", rich_help_panel=OBSTACLES
    ),
]
Margin = Annotated[
    float | None,
    Option(
        "--margin",
        metavar="M",
        help="Distance that bodies must keep from each other [m]. Default: 0.",
        rich_help_panel=OBSTACLES,
    ),
]
Collisions = Annotated[
    bool | None,
    Option(
        "--collisions/--no-collisions",
        help="Whether contacts are checked. Default: where all shapes can be read.",
        show_default=False,
        rich_help_panel=OBSTACLES,
    ),
]
Millimetres = Annotated[
    float | None,
    Option("--tolerance-mm", metavar="MM", min=0.0, help="Lengths up to this are the same. Default: 1e-6."),
]
DegreesOfTolerance = Annotated[
    float | None,
    Option("--tolerance-deg", metavar="DEG", min=0.0, help="Angles up to this are the same. Default: 6e-8."),
]
Ignored = Annotated[
    str | None,
    Option("--ignore", metavar="KINDS", help="Does not count: limits, collisions, visuals, names; with commas."),
]
Threads = Annotated[int, Option("--threads", metavar="N", min=1, max=MOST_THREADS, help="Threads that solve.")]


def output(text: str = "Write here instead of stdout.") -> Any:
    """The option --output, which does what ``text`` says."""
    return Option("--output", "-o", metavar="FILE", help=text, rich_help_panel=OUTPUT)


Output = Annotated[Path | None, output()]


class Record:
    """Options as fields of a dataclass; its subclasses are annotations of parameters of commands."""

    GROUP: ClassVar[str | None] = None

    @classmethod
    def parameters(cls) -> list[inspect.Parameter]:
        """The options."""
        hints = get_type_hints(cls, include_extras=True)
        return [
            parameter(each.name, hints[each.name], inspect.Parameter.empty if each.default is MISSING else each.default)
            for each in fields(cls)  # type: ignore[arg-type]
        ]

    @classmethod
    def read(cls, values: dict[str, Any]) -> Self:
        """The record of the values of its options."""
        return cls(**values)


@dataclass(frozen=True)
class PoseOptions(Record):
    """Every way to name poses, as typed; None for what is not there. ``cli.targets`` reads them."""

    GROUP = POSES
    xyz: Annotated[list[str] | None, Option(metavar="X,Y,Z", help="Position of the tip [m]; repeatable.")] = None
    rpy: Annotated[list[str] | None, Option(metavar="R,P,Y", help="Roll, pitch, yaw about fixed x, y, z [rad].")] = None
    quat_xyzw: Annotated[list[str] | None, Option(metavar="X,Y,Z,W", help="Orientation, scalar last.")] = None
    quat_wxyz: Annotated[list[str] | None, Option(metavar="W,X,Y,Z", help="Orientation, scalar first.")] = None
    rotvec: Annotated[list[str] | None, Option(metavar="X,Y,Z", help="Rotation axis times angle [rad].")] = None
    q: Annotated[
        list[str] | None,
        Option(metavar="Q1,Q2,...|FILE", help="The tip at joint vectors: typed, of a file, or -; repeatable."),
    ] = None
    poses: Annotated[
        str | None,
        Option(
            "--poses",
            "-p",
            metavar="FILE",
            help="csv (x,y,z and qw,qx,qy,qz or roll,pitch,yaw or rx,ry,rz), json, npy, npz, or -.",
        ),
    ] = None


def parameter(name: str, hint: Any, default: Any = None) -> inspect.Parameter:
    """An option of a command."""
    return inspect.Parameter(name, inspect.Parameter.KEYWORD_ONLY, default=default, annotation=hint)


def expanded(command: Callable[..., None]) -> Callable[..., None]:
    """A command with the options of records in the place of its parameters that are records.

    A parameter of the command with the name of a record's option declares that option instead, and both get its value.
    """
    hints = get_type_hints(command, include_extras=True)
    signature = inspect.signature(command).parameters
    records = {name: hint for name, hint in hints.items() if isinstance(hint, type) and issubclass(hint, Record)}
    inner = {name: [_grouped(each, record.GROUP) for each in record.parameters()] for name, record in records.items()}
    own = [name for name in signature if name not in records]

    @functools.wraps(command)
    def run(**values: Any) -> None:
        if values.pop("as_json", False):
            if values["printed_as"] not in (signature["printed_as"].default, "json"):
                other = f"--json and --format {values['printed_as'].value} exclude each other"
                raise typer.BadParameter(other, param_hint="--json")
            kind = get_type_hints(command)["printed_as"]
            values["printed_as"] = (get_args(kind) or (kind,))[0]("json")
        made = {
            name: record.read({each.name: values[each.name] for each in inner[name]})
            for name, record in records.items()
        }
        command(**{name: values[name] for name in own}, **made)

    parameters: list[inspect.Parameter] = []
    for name, each in signature.items():
        if name in records:
            parameters += [option for option in inner[name] if option.name not in own]
        else:
            parameters.append(each.replace(annotation=hints[name], kind=inspect.Parameter.KEYWORD_ONLY))
        if name == "printed_as":
            parameters.append(parameter("as_json", Json, False))
    parameters.sort(key=lambda each: each.name in own or not is_argument(each))
    run.__signature__ = inspect.Signature(parameters)  # type: ignore[attr-defined]
    return run


def _grouped(one: inspect.Parameter, group: str | None) -> inspect.Parameter:
    """An option that stands in a group of the help, its own one if it has one."""
    kind, option = get_args(one.annotation)
    option = copy.copy(option)
    option.rich_help_panel = option.rich_help_panel or group
    return one.replace(annotation=Annotated[kind, option])


def is_argument(one: inspect.Parameter) -> bool:
    """Whether it is an argument and no option."""
    return any(isinstance(mark, ArgumentInfo) for mark in get_args(one.annotation)[1:])


def is_terminal(stream: IO[str] | None) -> bool:
    """Whether a person reads there; a stream that was closed before the program began is None."""
    return stream is not None and stream.isatty()


def format_for(chosen: Format | None, output: Path | None, *, terminal: bool) -> Format:
    """The format to write: the chosen one, else the one that the file's name ends in, else a table.

    Raises:
        typer.BadParameter: binary data would go to a terminal.
    """
    if chosen is None:
        suffix = "" if output is None else output.suffix.lstrip(".").lower()
        chosen = Format(suffix) if suffix in tuple(Format) else Format.TABLE
    if chosen is Format.NPZ and output is None and terminal:
        raise typer.BadParameter(
            "npz is binary: give --output FILE, or redirect standard output", param_hint="--format"
        )
    return chosen
