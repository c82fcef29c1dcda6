"""``Plan``, the result of ``arm.follow``."""

import os
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from urdf_ik.errors import ArgumentError
from urdf_ik.ik.pose_solving import solve
from urdf_ik.ik.solutions import branch_names, limits
from urdf_ik.ik.solver import Solver
from urdf_ik.kinematics import velocity
from urdf_ik.paths.path_settings import Obstacles
from urdf_ik.paths.timing import Timed, timed, write_rows
from urdf_ik.support.report import Report
from urdf_ik.support.text import Section
from urdf_ik.typing import Array


class Change(NamedTuple):
    """A reconfiguration: the arm changes to another branch before a waypoint.

    Attributes:
        waypoint: number of the first waypoint after it.
        before: branch at the waypoint before.
        after: branch at ``waypoint``.
        free: whether the arm touches nothing on the straight joint motion from the waypoint before; None without a
            check for collisions.
    """

    waypoint: int
    before: str
    after: str
    free: bool | None


EVERY_BRANCH = "every branch"
"""``Stop.branch`` where the stop holds for all branches: none gets past the waypoint."""


class Stop(NamedTuple):
    """Where all paths from one branch of the first waypoint end.

    Attributes:
        branch: name of the branch at the first waypoint, or ``EVERY_BRANCH``.
        waypoint: number of the first waypoint that cannot be reached from it.
        cause: 'reach', 'limit', 'contact' or 'jump'; 'time' where the time limit ended the search before any plan.
        reason: the cause in words, with the number, the joint or the bodies.
    """

    branch: str
    waypoint: int
    cause: str
    reason: str

    def __str__(self) -> str:
        return f"{self.branch}: stops before waypoint {self.waypoint}: {self.reason}"


class Margins(NamedTuple):
    """The margins of a plan at each waypoint.

    Attributes:
        limits: (m,) rad or m, distance to the nearest joint limit; infinite where no joint has one.
        clearance: (m,) m, least distance between bodies that must not touch; NaN where collisions are not checked.
        manipulability: (m,) Yoshikawa's.
    """

    limits: Array
    clearance: Array
    manipulability: Array


@dataclass(frozen=True, eq=False, repr=False)
class Plan(Report):
    """Joint vectors along a path, or the reason why there is no plan.

    Attributes:
        solver: the solver of the arm that moves.
        poses: (m, 4, 4) m, the waypoints.
        found: whether there is a plan.
        q: (m, n) rad or m, one joint vector a waypoint; (0, n) where there is no plan.
        branches: m names of branches.
        cost: the minimised measure, summed over the path; infinite where there is no plan.
        changes: reconfigurations.
        stops: where there is no plan, the reason for each branch of the first waypoint.
        motion: (k, n) rad or m, the joint vectors with those added between waypoints. While the joints
            move linearly between them, the tip stays within the tolerance of the path.
        place: (k,) position of each of these along the path: 2.5 is half way from waypoint 2 to waypoint 3.
        tolerance: (m, rad): every motion was proven to stay this near to the straight segments.
        obstacles: the bodies that the plan stays clear of; None where collisions are not checked.
        others: computes the ``alternatives`` when they are first used.
        unchecked: why contacts were not checked, such as '6 meshes missing' or 'not asked for'; '' where they were.
        unlooked: what the time limit left out; '' where the search was completed.

    Example:
        >>> import urdf_ik
        >>> arm = urdf_ik.load("scara_rrpr")
        >>> T0, T1 = arm.fk([[0.3, 0.5, 0.1, 0.2], [0.5, 0.7, 0.1, 0.2]])
        >>> plan = arm.follow(urdf_ik.line(T0, T1, 10))
        >>> plan.found, plan.q.shape, plan.changes
        (True, (10, 4), ())
    """

    solver: Solver
    poses: Array
    q: Array
    branches: tuple[str, ...] = ()
    cost: float = np.inf
    changes: tuple[Change, ...] = ()
    stops: tuple[Stop, ...] = ()
    motion: Array = field(default_factory=lambda: np.empty((0, 0)))
    place: Array = field(default_factory=lambda: np.empty(0))
    tolerance: tuple[float, float] = (0.0, 0.0)
    obstacles: Obstacles | None = field(default=None, repr=False)
    others: Callable[[], tuple["Plan", ...]] | None = field(default=None, repr=False)
    unchecked: str = ""
    unlooked: str = ""

    @property
    def found(self) -> bool:
        """Whether there is a plan."""
        return bool(len(self.q))

    @property
    def order(self) -> tuple[int, float]:
        """Plans are compared by their changes of branch, then by their costs."""
        return len(self.changes), self.cost

    def __bool__(self) -> bool:
        return self.found

    def __len__(self) -> int:
        return len(self.q)

    @cached_property
    def alternatives(self) -> tuple["Plan", ...]:
        """The best plan from every branch of the first waypoint that leads to the end, the cheapest first."""
        plans = () if self.others is None else self.others()
        return tuple(replace(plan, unchecked=self.unchecked) for plan in plans)

    @cached_property
    def margins(self) -> Margins:
        """Room to limits, obstacles and singularities along the plan."""
        room = limits.room(self.q, self.solver.limits)
        clearance = np.full(len(self.q), np.nan)
        if self.obstacles is not None and self.found:
            clearance = np.asarray(self.obstacles.model.distance(self.q))
        return Margins(room, clearance, velocity.manipulability(self.solver.chain, self.q))

    def explain(self) -> str:
        """Why there is no plan: a line for each branch of the first waypoint, the one that gets farthest first.

        Returns:
            '' where there is a plan.
        """
        return "" if self.found else "\n".join(self.lines())

    def timed(self, velocity: Any = None, acceleration: Any = None, *, dt: float = 0.01) -> Timed:
        """When the arm is where, as fast as the limits allow; see :func:`urdf_ik.paths.timing.timed`.

        Example:
            >>> import urdf_ik
            >>> arm = urdf_ik.load("scara_rrpr")
            >>> T0, T1 = arm.fk([[0.3, 0.5, 0.1, 0.2], [0.5, 0.7, 0.1, 0.2]])
            >>> timed = arm.follow(urdf_ik.line(T0, T1, 10)).timed(velocity=1.0, acceleration=5.0)
            >>> timed.duration > 0.0, bool(abs(timed.qd).max() < 1.001)
            (True, True)
        """
        return timed(self, velocity, acceleration, dt=dt)

    def __getstate__(self) -> dict[str, Any]:
        # ``others`` cannot be pickled, so the alternatives are computed first.
        plans = tuple(replace(plan, others=None) for plan in self.alternatives)
        return {**self.__dict__, "alternatives": plans, "others": None}

    def to_csv(self, path: str | os.PathLike[str]) -> None:
        """Write the motion, a row a joint vector: its place, its branch, the joints by name [rad or m].

        A whole number in the column ``waypoint`` is a waypoint that was given; 2.5 is half way from waypoint 2 to
        waypoint 3.

        Raises:
            ArgumentError: there is no plan, or the file cannot be written.
        """
        if not self.found:
            raise ArgumentError(f"there is no plan to write: {self.explain()}")
        rows = zip(self.place.tolist(), self.motion.tolist(), strict=True)
        write_rows(
            path,
            ["waypoint", "branch", *self.solver.joint_names],
            ([f"{place:.17g}", self.branches[int(place)], *q] for place, q in rows),
        )

    def to_dict(self) -> dict[str, Any]:
        """The plan as plain lists, numbers and text; also of a path without a plan."""
        return {
            "arm": self.solver.name,
            "base": self.solver.chain.base,
            "tip": self.solver.chain.tip,
            "joints": list(self.solver.joint_names),
            "units": {"angle": "rad", "length": "m"},
            "found": self.found,
            "cost": self.cost if self.found else None,
            "q": self.q.tolist(),
            "motion": self.motion.tolist(),
            "place": self.place.tolist(),
            "branches": list(self.branches),
            "changes": [change._asdict() for change in self.changes],
            "stops": [stop._asdict() for stop in self.stops],
            "contacts": f"not checked: {self.unchecked}" if self.unchecked else "checked",
            "search": self.unlooked or "complete",
        }

    @property
    def faulty(self) -> bool:
        """Whether there is no plan."""
        return not self.found

    def title(self) -> str:
        """The arm and the number of waypoints."""
        return f"plan of {self.solver.name} along {len(self.poses)} waypoints"

    def verdict(self) -> str:
        """Whether there is a plan, and what was left out."""
        unchecked = f"contacts not checked: {self.unchecked}" if self.unchecked else ""
        return ", ".join(filter(None, ("found" if self.found else "no plan", unchecked, self.unlooked)))

    def lines(self) -> tuple[str, ...]:
        """Branches, cost and largest step; or the reason why each branch stops."""
        if not self.found:
            return tuple(map(str, self.stops))
        steps = np.abs(np.diff(self.q, axis=0)).max(axis=0, initial=0.0)
        joint = int(np.argmax(steps))
        return (
            " then ".join(dict.fromkeys(self.branches)),
            f"cost {self.cost:.6g}, {len(self.changes)} reconfigurations",
            f"largest step {steps[joint]:.4g} of {self.solver.joint_names[joint]}",
            f"{len(self.motion) - len(self.q)} waypoints added between those given",
        )

    def sections(self) -> tuple[Section, ...]:
        """The least margins."""
        names = ("room to a limit [rad or m]", "clearance [m]", "manipulability")
        least = zip(names, self.margins if self.found else (), strict=self.found)
        rows = tuple((name, f"{values.min():.4g}") for name, values in least if not np.isnan(values).any())
        return (Section("margins", ("least", "value"), rows, left=("least",)),) if rows else ()


def followed(plan: Plan) -> Plan:
    """Name the branches of an arm whose solutions have only numbers: a solution that is followed keeps its number.

    The arm moves from waypoint to waypoint without a jump, so the number at the first waypoint, or after a change of
    branch, names the whole motion. The sign before it is that of the Jacobian's determinant at each waypoint: where it
    changes, the motion crosses a singularity. Branches named by geometry remain.
    """
    if not branch_names.local(plan.solver.structure.branches):
        return plan
    if not plan.found:
        if plan.solver.parameters:
            return plan
        known = dict(zip(plan.solver.structure.branches, solve(plan.solver, plan.poses[0]).names, strict=True))
        return replace(plan, stops=tuple(s._replace(branch=str(known.get(s.branch, s.branch))) for s in plan.stops))
    signs = branch_names.determinant_signs(plan.solver, plan.q)
    begins = [0, *(change.waypoint for change in plan.changes)]
    names: list[str] = []
    for begin, end in zip(begins, [*begins[1:], len(plan.q)], strict=True):
        for k in range(begin, end):
            name = plan.branches[begin if branch_names.is_local(plan.branches[k]) else k]
            sign = 0 if signs is None or not branch_names.is_local(name) else int(signs[k])
            names.append(f"{branch_names.sign_in_words(sign)}{name}")
    changes = tuple(c._replace(before=names[c.waypoint - 1], after=names[c.waypoint]) for c in plan.changes)
    others = plan.others
    renamed = None if others is None else lambda: tuple(followed(other) for other in others())
    return replace(plan, branches=tuple(names), changes=changes, others=renamed)
