"""The intervals of the redundancy parameter in which each branch has solutions.

All solutions at the values of a grid are starts; the compiled core follows the curves between them
(src/core/motion/self_motion/curves.hpp): every solution at a value of the grid must be met from both sides. Curves that
lie wholly between two values of the grid are searched for separately: from where the closed form's branches, continued
beyond their ends, come nearest to the pose, and from starts all over the joints where there is no closed form.
"""

from dataclasses import replace
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from urdf_ik import _core
from urdf_ik.ik.families.parts.family import FamilyMember
from urdf_ik.ik.pose_solving import solve
from urdf_ik.ik.redundancy.curves import Curves, End, Found, joined
from urdf_ik.ik.redundancy.intervals import Intervals
from urdf_ik.ik.redundancy.values import only_parameter
from urdf_ik.ik.solver import Solver
from urdf_ik.kinematics.chain.redundancy import SWIVEL, Redundancy, spread
from urdf_ik.model.poses import as_pose_array
from urdf_ik.support import inputs
from urdf_ik.support.angles import TURN, wrapped
from urdf_ik.support.read_only import frozen
from urdf_ik.typing import Array, Threads

GRID, GRID_GENERAL = 32, 24
"""Values at which everything is solved: where a closed form does that, and where the elimination does."""
FINER = 4
"""By what the grid is finer on which the branches of a closed form are taken beyond their ends."""
_OFF, _OFF_BY_ERROR = 1e-9, 8.0
"""Error [rad, share of the arm's size] below which such a branch is a solution: of an exact closed form, and as a
multiple of how far the ideal arm is off."""
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


def intervals(solver: Solver, T: Any, *, within_limits: bool = True, threads: Threads = 1) -> Intervals:
    """Where along the redundancy parameter each branch has solutions, and what ends them.

    The curves of solutions are followed from a grid of values; their ends are computed to 1e-9.
    :mod:`urdf_ik.ik.redundancy.interval_search` says how, and what may be missed between two values of the grid.

    Args:
        solver: of an arm with one redundancy parameter.
        T: (..., 4, 4) poses of the tip in the base [m], or a ``pinocchio.SE3``.
        within_limits: only solutions inside the joint limits count.
        threads: number of threads that share the solving, or 'auto'.

    Returns:
        Of a single pose a sequence of :class:`urdf_ik.Interval`, by branch and by value; of a batch,
        ``intervals[i]`` are those of one pose.

    Raises:
        PoseError: a target is no pose.
        UnsupportedArm: the arm has no redundancy parameter, or several.

    Example:
        >>> import urdf_ik
        >>> arm = urdf_ik.load("srs_7r")
        >>> first = arm.intervals(arm.fk([0.3, 0.5, -0.4, 0.9, 0.2, -0.6, 0.1]))[0]
        >>> round(first.low, 6), round(first.high, 6), str(first.ends[0])
        (-2.588603, -1.49593, "lower limit of joint 'joint_3'")
    """
    member, T = only_parameter(solver, "intervals"), as_pose_array(T)
    threads, curves, stack = inputs.threads(threads), Curves.of(solver), T.reshape(-1, 4, 4)
    bounds = np.tile([-np.inf, np.inf], (7, 1))
    if within_limits:
        bounds[: solver.dof] = solver.limits
    parts = []
    for k in range(0, max(len(stack), 1), _AT_ONCE):
        traced = _traced(solver, member, curves, stack[k : k + _AT_ONCE], bounds, threads)
        parts.append(replace(traced, pose=traced.pose + k))
    return Intervals(solver, T, joined(parts), within_limits)


def span(solver: Solver, parameter: Redundancy, T: Array) -> tuple[float, float]:
    """Least and greatest value that is tried for poses (m, 4, 4)."""
    if parameter.round:
        return -np.pi, np.pi
    low, high = parameter.range
    if np.isfinite(high - low):
        return low, high
    reach = float(np.linalg.norm(T[:, :3, 3] - solver.chain.P[0], axis=1).max(initial=0.0)) + solver.chain.size
    return max(low, -reach), min(high, reach)


def _at_one_value(solver: Solver, curves: Curves, T: Array, value: float, bounds: Array, threads: int) -> Found:
    """The intervals of a parameter that has one value only: solutions, as intervals of no width."""
    values = np.full(len(T), value)
    solutions = solve(solver, T, redundancy=values, threads=threads)
    kept = solutions.within_limits() if np.isfinite(bounds).any() else solutions
    pose, column = np.nonzero(kept.valid)
    q, one = solutions.q[pose, column], np.full(len(pose), value)
    core = np.hstack([one[:, None], np.zeros((len(pose), 2)), curves.seven(q, one), np.zeros((len(pose), 7))])
    first, count = np.arange(len(pose)), np.ones(len(pose), dtype=np.intp)
    ends = np.full((len(pose), 2), End("range"))
    return Found(pose, one, one, column, ends, first, count, one, q, core)


def _traced(solver: Solver, member: FamilyMember, curves: Curves, T: Array, bounds: Array, threads: int) -> Found:
    """The intervals of a few poses, their curves followed."""
    parameter = member.parameters[0]
    # Where another plan serves every value, there are no branches beyond their ends either.
    general = member.family.by_elimination or not isinstance(member.solver, _core.Solver)
    low, high = span(solver, parameter, T)
    if not parameter.round and high - low < NARROWEST:
        return _at_one_value(solver, curves, T, 0.5 * (low + high), bounds, threads)
    grid = _grid(low, high, GRID_GENERAL if general else GRID, parameter.round)
    solutions = solve(solver, T[:, None], redundancy=grid, threads=threads)
    q = curves.seven(solutions.q, np.broadcast_to(grid[:, None], solutions.valid.shape))
    fine = _grid(low, high, FINER * len(grid), parameter.round)
    beyond = None if general else np.ascontiguousarray(_beyond(solver, member, curves, T, fine))
    scale = np.ones(7)
    scale[: solver.dof] = np.where(solver.chain.prismatic, solver.chain.size, np.pi)
    flags = np.ascontiguousarray(solutions.valid.view(np.uint8))
    arrays = np.ascontiguousarray(T), np.ascontiguousarray(q), flags, beyond
    constant = grid, bounds, max(_OFF, _OFF_BY_ERROR * member.error)
    samples, rows = _followed(solver, curves, arrays, constant, _starts(STARTS if general else 0) * scale)
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
    ends = _table_of_ends(solver.joint_names)[numbers[:, 4:6], numbers[:, 6:8]]
    found = Found(pose, low, high, column, ends, first, count, value, joints, samples)
    _name(solver, T, found)
    return found.of(np.lexsort((low, column, pose)))


@lru_cache(maxsize=64)
def _grid(low: float, high: float, count: int, is_round: bool) -> Array:
    """Evenly spread values (count,); a periodic grid does without the end."""
    return frozen(np.linspace(low, high, count, endpoint=not is_round))


@lru_cache(maxsize=2)
def _starts(count: int) -> Array:
    """Joint vectors (count, 7) from -1 to 1, the same in every call."""
    return frozen(np.random.default_rng(0).uniform(-1.0, 1.0, (count, 7)))


def _followed(
    solver: Solver, curves: Curves, arrays: tuple[Any, ...], constant: tuple[Array, Array, float], starts: Array
) -> tuple[Array, Array]:
    """Samples and intervals of poses (m, 4, 4) from the core.

    A part of a curve that holds no value of the grid is seldom alone: all solutions at a value in its middle are starts
    for another look at its pose.

    Args:
        solver: of the arm.
        curves: of the arm.
        arrays: the poses; (m, v, B, 7) their solutions at the grid and (m, v, B) whether there is one; (m, w, B, 7) the
            closed form's branches at finer values, beyond their ends too, or None.
        constant: (v,) the grid; (7, 2) limits; the error below which branches beyond their ends are solutions.
        starts: (k, 7) joint vectors from which loops are looked for.
    """
    grid, bounds, off = constant

    def ask(rows: slice, starts: Array) -> list[Array]:
        parts: list[Any] = [each if each is None else each[rows] for each in arrays]
        T, q, flags, beyond = parts
        answer = curves.core.intervals(T, grid, curves.parameter.round, q, flags, bounds, beyond, off, starts)
        return [np.asarray(each) for each in answer]

    samples, rows, unseen = ask(slice(None), starts)
    again = np.unique(unseen[:, 0].astype(np.intp))
    parts, tables, first = [samples], [rows[~np.isin(rows[:, 0], again)]], len(samples)
    for i in again.tolist():
        values = curves.parameter.wrapped(unseen[unseen[:, 0] == i, 1])
        solutions = solve(solver, arrays[0][i], redundancy=values)
        there = curves.seven(solutions.q, np.broadcast_to(values[:, None], solutions.valid.shape))[solutions.valid]
        more, table, _ = ask(slice(i, i + 1), np.ascontiguousarray(np.vstack([starts, there])))
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
