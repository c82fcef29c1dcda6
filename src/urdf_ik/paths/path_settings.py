"""The declaration of the settings of a path, and the check of values per joint."""

import inspect
from collections.abc import Callable
from dataclasses import Field, dataclass, field, fields
from typing import TYPE_CHECKING, Any, Literal, NamedTuple, TypeVar

import numpy as np
from numpy.typing import NDArray

from urdf_ik.cell.swept_motions import TOUCH
from urdf_ik.errors import ArgumentError
from urdf_ik.ik.nearest import nearest as nearest_solution
from urdf_ik.ik.solutions.distances import per_joint
from urdf_ik.ik.solver import Solver
from urdf_ik.paths.planner.nodes import Joints
from urdf_ik.support import inputs
from urdf_ik.support.angles import amount, largest_apart
from urdf_ik.support.watch import Watch
from urdf_ik.typing import Array

if TYPE_CHECKING:
    from urdf_ik.cell import (
        CollisionModel,
        World,  # brings lxml and the obstacles
    )


COSTS = ("l1", "l2", "max", "time")
"""Sum of |dq|, sum of dq^2, largest |dq|, as the compiled core numbers them, and time."""

Kind = Literal["joint vector", "number", "per joint", "length and angle", "choice", "part", "flag", "contacts", "world"]
"""Form of a setting's value as an option of the command."""
_Function = TypeVar("_Function", bound=Callable[..., Any])


def _setting(default: Any, kind: Kind, text: str, unit: str = "") -> Any:
    """A field with what its documentation and its option need: a sentence, and the unit of its value."""
    return field(default=default, metadata={"kind": kind, "help": text, "unit": unit})


@dataclass(frozen=True)
class PathSettings:
    """Settings of a path: the keyword arguments of :meth:`urdf_ik.Arm.follow`, and the options of ``urdf-ik path``."""

    start: Any = _setting(
        None, "joint vector", "Joint vector at the first waypoint; by default the best one.", "rad or m"
    )
    end: Any = _setting(None, "joint vector", "Joint vector at the last waypoint; by default the best one.", "rad or m")
    world: "World | None" = _setting(None, "world", "Obstacles.")
    margin: float = _setting(0.0, "number", "Distance that bodies must keep from each other and from obstacles.", "m")
    collisions: bool | str = _setting(
        True,
        "contacts",
        "Whether contacts are checked, at the waypoints and all the way between them; by default where the collision "
        "shapes can be read. 'require': an error where they cannot be.",
    )
    cost: str = _setting(
        "l2",
        "choice",
        "Cost of a step: the sum of abs(dq) (l1), of dq^2 (l2), the largest (max), or its time (time).",
    )
    weights: Any = _setting(None, "per joint", "Factor on abs(dq) of each joint, on dq^2 for l2; by default 1.")
    limit_cost: float = _setting(
        0.0,
        "number",
        "Weight of the squared nearness to the nearest limit, 0 in the middle of the range and 1 at the limit.",
    )
    max_step: Any = _setting(None, "per joint", "Largest step of a joint between two waypoints.", "rad or m")
    tolerance: Any = _setting(
        None,
        "length and angle",
        "Largest distance of the tip from the straight segments; by default 0.001 m and 0.02 rad, or four times these "
        "where no plan keeps to them.",
        "m, rad",
    )
    first: str | None = _setting(
        None,
        "part",
        "For arms that cannot reach whole poses: 'position' or 'orientation' is exact, the other is missed by as "
        "little as a smooth motion allows; the waypoints are then the nearest poses in reach.",
    )
    reconfigure: bool = _setting(
        False, "flag", "Whether the branch may change, as seldom as possible, where no motion leads all the way."
    )
    time_limit: float | None = _setting(None, "number", "Longest search; then the best plan so far.", "s")
    progress: Callable[[str], object] | None = field(
        default=None, metadata={"help": "Called with a description of the next step of the search."}
    )


def options() -> dict[str, Field[Any]]:
    """The settings that are options of the command, by name."""
    return {setting.name: setting for setting in fields(PathSettings) if "kind" in setting.metadata}


def takes_settings(function: _Function) -> _Function:
    """Show the settings in the signature and the docstring of a function that takes them as ``**settings``."""
    signature = inspect.signature(function)
    own = [parameter for parameter in signature.parameters.values() if parameter.kind is not parameter.VAR_KEYWORD]
    keyword = inspect.Parameter.KEYWORD_ONLY
    shown = [inspect.Parameter(f.name, keyword, default=f.default, annotation=f.type) for f in fields(PathSettings)]
    function.__signature__ = signature.replace(parameters=[*own, *shown])  # type: ignore[attr-defined]
    indent = " " * 12
    lines = "\n".join(f"{indent}{line}" for line in described().splitlines())
    function.__doc__ = (function.__doc__ or "").replace(f"{indent}**settings: see PathSettings.", lines)
    return function


def described() -> str:
    """A line a setting: its name, a sentence, the unit."""
    lines = []
    for setting in fields(PathSettings):
        unit = f" [{setting.metadata['unit']}]" if setting.metadata.get("unit") else ""
        lines.append(f"{setting.name}: {setting.metadata['help'].removesuffix('.')}{unit}.")
    return "\n".join(lines)


PathSettings.__doc__ = f"{PathSettings.__doc__}\n\nAttributes:\n    " + described().replace("\n", "\n    ")


def velocities(solver: Solver) -> Array:
    """(n,) rad/s or m/s, the velocity limits of the URDF."""
    limits = solver.velocity_limits
    if missing := [name for name, limit in zip(solver.joint_names, limits, strict=True) if np.isinf(limit)]:
        raise ArgumentError(
            f"{solver.name} has no velocity limit for {', '.join(missing)}: give them, or write "
            '<limit velocity="..."/> in the URDF'
        )
    return limits


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

    model: "CollisionModel"
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
        kind: index of the cost in ``COSTS``, 'time' as 'max' of shares of the speeds.
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
        """(n,) rad or m: the largest step between waypoints, ``max_step``, but at most half the distance of images."""
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
    cost = inputs.choice(settings.cost, "cost", COSTS)
    weights, max_step = settings.weights, settings.max_step
    factors = np.ones(len(names)) if weights is None else per_joint("weights", weights, names, (0.0,))
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
