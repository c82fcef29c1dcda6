"""What several commands take, once: the arm that they are about and how it is loaded, and a pose as it is typed."""

from __future__ import annotations

import functools
import inspect
import sys
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import typer

from urdf_ik.cli import options
from urdf_ik.cli.chunked import options as chunked
from urdf_ik.cli.chunked.places import Places
from urdf_ik.errors import escaped
from urdf_ik.support.text import quoted

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from urdf_ik.arm import Arm
    from urdf_ik.cli.console import Angles
    from urdf_ik.model.urdf import UrdfModel


@dataclass(frozen=True)
class ChosenArm:
    """The options as typed: a URDF file, a name or '-', and what is asked of it."""

    robot: str
    base: str | None = None
    tip: str | None = None
    lock: list[str] | None = None
    chain: str | None = None
    srdf: Path | None = None
    mesh_root: list[Path] | None = None
    xacro_arg: list[str] | None = None
    tool_xyz: str | None = None
    tool_rpy: str | None = None
    redundancy_joint: list[str] | None = None
    free_axis: str | None = None
    free_at: str | None = None
    degrees: bool = False

    def load(self) -> Arm:
        """The arm.

        Raises:
            typer.BadParameter: standard input is closed, or a lock or a tool's place cannot be understood.
            UrdfIkError: there is no such arm.
        """
        from urdf_ik.arm import load
        from urdf_ik.cli import free_value

        source = self._source()
        locked = free_value.locked(self.lock or (), "--lock")
        tool = self._tool()
        arm = load(
            source,
            base=self.base,
            tip=self.tip,
            chain=self.chain,
            srdf=self.srdf,
            locked=locked,
            redundancy=self.redundancy_joint or (),
            mesh_roots=self.mesh_root or (),
            xacro_args=self._xacro_args(),
        )
        self._say_which(arm)
        if tool is not None:
            names = ("tool", *(f"tool_{k}" for k in range(2, len(arm.model.links) + 3)))
            arm = arm.with_tool(tool, name=next(name for name in names if name not in arm.model.links))
        return self._freed(arm)

    def _freed(self, arm: Arm) -> Arm:
        """The arm with its free axis, where one is asked for."""
        from urdf_ik.cli import console

        if self.free_axis is None:
            if self.free_at is not None:
                raise console.usage("a point on an axis needs the axis: --free-axis z", "--free-at")
            return arm
        named = self.free_axis.strip() in ("x", "y", "z")
        axis = self.free_axis.strip() if named else console.numbers(self.free_axis, "--free-axis", ("x", "y", "z"))
        at = None if self.free_at is None else console.numbers(self.free_at, "--free-at", ("x", "y", "z"))
        return arm.with_free_axis(axis, at)

    def model(self) -> UrdfModel:
        """The whole URDF, whichever chain is meant.

        Raises:
            typer.BadParameter: standard input is closed, or an argument of a xacro cannot be understood.
            UrdfIkError: there is no such robot.
        """
        from urdf_ik.arm.loading import read

        return read(self._source(), mesh_roots=self.mesh_root or (), xacro_args=self._xacro_args())[0]

    def _source(self) -> Any:
        if self.robot == "-" and sys.stdin is None:
            raise typer.BadParameter("standard input is closed", param_hint="ROBOT")
        return sys.stdin.buffer if self.robot == "-" else self.robot

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

    def _tool(self) -> NDArray[np.float64] | None:
        """Pose of the tool's centre point in the tip link; None without a tool."""
        if self.tool_xyz is None and self.tool_rpy is None:
            return None
        import numpy as np

        from urdf_ik.cli import console
        from urdf_ik.model.poses import pose

        xyz, rpy = (
            console.numbers("0,0,0" if typed is None else typed, option, names)
            for typed, option, names in (
                (self.tool_xyz, "--tool-xyz", ("x", "y", "z")),
                (self.tool_rpy, "--tool-rpy", ("roll", "pitch", "yaw")),
            )
        )
        return pose(xyz, rpy=np.deg2rad(rpy) if self.degrees else rpy)

    def without_stdin(self, source: str | None, option: str) -> None:
        """Refuse that ``source``, which ``option`` names, is standard input too."""
        if self.robot == "-" and source == "-":
            raise typer.BadParameter("the robot is read from standard input already", param_hint=option)


@dataclass(frozen=True)
class TypedPose:
    """A position and an orientation as typed; None where one was not given."""

    xyz: str | None
    quat_xyzw: str | None
    quat_wxyz: str | None
    rpy: str | None
    rotvec: str | None

    @property
    def orientations(self) -> Mapping[str, str | None]:
        """Each orientation by its option."""
        return {
            "--quat-xyzw": self.quat_xyzw,
            "--quat-wxyz": self.quat_wxyz,
            "--rpy": self.rpy,
            "--rotvec": self.rotvec,
        }


@dataclass(frozen=True)
class TypedPath:
    """A path and what it must keep to, as typed; None where that was not given."""

    waypoints: str | None
    world: Path | None
    start: str | None
    end: str | None
    margin: float | None
    cost: options.Cost | None
    limit_cost: float | None
    max_step: str | None
    tolerance: str | None
    reconfigure: bool | None
    collisions: bool | None


_CHOSEN = {
    "base": options.Base,
    "tip": options.Tip,
    "chain": options.ChainName,
    "srdf": options.Srdf,
    "lock": options.Lock,
    "mesh_root": options.MeshRoot,
    "xacro_arg": options.XacroArg,
    "tool_xyz": options.ToolXyz,
    "tool_rpy": options.ToolRpy,
    "redundancy_joint": options.RedundancyJoint,
    "free_axis": options.FreeAxis,
    "free_at": options.FreeAt,
}
_TYPED = {
    "xyz": options.Position,
    "quat_xyzw": options.QuatXyzw,
    "quat_wxyz": options.QuatWxyz,
    "rpy": options.Rpy,
    "rotvec": options.Rotvec,
}
_PATH = {
    "waypoints": options.Waypoints,
    "world": options.Cell,
    "start": options.StartAt,
    "end": options.EndAt,
    "margin": options.Apart,
    "cost": options.LeastOf,
    "limit_cost": options.LimitCost,
    "max_step": options.MaxStep,
    "tolerance": options.Straying,
    "reconfigure": options.Reconfigure,
    "collisions": options.Contacts,
}
_WORK = {"store": chunked.Store, "workers": chunked.Workers, "scheduler": chunked.Scheduler}
_GROUPS: Mapping[str, Mapping[str, Any]] = {"chosen": _CHOSEN, "typed": _TYPED, "path": _PATH, "work": _WORK}


def _catalogue_names() -> tuple[str, ...]:
    from urdf_ik.model import catalogue

    return catalogue.names()


def on_an_arm(command: Callable[..., None]) -> Callable[..., None]:
    """``command`` with ROBOT as first argument, and options in the places of its parameters.

    ``chosen``, a ``ChosenArm``, stands for those that say which arm; ``typed``, a ``TypedPose``, for those of a pose;
    ``path``, a ``TypedPath``, for those of a path; ``work``, a ``Places``, for where long work is kept and who does it.
    An option of a group that is a parameter, too, is declared by the parameter.
    """
    signature = inspect.signature(command, eval_str=True)

    @functools.wraps(command)
    def run(robot: str, **given: Any) -> None:
        typed = {name: given.pop(name) for name in _CHOSEN}
        given["chosen"] = ChosenArm(robot, **typed, degrees=given.get("degrees", False))
        if "typed" in signature.parameters:
            given["typed"] = TypedPose(**{name: given.pop(name) for name in _TYPED})
        if "path" in signature.parameters:
            given["path"] = TypedPath(**{name: given.pop(name) for name in _PATH})
        if "work" in signature.parameters:
            work = {name: given[name] for name in _WORK}
            given = {name: value for name, value in given.items() if name in signature.parameters}
            given["work"] = Places(**work)
        command(**given)

    keyword = inspect.Parameter.KEYWORD_ONLY
    parameters = [inspect.Parameter("robot", inspect.Parameter.POSITIONAL_OR_KEYWORD, annotation=options.Robot)]
    for name, parameter in signature.parameters.items():
        if name in _GROUPS:
            group = {n: kind for n, kind in _GROUPS[name].items() if n not in signature.parameters}
            parameters += [inspect.Parameter(n, keyword, default=None, annotation=kind) for n, kind in group.items()]
        else:
            parameters.append(parameter)
    run.__signature__ = signature.replace(parameters=parameters)  # type: ignore[attr-defined]
    return run


def angles_of(arm: Arm, degrees: bool) -> Angles:
    """How the arm's joint values are typed and shown."""
    import numpy as np

    from urdf_ik.cli.console import Angles

    return Angles(degrees, np.array([kind != "prismatic" for kind in arm.chain.joint_types]))
