"""The settings of a path, checked and as arrays."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from urdf_ik.errors import ArgumentError, printable
from urdf_ik.ik.nearest import nearest as nearest_solution
from urdf_ik.ik.solver import Solver
from urdf_ik.paths.path_settings import COSTS, PathSettings
from urdf_ik.paths.planner import graph
from urdf_ik.paths.planner.joint_steps import Joints
from urdf_ik.paths.planner.obstacles import Obstacles
from urdf_ik.paths.planner.straightness import Tolerance
from urdf_ik.support import inputs
from urdf_ik.support.angles import largest_apart
from urdf_ik.support.text import quoted
from urdf_ik.support.watch import Watch
from urdf_ik.typing import Array

POSITION, ROTATION = 1e-3, 0.02
"""Default tolerance: greatest distance of the tip from the straight segment between two waypoints [m, rad]."""
LOOSER = 4.0
"""Factor on the default tolerance, where no plan keeps to it."""
AT_WAYPOINT = 1e-6
"""m and rad: the pose of a start or end joint vector may be this far from its waypoint."""


@dataclass(frozen=True)
class CheckedSettings:
    """The settings of a path in the form that the search reads, with the solver and the obstacles.

    Attributes:
        solver: the arm's solver.
        joints: the images of joint vectors whole turns apart, and the steps between them.
        kind: index of the cost in ``COSTS``.
        weights: (n,).
        max_step: (n,) rad or m between two waypoints, infinite where a joint has no such limit.
        tolerance: of the tip from the straight segments.
        start: (n,) joint vector at the first waypoint, or None.
        end: (n,) at the last one, or None.
        obstacles: the bodies that the arm must not touch, or None.
        limit_cost: weight of the cost of being near a joint limit.
        reconfigure: whether the branch may be changed.
        looser: whether a plan may stray ``LOOSER`` times as far where no plan stays within the tolerance.
        watch: the time limit and the progress of the search.
        whole: the solver and the obstacles of the whole search; parts of it hold a parameter, or leave obstacles out.
    """

    solver: Solver
    joints: Joints
    kind: int
    weights: Array
    max_step: Array
    tolerance: Tolerance
    start: Array | None
    end: Array | None
    obstacles: Obstacles | None
    limit_cost: float
    reconfigure: bool
    looser: bool
    watch: Watch
    whole: tuple[Solver, Obstacles | None]

    @property
    def window(self) -> Array:
        """(n,) greatest step that an edge may take: half a turn of its images."""
        half = np.where(self.joints.turn > 0.0, 0.5 * self.joints.turn, np.inf)
        return np.minimum(self.max_step, half) + 1e-12


def checked(solver: Solver, T: Array, given: PathSettings, obstacles: Obstacles | None) -> CheckedSettings:
    """The settings of a path, checked.

    Args:
        solver: the arm's solver.
        T: (m, 4, 4) m, waypoints.
        given: the settings.
        obstacles: the bodies that the arm must not touch.

    Raises:
        ArgumentError: a setting is invalid or does not fit the arm; the message names the valid values.
    """
    names = solver.joint_names
    cost = inputs.choice(given.cost, "cost", COSTS)
    factors = np.ones(len(names)) if given.weights is None else each_joint("weights", given.weights, names, zero=True)
    if cost == "time":
        factors = factors / velocities(solver)
    return CheckedSettings(
        solver=solver,
        joints=Joints.of(solver.chain),
        kind=graph.COSTS.index("max" if cost == "time" else cost),
        weights=factors,
        max_step=np.full(len(names), np.inf)
        if given.max_step is None
        else each_joint("max_step", given.max_step, names),
        tolerance=_tolerance(given.tolerance),
        start=_at_pose(solver, "start", given.start, T[0], 0),
        end=_at_pose(solver, "end", given.end, T[-1], len(T) - 1),
        obstacles=obstacles,
        limit_cost=inputs.number(given.limit_cost, "limit_cost", low=0.0),
        reconfigure=inputs.flag(given.reconfigure, "reconfigure"),
        looser=given.tolerance is None and not given.reconfigure,
        watch=Watch(given.time_limit, given.progress),
        whole=(solver, obstacles),
    )


def velocities(solver: Solver) -> Array:
    """(n,) rad/s or m/s, the velocity limits that the URDF gives.

    Raises:
        ArgumentError: a joint has no velocity limit.
    """
    limits = solver.velocity_limits
    if missing := [name for name, limit in zip(solver.joint_names, limits, strict=True) if np.isinf(limit)]:
        raise ArgumentError(
            f"{solver.name} has no velocity limit for {', '.join(missing)}: give them, or write "
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


def _at_pose(solver: Solver, name: str, value: Any, T: Array, waypoint: int) -> Array | None:
    """A joint vector that is given for a waypoint."""
    if value is None:
        return None
    q = solver.chain.check(value)
    if q.shape != (solver.dof,):
        raise ArgumentError(f"{name} has the shape {q.shape}; one joint vector ({solver.dof},) is needed")
    reached = solver.chain.fk(q)
    if solver.free_axis is None:
        apart = float(np.linalg.norm(reached[:3, 3] - T[:3, 3]))
        turned = float(np.linalg.norm(reached[:3, :3] - T[:3, :3]) / np.sqrt(2.0))
    else:
        apart, turned = (float(off) for off in solver.free_axis.apart(reached, T))
    if max(apart, turned) > AT_WAYPOINT:
        nearest = nearest_solution(solver, T, q).q.reshape(-1, solver.dof)
        beside = "" if np.isnan(nearest).any() else f"; its nearest solution is {largest_apart(nearest[0], q):.4g} off"
        raise ArgumentError(
            f"{name} is no solution of waypoint {waypoint}: its pose is {apart:.3g} m and {turned:.3g} rad off{beside}"
        )
    low, high = solver.limits.T
    for joint, x, a, b in zip(solver.joint_names, q, low, high, strict=True):
        if not a - 1e-9 <= x <= b + 1e-9:
            raise ArgumentError(f"{name} is outside the limits: {joint} is {x:.6g}, from {a:.6g} to {b:.6g} is valid")
    return q
