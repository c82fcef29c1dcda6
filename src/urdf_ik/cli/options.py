"""Options that several commands share, and records of options: each is declared once."""

from __future__ import annotations

import functools
import inspect
from collections.abc import Callable
from dataclasses import MISSING, dataclass, fields, is_dataclass
from enum import StrEnum
from pathlib import Path
from typing import IO, Annotated, Any, get_args, get_type_hints

import typer
from typer import Option
from typer.models import ArgumentInfo

from urdf_ik import __version__
from urdf_ik.support.inputs import MOST_POSES, MOST_THREADS
from urdf_ik.support.settings import Form, Setting, settings_of


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


class Value(StrEnum):
    """Value of the voxels of a workspace map that a layer shows."""

    REACH = "reach"
    SOLUTIONS = "solutions"
    MANIPULABILITY = "manipulability"
    MARGIN = "margin"
    CLEARANCE = "clearance"


POSES_IN_A_FILE = (
    "csv with a header (x,y,z and qw,qx,qy,qz or roll,pitch,yaw), json, npy or npz of 4x4 matrices, or - for stdin."
)

Degrees = Annotated[bool, Option("--degrees", help="Angles in degrees, in and out, instead of rad.")]
Output = Annotated[Path | None, Option("--output", "-o", metavar="FILE", help="Write here instead of stdout.")]
DataFormat = Annotated[
    Format | None, Option("--format", "-f", help="Default: by the name of --output, else table.", show_default=False)
]
TextFormat = Annotated[ReportFormat, Option("--format", "-f", help="How to print it.")]
Seed = Annotated[int, Option("--seed", min=0, help="Seed of everything that is drawn.")]
Poses = Annotated[int, Option("-n", "--poses", min=1, max=MOST_POSES, help="Number of random poses.")]
World = Annotated[
    Path | None,
    Option(metavar="FILE", help="Obstacles: the collision shapes of a URDF of fixed links, in the base."),
]
Clear = Annotated[float | None, Option(metavar="M", help="Distance [m] that bodies must keep. Default: 0.")]
Threads = Annotated[int, Option(min=1, max=MOST_THREADS, help="Threads that solve.")]

# A layer of a workspace map.
Map = Annotated[
    Path | None,
    Option("--map", metavar="FILE|FOLDER", help="Map from `urdf-ik workspace`, to cut a layer from."),
]
Shown = Annotated[Value, Option("--show", help="Value of a layer's voxels.")]


def print_version(wanted: bool) -> None:
    """Print the version and leave, where that is wanted."""
    if wanted:
        typer.echo(f"urdf-ik {__version__}")
        raise typer.Exit


Version = Annotated[
    bool, Option("--version", callback=print_version, is_eager=True, help="Print the version and leave.")
]


@dataclass(frozen=True)
class Pose:
    """Options of a position and an orientation, as typed; None where one was not given."""

    xyz: Annotated[str | None, Option(metavar="X,Y,Z", help="Position of the tip [m].")] = None
    quat_xyzw: Annotated[str | None, Option(metavar="X,Y,Z,W", help="Orientation, scalar last.")] = None
    quat_wxyz: Annotated[str | None, Option(metavar="W,X,Y,Z", help="Orientation, scalar first.")] = None
    rpy: Annotated[str | None, Option(metavar="R,P,Y", help="Roll, pitch, yaw about fixed x, y, z.")] = None
    rotvec: Annotated[str | None, Option(metavar="X,Y,Z", help="Rotation axis times angle.")] = None


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
        record: its settings become the options; see :mod:`urdf_ik.support.settings`.
    """

    record: Any


_TYPED: dict[Form, tuple[Any, str]] = {
    Form.JOINT_VECTOR: (str, "Q1,Q2,..."),
    Form.NUMBER: (float, "VALUE"),
    Form.EACH_JOINT: (str, "V|V1,V2,..."),
    Form.LENGTH_AND_ANGLE: (str, "M,RAD"),
    Form.FLAG: (bool, ""),
    Form.CHECK: (bool, ""),
    Form.WORLD: (Path, "FILE"),
}
"""The type and the metavariable of an option for a setting of each form."""


def _option(name: str, found: Setting) -> Any:
    """The option of a setting; None stands for one that is not given."""
    kind: Any
    if found.form is Form.CHOICE:
        kind, metavar = StrEnum(name.title(), {each: each for each in found.choices}), ""
    else:
        kind, metavar = _TYPED[found.form]
    if found.form is Form.NUMBER and found.unit:
        metavar = found.unit.upper()
    text = f"{found.help.removesuffix('.')}{f' [{found.unit}]' if found.unit else ''}."
    if found.form is Form.WORLD:
        text = f"{text} The collision shapes of a URDF of fixed links, in the base."
    if found.form is Form.CHECK:
        text = f"{text} With --{name} it is an error where they cannot be."
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
        made = {name: record(**_values(record, given)) for name, record in records.items()}
        command(**{name: given[name] for name in own}, **made)

    parameters: list[inspect.Parameter] = []
    for name, parameter in inspect.signature(command).parameters.items():
        if name in records:
            parameters += [each for each in _parameters(records[name]) if each.name not in own]
        else:
            kind = inspect.Parameter.KEYWORD_ONLY
            parameters.append(parameter.replace(annotation=hints[name], kind=kind))
    parameters.sort(key=lambda each: each.name in own or not _is_argument(each.annotation))
    run.__signature__ = inspect.Signature(parameters)  # type: ignore[attr-defined]
    return run


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
                inner = tuple(_parameter(k, _option(k, found), None) for k, found in settings_of(mark.record).items())
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
    return tuple(out)


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
