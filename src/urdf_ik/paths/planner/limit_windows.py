"""Values of the redundancy parameter between those of a grid at which all joints are just inside their limits."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from urdf_ik.ik.pose_solving import solve
from urdf_ik.ik.solutions import limits
from urdf_ik.paths.checked_settings import CheckedSettings
from urdf_ik.paths.planner import nodes as node_sets
from urdf_ik.paths.planner.nodes import Nodes
from urdf_ik.typing import Array

ROUNDS = 6
"""How often the place of the greatest room is closed in upon; each round halves the step."""


def central(settings: CheckedSettings, q: Array) -> Array:
    """The images of joint vectors (..., n) that are nearest to the middle of the limits."""
    turn = settings.joints.turn
    step = np.where(turn > 0.0, turn, 1.0)
    middle = limits.middle(settings.solver.limits)
    return np.asarray(q - np.where(turn > 0.0, np.round((q - middle) / step) * step, 0.0))


def room(settings: CheckedSettings, q: Array) -> Array:
    """How far joint vectors (k, n) are inside the limits by their best images, negative outside (k,) [rad or m]."""
    return limits.room(central(settings, q), settings.solver.limits)


def narrow(settings: CheckedSettings, T: Array, everything: Nodes, grid: Array) -> Nodes:
    """Nodes in windows that the grid passes over.

    Along each branch the room to the limits is a function of the parameter; where it has a maximum between two values
    of the grid that is not positive at either, the maximum is closed in upon, and kept where it is positive.

    Args:
        settings: arm and joints.
        T: (m, 4, 4) m, waypoints.
        everything: all solutions on the grid, those outside the limits, too.
        grid: (v,) ascending.
    """
    count = len(grid)
    step = grid[1] - grid[0]
    branches = len(settings.solver.structure.branches)
    table = np.full((len(T), branches, count + 2), -np.inf)
    index = np.searchsorted(grid, everything.value - 0.5 * step) % count
    table[everything.at, everything.column, index + 1] = room(settings, everything.q)
    parameter = settings.solver.parameter
    if parameter is not None and parameter.round:
        table[..., 0], table[..., -1] = table[..., -2], table[..., 1]
    here, before, after = table[..., 1:-1], table[..., :-2], table[..., 2:]
    alone = ~np.isfinite(before) | ~np.isfinite(after)
    with np.errstate(invalid="ignore"):  # infinity less infinity, where a branch has no solution
        slope = np.maximum(
            np.where(np.isfinite(before), here - before, 0.0), np.where(np.isfinite(after), here - after, 0.0)
        )
        peak = (here < 0.0) & np.isfinite(here) & (here >= before) & (here >= after)
        peak &= (here + slope > 0.0) | alone
    at, column, k = np.nonzero(peak)
    if not len(at):
        return everything.chosen(np.zeros(0, dtype=np.intp))
    value, best, width = grid[k], here[at, column, k], step
    for _ in range(ROUNDS):
        width *= 0.5
        tried = value[:, None] + width * np.array([-1.0, 0.0, 1.0])
        found = _rooms(settings, T, at, column, tried)
        found[:, 1] = np.maximum(found[:, 1], best)
        pick = np.argmax(found, axis=1)
        value = tried[np.arange(len(at)), pick]
        best = found[np.arange(len(at)), pick]
    inside = np.flatnonzero(best > 0.0)
    order = inside[np.argsort(at[inside], kind="stable")]
    kept = node_sets.solved(settings.solver, settings.joints, T, at[order], value[order, None])
    wanted = set(zip(at[order].tolist(), column[order].tolist(), strict=True))
    return kept.chosen(
        np.array([pair in wanted for pair in zip(kept.at.tolist(), kept.column.tolist(), strict=True)], dtype=np.bool_)
    )


def _rooms(
    settings: CheckedSettings, T: Array, at: NDArray[np.int64], column: NDArray[np.int64], values: Array
) -> Array:
    """Room (k, v) of one branch each at values (k, v); minus infinity where it has no solution."""
    solutions = solve(settings.solver, T[at, None], redundancy=values)
    rows = np.arange(len(at))
    q, valid = solutions.q[rows, :, column], solutions.valid[rows, :, column]
    out = np.full(values.shape, -np.inf)
    out[valid] = room(settings, q[valid])
    return out
