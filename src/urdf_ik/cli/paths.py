"""A path as it is typed for ``urdf-ik path``, ``plot path`` and ``view``, and the plan along it."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from urdf_ik import paths
from urdf_ik.cli import console
from urdf_ik.cli.progress import Elapsed

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from urdf_ik.arm import Arm
    from urdf_ik.cell import World
    from urdf_ik.cli.chosen_arm import ChosenArm, TypedPath
    from urdf_ik.cli.console import Angles
    from urdf_ik.paths import Plan

    Array = NDArray[np.float64]


@dataclass(frozen=True)
class Followed:
    """A plan and what it was made of.

    Attributes:
        plan: found or not.
        source: the file of the waypoints, as a message calls it.
        world: its obstacles, or None.
        cost: what it costs least of.
        seconds: that it took.
    """

    plan: Plan
    source: str
    world: World | None
    cost: str
    seconds: float


def followed(arm: Arm, angles: Angles, typed: TypedPath, chosen: ChosenArm) -> Followed:
    """Read the waypoints and the world, and follow them.

    Raises:
        typer.BadParameter: no waypoints, or a value that is no number.
        UrdfIkError: a file that cannot be read, or a setting that makes no sense.
    """
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
    world = cell(typed.world, chosen)
    with Elapsed("following the path") as progress:
        poses = waypoints(typed.waypoints, angles)
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
    return Followed(plan, console.place(typed.waypoints), world, cost, progress.seconds)


def waypoints(source: str, angles: Angles) -> Array:
    """Poses (m, 4, 4) from a file, or from standard input for ``-``."""
    return paths.read_waypoints(console.opened(source, "--waypoints"), degrees=angles.degrees)


def cell(source: Path | None, chosen: ChosenArm) -> World | None:
    """The obstacles of a URDF; its meshes may come from the folders of ``--mesh-root``, too."""
    if source is None:
        return None
    from urdf_ik.cell import World

    return World.from_urdf(source, package_dirs=chosen.mesh_root or ())
