"""``urdf-ik compare``: two arms or more against each other."""

from __future__ import annotations

import re
import string
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from urdf_ik.cli import options
from urdf_ik.cli.chosen_arm import ChosenArm
from urdf_ik.cli.commands.verify import Degrees, Ignored, Millimetres
from urdf_ik.cli.errors import Status
from urdf_ik.cli.options import ReportFormat
from urdf_ik.cli.program import app, help_text
from urdf_ik.support.inputs import MOST_POSES

if TYPE_CHECKING:
    from urdf_ik.verify.comparison import Comparison, ManyArms

_ONE = "for one arm: A=..., B=..."

_FOR_ONE = re.compile(r"([A-Z])=(.*)", re.DOTALL)
_REPEATED = ("lock", "mesh_root", "xacro_arg", "redundancy_joint")


def _option(name: str, metavar: str, what: str) -> Any:
    return typer.Option(name, metavar=metavar, help=f"{what}; {_ONE}")


Robots = Annotated[
    list[str],
    typer.Argument(
        metavar="A B [C ...]", help="URDF files, names, or - for stdin. The first is what the others are compared with."
    ),
]
Base = Annotated[list[str] | None, _option("--base", "LINK", "Base link")]
Tip = Annotated[list[str] | None, _option("--tip", "LINK", "Tip link")]
Chain = Annotated[
    list[str] | None,
    _option("--chain", "NAME", "Which arm of several, as `info --chains` names it, or an SRDF's group"),
]
Srdf = Annotated[list[str] | None, _option("--srdf", "FILE", "SRDF, whose groups are the chains")]
Lock = Annotated[list[str] | None, _option("--lock", "NAME=VALUE", "Hold a joint there: rad or m, or 30deg")]
MeshRoot = Annotated[list[str] | None, _option("--mesh-root", "DIR", "Where meshes and ROS packages are looked for")]
XacroArg = Annotated[list[str] | None, _option("--xacro-arg", "NAME:=VALUE", "Argument of a xacro")]
ToolXyz = Annotated[
    list[str] | None,
    _option("--tool-xyz", "X,Y,Z", "Put a tool at the tip: its centre point in the tip link [m]"),
]
ToolRpy = Annotated[list[str] | None, _option("--tool-rpy", "R,P,Y", "Orientation of that tool [rad]")]
RedundancyJoint = Annotated[
    list[str] | None,
    _option("--redundancy-joint", "NAME", "Of more than six joints: the value of this one is free"),
]
FreeAxis = Annotated[list[str] | None, _option("--free-axis", "x|y|z|X,Y,Z", "Let the tip turn about this axis of it")]
FreeAt = Annotated[list[str] | None, _option("--free-at", "X,Y,Z", "A point of that axis, in the tip link [m]")]
Poses = Annotated[
    str | None,
    typer.Option("--poses", metavar="FILE", help=f"Ask all arms for these, too: {options.POSES_IN_A_FILE}"),
]
Each = Annotated[int, typer.Option("-n", "--random", min=1, max=MOST_POSES, help="Random poses that each arm makes.")]
ExitCode = Annotated[bool, typer.Option("--exit-code", help="End with status 1 where arms differ.")]


@app.command(
    help=help_text(
        "Compare arms, or URDFs of one arm (another tool, a calibrated copy): structure, frames, limits, shapes, "
        "reach, number of solutions for the same poses, joint values branch by branch, and how far B's tool is off "
        "when it is given A's joint vectors. What is the same to rounding is called the same.\n\n"
        "An option is for all arms; with a letter it is for one of them: --tip tool0, or --tip B=flange.",
        "urdf-ik compare zyyzyz_6r puma_560",
        "urdf-ik compare nominal.urdf calibrated.urdf --exit-code --tolerance-mm 0.5",
        "urdf-ik compare zyyzyz_6r my_arm.urdf --tip B=tool0 --tool-xyz 0,0,0.1 -n 100",
        "urdf-ik compare ur5 ur10 puma_560 --poses stations.csv",
    )
)
def compare(
    robots: Robots,
    base: Base = None,
    tip: Tip = None,
    chain: Chain = None,
    srdf: Srdf = None,
    lock: Lock = None,
    mesh_root: MeshRoot = None,
    xacro_arg: XacroArg = None,
    tool_xyz: ToolXyz = None,
    tool_rpy: ToolRpy = None,
    redundancy_joint: RedundancyJoint = None,
    free_axis: FreeAxis = None,
    free_at: FreeAt = None,
    poses: Poses = None,
    n: Each = 200,
    seed: options.Seed = 0,
    tolerance_mm: Millimetres = None,
    tolerance_deg: Degrees = None,
    ignore: Ignored = None,
    exit_code: ExitCode = False,
    printed_as: options.TextFormat = ReportFormat.TABLE,
) -> None:
    """Print the comparison."""
    from urdf_ik.cli import console
    from urdf_ik.cli.progress import Progress
    from urdf_ik.support.text import json_text
    from urdf_ik.verify import comparison

    given = {
        "base": base, "tip": tip, "chain": chain, "srdf": srdf, "lock": lock, "mesh_root": mesh_root,
        "xacro_arg": xacro_arg, "tool_xyz": tool_xyz, "tool_rpy": tool_rpy, "redundancy_joint": redundancy_joint,
        "free_axis": free_axis, "free_at": free_at,
    }  # fmt: skip
    chosen = _chosen(robots, given)
    for each in chosen:
        each.without_stdin(poses, "--poses")
    own = None if poses is None else console.read_poses(poses, "--poses")
    arms = [each.load() for each in chosen]
    with Progress("comparing", "solving") as progress:
        found = [
            comparison.compare(
                arms[0],
                other,
                n=n,
                seed=seed,
                poses=own,
                tolerance_mm=tolerance_mm,
                tolerance_deg=tolerance_deg,
                ignore=ignore or (),
                progress=progress.tick,
            )  # fmt: skip
            for other in arms[1:]
        ]
    many = None
    if own is not None:
        many = comparison.compare_many({_called(k, robots): arm for k, arm in enumerate(arms)}, own)
    if printed_as is ReportFormat.JSON:
        whole = {"comparisons": [each.to_dict() for each in found], "poses": None if many is None else many.to_dict()}
        console.write(found[0].to_json() if len(found) == 1 and many is None else json_text(whole), None)
    else:
        console.write(as_text(found, many), None)
    if exit_code and not all(each.same for each in found):
        raise typer.Exit(Status.FAILED)


def as_text(found: list[Comparison], many: ManyArms | None) -> str:
    """The tables of every comparison, and of the poses that were given."""
    from urdf_ik.cli import tables

    parts: list[Any] = []
    sections = [section for each in found for section in each.sections()]
    for section in [*sections, *([] if many is None else [many.section()])]:
        parts += [""] * bool(parts) + [section.title]
        if section.rows:
            parts.append(tables.grid(section.header, section.rows, left=section.left))
        parts += section.remarks
    return tables.render(*parts)


def _called(k: int, robots: list[str]) -> str:
    return f"{string.ascii_uppercase[k]} {Path(robots[k]).name}"


def _chosen(robots: list[str], given: dict[str, list[str] | None]) -> list[ChosenArm]:
    """Each arm with the options that are for it.

    Raises:
        typer.BadParameter: too few or too many arms, a letter without an arm, or an option twice for one arm.
    """
    from urdf_ik.cli import console
    from urdf_ik.support.text import quoted

    most = len(string.ascii_uppercase)
    if not 2 <= len(robots) <= most:
        raise console.usage(f"{len(robots)} arm{'s' * (len(robots) != 1)} given; two to {most} can be compared", "A B")
    if robots.count("-") > 1:
        raise console.usage("only one arm can be read from standard input", "A B")
    arms = [ChosenArm(robot) for robot in robots]
    for name, values in given.items():
        option = f"--{name.replace('_', '-')}"
        own: list[list[str]] = [[] for _ in robots]
        everyone: list[str] = []
        for value in values or ():
            letter = _FOR_ONE.fullmatch(value)
            if letter is None:
                everyone.append(value)
                continue
            k = string.ascii_uppercase.index(letter[1])
            if k >= len(robots):
                last = string.ascii_uppercase[len(robots) - 1]
                raise console.usage(f"{quoted(value)}: there is no arm {letter[1]}, the last one is {last}", option)
            own[k].append(letter[2])
        for k, mine in enumerate(own):
            taken = [*everyone, *mine] if name in _REPEATED else mine or everyone
            if not taken:
                continue
            if name not in _REPEATED and len(taken) > 1:
                raise console.usage(
                    f"given {len(taken)} times for arm {string.ascii_uppercase[k]}; once is enough", option
                )
            arms[k] = replace(arms[k], **{name: _typed(name, taken, option)})
    return arms


def _typed(name: str, taken: list[str], option: str) -> Any:
    """Values as ``ChosenArm`` holds them; files and folders must be there."""
    from urdf_ik.cli import console
    from urdf_ik.support.text import quoted

    if name not in ("srdf", "mesh_root"):
        return taken if name in _REPEATED else taken[0]
    paths = [Path(each) for each in taken]
    for path in paths:
        if not (path.is_dir() if name == "mesh_root" else path.is_file()):
            kind = "folder" if name == "mesh_root" else "file"
            raise console.usage(f"there is no {kind} {quoted(str(path))}", option)
    return paths if name == "mesh_root" else paths[0]
