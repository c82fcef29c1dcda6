"""The settings of a path, checked and as arrays, with the solver and the obstacles that the search uses."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from urdf_ik.cell.swept_motions import TOUCH
from urdf_ik.errors import ArgumentError
from urdf_ik.ik.nearest import nearest as nearest_solution
from urdf_ik.ik.solver import Solver
from urdf_ik.paths import path_settings
from urdf_ik.paths.path_settings import PathSettings, per_joint, velocities
from urdf_ik.paths.planner.nodes import Joints
from urdf_ik.support import inputs
from urdf_ik.support.angles import amount, largest_apart
from urdf_ik.support.watch import Watch
from urdf_ik.typing import Array

if TYPE_CHECKING:
    from urdf_ik.cell import CollisionModel

COSTS = ("l1", "l2", "max")
"""Sum of |dq|, sum of dq^2, largest |dq|: the numbering of the compiled core."""
POSITION_TOLERANCE, ROTATION_TOLERANCE = 1e-3, 0.02
"""Default of the largest distance of the tip from the straight segment between two waypoints [m, rad]."""
LOOSER = 4.0
"""Factor on the default tolerance where no plan stays within it."""
END_TOLERANCE = 1e-6
"""Largest distance of a given start or end from the pose of its waypoint [m, rad]."""
CLEARANCE = 2.0 * TOUCH
"""Distance beyond the margin that joint vectors keep, so that motions between them can be proven free [m]."""


class Obstacles(NamedTuple):
    """The links of the arm and a world, which must not come near each other.

    Attributes:
        model: the arm's collision model, with the world if there is one.
        margin: distance to keep [m].
    """

    model: CollisionModel
    margin: float

    def free(self, q: Array) -> NDArray[np.bool_]:
        """Whether joint vectors (k, n) are free of contact, (k,)."""
        return ~np.asarray(self.model.in_collision(q, self.margin + CLEARANCE))

    def motions_free(self, q0: Array, q1: Array) -> NDArray[np.bool_]:
        """Whether straight joint motions (k, n) are free of contact from end to end, (k,)."""
        return np.asarray(self.model.motions_free(q0, q1, self.margin).free)

    def pair(self, q: Array) -> tuple[str, str] | None:
        """The two bodies nearest to each other at a joint vector (n,)."""
        nearest = self.model.nearest_pair(q)
        return None if nearest is None else nearest.links


@dataclass(frozen=True)
class CheckedSettings:
    """The settings of a path as the search uses them.

    Attributes:
        solver: the arm's solver.
        joints: the arm's joints.
        kind: index of the cost in ``COSTS``.
        weights: (n,) factor on |dq|, on dq^2 for 'l2'.
        max_step: (n,) largest step between two waypoints, infinite for no limit [rad or m].
        tolerance: (m, rad) of the tip from the straight segments.
        start: (n,) joint vector at the first waypoint, or None.
        end: (n,) joint vector at the last waypoint, or None.
        obstacles: bodies that must not touch, or None.
        limit_cost: weight of the nearness to joint limits.
        reconfigure: whether the branch may change.
        looser: whether the search is repeated with ``LOOSER`` times the tolerance if no plan is found.
        watch: time limit and progress.
        whole: solver and obstacles of the whole search; ``solver`` and ``obstacles`` may be those of a part of it.
    """

    solver: Solver
    joints: Joints
    kind: int
    weights: Array
    max_step: Array
    tolerance: tuple[float, float]
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
        """(n,) largest step of an edge: half the distance between images, or ``max_step`` [rad or m]."""
        half = np.where(self.joints.turn > 0.0, 0.5 * self.joints.turn, np.inf)
        return np.minimum(self.max_step, half) + 1e-12

    @property
    def smooth(self) -> bool:
        """Whether the cost is a plain sum of squares, which smoothing minimises."""
        return COSTS[self.kind] == "l2" and not self.limit_cost


def checked(solver: Solver, T: Array, settings: PathSettings, obstacles: Obstacles | None) -> CheckedSettings:
    """Check the settings of a path.

    Args:
        solver: the arm's solver.
        T: (m, 4, 4) m, waypoints.
        settings: as they were given.
        obstacles: bodies that must not touch.
    """
    names = solver.joint_names
    cost = inputs.choice(settings.cost, "cost", path_settings.COSTS)
    weights, max_step = settings.weights, settings.max_step
    factors = np.ones(len(names)) if weights is None else per_joint("weights", weights, names, zero=True)
    if cost == "time":
        factors = factors / velocities(solver)
    tolerance = (POSITION_TOLERANCE, ROTATION_TOLERANCE) if settings.tolerance is None else settings.tolerance
    position, rotation = per_joint("tolerance", tolerance, ("position [m]", "rotation [rad]"))
    return CheckedSettings(
        solver=solver,
        joints=Joints.from_chain(solver.chain),
        kind=COSTS.index("max" if cost == "time" else cost),
        weights=factors,
        max_step=np.full(len(names), np.inf) if max_step is None else per_joint("max_step", max_step, names),
        tolerance=(float(position), min(float(rotation), 1.0)),
        start=_at_pose(solver, "start", settings.start, T[0], 0),
        end=_at_pose(solver, "end", settings.end, T[-1], len(T) - 1),
        obstacles=obstacles,
        limit_cost=inputs.number(settings.limit_cost, "limit_cost", low=0.0),
        reconfigure=bool(settings.reconfigure),
        looser=settings.tolerance is None and not settings.reconfigure,
        watch=Watch(settings.time_limit, settings.progress),
        whole=(solver, obstacles),
    )


def _at_pose(solver: Solver, name: str, value: Any, T: Array, waypoint: int) -> Array | None:
    """A joint vector that was given for a waypoint, checked."""
    if value is None:
        return None
    q = solver.chain.check(value)
    if q.shape != (solver.dof,):
        raise ArgumentError(f"{name} has the shape {q.shape}; one joint vector ({solver.dof},) is needed")
    reached = solver.chain.fk(q)
    if solver.free_axis is None:
        distance = float(np.linalg.norm(reached[:3, 3] - T[:3, 3]))
        angle = float(np.linalg.norm(reached[:3, :3] - T[:3, :3]) / np.sqrt(2.0))
    else:
        distance, angle = (float(off) for off in solver.free_axis.apart(reached, T))
    if max(distance, angle) > END_TOLERANCE:
        nearest = nearest_solution(solver, T, q).q.reshape(-1, solver.dof)
        far = amount(largest_apart(nearest[0], q))
        hint = "" if np.isnan(nearest).any() else f"; its nearest solution is {far} off"
        off = f"{distance:.3g} m and {amount(angle, form='.3g')}"
        raise ArgumentError(f"{name} is no solution of waypoint {waypoint}: its pose is {off} off{hint}")
    low, high = solver.limits.T
    for joint, x, a, b in zip(solver.joint_names, q, low, high, strict=True):
        if not a - 1e-9 <= x <= b + 1e-9:
            raise ArgumentError(f"{name} is outside the limits: {joint} is {x:.6g}, from {a:.6g} to {b:.6g} is valid")
    return q
