"""Arguments and options of the commands of ``urdf-ik``."""

from __future__ import annotations

from enum import StrEnum
from pathlib import Path
from typing import IO, Annotated

import typer
from typer import Argument, Option

from urdf_ik import __version__
from urdf_ik.cli.completion import robots_and_files
from urdf_ik.support.inputs import MOST_POSES


class Format(StrEnum):
    """Output of solutions and poses."""

    TABLE = "table"
    JSON = "json"
    CSV = "csv"
    NPZ = "npz"


class ReportFormat(StrEnum):
    """Output of reports."""

    TABLE = "table"
    JSON = "json"


class Picture(StrEnum):
    """What is drawn."""

    ARM = "arm"
    BRANCHES = "branches"
    OVERLAY = "overlay"
    LIMITS = "limits"
    WORKSPACE = "workspace"
    SLIDERS = "sliders"
    PATH = "path"
    INTERVALS = "intervals"


class Metric(StrEnum):
    """How far joint vectors are apart."""

    L2 = "l2"
    MAX = "max"
    TIME = "time"


class Quality(StrEnum):
    """What makes a solution better than others."""

    LIMITS = "limits"
    MANIPULABILITY = "manipulability"
    CLEARANCE = "clearance"


class Value(StrEnum):
    """What a layer of a workspace map shows."""

    REACH = "reach"
    SOLUTIONS = "solutions"
    MANIPULABILITY = "manipulability"
    MARGIN = "margin"
    CLEARANCE = "clearance"


class Cost(StrEnum):
    """What a path is to cost least of."""

    L1 = "l1"
    L2 = "l2"
    MAX = "max"
    TIME = "time"


class DHFormat(StrEnum):
    """Output of Denavit-Hartenberg tables."""

    TABLE = "table"
    JSON = "json"
    CSV = "csv"
    URDF = "urdf"


POSES_IN_A_FILE = (
    "csv with a header (x,y,z and qw,qx,qy,qz or roll,pitch,yaw), json, npy or npz of 4x4 matrices, or - for stdin."
)
OBSTACLES = "Obstacles: the collision shapes of a URDF of fixed links, in the"

# What every command takes.
Robot = Annotated[
    str,
    Argument(
        metavar="ROBOT",
        help="File (URDF, xacro, MJCF, or one of them in gzip), a name that `urdf-ik robots` lists, or - for stdin.",
        autocompletion=robots_and_files,
    ),
]
Base = Annotated[str | None, Option("--base", metavar="LINK", help="Base link; poses are given in its frame.")]
Tip = Annotated[str | None, Option("--tip", metavar="LINK", help="Tip link, whose pose is meant.")]
ChainName = Annotated[
    str | None,
    Option("--chain", metavar="NAME", help="Which arm of several, as `info --chains` names it, or an SRDF's group."),
]
Srdf = Annotated[
    Path | None,
    Option("--srdf", metavar="FILE", exists=True, dir_okay=False, help="SRDF, whose groups are the chains."),
]
XacroArg = Annotated[
    list[str] | None,
    Option("--xacro-arg", metavar="NAME:=VALUE", help="Argument of a xacro; repeatable."),
]
MeshRoot = Annotated[
    list[Path] | None,
    Option(
        "--mesh-root",
        metavar="DIR",
        exists=True,
        file_okay=False,
        help="Where meshes and ROS packages are looked for; repeatable.",
    ),
]
Degrees = Annotated[bool, Option("--degrees", help="Angles in degrees, in and out, instead of rad.")]
Lock = Annotated[
    list[str] | None,
    Option("--lock", metavar="NAME=VALUE", help="Hold a joint there: rad or m, or 30deg; repeatable."),
]
ToolXyz = Annotated[
    str | None,
    Option("--tool-xyz", metavar="X,Y,Z", help="Put a tool at the tip: its centre point in the tip link [m]."),
]
ToolRpy = Annotated[
    str | None,
    Option("--tool-rpy", metavar="R,P,Y", help="Orientation of the tool at its centre point, in the tip link."),
]
RedundancyJoint = Annotated[
    list[str] | None,
    Option(
        "--redundancy-joint",
        metavar="NAME",
        help="Of more than six joints: the value of this one is what is free in a pose; repeatable.",
    ),
]
FreeAxis = Annotated[
    str | None,
    Option(
        "--free-axis",
        metavar="x|y|z|X,Y,Z",
        help="Let the tip turn about this axis of it, a tool that is round: the rotation is what --redundancy gives.",
    ),
]
FreeAt = Annotated[str | None, Option("--free-at", metavar="X,Y,Z", help="A point of that axis, in the tip link [m].")]
Output = Annotated[Path | None, Option("--output", "-o", metavar="FILE", help="Write here instead of stdout.")]
DataFormat = Annotated[
    Format | None, Option("--format", "-f", help="Default: by the name of --output, else table.", show_default=False)
]
TextFormat = Annotated[ReportFormat, Option("--format", "-f", help="How to print it.")]
Seed = Annotated[int, Option("--seed", min=0, help="Seed of everything that is drawn.")]

# What else `info` shows, and what `robots` lists.
Chains = Annotated[bool, Option("--chains", help="List the chains of the URDF instead, and which is meant by itself.")]
Word = Annotated[str, Argument(metavar="[WORD]", help="Only names that hold this.")]
All = Annotated[bool, Option("--all", help="The arms of robot_descriptions that are not here, too.")]

# Joint vectors of fk.
Vectors = Annotated[list[str] | None, Option("--q", metavar="Q1,Q2,...", help="Joint vector, rad or m; repeatable.")]
VectorFile = Annotated[
    str | None, Option("--file", metavar="FILE", help="Joint vectors: csv, json, npy, npz, or - for stdin.")
]

# Targets of ik.
Position = Annotated[str | None, Option("--xyz", metavar="X,Y,Z", help="Position of the tip [m].")]
QuatXyzw = Annotated[str | None, Option("--quat-xyzw", metavar="X,Y,Z,W", help="Orientation, scalar last.")]
QuatWxyz = Annotated[str | None, Option("--quat-wxyz", metavar="W,X,Y,Z", help="Orientation, scalar first.")]
Rpy = Annotated[str | None, Option("--rpy", metavar="R,P,Y", help="Roll, pitch, yaw about fixed x, y, z.")]
Rotvec = Annotated[str | None, Option("--rotvec", metavar="X,Y,Z", help="Rotation axis times angle.")]
Planted = Annotated[
    list[str] | None, Option("--q", metavar="Q1,Q2,...", help="The tip at this joint vector; repeatable.")
]
PoseFile = Annotated[str | None, Option("--poses", metavar="FILE", help="Poses from a file, or - for stdin.")]
Random = Annotated[
    int | None, Option("--random", metavar="N", min=1, max=MOST_POSES, help="N poses of random joint vectors.")
]

Redundancy = Annotated[
    str | None,
    Option(
        "--redundancy",
        metavar="V1,V2,...",
        help="Of seven joints, or with a free axis: solve each pose at these values of the parameter that "
        "`info` names. Default: what it is at the joint vector that a pose was made of, else the arm's default.",
        show_default=False,
    ),
]

# What becomes of the solutions of ik.
Turns = Annotated[bool, Option("--turns", help="Add the +-2 pi images inside the limits.")]
WithinLimits = Annotated[bool, Option("--within-limits", help="Keep those inside the limits.")]
CollisionFree = Annotated[bool, Option("--collision-free", help="Keep those free of self-collision, and of --world.")]
Nearest = Annotated[
    str | None, Option("--nearest", metavar="Q1,Q2,...", help="Keep the one nearest to this joint vector.")
]
Measured = Annotated[
    Metric,
    Option("--metric", help="Distance of --nearest: of all joints, of the largest one, or time at the URDF's speeds."),
]
Within = Annotated[
    str | None,
    Option("--within", metavar="V|V1,V2,...", help="Drop what has a joint further than this from --nearest."),
]
Best = Annotated[
    Quality | None,
    Option("--best", help="Keep the one farthest from its limits, from singularity, or from contact."),
]
Checked = Annotated[
    bool | None,
    Option(
        "--check/--no-check",
        help="Pinocchio's error and self-collision of each solution, or leave Pinocchio out. "
        "Default: both up to 20 poses, beyond that only the error.",
        show_default=False,
    ),
]

# What check compares.
Count = Annotated[int, Option("-n", "--poses", min=1, max=MOST_POSES, help="Number of random poses.")]
Complete = Annotated[
    bool,
    Option(
        "--complete",
        help="Instead: look for solutions in a second way too, at N random, N near singular, N right-angled poses.",
    ),
]
Collision = Annotated[
    bool | None,
    Option(
        "--collision/--no-collision",
        help="Compare collision checks, too. Default: where the URDF has collision shapes that can be read.",
        show_default=False,
    ),
]


# Tables.
TableOrRobot = Annotated[
    str, Argument(metavar="FILE", help="URDF file, a catalogue name, - for a URDF on stdin, or a table: .csv or .json.")
]
Convention = Annotated[
    str | None,
    Option(
        "--convention",
        metavar="standard|modified",
        help="Convention of what is printed; also of a table file that does not say its own. "
        "Default: the table's own, standard for a URDF.",
    ),
]
Snap = Annotated[
    float | None,
    Option(
        "--snap",
        metavar="TOLERANCE",
        min=0.0,
        help="Take neighbouring axes that are nearer than this to parallel [rad] or to meeting [share of the arm's "
        "size] for exactly so. Default: the URDF as written.",
    ),
]
TableFormat = Annotated[
    DHFormat | None, Option("--format", "-f", help="Default: by the name of --output, else table.", show_default=False)
]

# Workspaces.
Voxel = Annotated[
    float | None, Option("--voxel", metavar="M", help="Edge of a voxel [m]. Default: 0.1.", show_default=False)
]
Orientations = Annotated[
    int | None,
    Option("--orientations", metavar="N", min=1, help="Of them at each voxel. Default: 200.", show_default=False),
]
Bounds = Annotated[
    str | None,
    Option("--bounds", metavar="X0,Y0,Z0,X1,Y1,Z1", help="Box to look at [m]. Default: all that the links reach."),
]
MapFree = Annotated[bool, Option("--collision-free", help="Count those free of collision, too; slow.")]
Manipulability = Annotated[bool, Option("--manipulability", help="Keep each pose's greatest manipulability.")]
Margin = Annotated[bool, Option("--margin", help="Keep each pose's greatest limit margin.")]
Clearance = Annotated[bool, Option("--clearance", help="Keep each pose's greatest clearance; slow.")]
MapFile = Annotated[Path | None, Option("--output", "-o", metavar="FILE", help="Write the map here, as .npz.")]

# Paths. What is not given is None: `path`, `plot path` and `view` take the same.
Waypoints = Annotated[
    str | None,
    Option(
        "--waypoints",
        "-w",
        metavar="FILE",
        help=f"Poses of the tip: {POSES_IN_A_FILE}",
    ),
]
Cell = Annotated[
    Path | None,
    Option("--world", metavar="FILE", help=f"{OBSTACLES} base."),
]
StartAt = Annotated[str | None, Option("--start", metavar="Q1,Q2,...", help="Joint vector at the first waypoint.")]
EndAt = Annotated[str | None, Option("--end", metavar="Q1,Q2,...", help="Joint vector at the last waypoint.")]
Apart = Annotated[float | None, Option("--margin", metavar="M", help="Distance [m] that bodies must keep. Default: 0.")]
LeastOf = Annotated[
    Cost | None,
    Option("--cost", help="Least sum of |dq|, of dq^2, of each step's largest |dq|, or of time. Default: l2."),
]
LimitCost = Annotated[
    float | None, Option("--limit-cost", metavar="WEIGHT", help="Adds to the cost for being near a joint limit.")
]
MaxStep = Annotated[
    str | None,
    Option("--max-step", metavar="STEP", help="What a joint may move between waypoints: one number, or one a joint."),
]
Straying = Annotated[
    str | None,
    Option(
        "--tolerance",
        metavar="M,RAD",
        help="What the tip may stray from the straight segments. Default: 0.001,0.02, or four times it if need be.",
    ),
]
Reconfigure = Annotated[
    bool | None,
    Option("--reconfigure", help="Where no motion leads all the way, change the branch as seldom as possible."),
]
Contacts = Annotated[
    bool | None,
    Option("--collisions/--no-collisions", help="Stay free of contacts, which is the default, or don't ask."),
]
Starts = Annotated[bool, Option("--alternatives", help="The best plan from every start branch, too.")]
PlanFile = Annotated[
    Path | None, Option("--out", "--output", "-o", metavar="FILE", help="Write the plan: .csv, .json or .npz; rad, m.")
]
TimedFile = Annotated[
    Path | None,
    Option(
        "--timed",
        metavar="FILE",
        help="Write it in time, too, as fast as velocity and acceleration allow: .csv, .json or .npz; s, rad, m.",
    ),
]

# Pictures.
What = Annotated[
    Picture, Argument(metavar="[WHAT]", help="arm, branches, overlay, limits, workspace, sliders, path or intervals.")
]
At = Annotated[
    str | None, Option("--q", metavar="Q1,Q2,...", help="Joint vector: the posture, or the tip's pose to solve.")
]
Shapes = Annotated[bool, Option("--shapes/--no-shapes", help="The shapes of the links, too, meshes among them.")]
Map = Annotated[
    Path | None,
    Option("--map", metavar="FILE|FOLDER", help="Map that `urdf-ik workspace` made, to cut a layer from."),
]
Across = Annotated[str, Option("--axis", metavar="x|y|z", help="Axis that the layer of the workspace lies across.")]
Layer = Annotated[float, Option("--at", metavar="M", help="Where on that axis [m].")]
FirstAcross = Annotated[str | None, Option("--axis", metavar="x|y|z", help="Axis that the map's layer lies across.")]
FirstLayer = Annotated[
    float | None, Option("--at", metavar="M", help="Where on that axis [m]. Default: the middle.", show_default=False)
]
Shown = Annotated[Value, Option("--show", help="Value of a layer's voxels.")]
PictureFile = Annotated[
    Path | None,
    Option("--output", "-o", metavar="FILE", help="PNG, SVG or PDF. Default: a window.", show_default=False),
]


def print_version(wanted: bool) -> None:
    """Print the version and leave, where that is wanted."""
    if wanted:
        typer.echo(f"urdf-ik {__version__}")
        raise typer.Exit


Version = Annotated[
    bool, Option("--version", callback=print_version, is_eager=True, help="Print the version and leave.")
]

# Where the viewer listens.
Host = Annotated[
    str, Option("--host", metavar="ADDRESS", help="Listen there; 0.0.0.0 lets everybody in the network in.")
]
Port = Annotated[
    int | None,
    Option("--port", metavar="PORT", help="Default: 8080, or the first free one after it.", show_default=False),
]
Dark = Annotated[bool, Option("--dark", help="Light on dark.")]
Page = Annotated[
    Path | None, Option("--output", "-o", metavar="FILE", help="Write the scene there as one HTML page, and leave.")
]


def is_terminal(stream: IO[str] | None) -> bool:
    """Whether a person reads there; a stream that was closed before the program began is None."""
    return stream is not None and stream.isatty()


def format_for(chosen: Format | None, output: Path | None, *, terminal: bool) -> Format:
    """The format that was asked for, by the file's name where none was.

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
