"""``Plan``, the result of ``arm.follow``."""

from __future__ import annotations

import csv
import io
import os
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from urdf_ik.errors import ArgumentError
from urdf_ik.ik.solutions import IKSolutions, limits
from urdf_ik.ik.solutions.derivatives import joint_rates
from urdf_ik.ik.solver import Solver
from urdf_ik.kinematics import velocity
from urdf_ik.paths import plan_display
from urdf_ik.paths.planner.obstacles import Obstacles
from urdf_ik.paths.timing import Timed
from urdf_ik.support import files
from urdf_ik.support.display import short
from urdf_ik.support.text import json_text
from urdf_ik.typing import Array


class Change(NamedTuple):
    """A reconfiguration: the arm changes to another branch before a waypoint.

    Attributes:
        waypoint: number of the first waypoint after it.
        before: branch at the waypoint before.
        after: branch at ``waypoint``.
        free: whether the straight joint motion from one to the other touches nothing; None without a check
            for collisions.
    """

    waypoint: int
    before: str
    after: str
    free: bool | None


EVERY_BRANCH = "every branch"
"""The branch of a ``Stop`` at which no branch gets past a waypoint."""


class Stop(NamedTuple):
    """The end of all paths from one branch of the first waypoint.

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


@dataclass(frozen=True)
class Margins:
    """The margins of a plan at each waypoint.

    Attributes:
        limits: (m,) rad or m, distance to the nearest joint limit; infinite where no joint has one.
        clearance: (m,) m, least distance between bodies that must not touch; NaN where collisions are not checked.
        manipulability: (m,) Yoshikawa's.
    """

    limits: Array
    clearance: Array
    manipulability: Array


@dataclass(frozen=True)
class _Listed:
    """Alternatives that are already computed."""

    plans: tuple[Plan, ...]

    def __call__(self) -> tuple[Plan, ...]:
        return self.plans


@dataclass(frozen=True, eq=False)
class Plan:
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
        motion: (k, n) rad or m, the joint vectors with those added between waypoints. Moving linearly from one to the
            next, the tip stays within the tolerance of the path.
        place: (k,) position of each of these along the path: 2.5 is half way from waypoint 2 to waypoint 3.
        tolerance: (m, rad) from the straight segments within which every motion was proven to stay.
        obstacles: the bodies that the plan stays clear of; None where collisions are not checked.
        others: computes the ``alternatives`` at their first use.
        unchecked: why contacts were not checked, such as '6 meshes missing' or 'not asked for'; '' where they were.
        unlooked: what the time limit left out; '' where the search came to its end.

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
    others: Callable[[], tuple[Plan, ...]] | None = field(default=None, repr=False)
    unchecked: str = ""
    unlooked: str = ""

    @property
    def found(self) -> bool:
        """Whether there is a plan."""
        return bool(len(self.q))

    def __bool__(self) -> bool:
        return self.found

    def __len__(self) -> int:
        return len(self.q)

    @cached_property
    def alternatives(self) -> tuple[Plan, ...]:
        """The best plan from every branch of the first waypoint that leads to the end, the cheapest first."""
        found = () if self.others is None else self.others()
        return tuple(replace(plan, unchecked=self.unchecked) for plan in found)

    def with_others(self, others: Callable[[], tuple[Plan, ...]]) -> Plan:
        """This plan with a function that computes its alternatives at their first use.

        Example:
            >>> import urdf_ik
            >>> arm = urdf_ik.load("scara_rrpr")
            >>> T0, T1 = arm.fk([[0.3, 0.5, 0.1, 0.2], [0.5, 0.7, 0.1, 0.2]])
            >>> plan = arm.follow(urdf_ik.line(T0, T1, 10))
            >>> len(plan.with_others(lambda: (plan,)).alternatives)
            1
        """
        return replace(self, others=others)

    @cached_property
    def margins(self) -> Margins:
        """Room to limits, obstacles and singularities along the plan."""
        room = limits.room(self.q, self.solver.limits)
        clearance = np.full(len(self.q), np.nan)
        if self.obstacles is not None and self.found:
            clearance = np.asarray(self.obstacles.model.distance(self.q))
        return Margins(room, clearance, velocity.manipulability(self.solver.chain, self.q))

    def velocities(self, twists: ArrayLike, rates: ArrayLike | None = None) -> Array:
        """Joint velocities (m, n) rad/s or m/s at the waypoints, by the inverse of the Jacobian.

        Args:
            twists: (m, 6) or (6,) m/s and rad/s of the targets at the waypoints, in base axes at their origins.
            rates: (m, k) or (k,) per s, of the redundancy parameters; default: zeros.

        Returns:
            NaN at a singular waypoint.

        Raises:
            ArgumentError: there is no plan, or an argument does not fit.

        Example:
            >>> import urdf_ik
            >>> arm = urdf_ik.load("scara_rrpr")
            >>> T0, T1 = arm.fk([[0.3, 0.5, 0.1, 0.2], [0.5, 0.7, 0.1, 0.2]])
            >>> arm.follow(urdf_ik.line(T0, T1, 10)).velocities([0.1, 0.0, 0.0, 0.0, 0.0, 0.0]).shape
            (10, 4)
        """
        return joint_rates(self._solutions(), twists, rates)[..., 0, :]

    def accelerations(self, twists: ArrayLike, twist_rates: ArrayLike | None = None) -> Array:
        """Joint accelerations (m, n) rad/s^2 or m/s^2 at the waypoints, redundancy parameters held.

        Args:
            twists: (m, 6) or (6,) as in :meth:`velocities`.
            twist_rates: (m, 6) or (6,) m/s^2 and rad/s^2, at which the twists change, in base axes; default: zeros.

        Returns:
            NaN at a singular waypoint.

        Raises:
            ArgumentError: there is no plan, or an argument does not fit.
            UnsupportedArm: the arm is solved for the task 'position and axis'.

        Example:
            >>> import urdf_ik
            >>> arm = urdf_ik.load("scara_rrpr")
            >>> T0, T1 = arm.fk([[0.3, 0.5, 0.1, 0.2], [0.5, 0.7, 0.1, 0.2]])
            >>> arm.follow(urdf_ik.line(T0, T1, 10)).accelerations([0.1, 0.0, 0.0, 0.0, 0.0, 0.0]).shape
            (10, 4)
        """
        solutions = self._solutions()
        changes = np.zeros(6) if twist_rates is None else twist_rates
        return joint_rates(solutions, changes, bent=solutions.d2q_dT2(twists))[..., 0, :]

    def _solutions(self) -> IKSolutions:
        """The plan's joint vectors as solutions of its waypoints, one column."""
        self._require()
        info = np.ones((len(self.q), 1), np.uint8)
        return IKSolutions(self.solver, self.poses, self.q[:, None].copy(), info, ("plan",))

    def explain(self) -> str:
        """Why there is no plan: a line for each branch of the first waypoint, the one that gets farthest first.

        Returns:
            '' where there is a plan.

        Example:
            >>> import urdf_ik
            >>> arm = urdf_ik.load("scara_rrpr")
            >>> T = arm.fk([0.3, 0.5, 0.1, 0.2])
            >>> away = T.copy()
            >>> away[0, 3] = 0.9
            >>> "out of reach" in arm.follow(urdf_ik.line(T, away, 10)).explain()
            True
        """
        return "" if self.found else "\n".join(str(stop) for stop in self.stops)

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
        from urdf_ik.paths.timing import timed

        return timed(self, velocity, acceleration, dt=dt)

    def __getstate__(self) -> dict[str, Any]:
        # The alternatives are found when they are asked for, by what cannot be pickled: they go along as they are.
        state = {name: value for name, value in self.__dict__.items() if name != "alternatives"}
        if self.others is not None:
            state["others"] = _Listed(tuple(replace(plan, others=None) for plan in self.alternatives))
        return state

    def to_csv(self, path: str | os.PathLike[str]) -> None:
        """Write the motion, a row a joint vector: its place, its branch, the joints by name [rad or m].

        A whole number in the column ``waypoint`` is a waypoint that was given; 2.5 is half way from waypoint 2 to
        waypoint 3.

        Raises:
            ArgumentError: there is no plan, or the file cannot be written.

        Example:
            >>> from pathlib import Path
            >>> import urdf_ik
            >>> arm = urdf_ik.load("scara_rrpr")
            >>> T0, T1 = arm.fk([[0.3, 0.5, 0.1, 0.2], [0.5, 0.7, 0.1, 0.2]])
            >>> arm.follow(urdf_ik.line(T0, T1, 10)).to_csv("plan.csv")
            >>> Path("plan.csv").read_text().splitlines()[0]
            'waypoint,branch,joint_1,joint_2,joint_3,joint_4'
        """
        self._require()
        text = io.StringIO()
        rows = csv.writer(text)
        rows.writerow(["waypoint", "branch", *self.solver.joint_names])
        for place, q in zip(self.place.tolist(), self.motion.tolist(), strict=True):
            rows.writerow([f"{place:.17g}", self.branches[int(place)], *map(repr, q)])
        files.write(path, text.getvalue().encode())

    def to_json(self, path: str | os.PathLike[str] | None = None) -> str:
        """The plan as JSON, written to a file where one is given; also of a path without a plan.

        Raises:
            ArgumentError: the file cannot be written.

        Example:
            >>> import json
            >>> import urdf_ik
            >>> arm = urdf_ik.load("scara_rrpr")
            >>> T0, T1 = arm.fk([[0.3, 0.5, 0.1, 0.2], [0.5, 0.7, 0.1, 0.2]])
            >>> json.loads(arm.follow(urdf_ik.line(T0, T1, 10)).to_json())["found"]
            True
        """
        text = json_text(
            {
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
            },
        )
        if path is not None:
            files.write(path, text.encode())
        return text

    def to_npz(self, path: str | os.PathLike[str]) -> None:
        """Write q, poses, branches, joints, motion and place as NumPy arrays.

        Raises:
            ArgumentError: there is no plan, or the file cannot be written.

        Example:
            >>> import numpy as np
            >>> import urdf_ik
            >>> arm = urdf_ik.load("scara_rrpr")
            >>> T0, T1 = arm.fk([[0.3, 0.5, 0.1, 0.2], [0.5, 0.7, 0.1, 0.2]])
            >>> arm.follow(urdf_ik.line(T0, T1, 10)).to_npz("plan.npz")
            >>> np.load("plan.npz")["q"].shape
            (10, 4)
        """
        self._require()
        held = {
            "q": self.q, "poses": self.poses, "branches": np.array(self.branches), "motion": self.motion,
            "joints": np.array(self.solver.joint_names), "place": self.place,
        }  # fmt: skip
        files.write(path, lambda file: np.savez(file, allow_pickle=False, **held))

    def __str__(self) -> str:
        unchecked = f", contacts not checked: {self.unchecked}" if self.unchecked else ""
        unchecked += f", {self.unlooked}" if self.unlooked else ""
        if not self.found:
            return f"no plan for {self.solver.name} along {len(self.poses)} waypoints{unchecked}\n{self.explain()}"
        changes = f", {len(self.changes)} reconfigurations" if self.changes else ""
        step = np.abs(np.diff(self.q, axis=0)).max(initial=0.0)
        return (
            f"{len(self.q)} waypoints of {self.solver.name}: {self.branches[0]} to {self.branches[-1]}{changes}, "
            f"cost {self.cost:.6g}, largest step {step:.4f}{unchecked}"
        )

    def __repr__(self) -> str:
        return short(plan_display.title(self), plan_display.lines(self))

    def _repr_html_(self) -> str:
        return plan_display.html(self)

    def _require(self) -> None:
        if not self.found:
            raise ArgumentError(f"there is no plan to write: {self.explain()}")
