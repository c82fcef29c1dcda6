"""The intervals of the redundancy parameter in which each branch has solutions.

All solutions at the values of a grid are starts; the compiled core follows the curves between them, see
src/core/self_motion/curves.hpp: every solution at a value of the grid must be met from both sides. What lies between
two values of the grid only is looked for where the closed form's branches, taken beyond their ends, come nearest to
the pose, and from starts all over the joints where there is no closed form.
"""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from urdf_ik import _core
from urdf_ik.ik.families.parts.family import FamilyMember
from urdf_ik.ik.pose_solving import solve
from urdf_ik.ik.redundancy import closed_form
from urdf_ik.ik.redundancy.curves import Curves, End, Found, joined
from urdf_ik.ik.redundancy.intervals import Intervals
from urdf_ik.ik.redundancy.values import only_parameter
from urdf_ik.ik.solver import Solver
from urdf_ik.kinematics.chain.redundancy import SWIVEL, Redundancy, spread
from urdf_ik.model.poses import as_pose_array
from urdf_ik.support import inputs
from urdf_ik.support.angles import TURN, shortest, wrapped
from urdf_ik.support.read_only import frozen
from urdf_ik.typing import Array, Threads

GRID, GRID_GENERAL = 32, 24
"""Values at which everything is solved: where a closed form does that, and where the elimination does."""
FINER = 4
"""By what the grid is finer on which the branches of a closed form are taken beyond their ends."""
_OFF, _OFF_BY_ERROR = 1e-9, 8.0
"""Error [rad, share of the arm's size] below which such a branch is a solution: of an exact closed form, and as a
multiple of how far the ideal arm is off."""
SPREAD = 0.15
"""rad between samples of intervals in closed form."""
NARROWEST = 1e-9
"""rad or m: a narrower range of the parameter is one value."""
STARTS = 96
"""Joint vectors from which loops between two values are looked for where the elimination solves."""
_AT_ONCE = 64
"""Poses whose grids are solved at a time: some 5 MB of solutions."""
_CAUSES = ("none", "fold", "reach", "singularity", "limit", "limit", "range")
"""Of the core's ends, in their order."""
_UPPER = 5
# Numbers of a sample: value, rate, arc, joints, tangent.
_VALUE, _JOINTS = 0, slice(3, 10)


def intervals(
    solver: Solver,
    T: Any,
    *,
    within_limits: bool = True,
    world: Any = None,
    threads: Threads = 1,
) -> Intervals:
    """Where along the redundancy parameter each branch has solutions, and what ends them.

    The curves of solutions are followed from a grid of values; their ends are computed to 1e-9. For exact S-R-S
    arms, and for a free axis that is that of the last joint, they are roots in closed form.
    :mod:`urdf_ik.ik.redundancy.interval_search` says how, and what may be missed between two values of the grid.

    Args:
        solver: of an arm with one redundancy parameter.
        T: (..., 4, 4) poses of the tip in the base [m], or a ``pinocchio.SE3``.
        within_limits: only solutions inside the joint limits count.
        world: only solutions count that touch neither it nor the arm itself.
        threads: number of threads that share the solving, or 'auto'.

    Returns:
        Of a single pose a sequence of :class:`urdf_ik.Interval`, by branch and by value; of a batch,
        ``intervals[i]`` are those of one pose.

    Raises:
        PoseError: a target is no pose.
        UnsupportedArm: the arm has no redundancy parameter, or several.
        UrdfError: a world is given, and the URDF's collision shapes are missing or cannot be read.

    Example:
        >>> import urdf_ik
        >>> arm = urdf_ik.load("srs_7r")
        >>> first = arm.intervals(arm.fk([0.3, 0.5, -0.4, 0.9, 0.2, -0.6, 0.1]))[0]
        >>> round(first.low, 6), round(first.high, 6), str(first.ends[0])
        (-2.588603, -1.49593, "lower limit of joint 'joint_3'")
    """
    plan, T = only_parameter(solver, "intervals"), as_pose_array(T)
    threads, curves, stack = inputs.threads(threads), Curves.of(solver), T.reshape(-1, 4, 4)
    bounds = np.full((7, 2), np.inf)
    bounds[:, 0] = -np.inf
    if within_limits:
        bounds[: solver.dof] = solver.limits
    parts, open_ = [], np.arange(len(stack))
    way = closed_form.sense(solver, plan)
    if len(stack) and (closed_form.is_closed(plan) or way):
        closed, open_ = (
            closed_form.last_axis_intervals(solver, way, stack, bounds[: solver.dof])
            if way
            else closed_form.swivel_intervals(solver, plan, stack, bounds)
        )
        parts.append(closed if world is None and not len(open_) else with_samples(solver, stack, closed))
    for k in range(0, len(open_), _AT_ONCE):
        some = open_[k : k + _AT_ONCE]
        traced = _found(solver, plan, curves, stack[some], bounds, threads)
        parts.append(replace(traced, pose=some[traced.pose]))
    found = joined(parts) if parts else _nothing(solver)
    if world is not None and len(found.low):
        found = without_contacts(solver.arm.cell.in_world(world), curves, stack, found)
    return Intervals(solver, T, found, within_limits, with_samples)


def span(solver: Solver, parameter: Redundancy, T: Array) -> tuple[float, float]:
    """Least and greatest value that is tried for poses (m, 4, 4)."""
    if parameter.round:
        return -np.pi, np.pi
    low, high = parameter.range
    if np.isfinite(high - low):
        return low, high
    reach = float(np.linalg.norm(T[:, :3, 3] - solver.chain.P[0], axis=1).max()) + solver.chain.size
    return max(low, -reach), min(high, reach)


def with_samples(solver: Solver, T: Array, found: Found) -> Found:
    """Intervals of poses (m, 4, 4) without samples, with samples at evenly spread values."""
    curves = Curves.of(solver)
    count = np.maximum(np.ceil((found.high - found.low) / SPREAD).astype(np.intp) + 1, 3)
    first = np.cumsum(count) - count
    of = np.repeat(np.arange(len(count)), count)
    share = (np.arange(count.sum()) - first[of]) / (count[of] - 1)
    value = found.low[of] + share * (found.high - found.low)[of]
    solutions = solve(solver, T[found.pose[of]], redundancy=curves.parameter.wrapped(value))
    q = solutions.q[np.arange(len(of)), found.column[of]]
    core = [
        curves.samples(T[pose], q[a : a + n], value[a : a + n])
        for pose, a, n in zip(found.pose, first, count, strict=True)
    ]
    rows = np.concatenate([*core, np.empty((0, 17))])
    return replace(found, first=first, count=count, value=value, q=q, core=rows)


def _at_one_value(solver: Solver, curves: Curves, T: Array, value: float, bounds: Array, threads: int) -> Found:
    """The intervals of a parameter that has one value only: solutions, as intervals of no width."""
    values = np.full(len(T), value)
    solutions = solve(solver, T, redundancy=values, threads=threads)
    kept = solutions.within_limits() if np.isfinite(bounds).any() else solutions
    pose, column = np.nonzero(kept.valid)
    q, one = solutions.q[pose, column], np.full(len(pose), value)
    core = [curves.samples(T[i], each[None], values[:1]) for i, each in zip(pose, q, strict=True)]
    first, count = np.arange(len(pose)), np.ones(len(pose), dtype=np.intp)
    ends = np.full((len(pose), 2), End("range"))
    return Found(pose, one, one, column, ends, first, count, one, q, np.concatenate([*core, np.empty((0, 17))]))


def _nothing(solver: Solver) -> Found:
    """No interval of no pose."""
    none, empty = np.zeros(0, dtype=np.intp), np.zeros(0)
    ends, samples = np.empty((0, 2), dtype=object), (empty, np.empty((0, solver.dof)), np.empty((0, 17)))
    return Found(none, empty, empty, none, ends, none, none, *samples)


def _found(solver: Solver, plan: FamilyMember, curves: Curves, T: Array, bounds: Array, threads: int) -> Found:
    """The intervals of a few poses, their curves followed."""
    parameter = plan.parameters[0]
    # Where another plan serves every value, there are no branches beyond their ends either.
    general = plan.family.by_elimination or not isinstance(plan.solver, _core.Solver)
    low, high = span(solver, parameter, T)
    if not parameter.round and high - low < NARROWEST:
        return _at_one_value(solver, curves, T, 0.5 * (low + high), bounds, threads)
    grid = _grid(low, high, GRID_GENERAL if general else GRID, parameter.round)
    solutions = solve(solver, T[:, None], redundancy=grid, threads=threads)
    q = solutions.q
    if curves.appended:
        q = np.ascontiguousarray(curves.seven(q, np.broadcast_to(grid[:, None], solutions.valid.shape)))
    beyond = None
    if not general:
        fine = _grid(low, high, FINER * len(grid), parameter.round)
        beyond = np.ascontiguousarray(_beyond(solver, plan, curves, T, fine))
    scale = np.ones(7)
    scale[: solver.dof] = np.where(solver.chain.prismatic, solver.chain.size, np.pi)
    starts = _starts(STARTS if general else 0) * scale
    flags = np.ascontiguousarray(solutions.valid.view(np.uint8))
    poses = np.ascontiguousarray(T)
    given = _Given(grid, q, flags, bounds, beyond, max(_OFF, _OFF_BY_ERROR * plan.error), starts)
    samples, rows = _followed(solver, curves, poses, given)
    numbers = rows.astype(np.intp)
    pose, first, count, column = numbers[:, :4].T
    value, joints = samples[:, _VALUE], curves.joints(samples[:, _JOINTS])
    low, high = value[first], value[first + count - 1]
    if parameter.unit == "rad":
        turned = wrapped(low) - low
        whole = np.abs(high - low - TURN) <= 1e-12
        turned[whole] = -np.pi - low[whole]
        samples_of = np.repeat(first - np.cumsum(count) + count, count) + np.arange(count.sum())
        value = value.copy()
        value[samples_of] += np.repeat(turned, count)
        low, high = low + turned, high + turned
    ends = _ends(solver, numbers[:, 4:6], numbers[:, 6:8])
    found = Found(pose, low, high, column, ends, first, count, value, joints, samples)
    _name(solver, T, found)
    order = np.lexsort((low, column, pose))
    return found.of(order)


@lru_cache(maxsize=64)
def _grid(low: float, high: float, count: int, is_round: bool) -> Array:
    """Evenly spread values (count,); a periodic grid does without the end."""
    return frozen(np.linspace(low, high, count, endpoint=not is_round))


@lru_cache(maxsize=2)
def _starts(count: int) -> Array:
    """Joint vectors (count, 7) from -1 to 1, the same in every call."""
    return frozen(np.random.default_rng(0).uniform(-1.0, 1.0, (count, 7)))


class _Given(NamedTuple):
    """What the core is given for poses (m, 4, 4).

    Attributes:
        grid: (v,) values.
        q: (m, v, B, 7) the solutions there.
        flags: (m, v, B) whether there is one.
        limits: (7, 2), infinite where there is none.
        beyond: (m, w, B, 7) the closed form's branches at finer values, beyond their ends too; None without one.
        off: error below which these are solutions.
        starts: (k, 7) joint vectors from which loops are looked for.
    """

    grid: Array
    q: Array
    flags: NDArray[np.uint8]
    limits: Array
    beyond: Array | None
    off: float
    starts: Array

    def of(self, i: int, more: Array) -> _Given:
        """Of one pose, with more starts (k, 7)."""
        one = slice(i, i + 1)
        beyond = None if self.beyond is None else self.beyond[one]
        starts = np.ascontiguousarray(np.vstack([self.starts, more]))
        return self._replace(q=self.q[one], flags=self.flags[one], beyond=beyond, starts=starts)


def _followed(solver: Solver, curves: Curves, T: Array, given: _Given) -> tuple[Array, Array]:
    """Samples and intervals of poses (m, 4, 4) from the core.

    A part of a curve that holds no value of the grid is seldom alone: all solutions at a value in its middle are starts
    for another look at its pose.
    """

    def ask(poses: Array, what: _Given) -> tuple[Array, Array, Array]:
        grid, q, flags, limits, beyond, off, starts = what
        is_round = curves.parameter.round
        samples, rows, unseen = curves.core.intervals(poses, grid, is_round, q, flags, limits, beyond, off, starts)
        return np.asarray(samples), np.asarray(rows), np.asarray(unseen)

    samples, rows, unseen = ask(T, given)
    if not len(unseen):
        return samples, rows
    again = np.unique(unseen[:, 0].astype(np.intp))
    parts, tables, first = [samples], [rows[~np.isin(rows[:, 0], again)]], len(samples)
    for i in again.tolist():
        values = curves.parameter.wrapped(unseen[unseen[:, 0] == i, 1])
        found = solve(solver, T[i], redundancy=values)
        there = curves.seven(found.q, np.broadcast_to(values[:, None], found.valid.shape))[found.valid]
        more, table, _ = ask(T[i : i + 1], given.of(i, there))
        table[:, 0] = i
        table[:, 1] += first
        first += len(more)
        parts.append(more)
        tables.append(table)
    return np.concatenate(parts), np.concatenate(tables)


def _beyond(solver: Solver, plan: FamilyMember, curves: Curves, T: Array, grid: Array) -> Array:
    """Joint vectors (m, v, B, 7) of all branches at the values (v,), beyond their ends too; not verified."""
    poses, values = spread(plan.parameters, T[:, None], grid)
    branches = len(plan.branches)
    q = np.full((*values.shape, branches, solver.dof), np.nan)
    rows = q.reshape(-1, branches, solver.dof)
    plan.solver.solve(
        poses.reshape(-1, 4, 4), None, rows, np.zeros(rows.shape[:2], np.uint8), values.reshape(-1), 1, beyond=True
    )
    out = curves.seven(q, np.broadcast_to(values[..., None], q.shape[:-1])) if curves.appended else q
    if plan.parameters[0].kind != SWIVEL:
        given = 6 if curves.appended else solver.joint_names.index(plan.parameters[0].joint)
        out[..., given] = values[..., None]  # branches that are no solution have no value yet
    return out


def _ends(solver: Solver, why: NDArray[np.intp], joint: NDArray[np.intp]) -> NDArray[np.object_]:
    """Ends (k, 2) as the core gives them: numbers of the cause and of the joint, -1 without one."""
    return _table_of_ends(solver.joint_names)[why, joint]


@lru_cache(maxsize=64)
def _table_of_ends(joint_names: tuple[str, ...]) -> NDArray[np.object_]:
    """Every end, by the numbers of its cause and of its joint; the last column is without a joint."""
    table = np.empty((len(_CAUSES), len(joint_names) + 1), dtype=object)
    for k, cause in enumerate(_CAUSES):
        limit = cause == "limit"
        table[k, :-1] = [End(cause, name, upper=k == _UPPER) if limit else None for name in joint_names]
        table[k, -1] = None if limit else End(cause)
    return frozen(table)


def _name(solver: Solver, T: Array, found: Found) -> None:
    """Fill in the columns of intervals that hold no value of the grid: those of the solutions in their middles."""
    unknown = np.flatnonzero(found.column < 0)
    if not len(unknown):
        return
    at = found.first[unknown] + found.count[unknown] // 2
    solutions = solve(solver, T[found.pose[unknown]], redundancy=found.value[at])
    apart = np.abs(wrapped(solutions.q - found.q[at][:, None])).max(axis=-1)
    found.column[unknown] = np.nanargmin(np.where(np.isnan(apart), np.inf, apart), axis=1)


STEP = 0.05
"""rad or shares of the arm's size along a curve between two joint vectors that are asked about first."""
NARROWEST_FREE = 1e-5
"""rad or m: a motion between two free values is cut down to this before it counts as a contact between them."""
_ENDS = 36
"""How often the place of a contact is halved: from ``STEP`` to below 1e-11."""


def without_contacts(model: Any, curves: Curves, T: Array, found: Found) -> Found:
    """Cut intervals of poses (m, 4, 4) where bodies touch.

    Between two values that are free the straight motion of the joints is proven free, or cut in halves, down to
    ``NARROWEST``; where a free value has one in contact beside it, the place of the contact is halved.
    """
    pieces = [piece for k in range(len(found.low)) for piece in _cut(model, curves, T[found.pose[k]], found, k)]
    count = np.array([len(piece.values) for piece in pieces], dtype=np.intp)
    of = found.of(np.array([piece.interval for piece in pieces], dtype=np.intp))
    samples = [curves.samples(T[pose], each.q, each.values) for pose, each in zip(of.pose, pieces, strict=True)]
    return replace(
        of,
        low=np.array([piece.values[0] for piece in pieces]),
        high=np.array([piece.values[-1] for piece in pieces]),
        ends=np.array([piece.ends for piece in pieces], dtype=object).reshape(-1, 2),
        first=np.cumsum(count) - count,
        count=count,
        value=np.concatenate([*(piece.values for piece in pieces), []]),
        q=np.concatenate([*(piece.q for piece in pieces), found.q[:0]]),
        core=np.concatenate([*samples, found.core[:0]]),
    )


class _Piece(NamedTuple):
    """What is left of an interval: its number, samples of growing value, and ends."""

    interval: int
    values: Array
    q: Array
    ends: tuple[End, End]


def _cut(model: Any, curves: Curves, T: Array, found: Found, k: int) -> list[_Piece]:
    """The pieces of interval ``k``, of pose T (4, 4), without contacts."""
    part = slice(found.first[k], found.first[k] + found.count[k])
    value, q = _refined(curves, T, found.value[part], found.q[part])
    hit = np.asarray(model.in_collision(q), dtype=np.bool_)
    # Motions between free neighbours that are not proven free are halved.
    while True:
        near = np.flatnonzero(~hit[:-1] & ~hit[1:] & (np.diff(value) > NARROWEST_FREE))
        way = _way(curves, q[near], q[near + 1])
        near = near[~np.asarray(model.motions_free(q[near], q[near] + way).free)] if len(near) else near
        fresh = 0.5 * (value[near] + value[near + 1])
        if not len(near):
            break
        joints = curves.at(np.broadcast_to(T, (len(near), 4, 4)), q[near], fresh)
        value, q = np.insert(value, near + 1, fresh), np.insert(q, near + 1, joints, axis=0)
        hit = np.insert(hit, near + 1, np.asarray(model.in_collision(joints), dtype=np.bool_))
    out = []
    edges = np.flatnonzero(np.diff(np.concatenate([[1], hit.astype(np.int8), [1]])))
    for start, stop in zip(edges[::2], edges[1::2], strict=True):
        values, joints, (low, high) = value[start:stop], q[start:stop], tuple(found.ends[k])
        if start > 0:
            at, there, low = _contact(model, curves, T, value, q, start, start - 1)
            values, joints = np.append(at, values), np.vstack([there, joints])
        if stop < len(value):
            at, there, high = _contact(model, curves, T, value, q, stop - 1, stop)
            values, joints = np.append(values, at), np.vstack([joints, there])
        out.append(_Piece(k, values, joints, (low, high)))
    return out


def _refined(curves: Curves, T: Array, value: Array, q: Array) -> tuple[Array, Array]:
    """Samples (k,), (k, n) of a curve, and others between them, so that no joint moves by more than ``STEP``."""
    pieces = np.ceil(np.abs(_way(curves, q[:-1], q[1:])).max(axis=1) / STEP).astype(np.intp)
    share = [np.arange(count) / count for count in np.maximum(pieces, 1)]
    before = np.repeat(np.arange(len(share)), [len(each) for each in share])
    values = value[before] + np.concatenate([*share, []]) * np.diff(value)[before]
    joints = q[before].copy()
    fresh = values > value[before]
    joints[fresh] = curves.at(np.broadcast_to(T, (int(fresh.sum()), 4, 4)), joints[fresh], values[fresh])
    kept = ~np.isnan(joints).any(axis=1)
    return np.append(values[kept], value[-1]), np.vstack([joints[kept], q[-1:]])


def _contact(
    model: Any, curves: Curves, T: Array, value: Array, q: Array, inside: int, outside: int
) -> tuple[float, Array, End]:
    """The last free value from sample ``inside`` towards ``outside``, its joint vector, and what touches behind it."""
    free, held, joints, touching = value[inside], value[outside], q[inside], q[outside]
    for _ in range(_ENDS):
        middle = 0.5 * (free + held)
        there = curves.at(T[None], joints[None], np.array([middle]))[0]
        if np.isnan(there).any():
            break
        if model.in_collision(there[None])[0]:
            held, touching = middle, there
        else:
            free, joints = middle, there
    nearest = model.nearest_pair(touching)
    return float(free), joints, End("contact", pair=None if nearest is None else nearest.links)


def _way(curves: Curves, q0: Array, q1: Array) -> Array:
    """How far each joint goes from q0 (k, n) to q1 (k, n), angles by the shorter way round."""
    return np.where(curves.turning, shortest(q1 - q0), q1 - q0)
