"""The arm that a command is about: the options that say which, and how it is loaded."""

from __future__ import annotations

import math
import sys
from collections.abc import Collection
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Annotated, Any, ClassVar

import numpy as np
import typer
from numpy.typing import NDArray
from typer import Argument, Option

from urdf_ik.arm import Arm
from urdf_ik.cell import World
from urdf_ik.cli import console
from urdf_ik.cli.console import Angles
from urdf_ik.cli.options import PoseOptions
from urdf_ik.cli.prompt.completion import links, robots_and_files
from urdf_ik.errors import escaped
from urdf_ik.model.urdf import UrdfModel
from urdf_ik.support.text import quoted

_XYZ = ("x", "y", "z")
_MOST_WARNINGS = 10


@dataclass(frozen=True)
class ArmOptions:
    """Every option of loading an arm, as typed; the keyword arguments of ``urdf_ik.load`` and a tool."""

    GROUP: ClassVar[str] = "The arm"
    robot: Annotated[
        str,
        Argument(
            metavar="ROBOT",
            help="URDF, xacro or MJCF file (or its gzip), a name of `urdf-ik robots`, or - for stdin.",
            autocompletion=robots_and_files,
        ),
    ]
    base: Annotated[
        str | None, Option(metavar="LINK", help="Base link: poses are in its frame.", autocompletion=links)
    ] = None
    tip: Annotated[
        str | None, Option(metavar="LINK", help="Tip link: poses are of its frame.", autocompletion=links)
    ] = None
    chain: Annotated[str | None, Option(metavar="NAME", help="A chain of `info --chains`, or a group of an SRDF.")] = (
        None
    )
    srdf: Annotated[
        Path | None,
        Option(
            metavar="FILE",
            exists=True,
            dir_okay=False,
            help="SRDF: its groups are chains, its disabled pairs may touch.",
        ),
    ] = None
    allow: Annotated[
        list[str] | None,
        Option(metavar="LINK,LINK", help="Two links that may touch (`info --pairs`); repeatable."),
    ] = None
    lock: Annotated[
        list[str] | None, Option(metavar="NAME=VALUE", help="Hold a joint: rad, m, or 30deg; repeatable.")
    ] = None
    mesh_root: Annotated[
        list[Path] | None,
        Option(metavar="DIR", exists=True, file_okay=False, help="Folder of meshes or ROS packages; repeatable."),
    ] = None
    xacro_arg: Annotated[list[str] | None, Option(metavar="NAME:=VALUE", help="Argument of a xacro; repeatable.")] = (
        None
    )
    strict: Annotated[bool, Option("--strict", help="Refuse defects anywhere in the URDF.")] = False
    tool_xyz: Annotated[
        str | None, Option(metavar="X,Y,Z", help="Put a tool there: its point in the tip link [m].")
    ] = None
    tool_rpy: Annotated[str | None, Option(metavar="R,P,Y", help="The tool's orientation in the tip link [rad].")] = (
        None
    )
    redundancy_joint: Annotated[
        list[str] | None,
        Option(metavar="NAME", help="Joint whose value is a redundancy parameter; repeatable."),
    ] = None
    free_axis: Annotated[
        str | None,
        Option(metavar="x|y|z|X,Y,Z", help="Axis about which the tool may turn freely, in the tip."),
    ] = None
    free_at: Annotated[str | None, Option(metavar="X,Y,Z", help="A point of that axis, in the tip link [m].")] = None

    def load(self, degrees: bool = False) -> Arm:
        """The arm.

        Args:
            degrees: whether the tool's orientation is in degrees.

        Raises:
            typer.BadParameter: standard input is closed, or a lock or a tool's place cannot be understood.
            UrdfIkError: there is no such arm.
        """
        tool = self._tool(degrees)
        arm = self._loaded()
        _say_warnings(arm.model)
        self._say_which(arm)
        if tool is not None:
            names = ("tool", *(f"tool_{k}" for k in range(2, len(arm.model.links) + 3)))
            arm = arm.with_tool(tool, name=next(name for name in names if name not in arm.model.links))
        for typed in self.allow or ():
            first, comma, second = (part.strip() for part in typed.partition(","))
            if not (first and comma and second):
                raise typer.BadParameter(f"{quoted(typed)} is not LINK,LINK", param_hint="--allow")
            arm = arm.with_cell(arm.cell.allow(first, second))
        return self._freed(arm)

    def _freed(self, arm: Arm) -> Arm:
        """The arm with the free axis of the options, if there is one."""
        if self.free_axis is None:
            if self.free_at is not None:
                raise console.usage("a point on an axis needs the axis: --free-axis z", "--free-at")
            return arm
        named = self.free_axis.strip() in ("x", "y", "z")
        axis = self.free_axis.strip() if named else console.numbers(self.free_axis, "--free-axis", _XYZ)
        at = None if self.free_at is None else console.numbers(self.free_at, "--free-at", _XYZ)
        return arm.with_free_axis(axis, at)

    def model(self) -> UrdfModel:
        """The whole URDF, whichever chain is meant.

        Raises:
            typer.BadParameter: standard input is closed, or an argument of a xacro cannot be understood.
            UrdfIkError: there is no such robot.
        """
        from urdf_ik.arm.loading import read

        roots, arguments = self.mesh_root or (), self._xacro_args()
        model = read(self._source(), mesh_roots=roots, xacro_args=arguments, strict=self.strict)[0]
        _say_warnings(model)
        return model

    def _loaded(self) -> Arm:
        from urdf_ik.arm import is_compiled, load, load_compiled

        source = self._source()
        if is_compiled(source):
            kept = ("mesh_root", "xacro_arg", "strict", "allow", "tool_xyz", "tool_rpy")
            self.require_only(kept, f"{self.robot} is a compiled arm, which has its settings")
            return load_compiled(source)
        return load(
            source,
            base=self.base,
            tip=self.tip,
            chain=self.chain,
            srdf=self.srdf,
            locked=self._locked(),
            redundancy=self.redundancy_joint or (),
            mesh_roots=self.mesh_root or (),
            xacro_args=self._xacro_args(),
            strict=self.strict,
        )

    def _source(self) -> Any:
        if self.robot == "-" and sys.stdin is None:
            raise typer.BadParameter("standard input is closed", param_hint="ROBOT")
        return sys.stdin.buffer if self.robot == "-" else self.robot

    def _locked(self) -> dict[str, float]:
        """Joint names and values [rad or m] of ``NAME=VALUE``; a value that ends in ``deg`` is in degrees."""
        out = {}
        for text in self.lock or ():
            name, _, value = text.rpartition("=")
            number = value.strip().removesuffix("deg")
            try:
                out[name.strip()] = math.radians(float(number)) if number != value.strip() else float(number)
            except ValueError:
                name = ""
            if not name:
                message = f"{quoted(text)} is not NAME=VALUE, such as joint_7=0.5 or joint_7=30deg"
                raise typer.BadParameter(message, param_hint="--lock")
        return out

    def _xacro_args(self) -> dict[str, str] | None:
        """Arguments of a xacro; None where there are none, so that only a xacro is read as one."""
        parts = [typed.partition(":=") for typed in self.xacro_arg or ()]
        for (name, given, _), typed in zip(parts, self.xacro_arg or (), strict=True):
            if not (name and given):
                raise typer.BadParameter(f"{quoted(typed)} is not NAME:=VALUE", param_hint="--xacro-arg")
        return {name: value for name, _, value in parts} or None

    def _say_which(self, arm: Arm) -> None:
        """Say on standard error which chain was chosen of several, or which tip of several links at its end."""
        if self.tip is not None or self.robot in _catalogue_names():
            return
        chains = arm.model.chains(self.base)
        meant = [each for each in chains if each.tip == arm.tip]
        others = len(chains) - len(meant)
        if not meant or not (others or meant[0].frames):
            return
        also = f"; {', '.join(meant[0].frames[:4])} are fixed to it, too" if meant[0].frames else ""
        also = also.replace(" are fixed to it", " is fixed to it") if len(meant[0].frames) == 1 else also
        rest = f"; `urdf-ik info --chains` lists {others} more" if others else ""
        typer.echo(escaped(f"chain: {arm.base} to {arm.tip} ({meant[0].reason}){also}{rest}"), err=True)

    def _tool(self, degrees: bool) -> NDArray[np.float64] | None:
        """Pose of the tool's centre point in the tip link; None without a tool."""
        if self.tool_xyz is None and self.tool_rpy is None:
            return None
        from urdf_ik.model.poses import pose

        xyz, rpy = (
            console.numbers("0,0,0" if typed is None else typed, option, names)
            for typed, option, names in (
                (self.tool_xyz, "--tool-xyz", _XYZ),
                (self.tool_rpy, "--tool-rpy", ("roll", "pitch", "yaw")),
            )
        )
        return pose(xyz, rpy=np.deg2rad(rpy) if degrees else rpy)

    def require_only(self, names: Collection[str], why: str) -> None:
        """Refuse options of one arm where there is none.

        Raises:
            typer.BadParameter: an option other than ``names`` is given.
        """
        for each in fields(self):
            if each.name not in ("robot", *names) and getattr(self, each.name):
                option = f"--{each.name.replace('_', '-')}"
                raise console.usage(f"{why}, and {option} is for an arm", option)

    def without_stdin(self, source: str | None, option: str) -> None:
        """Refuse that ``source``, which ``option`` names, is standard input too."""
        if self.robot == "-" and source == "-":
            raise typer.BadParameter("the robot is read from standard input already", param_hint=option)

    def apart_from(self, typed: PoseOptions) -> None:
        """Refuse that poses come from standard input, too."""
        self.without_stdin(typed.poses, "--poses")
        for text in typed.q or ():
            self.without_stdin(text, "--q")


def read_world(file: Path | None, arm: ArmOptions) -> World | None:
    """The obstacles of a URDF; its meshes may come from the folders of ``--mesh-root``, too."""
    if file is None:
        return None
    from urdf_ik.cell import World

    return World.from_urdf(file, package_dirs=arm.mesh_root or ())


def _catalogue_names() -> tuple[str, ...]:
    from urdf_ik.model import catalogue

    return catalogue.names()


def angles_of(arm: Arm, degrees: bool) -> Angles:
    """How the arm's joint values are typed and shown."""
    return Angles(degrees, np.array([kind != "prismatic" for kind in arm.chain.joint_types]))


def _say_warnings(model: UrdfModel) -> None:
    """Say on standard error which parts of the URDF were not read as they are written."""
    for warning in model.warnings[:_MOST_WARNINGS]:
        typer.echo(escaped(f"warning: {warning}"), err=True)
    if len(model.warnings) > _MOST_WARNINGS:
        typer.echo(f"warning: {len(model.warnings) - _MOST_WARNINGS} more; `urdf-ik info` lists them", err=True)
