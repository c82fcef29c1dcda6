"""Options of the commands: a name, a type and a default in code, and the rest in a docstring's section ``Options``.

An entry of such a section reads ``name (-x METAVAR): Help.``: in the parentheses stand a short name, another long name,
and what the help calls the value. ``Options (Poses):`` is a group of the help; ``Positional:`` is for arguments.
"""

import functools
import inspect
import re
from collections.abc import Callable
from dataclasses import dataclass
from enum import StrEnum
from pathlib import Path
from typing import IO, Annotated, Any, ClassVar, NamedTuple, Self, get_args, get_origin, get_type_hints

import typer
from typer import Argument, Option
from typer.models import ArgumentInfo

from urdf_ik.support.angles import shown_in_degrees
from urdf_ik.support.inputs import MOST_POSES, MOST_THREADS

Format = StrEnum("Format", ["TABLE", "JSON", "CSV", "NPZ"])
ReportFormat = StrEnum("ReportFormat", ["TABLE", "JSON"])
ReviewFormat = StrEnum("ReviewFormat", ["TABLE", "JSON", "GITHUB", "SARIF", "MARKDOWN"])
PartOfPose = StrEnum(
    "PartOfPose",
    [
        "pose",
        "position",
        "position-and-axis",
        "level",
        "orientation",
        "axis",
        "look-at",
        "planar-position",
        "planar-pose",
    ],
)
"""What a target fixes of the tip's pose; see :class:`urdf_ik.Task`, and :mod:`urdf_ik.ik.tasks` for planar arms."""
MOST = {"n": MOST_POSES, "random": MOST_POSES, "threads": MOST_THREADS}
"""Greatest values of options that are numbers."""


class Shared:
    """The options that several commands have.

    Options:
        tolerance_mm (MM): Lengths up to this are the same. Default: 1e-6.
        tolerance_deg (DEG): Angles up to this are the same. Default: 6e-8.
        ignore (KINDS): Does not count: limits, collisions, visuals, names; with commas.
        threads (N): Threads that solve.

    Options (Poses):
        seed (N): Seed of everything that is drawn.
        n (--random -n N): Number of random poses.
        task: Part of the pose that counts; level: all but the yaw. Default: all of it.
        axis (x|y|z|X,Y,Z): The tip's axis of --task position, axis or look-at.
        redundancy (V1,V2,...): Values of the redundancy parameter that `info` names. Default: that of --q, else the
            arm's.

    Options (Obstacles):
        world (FILE): Obstacles: the shapes of a URDF of fixed links.
        margin (M): Distance that bodies must keep from each other [m]. Default: 0.
        collisions: Whether contacts are checked. Default: where all shapes can be read.

    Options (Output):
        time_limit (S): Longest work; then what it has so far.
        degrees: All angles in degrees, typed and shown, those of --rpy and --rotvec too.
        pendant: Joint 3 against the horizon, as a FANUC pendant shows it; typed and shown.
        printed_as (--format -f): How to print it. Default: by the name of --output, else table.
        as_json (--json): The same as --format json.
        output (-o FILE): Write here instead of stdout.
    """


class Record:
    """Options as fields of a dataclass; its subclasses are annotations of parameters of commands."""

    GROUP: ClassVar[str] = "Options"

    @classmethod
    def parameters(cls, command: Any) -> list[inspect.Parameter]:
        """The options; what the docstring of the command says of them goes before what this one says."""
        return parameters(cls, command, cls.GROUP)

    @classmethod
    def read(cls, values: dict[str, Any]) -> Self:
        """The record of the values of its options."""
        return cls(**values)


@dataclass(frozen=True)
class PoseOptions(Record):
    """Every way to name poses, as typed; None for what is not there. ``cli.targets`` reads them.

    Options:
        xyz (X,Y,Z): Position of the tip [m]; repeatable.
        rpy (R,P,Y): Roll, pitch, yaw about fixed x, y, z [rad].
        quat_xyzw (X,Y,Z,W): Orientation, scalar last.
        quat_wxyz (W,X,Y,Z): Orientation, scalar first.
        rotvec (X,Y,Z): Rotation axis times angle [rad].
        abb (Q1,Q2,Q3,Q4): Orientation as ABB writes it: the scalar first.
        fanuc (W,P,R): Orientation as FANUC writes it [rad].
        kuka (A,B,C): Orientation as KUKA writes it [rad].
        motoman (RX,RY,RZ): Orientation as Yaskawa writes it [rad].
        staubli (RX,RY,RZ): Orientation as Staubli writes it [rad].
        q (Q1,Q2,...|FILE): The tip at joint vectors: typed, of a file, or -; repeatable.
        poses (-p FILE): csv (x,y,z and qw,qx,qy,qz or roll,pitch,yaw or rx,ry,rz), json, npy, npz, or -.
    """

    GROUP = "Poses"
    xyz: list[str] | None = None
    rpy: list[str] | None = None
    quat_xyzw: list[str] | None = None
    quat_wxyz: list[str] | None = None
    rotvec: list[str] | None = None
    abb: list[str] | None = None
    fanuc: list[str] | None = None
    kuka: list[str] | None = None
    motoman: list[str] | None = None
    staubli: list[str] | None = None
    q: list[str] | None = None
    poses: str | None = None


class Text(NamedTuple):
    """What a docstring says of an option."""

    names: list[str]
    metavar: str | None
    help: str
    group: str
    argument: bool


_SECTION = re.compile(r"(Options|Positional)(?: \((.+)\))?:")
_ENTRY = re.compile(r"    (\w+)(?: \(([^)]+)\))?: (.+)")


def texts(holder: Any) -> dict[str, Text]:
    """The options in the sections of a docstring."""
    out: dict[str, Text] = {}
    section, last = None, ""
    for line in inspect.cleandoc(holder.__doc__ or "").splitlines():
        if line and not line.startswith(" "):
            section = _SECTION.fullmatch(line)
        elif section and (entry := _ENTRY.fullmatch(line)):
            last, words = entry[1], (entry[2] or "").split()
            names, metavar = [word for word in words if word[0] == "-"], [word for word in words if word[0] != "-"]
            out[last] = Text(names, " ".join(metavar) or None, entry[3], section[2] or "", section[1] == "Positional")
        elif section and line:
            out[last] = out[last]._replace(help=f"{out[last].help} {line.strip()}")
    return out


def parameters(holder: Any, command: Any, group: str = "Options") -> list[inspect.Parameter]:
    """The options of a command or of one of its records, in order; those of records in their places."""
    shared, hints = texts(Shared), get_type_hints(holder, include_extras=True)
    known = shared | texts(holder) | texts(command)
    out: list[inspect.Parameter] = []
    for name, each in inspect.signature(holder).parameters.items():
        hint = hints[name]
        if isinstance(hint, type) and issubclass(hint, Record):
            out += hint.parameters(command)
            continue
        place = known[name].group or (shared[name].group if name in shared else "") or group
        out.append(parameter(name, hint, each.default, known[name], place))
        if name == "printed_as":
            out.append(parameter("as_json", bool, False, shared["as_json"], place))
    return out


def parameter(name: str, kind: Any, default: Any, text: Text, group: str) -> inspect.Parameter:
    """An option of a command."""
    kinds = (get_args(kind) or (kind,)) if get_origin(kind) is not list else (kind,)
    shown: dict[str, Any] = {"metavar": text.metavar, "help": text.help, "show_default": type(default) in (int, float)}
    if int in kinds:
        shown |= {"min": 0 if default == 0 or name == "port" else 1, "max": MOST.get(name)}
    if text.metavar == "DIR":
        shown |= {"exists": True, "file_okay": False}
    long = f"--{name.replace('_', '-')}"
    names = [*([] if any(each[:2] == "--" for each in text.names) else [long]), *text.names]
    if bool in kinds and type(None) in kinds:
        names = [f"{long}/--no-{long[2:]}"]
    mark = Argument(**shown) if text.argument else Option(*names, rich_help_panel=group, **shown)
    return inspect.Parameter(name, inspect.Parameter.KEYWORD_ONLY, default=default, annotation=Annotated[kind, mark])


def expanded(command: Callable[..., None]) -> Callable[..., None]:
    """A command with the options of records in the place of its parameters that are records."""
    hints = get_type_hints(command, include_extras=True)
    records = {name: hint for name, hint in hints.items() if isinstance(hint, type) and issubclass(hint, Record)}
    inner = {name: [each.name for each in record.parameters(command)] for name, record in records.items()}

    @functools.wraps(command)
    def run(**values: Any) -> None:
        if values.pop("as_json", False):
            default = inspect.signature(command).parameters["printed_as"].default
            if values["printed_as"] not in (default, "json"):
                other = f"--json and --format {values['printed_as'].value} exclude each other"
                raise typer.BadParameter(other, param_hint="--json")
            kind = hints["printed_as"]
            values["printed_as"] = (get_args(kind) or (kind,))[0]("json")
        made = {name: record.read({each: values.pop(each) for each in inner[name]}) for name, record in records.items()}
        with shown_in_degrees(bool(values.get("degrees"))):
            command(**values, **made)

    every = sorted(parameters(command, command), key=lambda each: each.name in hints or not is_argument(each))
    run.__signature__ = inspect.Signature(every)  # type: ignore[attr-defined]
    return run


def is_argument(one: inspect.Parameter) -> bool:
    """Whether it is an argument and no option."""
    return any(isinstance(mark, ArgumentInfo) for mark in get_args(one.annotation)[1:])


def is_terminal(stream: IO[str] | None) -> bool:
    """Whether a person reads there; a stream that was closed before the program began is None."""
    return stream is not None and stream.isatty()


def format_for(chosen: Format | None, output: Path | None, *, terminal: bool) -> Format:
    """The format to write: the chosen one, else the one that the file's name ends in, else a table."""
    if chosen is None:
        suffix = "" if output is None else output.suffix.lstrip(".").lower()
        chosen = Format(suffix) if suffix in tuple(Format) else Format.TABLE
    if chosen is Format.NPZ and output is None and terminal:
        raise typer.BadParameter(
            "npz is binary: give --output FILE, or redirect standard output", param_hint="--format"
        )
    return chosen
