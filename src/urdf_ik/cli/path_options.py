"""Options of a path, for ``urdf-ik path``, ``plot path`` and ``view``; and the plan along it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated, Any, ClassVar

import numpy as np

from urdf_ik.arm import Arm
from urdf_ik.cell import World
from urdf_ik.cli import console
from urdf_ik.cli.arm_options import ArmOptions, read_world
from urdf_ik.cli.console import Angles
from urdf_ik.cli.options import PoseOptions, SettingsOf
from urdf_ik.cli.progress import Elapsed
from urdf_ik.cli.solutions.targets import Target
from urdf_ik.paths import Plan
from urdf_ik.paths.path_settings import Kind, PathSettings, options


@dataclass(frozen=True)
class PathOptions:
    """The settings of a path, as typed; None for what was not given."""

    GROUP: ClassVar[str] = "Path"
    settings: Annotated[Mapping[str, Any], SettingsOf(PathSettings)]

    def read(self, angles: Angles, chosen: ArmOptions, names: tuple[str, ...]) -> PathSettings:
        """The settings with their values in rad and m.

        Raises:
            typer.BadParameter: a value that is not a number, or too many or too few of them.
            UrdfIkError: the world cannot be read.
        """
        kinds = {name: setting.metadata["kind"] for name, setting in options().items()}
        given = {name: typed for name, typed in self.settings.items() if typed is not None}
        return PathSettings(
            **{name: _value(kinds[name], typed, name, angles, chosen, names) for name, typed in given.items()}
        )


def _value(kind: Kind, typed: Any, name: str, angles: Angles, chosen: ArmOptions, names: tuple[str, ...]) -> Any:
    """The value of a setting, from its option."""
    option = f"--{name.replace('_', '-')}"
    if kind == "joint vector":
        return angles.typed(console.numbers(typed, option, names))
    if kind == "per joint":
        one = len(typed.replace(",", " ").split()) == 1
        values = np.broadcast_to(console.numbers(typed, option, (name,) if one else names), len(names))
        return angles.typed(values) if options()[name].metadata["unit"] else values
    if kind == "length and angle":
        length, angle = console.numbers(typed, option, ("m", angles.unit)).tolist()
        return length, float(np.deg2rad(angle)) if angles.degrees else angle
    if kind == "world":
        return read_world(typed, chosen)
    if kind == "contacts":
        return "require" if typed else False
    return typed.value if kind == "choice" else typed


@dataclass(frozen=True)
class Followed:
    """A plan and its inputs.

    Attributes:
        arm: the arm that follows the path.
        plan: found or not.
        source: the file of the waypoints, as a message calls it.
        world: its obstacles, or None.
        cost: the cost that is least.
        seconds: time that the search took [s].
    """

    arm: Arm
    plan: Plan
    source: str
    world: World | None
    cost: str
    seconds: float


def followed(
    arm: Arm, angles: Angles, waypoints: PoseOptions | Target, path: PathOptions, chosen: ArmOptions
) -> Followed:
    """Read the waypoints, if they are not read yet, and the world, and follow them.

    Raises:
        typer.BadParameter: no waypoints, or a value that is not a number.
        UrdfIkError: a file that cannot be read, or a setting that makes no sense.
    """
    from urdf_ik.cli.solutions import targets

    settings = path.read(angles, chosen, arm.joint_names)
    with Elapsed("following the path") as progress:
        found = waypoints
        if isinstance(found, PoseOptions):
            found = targets.required(arm, found, angles, "waypoints")
        plan = arm.follow(found.poses, **vars(settings))
    return Followed(arm, plan, found.source, settings.world, settings.cost, progress.seconds)
