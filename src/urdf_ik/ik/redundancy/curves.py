"""Curves of joint vectors that hold a pose, intervals of the redundancy parameter along them, and least costs."""

from collections.abc import Callable
from dataclasses import dataclass, fields, replace

import numpy as np
from numpy.typing import NDArray

from urdf_ik._core import SelfMotion
from urdf_ik.errors import UnsupportedArm
from urdf_ik.ik.solutions import distances, limits
from urdf_ik.ik.solutions.distances import Measure, Quality, Wish
from urdf_ik.ik.solver import Solver
from urdf_ik.kinematics import velocity
from urdf_ik.kinematics.chain.redundancy import Redundancy
from urdf_ik.support.text import quoted
from urdf_ik.typing import Array

CAUSES = {
    "none": "no end",
    "fold": "fold",
    "reach": "edge of reach",
    "singularity": "singularity",
    "limit": "a joint's limit",
    "range": "end of the parameter's range",
}
"""Why an interval ends, and words for it. 'none': nothing ends there; it is the whole circle, or its closed curve
passes some values more than once and was cut at one; 'fold': two branches become one and end there; 'reach': the same,
and beyond it no branch has a solution; 'singularity': the joints could not be followed further."""


@dataclass(frozen=True)
class End:
    """Why an interval ends.

    Attributes:
        cause: one of ``CAUSES``.
        joint: whose limit it is, for 'limit'.
        upper: whether it is the upper limit, for 'limit'.
    """

    cause: str
    joint: str | None = None
    upper: bool | None = None

    def __str__(self) -> str:
        if self.cause == "limit":
            return f"{'upper' if self.upper else 'lower'} limit of joint {quoted(self.joint)}"
        return CAUSES[self.cause]


@dataclass(frozen=True, eq=False)
class Found:
    """Intervals as arrays, of k intervals.

    Attributes:
        pose: (k,) number of the pose.
        low: (k,) rad or m.
        high: (k,) rad or m.
        column: (k,) the solver's column of the solution in the middle.
        ends: (k, 2) both ends of each, End.
        first: (k,) its first sample.
        count: (k,) its samples, of growing value.
        value: (s,) rad or m, of samples on the curves, the ends of every interval among them.
        q: (s, n) rad or m, joint vectors of the samples, row by row with ``value``.
        core: (s, 17) the samples as the compiled core has them.
    """

    pose: NDArray[np.intp]
    low: Array
    high: Array
    column: NDArray[np.intp]
    ends: NDArray[np.object_]
    first: NDArray[np.intp]
    count: NDArray[np.intp]
    value: Array
    q: Array
    core: Array

    def of(self, which: NDArray[np.intp]) -> "Found":
        """Some of the intervals; the samples stay as they are."""
        return replace(self, **{name: getattr(self, name)[which] for name in _OF_INTERVALS})


_OF_INTERVALS = ("pose", "low", "high", "column", "ends", "first", "count")


def joined(parts: list[Found]) -> Found:
    """Several sets of intervals as one."""
    if len(parts) == 1:
        return parts[0]
    samples = np.cumsum([0, *(len(part.value) for part in parts)])
    moved = [replace(part, first=part.first + start) for part, start in zip(parts, samples, strict=False)]
    return Found(*(np.concatenate([getattr(part, each.name) for part in moved]) for each in fields(Found)))


Columns = NDArray[np.intp]
Cost = Callable[[Array, Columns], Array]
"""(joint vectors (k, n), numbers of their poses (k,)) -> costs (k,)."""

# Share of the way between two samples at which the search for a minimum ends.
_FINEST = 1e-8
_GOLDEN = 0.5 * (np.sqrt(5.0) - 1.0)
# Costs of solutions outside the limits, and of those that are too far from the reference: more than any distance.
_OUTSIDE, _BEYOND = 1e7, 1e5


@dataclass(frozen=True, eq=False)
class Curves:
    """The curves of an arm, as the compiled core follows them.

    Attributes:
        core: what follows them, of seven joints.
        parameter: the redundancy parameter.
        appended: whether the parameter stands behind the arm's joints as a seventh one, since it is none of them.
    """

    core: SelfMotion
    parameter: Redundancy
    appended: bool

    @classmethod
    def of(cls, solver: Solver) -> "Curves":
        """The curves of an arm with one redundancy parameter.

        Raises:
            UnsupportedArm: nothing follows its curves.
        """
        member = solver.redundant_member
        if member.self_motion is None:
            raise UnsupportedArm(
                f"{solver.name}: intervals of the redundancy parameter are not found for arms whose joints mimic "
                "others, that have several parameters, or whose joints do not move the tip in every way; "
                "ik(T, redundancy=values) solves at values"
            )
        return cls(member.self_motion, member.parameters[0], solver.dof < 7)

    def seven(self, q: Array, values: Array) -> Array:
        """Joint vectors (..., n) with the parameter's values (...) behind them where it is none of the joints."""
        return np.concatenate([q, values[..., None]], axis=-1) if self.appended else q

    def joints(self, q: Array) -> Array:
        """The arm's joints of vectors (..., 7)."""
        return q[..., :-1] if self.appended else q


def least(curves: Curves, T: Array, found: Found, cost: Cost) -> tuple[Array, Array]:
    """Where in the intervals of poses (m, 4, 4) a cost is least: values (m,) of the parameter, and the costs.

    The lowest of the samples along each interval are closed in upon between their neighbours by golden sections along
    the curve, to 1e-8 of the way. Samples are at most 0.3 apart along the curve [rad, share of size].

    Returns:
        A pose without an interval gets NaN and an infinite cost.
    """
    m, k = len(T), len(found.low)
    value, lowest = np.full(m, np.nan), np.full(m, np.inf)
    if not k:
        return value, lowest
    # Samples of all intervals in a row: number of the interval, number of the sample.
    interval = np.repeat(np.arange(k), found.count)
    start = np.repeat(np.cumsum(found.count) - found.count, found.count)
    sample = found.first[interval] + np.arange(len(interval)) - start
    pose = found.pose[interval]
    costs = cost(found.q[sample], pose)
    np.minimum.at(lowest, pose, costs)
    best = np.flatnonzero(costs == lowest[pose])
    value[pose[best]] = found.value[sample[best]]

    first = np.concatenate([[True], interval[1:] != interval[:-1]])
    last = np.concatenate([interval[1:] != interval[:-1], [True]])
    before, after = np.roll(costs, 1), np.roll(costs, -1)
    valley = (first | (costs <= before)) & (last | (costs <= after)) & np.isfinite(costs)
    places = np.flatnonzero(valley)
    here, of = sample[places], pose[places]
    before = found.core[np.where(first[places], here, here - 1)]
    middle = found.core[here]
    after = found.core[np.where(last[places], here, here + 1)]
    values = np.empty(len(here))

    def at(share: Array) -> Array:
        """Costs at shares from -1, the sample before, by 0, the one in the middle, to 1, the one behind."""
        back = (share < 0.0)[:, None]
        one, other = np.where(back, before, middle), np.where(back, middle, after)
        points = np.asarray(curves.core.between(T[of], one, other, np.where(share < 0.0, 1.0 + share, share)))
        q = curves.joints(points[:, 1:])
        out = np.full(len(share), np.inf)
        good = ~np.isnan(q).any(axis=1)
        out[good] = cost(q[good], of[good])
        values[:] = points[:, 0]
        return out

    a, b = np.where(first[places], 0.0, -1.0), np.where(last[places], 0.0, 1.0)
    c, d = b - _GOLDEN * (b - a), a + _GOLDEN * (b - a)
    at_c, at_d = at(c), at(d)
    while len(a) and (b - a).max() > _FINEST:
        left = at_c <= at_d
        a, b = np.where(left, a, c), np.where(left, d, b)
        fresh = np.where(left, b - _GOLDEN * (b - a), a + _GOLDEN * (b - a))
        at_fresh = at(fresh)
        c, d = np.where(left, fresh, d), np.where(left, c, fresh)
        at_c, at_d = np.where(left, at_fresh, at_d), np.where(left, at_c, at_fresh)
    reached = at(np.where(at_c <= at_d, c, d))
    for k in np.argsort(-reached, kind="stable"):
        if reached[k] < lowest[of[k]]:
            value[of[k]], lowest[of[k]] = values[k], reached[k]
    return value, lowest


def distance(solver: Solver, q: Array, q_ref: Array, bounds: Array, measure: Measure) -> Array:
    """(k,) of solutions (k, n): the distance of the nearest image inside the bounds from (k, n), infinite for NaN rows.

    If no image is inside, ``_OUTSIDE`` plus the excess; if none is near enough, ``_BEYOND`` plus the excess.
    """
    turning = ~solver.chain.prismatic
    image, inside = limits.image_near(q, q_ref, bounds, turning)
    apart = distances.difference(image, q_ref, np.zeros(solver.dof))
    cost = _share(solver, measure, apart)
    if measure.within is not None:
        beyond = measure.beyond(apart)
        cost = np.where(beyond > 0.0, _BEYOND + beyond, cost)
    if not inside.all():
        _, out = limits.excess(q[~inside], bounds, turning)
        cost[~inside] = np.nan_to_num(_OUTSIDE + np.abs(out).max(axis=-1), nan=np.inf)
    return cost


def quality(solver: Solver, q: Array, by: Quality | Wish) -> Array:
    """(k,) how good solutions (k, n) are, more is better; see :meth:`urdf_ik.IKSolutions.scores`."""
    if isinstance(by, Wish):
        return by.scores(solver.chain, q)
    if by == "manipulability":
        return velocity.manipulability(solver.chain, q, solver.control.part)
    if by == "clearance":
        return np.asarray(solver.arm.cell.in_world(None).distance(q))
    inmost, _ = limits.image_inmost(q, solver.limits, ~solver.chain.prismatic)
    return np.nan_to_num(limits.margin(inmost, solver.limits), nan=-np.inf)


def _share(solver: Solver, measure: Measure, apart: Array) -> Array:
    """The distance (...) as a share of that at which every joint is 1 rad or m away, so that no weights matter here."""
    return measure.distance(apart) / (float(measure.distance(np.ones(solver.dof))) or 1.0)
