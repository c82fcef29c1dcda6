"""The settings of a path: the one place that declares them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from urdf_ik.cell import World
from urdf_ik.support.settings import Form, documented, setting

COSTS = ("l1", "l2", "max", "time")


@documented
@dataclass(frozen=True)
class PathSettings:
    """Settings of a path: the keyword arguments of :meth:`urdf_ik.Arm.follow`, and the options of ``urdf-ik path``.

    ``progress``, a function, is called with what is being looked at, in words; it is no option of the command.
    """

    start: Any = setting(
        None, "Joint vector at the first waypoint; by default the best one.", Form.JOINT_VECTOR, "rad or m"
    )
    end: Any = setting(
        None, "Joint vector at the last waypoint; by default the best one.", Form.JOINT_VECTOR, "rad or m"
    )
    world: World | None = setting(None, "Obstacles.", Form.WORLD)
    margin: float = setting(0.0, "Distance that bodies must keep from each other and from obstacles.", Form.NUMBER, "m")
    collisions: bool | str = setting(
        True,
        "Whether contacts are checked, at the waypoints and all the way between them; by default where the collision "
        "shapes can be read.",
        Form.CHECK,
    )
    cost: str = setting(
        "l2",
        "Cost of a step: the sum of |dq| (l1), of dq^2 (l2), the largest |dq| (max), or the time it takes (time).",
        Form.CHOICE,
        choices=COSTS,
    )
    weights: Any = setting(None, "Factor on |dq| of each joint, on dq^2 for l2; by default 1.", Form.EACH_JOINT)
    limit_cost: float = setting(
        0.0,
        "Weight of the squared nearness to the nearest limit, 0 in the middle of the range and 1 at the limit.",
        Form.NUMBER,
    )
    max_step: Any = setting(None, "Largest step of a joint between two waypoints.", Form.EACH_JOINT, "rad or m")
    tolerance: Any = setting(
        None,
        "Largest distance of the tip from the straight segments; by default 0.001 m and 0.02 rad, or four times these "
        "where no plan keeps to them.",
        Form.LENGTH_AND_ANGLE,
        "m, rad",
    )
    reconfigure: bool = setting(
        False, "Whether the branch may change, as seldom as possible, where no motion leads all the way.", Form.FLAG
    )
    time_limit: float | None = setting(
        None,
        "Longest search; then the best plan so far.",
        Form.NUMBER,
        "s",
    )
    progress: Callable[[str], object] | None = None
