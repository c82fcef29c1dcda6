"""Smoothing of a route: its joint vectors move to where the sum of squared steps is least, without changing poses.

Every joint vector moves by N a, where N is in the null space of the task's Jacobian. To first order the sum of squared
steps is a quadratic function of all a that couples only neighbours, so its minimum solves a tridiagonal system
(Gauss-Newton). Joint vectors that would leave the limits or make contact stay where they were.
"""

import numpy as np
from scipy.linalg import solveh_banded

from urdf_ik.ik.redundancy.values import nearest_values
from urdf_ik.paths.path_settings import CheckedSettings, Obstacles
from urdf_ik.paths.planner.assembly import Refined
from urdf_ik.paths.planner.nodes import nearest_solutions
from urdf_ik.typing import Array

MOST_STEPS = 30
"""Most Gauss-Newton steps. Decides cost only: each step lowers the sum of squares."""
WORTHWHILE = 0.999
"""Take another step while the last one lowered the sum by more than 0.1 %. Decides cost only."""
LONGEST_STEP = 0.2
"""Largest change of a joint per step [rad or m]; a solution farther from its prediction is on another branch."""


def smoothed(settings: CheckedSettings, refined: Refined, q: Array) -> Array:
    """Joint vectors (k, n) of a route at a local minimum of the sum of squared steps.

    Args:
        settings: of the path; a given start and end remain.
        refined: the waypoints.
        q: (k, n) rad or m, solutions without jumps and free of contact.
    """
    least = _least(settings, refined, q, None)
    # The result is usually free of contact; only if it is not, contacts are checked at every step.
    if settings.obstacles is None or settings.obstacles.free(least).all():
        return least
    return _least(settings, refined, q, settings.obstacles)


def _least(settings: CheckedSettings, refined: Refined, q: Array, obstacles: Obstacles | None) -> Array:
    factor = np.sqrt(settings.weights) * np.sqrt(refined.pieces)[:, None]
    fixed = np.zeros(len(q), dtype=np.bool_)
    fixed[0], fixed[-1] = settings.start is not None, settings.end is not None
    low, high = settings.solver.limits.T
    least = sum_of_squares(q, factor)
    for _ in range(MOST_STEPS):
        N = _null_space(settings, refined, q)
        N[fixed] = 0.0
        step = N * newton_step(q, N, factor)[:, None]
        longest = np.abs(step).max()
        step *= min(1.0, LONGEST_STEP / longest) if longest else 1.0
        best = None
        for share in (1.0, 0.5, 0.25, 0.1):
            moved = q + share * step
            values = nearest_values(settings.solver, moved, refined.T)
            trial, distance = nearest_solutions(settings.solver, settings.joints, refined.T, moved, values)
            good = (distance < LONGEST_STEP) & ((trial >= low) & (trial <= high)).all(axis=1)
            if obstacles is not None:
                good[good] = obstacles.free(trial[good])
            trial = np.where(good[:, None] & ~fixed[:, None], trial, q)
            total = sum_of_squares(trial, factor)
            if total < least:
                best = total, trial
                break
        if best is None:
            break
        before, (least, q) = least, best
        if not least < WORTHWHILE * before:
            break
    return q


def sum_of_squares(q: Array, factor: Array) -> float:
    """The sum over steps of (factor dq)^2, along joint vectors (k, n)."""
    return float(((np.diff(q, axis=0) * factor) ** 2).sum())


def newton_step(q: Array, N: Array, factor: Array) -> Array:
    """Coefficients (k,) with which q + N a minimises the sum of squares; N (k, n) are directions of motion."""
    left, right, gap = N[:-1] * factor, N[1:] * factor, np.diff(q, axis=0) * factor
    diagonal, slope = np.zeros(len(q)), np.zeros(len(q))
    diagonal[:-1] += (left * left).sum(axis=1)
    diagonal[1:] += (right * right).sum(axis=1)
    slope[:-1] += (left * gap).sum(axis=1)
    slope[1:] -= (right * gap).sum(axis=1)
    # The added diagonal keeps the system regular where the whole route can slide, or a joint vector is fixed.
    diagonal += 1e-9 * max(float(diagonal.max()), 1e-12)
    banded = np.stack([np.append(0.0, -(left * right).sum(axis=1)), diagonal])
    return np.asarray(solveh_banded(banded, slope, check_finite=False))


def _null_space(settings: CheckedSettings, refined: Refined, q: Array) -> Array:
    """(k, n) unit vectors of the null space of the task's Jacobian; lengths count in arm sizes."""
    solver = settings.solver
    J = solver.chain.jacobian(q)
    if solver.free_axis is not None:
        J = solver.free_axis.reduced(refined.T[:, :3, :3], J)
    J = np.concatenate([J[:, :3] / solver.chain.size, J[:, 3:]], axis=1)
    # The last column of Q in J^T = Q R is at right angles to all rows of J, of whatever rank.
    return np.ascontiguousarray(np.linalg.qr(np.swapaxes(J, 1, 2), mode="complete")[0][:, :, -1])
