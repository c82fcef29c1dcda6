"""``Intervals``: where each branch has solutions, what ends each interval, and the choice along them."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from urdf_ik.errors import ArgumentError
from urdf_ik.ik.pose_solving import solve
from urdf_ik.ik.redundancy import curves
from urdf_ik.ik.redundancy.curves import Curves, End, Found
from urdf_ik.ik.solutions import IKSolutions, distances
from urdf_ik.ik.solutions.distances import Metric, Quality, Wish, check_quality
from urdf_ik.ik.solutions.solution import picked, place_of
from urdf_ik.ik.solver import Solver
from urdf_ik.kinematics.chain.redundancy import Redundancy
from urdf_ik.support.angles import TURN, shown, unit_of
from urdf_ik.support.report import html_of, short
from urdf_ik.support.text import Section, aligned, quoted
from urdf_ik.typing import Array


@dataclass(frozen=True)
class Interval:
    """Values of the redundancy parameter at which one branch has solutions.

    Attributes:
        branch: its name, in the middle of the interval.
        low: rad or m, the least value; angles in (-pi, pi].
        high: rad or m, the greatest value; beyond pi where the interval passes half a turn. The whole circle is
            (-pi, pi).
        ends: why it ends at ``low`` and at ``high``.
        unit: 'rad' or 'm'.

    Example:
        >>> import urdf_ik
        >>> arm = urdf_ik.load("srs_7r")
        >>> interval = arm.intervals(arm.fk([0.3, 0.5, -0.4, 0.9, 0.2, -0.6, 0.1]), within_limits=False)[0]
        >>> interval.branch, round(interval.low, 4), round(interval.high, 4), str(interval.ends[0])
        ('shoulder noflip, elbow up, wrist noflip', -3.1416, 3.1416, 'no end')
    """

    branch: str
    low: float
    high: float
    ends: tuple[End, End]
    unit: str = "rad"

    @property
    def width(self) -> float:
        """Rad or m between the ends."""
        return self.high - self.low

    def __contains__(self, value: object) -> bool:
        number = float(value)  # type: ignore[arg-type]
        turned = self.low + (number - self.low) % TURN if self.high > np.pi else number
        return bool(self.low <= number <= self.high or self.low <= turned <= self.high)

    def __str__(self) -> str:
        low, high = (f"{shown(value, self.unit):.6f}" for value in (self.low, self.high))
        return f"{self.branch}: {low} ({self.ends[0]}) to {high} ({self.ends[1]})"


class Intervals:
    """Where along the redundancy parameter a pose has solutions: for each branch its intervals, and what ends them.

    Of a single pose it is a sequence of :class:`Interval`; of a batch, ``intervals[i]`` are those of one pose.

    Attributes:
        within_limits: whether only solutions inside the joint limits count.

    Example:
        >>> import urdf_ik
        >>> arm = urdf_ik.load("srs_7r")
        >>> intervals = arm.intervals(arm.fk([0.3, 0.5, -0.4, 0.9, 0.2, -0.6, 0.1]))
        >>> len(intervals), {interval.branch for interval in intervals} <= set(arm.structure.branches)
        (26, True)
    """

    def __init__(self, solver: Solver, T: Array, found: Found, within_limits: bool) -> None:
        """Keep what was found for poses ``T`` (..., 4, 4)."""
        self.solver = solver
        self.within_limits = within_limits
        self._T, self._found = T, found

    @property
    def parameter(self) -> Redundancy:
        """The redundancy parameter."""
        return self.solver.redundant_member.parameters[0]

    @property
    def arm(self) -> Any:
        """The :class:`urdf_ik.Arm` that they are intervals of."""
        return self.solver.arm

    @property
    def shape(self) -> tuple[int, ...]:
        """Shape of the batch; () for a single pose."""
        return self._T.shape[:-2]

    @property
    def count(self) -> NDArray[np.intp]:
        """(...) number of intervals of each pose."""
        m = int(np.prod(self.shape))
        return np.bincount(self._found.pose, minlength=m).reshape(self.shape)

    def __len__(self) -> int:
        self._single("len()")
        return len(self._found.low)

    def __iter__(self) -> Iterator[Interval]:
        self._single("iteration")
        return (self._interval(k) for k in range(len(self._found.low)))

    def __getitem__(self, index: Any) -> Any:
        """An :class:`Interval` of a single pose; of a batch the intervals of one pose."""
        if not self.shape:
            return self._interval(place_of(len(self._found.low), index, "intervals of this pose"))
        place = picked(self.shape, index)
        if place.ndim:
            raise ArgumentError(f"index {quoted(index)} leaves more than one pose of a batch of shape {self.shape}")
        found = self._found.of(np.flatnonzero(self._found.pose == place))
        found = replace(found, pose=np.zeros(len(found.low), dtype=np.intp))
        return Intervals(self.solver, self._T[index], found, self.within_limits)

    def samples(self, k: int) -> tuple[Array, Array]:
        """Growing values (s,) in interval ``k`` of a single pose, from end to end, and joint vectors (s, n) there.

        Raises:
            ArgumentError: these are the intervals of a batch.
        """
        self._single("samples()")
        found = self._found
        k = place_of(len(found.low), k, "intervals of this pose")
        part = slice(found.first[k], found.first[k] + found.count[k])
        return found.value[part], found.q[part]

    def merged(self) -> Array:
        """(k, 2) rad or m: where any branch of a single pose has a solution, lowest first."""
        self._single("merged()")
        return _union(self._found.low, self._found.high, self.parameter.round)

    def nearest(
        self,
        q_ref: ArrayLike,
        *,
        metric: Metric = "l2",
        weights: ArrayLike | None = None,
        within: ArrayLike | None = None,
    ) -> IKSolutions:
        """The joint vector nearest to ``q_ref`` of all in the intervals: one column a pose.

        Args:
            q_ref: (n,), or one for each pose (..., n), rad or m.
            metric: 'l2', 'max' or 'time'; see :meth:`urdf_ik.IKSolutions.nearest`, also for the next two.
            weights: (n,) of the joints in the distance.
            within: rad or m that no joint may be further away.

        Raises:
            ArgumentError: ``q_ref``, ``weights`` or ``within`` does not fit.
            ArgumentError: there is no such metric, or ``within`` is negative.

        Example:
            >>> import urdf_ik
            >>> arm = urdf_ik.load("srs_7r")
            >>> q = [0.3, 0.5, -0.4, 0.9, 0.2, -0.6, 0.1]
            >>> arm.intervals(arm.fk(q)).nearest(q)[0].q.round(6).tolist()
            [0.3, 0.5, -0.4, 0.9, 0.2, -0.6, 0.1]
        """
        reference = distances.reference(q_ref, self.solver.joint_names, self.shape)
        inside = self.within_limits
        values = self.nearest_values(reference, metric=metric, weights=weights, within=within, within_limits=inside)
        return self._at(values).nearest(reference, weights, metric=metric, within=within, within_limits=inside)

    def nearest_values(
        self,
        q_ref: Array,
        *,
        metric: Metric,
        weights: ArrayLike | None,
        within: ArrayLike | None,
        within_limits: bool,
    ) -> Array:
        """(...) values of the parameter at which poses come nearest to ``q_ref``; NaN for those without an interval.

        Where no solution is inside the limits and near enough, the value is the one that misses these bounds least.
        Arguments as :meth:`nearest` has them; ``within_limits``: whether only images inside the limits count.
        """
        measure = distances.measure(self.solver, metric, weights, within)
        reference = distances.reference(q_ref, self.solver.joint_names, self.shape)
        each = np.broadcast_to(reference, (*self.shape, self.solver.dof)).reshape(-1, self.solver.dof)
        bounds = self.solver.limits if within_limits else np.tile([-np.inf, np.inf], (self.solver.dof, 1))

        def cost(q: Array, pose: NDArray[np.intp]) -> Array:
            return curves.distance(self.solver, q, each[pose], bounds, measure)

        return self._least(cost)

    def best(self, by: Quality | Wish) -> IKSolutions:
        """The joint vector that is best by a measure of quality, of all in the intervals: one column a pose.

        Args:
            by: 'limits', 'manipulability', 'clearance' or a wish; see :meth:`urdf_ik.IKSolutions.best`.

        Raises:
            ArgumentError: there is no such measure.
            UrdfError: 'clearance' is asked for, and the URDF's collision shapes are missing or cannot be read.
        """
        check_quality(by, self.solver.chain)

        def cost(q: Array, pose: NDArray[np.intp]) -> Array:
            return -curves.quality(self.solver, q, by)

        solutions = self._at(self._least(cost))
        return solutions.within_limits().best(by) if self.within_limits else solutions.best(by)

    def table(self) -> str:
        """One line an interval of a single pose: its branch, its ends [rad or m], and why it ends."""
        self._single("table()")
        title = f"{self.solver.name}: {len(self)} intervals of the {self.parameter}"
        return "\n".join([title, *aligned(self._rows(), left=(0, 2, 4))])

    def _rows(self) -> list[list[str]]:
        """The header, and a row an interval of a single pose."""
        unit = unit_of(self.parameter.unit)
        rows = [["branch", f"from [{unit}]", "because", f"to [{unit}]", "because"]]
        for each in () if self.shape else self:
            low, high = (f"{shown(value, each.unit):.6f}" for value in (each.low, each.high))
            rows.append([each.branch, low, str(each.ends[0]), high, str(each.ends[1])])
        return rows

    def __str__(self) -> str:
        return repr(self) if self.shape else self.table()

    def __repr__(self) -> str:
        of = f"poses {self.shape}, " if self.shape else ""
        inside = " within the limits" if self.within_limits else ""
        title = f"Intervals of {self.solver.name}: {of}{len(self._found.low)} intervals{inside}"
        return short(title, [] if self.shape else [str(each) for each in self])

    def _repr_html_(self) -> str:
        header, *rows = self._rows()
        title = f"{self.solver.name}: intervals of the {self.parameter}"
        found = f"{len(self._found.low)} intervals{' within the limits' * self.within_limits}"
        if self.shape:
            found += f" of poses {self.shape}; intervals[i] shows one"
        return html_of(title, found, bool(len(self._found.low)), [Section("", tuple(header), tuple(map(tuple, rows)))])

    def _least(self, cost: curves.Cost) -> Array:
        """(...) the values at which a cost is least; NaN for poses without an interval."""
        stack = self._T.reshape(-1, 4, 4)
        value, _ = curves.least(Curves.of(self.solver), stack, self._found, cost)
        return value.reshape(self.shape)

    def _at(self, values: Array) -> IKSolutions:
        """The solutions at values, of poses without one at the default."""
        values = np.where(np.isnan(values), self.parameter.default, self.parameter.wrapped(values))
        return solve(self.solver, self._T, redundancy=values)

    def _interval(self, k: int) -> Interval:
        found = self._found
        branch = self.solver.structure.branches[found.column[k]]
        return Interval(branch, float(found.low[k]), float(found.high[k]), tuple(found.ends[k]), self.parameter.unit)

    def _single(self, what: str) -> None:
        if self.shape:
            raise ArgumentError(
                f"{what} needs the intervals of a single pose, and these are of a batch of shape {self.shape}; take "
                "one, intervals[i]"
            )


def _union(low: Array, high: Array, is_round: bool) -> Array:
    """(k, 2) the union of intervals (j,), which may pass half a turn where values go round."""
    if not len(low):
        return np.empty((0, 2))
    order = np.argsort(low, kind="stable")
    merged = [[float(low[order[0]]), float(high[order[0]])]]
    for k in order[1:]:
        if low[k] <= merged[-1][1]:
            merged[-1][1] = max(merged[-1][1], float(high[k]))
        else:
            merged.append([float(low[k]), float(high[k])])
    if is_round:
        if any(b - a >= TURN for a, b in merged):
            return np.array([[-np.pi, np.pi]])
        # An interval that passes half a turn may overlap the first ones.
        while len(merged) > 1 and merged[-1][1] - TURN >= merged[0][0]:
            merged[-1][1] = max(merged[-1][1], merged.pop(0)[1] + TURN)
        if merged[0][1] - merged[0][0] >= TURN or (len(merged) == 1 and merged[0][1] - TURN >= merged[0][0]):
            return np.array([[-np.pi, np.pi]])
    return np.array(merged)
