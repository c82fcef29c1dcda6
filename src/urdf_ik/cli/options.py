"""Options that several commands share, and records of options: each is declared once."""

from __future__ import annotations

import copy
import functools
import inspect
from collections.abc import Callable, Mapping
from dataclasses import MISSING, dataclass, fields, is_dataclass
from enum import StrEnum
from pathlib import Path
from typing import IO, Annotated, Any, ClassVar, get_args, get_type_hints

import typer
from typer import Option
from typer.models import ArgumentInfo

from urdf_ik.cli.prompt.completion import data_files
from urdf_ik.paths import path_settings
from urdf_ik.support.inputs import MOST_POSES, MOST_THREADS
from urdf_ik.version import __version__


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


class PartOfPose(StrEnum):
    """What a target fixes of the tip's pose, for arms with few joints; see :mod:`urdf_ik.ik.tasks`."""

    POSE = "pose"
    POSITION = "position"
    POSITION_AND_AXIS = "position-and-axis"
    PLANAR_POSITION = "planar-position"
    PLANAR_POSE = "planar-pose"


class Value(StrEnum):
    """Value of the voxels of a workspace map that a layer shows."""

    REACH = "reach"
    SOLUTIONS = "solutions"
    MANIPULABILITY = "manipulability"
    MARGIN = "margin"
    CLEARANCE = "clearance"


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
Output = Annotated[
    Path | None,
    Option("--output", "-o", metavar="FILE", help="Write here instead of stdout.", rich_help_panel=OUTPUT),
]
DataFormat = Annotated[
    Format | None,
    Option(
        "--format",
        "-f",
        help="Default: by the name of --output, else table.",
        show_default=False,
        rich_help_panel=OUTPUT,
    ),
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
        "--world",
        metavar="FILE",
        help="Obstacles: the shapes of a URDF of fixed links.",
        rich_help_panel=OBSTACLES,
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
Threads = Annotated[int, Option("--threads", metavar="N", min=1, max=MOST_THREADS, help="Threads that solve.")]

# A layer of a workspace map.
Map = Annotated[
    Path | None,
    Option("--map", metavar="PATH", help="Map from `urdf-ik workspace`, to cut a layer from."),
]
Shown = Annotated[
    Value, Option("--show", metavar="VALUE", help=f"Value of a layer's voxels: {', '.join(Value)}.", show_default=False)
]


def print_version(wanted: bool) -> None:
    """Print the version and leave, where that is wanted."""
    if wanted:
        typer.echo(f"urdf-ik {__version__}")
        raise typer.Exit


Version = Annotated[
    bool, Option("--version", callback=print_version, is_eager=True, help="Print the version and leave.")
]


@dataclass(frozen=True)
class PoseOptions:
    """Every way to name poses, as typed; None for what was not given. ``cli.solutions.targets`` reads them."""

    GROUP: ClassVar[str] = POSES
    xyz: Annotated[list[str] | None, Option(metavar="X,Y,Z", help="Position of the tip [m]; repeatable.")] = None
    rpy: Annotated[list[str] | None, Option(metavar="R,P,Y", help="Roll, pitch, yaw about fixed x, y, z [rad].")] = None
    quat_xyzw: Annotated[list[str] | None, Option(metavar="X,Y,Z,W", help="Orientation, scalar last.")] = None
    quat_wxyz: Annotated[list[str] | None, Option(metavar="W,X,Y,Z", help="Orientation, scalar first.")] = None
    rotvec: Annotated[list[str] | None, Option(metavar="X,Y,Z", help="Rotation axis times angle [rad].")] = None
    q: Annotated[
        list[str] | None,
        Option(
            metavar="Q1,Q2,...|FILE",
            help="The tip at joint vectors: typed, of a file, or -; repeatable.",
            autocompletion=data_files,
        ),
    ] = None
    poses: Annotated[
        str | None,
        Option(
            "--poses",
            "-p",
            metavar="FILE",
            help="csv (x,y,z and qw,qx,qy,qz or roll,pitch,yaw or rx,ry,rz), json, npy, npz, or -.",
            autocompletion=data_files,
        ),
    ] = None


@dataclass(frozen=True)
class ForEach:
    """Marks a field of a record that holds the options of another record for several arms, as typed, by name.

    Attributes:
        record: every option of it can be given once for all arms, or for one arm as ``LETTER=VALUE``.
    """

    record: Any


@dataclass(frozen=True)
class SettingsOf:
    """Marks a field of a record that holds the settings of another record, as typed, by name.

    Attributes:
        record: its settings become the options; see :mod:`urdf_ik.paths.path_settings`.
    """

    record: Any


_TYPED: dict[path_settings.Kind, tuple[Any, str]] = {
    "joint vector": (str, "Q1,Q2,..."),
    "number": (float, "VALUE"),
    "per joint": (str, "V|V1,V2,..."),
    "length and angle": (str, "M,RAD"),
    "flag": (bool, ""),
}
"""The type and the metavariable of an option for a setting of each kind."""
_SHARED = {"world": World, "margin": Margin, "collisions": Collisions}
"""Settings whose options other commands have, too."""


def _option(name: str, setting: Mapping[str, Any]) -> Any:
    """The option of a setting; None stands for one that is not given."""
    if name in _SHARED:
        return _SHARED[name]
    kind: Any
    if setting["kind"] == "choice":
        kind, metavar = StrEnum(name.title(), {cost: cost for cost in path_settings.COSTS}), ""
    else:
        kind, metavar = _TYPED[setting["kind"]]
    unit = setting["unit"]
    if setting["kind"] == "number" and unit:
        metavar = unit.upper()
    text = f"{setting['help'].removesuffix('.')}{f' [{unit}]' if unit else ''}."
    return Annotated[kind | None, Option(metavar=metavar or None, help=text)]


def expanded(command: Callable[..., None]) -> Callable[..., None]:
    """A command with the fields of records in the place of its parameters that are records.

    A record is a dataclass whose fields are annotated as options. A parameter of the command with the name of a field
    declares that option instead of the field, and both get its value.
    """
    hints = get_type_hints(command, include_extras=True)
    records: dict[str, Any] = {name: hint for name, hint in hints.items() if is_dataclass(hint)}
    own = [name for name in inspect.signature(command).parameters if name not in records]

    @functools.wraps(command)
    def run(**given: Any) -> None:
        if given.pop("as_json", False):
            given["printed_as"] = _json(command, given["printed_as"])
        made = {name: record(**_values(record, given)) for name, record in records.items()}
        command(**{name: given[name] for name in own}, **made)

    parameters: list[inspect.Parameter] = []
    for name, parameter in inspect.signature(command).parameters.items():
        if name in records:
            parameters += [each for each in _parameters(records[name]) if each.name not in own]
        else:
            kind = inspect.Parameter.KEYWORD_ONLY
            parameters.append(parameter.replace(annotation=hints[name], kind=kind))
    if "printed_as" in own:
        after = [each.name for each in parameters].index("printed_as") + 1
        parameters.insert(after, _parameter("as_json", Json, False))
    parameters.sort(key=lambda each: each.name in own or not _is_argument(each.annotation))
    run.__signature__ = inspect.Signature(parameters)  # type: ignore[attr-defined]
    return run


def _json(command: Callable[..., None], printed_as: Any) -> Any:
    """The format json among a command's formats.

    Raises:
        typer.BadParameter: another format was asked for as well.
    """
    default = inspect.signature(command).parameters["printed_as"].default
    if printed_as not in (default, "json"):
        raise typer.BadParameter(f"--json and --format {printed_as.value} exclude each other", param_hint="--json")
    kinds = get_args(get_type_hints(command)["printed_as"]) or (get_type_hints(command)["printed_as"],)
    return kinds[0]("json")


def _values(record: Any, given: dict[str, Any]) -> dict[str, Any]:
    """The values of a record's fields."""
    out = {}
    for name, _, _, inner in hinted_fields(record):
        out[name] = given[name] if inner is None else {each.name: given[each.name] for each in inner}
    return out


@functools.cache
def hinted_fields(record: Any) -> tuple[tuple[str, Any, Any, tuple[inspect.Parameter, ...] | None], ...]:
    """Name, annotation and default of each field, and the options that it stands for where it is marked."""
    hints = get_type_hints(record, include_extras=True)
    out = []
    for each in fields(record):
        hint, inner = hints[each.name], None
        for mark in get_args(hint)[1:]:
            if isinstance(mark, SettingsOf):
                inner = tuple(_parameter(k, _option(k, f.metadata), None) for k, f in path_settings.options().items())
            if isinstance(mark, ForEach):
                inner = tuple(_for_each(one) for one in _parameters(mark.record) if not _is_argument(one.annotation))
        out.append((each.name, hint, inspect.Parameter.empty if each.default is MISSING else each.default, inner))
    return tuple(out)


@functools.cache
def _parameters(record: Any) -> tuple[inspect.Parameter, ...]:
    """The options of a record."""
    out: list[inspect.Parameter] = []
    for name, hint, default, inner in hinted_fields(record):
        out += [_parameter(name, hint, default)] if inner is None else inner
    return tuple(_in_group(each, getattr(record, "GROUP", None)) for each in out)


def _in_group(one: inspect.Parameter, group: str | None) -> inspect.Parameter:
    """An option that stands in a group of the help, its own one if it has one."""
    kind, option = get_args(one.annotation)
    if group is None or option.rich_help_panel is not None:
        return one
    option = copy.copy(option)
    option.rich_help_panel = group
    return one.replace(annotation=Annotated[kind, option])


def _parameter(name: str, hint: Any, default: Any) -> inspect.Parameter:
    return inspect.Parameter(name, inspect.Parameter.KEYWORD_ONLY, default=default, annotation=hint)


def _for_each(one: inspect.Parameter) -> inspect.Parameter:
    """An option of one arm as an option of several; a flag holds for all of them."""
    kind, option = get_args(one.annotation)
    if kind is bool:
        return one
    text = f"{option.help.removesuffix('.').removesuffix('; repeatable')}; for one arm: A=..., B=..."
    return _parameter(one.name, Annotated[list[str] | None, Option(metavar=option.metavar, help=text)], None)


def _is_argument(hint: Any) -> bool:
    return any(isinstance(mark, ArgumentInfo) for mark in get_args(hint)[1:])


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
