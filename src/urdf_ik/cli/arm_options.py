"""The arms that a command is about: the options that say which, and how they are loaded."""

import inspect
import math
import re
import string
import sys
from collections.abc import Collection, Iterator
from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import Any, Self, get_args, get_origin, get_type_hints

import numpy as np

from urdf_ik.arm import Arm, is_compiled
from urdf_ik.cell import World
from urdf_ik.cli import console, options
from urdf_ik.cli.console import Angles, usage
from urdf_ik.cli.options import PoseOptions, Record
from urdf_ik.model import catalogue
from urdf_ik.model.urdf import UrdfModel
from urdf_ik.model.urdf.checks import in_words
from urdf_ik.typing import Array

_XYZ, _RPY = ("x", "y", "z"), ("roll", "pitch", "yaw")
_WARNINGS_SHOWN = 10
_LETTERS = string.ascii_uppercase
_FOR_ONE = re.compile(r"([A-Z])=(.*)", re.DOTALL)


@dataclass(frozen=True)
class ArmOptions(Record):
    """Every option of loading an arm, as typed; the keyword arguments of ``urdf_ik.load`` and a tool.

    Positional:
        robot (ROBOT): URDF, xacro or MJCF file, a name of `urdf-ik robots`, or - for stdin.

    Options:
        base (LINK): Base link: poses are in its frame.
        tip (LINK): Tip link: poses are of its frame.
        chain (NAME): A chain of `info --chains`, or a group of an SRDF.
        srdf (FILE): SRDF: its groups are chains, its disabled pairs may touch.
        allow (LINK,LINK): Two links that may touch (`info --pairs`); repeatable.
        lock (NAME=VALUE): Hold a joint: rad, m, or 30deg; repeatable.
        mesh_root (DIR): Folder of meshes or ROS packages; repeatable.
        xacro_arg (NAME:=VALUE): Argument of a xacro; repeatable.
        strict: Refuse defects anywhere in the URDF.
        tool_xyz (X,Y,Z): Put a tool there: its point in the tip link [m].
        tool_rpy (R,P,Y): The tool's orientation in the tip link [rad].
        tool_cylinder (R,L): The tool's body: a cylinder along z of the tip link, from its origin on [m].
        tool_urdf (FILE): The tool's body: collision shapes of a URDF whose root is the tip link, joints at zero.
        redundancy_joint (NAME): Joint whose value is a redundancy parameter; repeatable.
        free_axis (x|y|z|X,Y,Z): Axis about which the tool may turn freely, in the tip.
        free_at (X,Y,Z): A point of that axis, in the tip link [m].
    """

    GROUP = "The arm"
    robot: str
    base: str | None = None
    tip: str | None = None
    chain: str | None = None
    srdf: Path | None = None
    allow: list[str] | None = None
    lock: list[str] | None = None
    mesh_root: list[Path] | None = None
    xacro_arg: list[str] | None = None
    strict: bool = False
    tool_xyz: str | None = None
    tool_rpy: str | None = None
    tool_cylinder: str | None = None
    tool_urdf: Path | None = None
    redundancy_joint: list[str] | None = None
    free_axis: str | None = None
    free_at: str | None = None

    def loaded(
        self, degrees: bool = False, typed: PoseOptions | None = None, pendant: bool = False
    ) -> tuple[Arm, Angles]:
        """The arm, and how its joint values are typed and shown; see :meth:`load`.

        ``typed``: the poses of the command, which cannot come from standard input if the robot does.
        """
        if typed is not None:
            self.apart_from(typed)
        arm = self.load(degrees)
        if not pendant:
            return arm, angles_of(arm, degrees)
        from urdf_ik.ik.configurations import OPW

        _, second, third, *_ = OPW.from_chain(arm.chain).signs
        return arm, replace(angles_of(arm, degrees), horizon=float(second * third))

    def load(self, degrees: bool = False) -> Arm:
        """The arm; ``degrees``: whether the tool's orientation is in degrees."""
        tool = self._tool(degrees)
        arm = self._loaded()
        _say_warnings(arm.model)
        self._say_which(arm)
        if tool is not None:
            names = ("tool", *(f"tool_{k}" for k in range(2, len(arm.model.links) + 3)))
            name = next(name for name in names if name not in arm.model.links)
            arm = arm.with_tool(tool, self._tool_shapes(), name=name)
        for first, second in _pairs(self.allow, ",", "--allow", "LINK,LINK"):
            arm = arm.with_cell(arm.cell.allow(first, second.strip()))
        if self.free_axis is None:
            if self.free_at is not None:
                raise usage("a point on an axis needs the axis: --free-axis z", "--free-at")
            return arm
        axis = self.free_axis.strip()
        at = None if self.free_at is None else console.numbers(self.free_at, "--free-at", _XYZ)
        return arm.with_free_axis(axis if axis in _XYZ else console.numbers(axis, "--free-axis", _XYZ), at)

    def model(self) -> UrdfModel:
        """The whole URDF, whichever chain is meant."""
        from urdf_ik.arm.loading import read

        roots, arguments = self.mesh_root or (), self._xacro_args()
        model = read(self._source(), mesh_roots=roots, xacro_args=arguments, strict=self.strict)[0]
        _say_warnings(model)
        return model

    def _loaded(self) -> Arm:
        from urdf_ik.arm import load, load_compiled

        source = self._source()
        if is_compiled(source):
            kept = ("mesh_root", "xacro_arg", "strict", "allow", "tool_xyz", "tool_rpy")
            self.require_only(kept, f"{self.robot} is a compiled arm, which has its settings")
            return load_compiled(source)
        return load(source, **self._settings())

    def _settings(self) -> dict[str, Any]:
        """The arguments of ``urdf_ik.load`` that were typed."""
        named: dict[str, Any] = {name: getattr(self, name) for name in ("base", "tip", "chain", "strict")}
        named |= {"locked": self._locked(), "redundancy": self.redundancy_joint, "xacro_args": self._xacro_args()}
        named |= {"srdf": self.srdf and str(self.srdf), "mesh_roots": list(map(str, self.mesh_root or ()))}
        return {name: value for name, value in named.items() if value not in (None, False, {}, [])}

    @property
    def definition(self) -> str:
        """The line of Python that loads the arm; a comment names the options that are no arguments of ``load``."""
        typed = "".join(f", {name}={value!r}" for name, value in self._settings().items())
        names = ("allow", "tool_xyz", "tool_rpy", "tool_cylinder", "tool_urdf", "free_axis", "free_at")
        further = [f"--{name.replace('_', '-')}" for name in names if getattr(self, name)]
        tail = f"  # without {', '.join(further)}" if further else ""
        if is_compiled(self.robot):
            return f"import urdf_ik; arm = urdf_ik.load_compiled({self.robot!r}){tail}"
        source = "sys.stdin.buffer" if self.robot == "-" else repr(self.robot)
        return f"import sys, urdf_ik; arm = urdf_ik.load({source}{typed}){tail}"

    def _source(self) -> Any:
        if self.robot == "-" and sys.stdin is None:
            raise usage("standard input is closed", "ROBOT")
        return sys.stdin.buffer if self.robot == "-" else self.robot

    def _locked(self) -> dict[str, float]:
        """Joint names and values [rad or m] of ``NAME=VALUE``; a value that ends in ``deg`` is in degrees."""
        out, form = {}, "NAME=VALUE, such as joint_7=0.5 or joint_7=30deg"
        for name, value in _pairs(self.lock, "=", "--lock", form):
            number, degrees, _ = value.strip().partition("deg")
            try:
                out[name] = math.radians(float(number)) if degrees else float(number)
            except ValueError:
                raise usage(f"{name}={value} holds no number; give {form}", "--lock") from None
        return out

    def _xacro_args(self) -> dict[str, str] | None:
        """Arguments of a xacro; None where there are none, so that only a xacro is read as one."""
        return dict(_pairs(self.xacro_arg, ":=", "--xacro-arg", "NAME:=VALUE")) or None

    def _say_which(self, arm: Arm) -> None:
        """Say on standard error which chain was chosen of several, or which tip of several links at its end."""
        if self.tip is not None or self.robot in catalogue.names():
            return
        chains = arm.model.chains(self.base) or arm.model.chains()
        meant = [each for each in chains if each.tip == arm.tip]
        others = len(chains) - len(meant)
        if not meant or not (others or meant[0].frames):
            return
        frames = meant[0].frames[:4]
        also = f"; {', '.join(frames)} {'is' if len(frames) == 1 else 'are'} fixed to it, too" if frames else ""
        rest = f"; `urdf-ik info --chains` lists {others} more" if others else ""
        console.say(f"chain: {arm.base} to {arm.tip} ({meant[0].reason}){also}{rest}")

    def _tool(self, degrees: bool) -> Array | None:
        """Pose of the tool's centre point in the tip link; None without a tool."""
        if not (self.tool_xyz or self.tool_rpy or self.tool_cylinder or self.tool_urdf):
            return None
        from urdf_ik.model.poses import pose

        xyz = console.numbers(self.tool_xyz or "0,0,0", "--tool-xyz", _XYZ)
        rpy = console.numbers(self.tool_rpy or "0,0,0", "--tool-rpy", _RPY)
        return pose(xyz, rpy=np.deg2rad(rpy) if degrees else rpy)

    def _tool_shapes(self) -> list[Any]:
        """The tool's shapes, with their poses in the tip link."""
        from urdf_ik.cell.shapes import Cylinder
        from urdf_ik.cell.world import placed_shapes
        from urdf_ik.model import urdf
        from urdf_ik.model.poses import pose

        out: list[Any] = []
        if self.tool_cylinder is not None:
            radius, length = console.numbers(self.tool_cylinder, "--tool-cylinder", ("radius", "length")).tolist()
            out.append((Cylinder(radius, length), pose([0.0, 0.0, 0.5 * length])))
        if self.tool_urdf is not None:
            tool = urdf.read(self.tool_urdf, mesh_roots=self.mesh_root or ())
            out += [(shape, placed) for _, shape, placed in placed_shapes(tool)]
        return out

    def require_only(self, names: Collection[str], why: str) -> None:
        """Refuse options of one arm where there is none."""
        for each in fields(self):
            if each.name not in ("robot", *names) and getattr(self, each.name):
                option = f"--{each.name.replace('_', '-')}"
                raise usage(f"{why}, and {option} is for an arm", option)

    def apart_from(self, typed: PoseOptions) -> None:
        """Refuse that poses come from standard input, too."""
        if self.robot == "-" and "-" in (typed.poses, *(typed.q or ())):
            option = "--poses" if typed.poses == "-" else "--q"
            raise usage("the robot is read from standard input already", option)


def _pairs(texts: list[str] | None, sign: str, option: str, form: str) -> Iterator[tuple[str, str]]:
    """The name before a sign in texts of an option, and what stands after it, verbatim."""
    for text in texts or ():
        name, found, value = text.partition(sign)
        if not (name.strip() and found):
            raise usage(f"{text!r} is not {form}", option)
        yield name.strip(), value


@dataclass(frozen=True)
class SeveralArms(Record):
    """The arms A, B, ... and their options as typed: ``--tip tool0`` for all, ``--tip B=flange`` for the second.

    Positional:
        robots (A B): Files, names that `urdf-ik robots` lists, or - for stdin. The first is the reference.
    """

    GROUP = ArmOptions.GROUP
    robots: list[str]
    options: dict[str, Any]

    @classmethod
    def parameters(cls, command: Any) -> list[inspect.Parameter]:
        """The arms, and each option of an arm as one that is repeatable; a flag holds for all of them."""
        text = options.texts(cls)["robots"]
        out = [options.parameter("robots", list[str], inspect.Parameter.empty, text, cls.GROUP)]
        for one in ArmOptions.parameters(command)[1:]:
            if get_args(one.annotation)[0] is not bool:
                text = options.texts(ArmOptions)[one.name]
                words = text.help.removesuffix(".").removesuffix("; repeatable")
                text = text._replace(help=f"{words}; for one arm: A=..., B=...")
                one = options.parameter(one.name, list[str] | None, None, text, cls.GROUP)
            out.append(one)
        return out

    @classmethod
    def read(cls, values: dict[str, Any]) -> Self:
        """The arms and their options."""
        return cls(values.pop("robots"), values)

    def each(self) -> list[ArmOptions]:
        """Each arm with its options."""
        count = len(self.robots)
        if not 2 <= count <= len(_LETTERS):
            raise usage(f"{count} arm{'s' * (count != 1)} given; two to {len(_LETTERS)} can be compared", "A B")
        if self.robots.count("-") > 1:
            raise usage("only one arm can be read from standard input", "A B")
        letters = _LETTERS[:count]
        return [
            ArmOptions(robot, **{name: self._value(name, letter, letters) for name in self.options})
            for robot, letter in zip(self.robots, letters, strict=True)
        ]

    def _value(self, name: str, letter: str, letters: str) -> Any:
        """The value of an option for one arm: what stands for it alone, else for all; of a list both."""
        values, option = self.options[name], f"--{name.replace('_', '-')}"
        if not isinstance(values, list):
            return values
        split = [(match[1], match[2]) if (match := _FOR_ONE.fullmatch(value)) else ("", value) for value in values]
        for other, value in split:
            if other not in letters:
                raise usage(f"'{other}={value}': there is no arm {other}, the last one is {letters[-1]}", option)
        shared, mine = ([value for place, value in split if place == which] for which in ("", letter))
        if get_origin(get_args(get_type_hints(ArmOptions)[name])[0]) is list:
            return [*shared, *mine] or None
        chosen = mine or shared
        if len(chosen) > 1:
            raise usage(f"given {len(chosen)} times for arm {letter}; once is enough", option)
        return chosen[0] if chosen else None


def read_world(file: Path | None, arm: ArmOptions) -> World | None:
    """The obstacles of a URDF; its meshes may come from the folders of ``--mesh-root``, too."""
    if file is None:
        return None
    from urdf_ik.cell import World

    return World.from_urdf(file, package_dirs=arm.mesh_root or ())


def angles_of(arm: Arm, degrees: bool) -> Angles:
    """How the arm's joint values are typed and shown."""
    return Angles(degrees, np.array([kind != "prismatic" for kind in arm.chain.joint_types]))


def _say_warnings(model: UrdfModel) -> None:
    """Say on standard error which parts of the URDF were not read as they are written."""
    lines = in_words(model.warnings)
    for line in lines[:_WARNINGS_SHOWN]:
        console.say(f"warning: {line}")
    if len(lines) > _WARNINGS_SHOWN:
        console.say(f"warning: {len(lines) - _WARNINGS_SHOWN} more; `urdf-ik info` lists them")
