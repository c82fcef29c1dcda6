"""Options of a path, for ``urdf-ik path``, ``plot path`` and ``view``; and the plan along it."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum
from typing import TYPE_CHECKING, Annotated

import numpy as np
from typer import Option

from urdf_ik.cli import console, options
from urdf_ik.cli.arm_options import ArmOptions, read_world
from urdf_ik.cli.progress import Elapsed

if TYPE_CHECKING:
    from urdf_ik.arm import Arm
    from urdf_ik.cell import World
    from urdf_ik.cli.console import Angles
    from urdf_ik.paths import Plan


class Cost(StrEnum):
    """Cost of a path."""

    L1 = "l1"
    L2 = "l2"
    MAX = "max"
    TIME = "time"


@dataclass(frozen=True)
class PathOptions:
    """A path and its settings, as typed; None for what was not given."""

    waypoints: Annotated[
        str | None,
        Option("--waypoints", "-w", metavar="FILE", help=f"Poses of the tip: {options.POSES_IN_A_FILE}"),
    ] = None
    world: options.World = None
    start: Annotated[str | None, Option(metavar="Q1,Q2,...", help="Joint vector at the first waypoint.")] = None
    end: Annotated[str | None, Option(metavar="Q1,Q2,...", help="Joint vector at the last waypoint.")] = None
    margin: options.Clear = None
    cost: Annotated[
        Cost | None,
        Option(help="Least sum of |dq|, of dq^2, of each step's largest |dq|, or of time. Default: l2."),
    ] = None
    limit_cost: Annotated[
        float | None, Option(metavar="WEIGHT", help="Adds to the cost for being near a joint limit.")
    ] = None
    max_step: Annotated[
        str | None,
        Option(metavar="STEP", help="Largest joint step between waypoints: one number, or one a joint."),
    ] = None
    tolerance: Annotated[
        str | None,
        Option(
            metavar="M,RAD",
            help="Distance of the tip from the straight segments. Default: 0.001,0.02, or four times it if need be.",
        ),
    ] = None
    reconfigure: Annotated[
        bool | None,
        Option("--reconfigure", help="Where no motion leads all the way, change the branch as seldom as possible."),
    ] = None
    collisions: Annotated[
        bool | None,
        Option("--collisions/--no-collisions", help="Stay free of contacts, which is the default, or don't ask."),
    ] = None


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


def followed(arm: Arm, angles: Angles, typed: PathOptions, chosen: ArmOptions) -> Followed:
    """Read the waypoints and the world, and follow them.

    Raises:
        typer.BadParameter: no waypoints, or a value that is no number.
        UrdfIkError: a file that cannot be read, or a setting that makes no sense.
    """
    from urdf_ik import paths

    if typed.waypoints is None:
        raise console.usage("a file of waypoints is needed, such as seam.csv", "--waypoints")
    chosen.without_stdin(typed.waypoints, "--waypoints")
    names = arm.joint_names
    vectors = {
        option: None if text is None else angles.typed(console.numbers(text, f"--{option}", names))
        for option, text in (("start", typed.start), ("end", typed.end))
    }
    step = None
    if typed.max_step is not None:
        one = len(typed.max_step.replace(",", " ").split()) == 1
        step = angles.typed(
            np.broadcast_to(console.numbers(typed.max_step, "--max-step", ("step",) if one else names), len(names))
        )
    tolerance = None
    if typed.tolerance is not None:
        far, turned = console.numbers(typed.tolerance, "--tolerance", ("m", angles.unit)).tolist()
        tolerance = far, float(np.deg2rad(turned)) if angles.degrees else turned
    world = read_world(typed.world, chosen)
    with Elapsed("following the path") as progress:
        poses = paths.read_waypoints(console.opened(typed.waypoints, "--waypoints"), degrees=angles.degrees)
        cost = "l2" if typed.cost is None else str(typed.cost.value)
        plan = arm.follow(
            poses,
            **vectors,
            world=world,
            margin=typed.margin or 0.0,
            collisions=typed.collisions is not False,
            cost=cost,
            margins=typed.limit_cost or 0.0,
            max_step=step,
            tolerance=tolerance,
            reconfigure=bool(typed.reconfigure),
        )
    return Followed(arm, plan, console.place(typed.waypoints), world, cost, progress.seconds)
