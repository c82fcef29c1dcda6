"""What a path is asked to keep to: costs, limits of the steps, tolerances; checked once."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from urdf_ik.errors import ArgumentError, printable
from urdf_ik.paths.planner.graph import COSTS
from urdf_ik.paths.planner.joint_steps import Joints
from urdf_ik.paths.planner.straightness import Tolerance
from urdf_ik.support import inputs
from urdf_ik.support.angles import largest_apart
from urdf_ik.support.text import quoted

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from urdf_ik.arm import Arm
    from urdf_ik.paths.planner.obstacles import Obstacles

    Array = NDArray[np.float64]

POSITION, ROTATION = 1e-3, 0.02
"""m and rad: how far the tip may stray from the straight segment between two waypoints, where nothing else is asked."""
LOOSER = 4.0
"""Factor on both, where no tolerance is asked for and no plan keeps to them."""
AT_WAYPOINT = 1e-6
"""m and rad: a start or an end whose pose is farther from its waypoint does not solve it."""


@dataclass(frozen=True)
class Settings:
    """See :meth:`urdf_ik.Arm.follow`.

    Attributes:
        arm: the arm.
        joints: how its joints turn.
        kind: index of the cost in ``COSTS``.
        weights: (n,).
        max_step: (n,) rad or m between two waypoints, infinite where there is no such limit.
        tolerance: from the straight segments.
        start: (n,) joint vector at the first waypoint, or None.
        end: (n,) at the last one, or None.
        obstacles: what to stay clear of.
        margins: weight of the costs of being near a joint limit.
        reconfigure: whether the branch may be changed.
        looser: whether a plan may stray ``LOOSER`` times as far where no plan keeps to the tolerance.
    """

    arm: Arm
    joints: Joints
    kind: int
    weights: Array
    max_step: Array
    tolerance: Tolerance
    start: Array | None
    end: Array | None
    obstacles: Obstacles | None
    margins: float
    reconfigure: bool
    looser: bool

    @property
    def window(self) -> Array:
        """(n,) greatest step that an edge may take: half a turn of its images."""
        half = np.where(self.joints.turn > 0.0, 0.5 * self.joints.turn, np.inf)
        return np.minimum(self.max_step, half) + 1e-12


def read(
    arm: Arm,
    T: Array,
    *,
    start: Any,
    end: Any,
    obstacles: Obstacles | None,
    cost: str,
    weights: Any,
    max_step: Any,
    tolerance: Any,
    margins: float,
    reconfigure: bool,
) -> Settings:
    """The settings of a path, checked.

    Raises:
        ArgumentError: one of them makes no sense or does not fit the arm; the message says what would be valid.
    """
    names = arm.joint_names
    inputs.choice(cost, "cost", (*COSTS, "time"))
    factors = np.ones(len(names)) if weights is None else each_joint("weights", weights, names, zero=True)
    kind = COSTS.index("max" if cost == "time" else cost)
    if cost == "time":
        factors = factors / velocities(arm)
    steps = np.full(len(names), np.inf) if max_step is None else each_joint("max_step", max_step, names)
    margins = inputs.number(margins, "margins", low=0.0)
    reconfigure = inputs.flag(reconfigure, "reconfigure")
    return Settings(
        arm, Joints.of(arm.chain), kind, factors, steps, _tolerance(tolerance),
        _at_pose(arm, "start", start, T[0], 0), _at_pose(arm, "end", end, T[-1], len(T) - 1),
        obstacles, margins, reconfigure, tolerance is None and not reconfigure,
    )  # fmt: skip


def velocities(arm: Arm) -> Array:
    """(n,) rad/s or m/s, the velocity limits that the URDF gives.

    Raises:
        ArgumentError: a joint has no velocity limit.
    """
    limits = arm.velocity_limits
    if missing := [name for name, limit in zip(arm.joint_names, limits, strict=True) if np.isinf(limit)]:
        raise ArgumentError(
            f"{arm.name} has no velocity limit for {', '.join(missing)}: give them, or write "
            '<limit velocity="..."/> in the URDF'
        )
    return limits


def each_joint(name: str, value: Any, names: tuple[str, ...], *, zero: bool = False) -> Array:
    """A positive number for each joint, from one number or from n: within a factor of LARGEST of one.

    zero: whether none of them may be infinite, but zero.

    Raises:
        ArgumentError: ``value`` is neither.
    """
    needed = f"a number, or one for each of {', '.join(map(printable, names))}"
    given = inputs.real(value, name, needed)
    fits = given.shape in ((), (1,), (len(names),))
    numbers = np.broadcast_to(given if fits else np.nan, (len(names),)).copy()
    if not (inputs.usable(numbers) | (numbers == (0.0 if zero else np.inf))).all():
        valid = f"{'zero, or ' if zero else ''}a number {inputs.USABLE}"
        each = ", ".join(map(printable, names))
        raise ArgumentError(f"{name} is {quoted(value)}; {valid} is needed, or one for each of {each}")
    return numbers


def _tolerance(value: Any) -> Tolerance:
    given = (POSITION, ROTATION) if value is None else value
    numbers = inputs.real(given, "tolerance", "two positive numbers (m, rad)")
    if numbers.shape != (2,) or not inputs.usable(numbers).all():
        raise ArgumentError(f"tolerance is {quoted(value)}; two numbers {inputs.USABLE} are needed: (m, rad)")
    return Tolerance(float(numbers[0]), min(float(numbers[1]), 1.0))


def _at_pose(arm: Arm, name: str, value: Any, T: Array, waypoint: int) -> Array | None:
    """A joint vector that is given for a waypoint."""
    if value is None:
        return None
    q = arm.chain.check(value)
    if q.shape != (arm.dof,):
        raise ArgumentError(f"{name} has the shape {q.shape}; one joint vector ({arm.dof},) is needed")
    reached = arm.fk(q)
    if arm.free_axis is None:
        apart = float(np.linalg.norm(reached[:3, 3] - T[:3, 3]))
        turned = float(np.linalg.norm(reached[:3, :3] - T[:3, :3]) / np.sqrt(2.0))
    else:
        apart, turned = (float(off) for off in arm.free_axis.apart(reached, T))
    if max(apart, turned) > AT_WAYPOINT:
        nearest = arm.ik_nearest(T, q).q.reshape(-1, arm.dof)
        beside = "" if np.isnan(nearest).any() else f"; its nearest solution is {largest_apart(nearest[0], q):.4g} off"
        raise ArgumentError(
            f"{name} is no solution of waypoint {waypoint}: its pose is {apart:.3g} m and {turned:.3g} rad off{beside}"
        )
    low, high = arm.limits.T
    for joint, x, a, b in zip(arm.joint_names, q, low, high, strict=True):
        if not a - 1e-9 <= x <= b + 1e-9:
            raise ArgumentError(f"{name} is outside the limits: {joint} is {x:.6g}, from {a:.6g} to {b:.6g} is valid")
    return q
