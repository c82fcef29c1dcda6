"""Smoothing of a route: the redundancy parameter moves to where the sum of squared steps is least.

Along its self-motion each joint vector is q + t d, t being its derivative by the parameter. To first order the sum of
squared steps is a quadratic function of all d that couples only neighbours, so its minimum solves a tridiagonal system
(Gauss-Newton). Joint vectors that would leave the limits or make contact stay where they were.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import solveh_banded

from urdf_ik.ik.pose_solving import solve
from urdf_ik.paths.checked_settings import CheckedSettings, Obstacles
from urdf_ik.paths.planner.assembly import Refined
from urdf_ik.typing import Array

MOST_STEPS = 30
"""Most steps of Newton's method."""
WORTHWHILE = 0.999
"""Take another step while the last one lowered the sum by more than 0.1 %."""
DIFFERENCE = 1e-5
"""Half the difference of the parameter in the central difference quotient [rad or m]."""
LONGEST_STEP = 0.1
"""Largest change of the parameter per step [rad or m]."""
SAME_BRANCH = 0.3
"""A solution farther than this from its prediction belongs to another branch [rad or m]."""


def smoothed(settings: CheckedSettings, refined: Refined, q: Array, value: Array) -> tuple[Array, Array]:
    """Joint vectors (k, n) and values (k,) of a route at a local minimum of the sum of squared steps.

    Args:
        settings: of the path; a given start and end remain.
        refined: the waypoints.
        q: (k, n) rad or m, without jumps and free of contact.
        value: (k,) redundancy parameter.
    """
    least = _least(settings, refined, q, value, None)
    # The result is usually free of contact; only if it is not, contacts are checked at every step.
    if settings.obstacles is None or settings.obstacles.free(least[0]).all():
        return least
    return _least(settings, refined, q, value, settings.obstacles)


def _least(
    settings: CheckedSettings, refined: Refined, q: Array, value: Array, obstacles: Obstacles | None
) -> tuple[Array, Array]:
    """The same, with contacts checked at every step where there are obstacles."""
    factor = np.sqrt(settings.weights) * np.sqrt(refined.pieces)[:, None]
    fixed = np.zeros(len(q), dtype=np.bool_)
    fixed[0], fixed[-1] = settings.start is not None, settings.end is not None
    least = sum_of_squares(q, factor)
    for _ in range(MOST_STEPS):
        t = _derivative(settings, refined, q, value)
        directions = np.where((fixed | np.isnan(t).any(axis=1))[:, None], 0.0, t)
        step = newton_step(q, directions[:, :, None], factor)[:, 0].clip(-LONGEST_STEP, LONGEST_STEP)
        best = None
        for share in (1.0, 0.5, 0.25):
            trial_value = _inside(settings, value + share * step)
            moved = np.nan_to_num(t) * (trial_value - value)[:, None]
            trial, good = _solved(settings, refined, q + moved, trial_value)
            if obstacles is not None:
                good[good] = obstacles.free(trial[good])
            trial, trial_value = np.where(good[:, None], trial, q), np.where(good, trial_value, value)
            total = sum_of_squares(trial, factor)
            if total < least:
                best = total, trial, trial_value
                break
        if best is None:
            break
        before, (least, q, value) = least, best
        if not least < WORTHWHILE * before:
            break
    return q, value


def sum_of_squares(q: Array, factor: Array) -> float:
    """The sum over steps of (factor dq)^2, along joint vectors (k, n)."""
    return float(((np.diff(q, axis=0) * factor) ** 2).sum())


def newton_step(q: Array, N: Array, factor: Array) -> Array:
    """Coefficients (k, j) with which q + N a minimises the sum of squares; N (k, n, j) are directions of motion."""
    k, _, j = N.shape
    left, right = N[:-1] * factor[:, :, None], N[1:] * factor[:, :, None]
    gap = np.diff(q, axis=0) * factor
    diagonal, slope = np.zeros((k, j, j)), np.zeros((k, j))
    diagonal[:-1] += np.einsum("kni,knj->kij", left, left)
    diagonal[1:] += np.einsum("kni,knj->kij", right, right)
    slope[:-1] += np.einsum("kni,kn->ki", left, gap)
    slope[1:] -= np.einsum("kni,kn->ki", right, gap)
    coupling = -np.einsum("kni,knj->kij", left, right)
    # The added diagonal keeps the system regular where the whole route can slide, or a joint vector is fixed.
    diagonal += 1e-9 * np.eye(j) * max(float(np.abs(diagonal).max()), 1e-12)
    banded = np.zeros((2 * j, k * j))
    for a in range(j):
        for b in range(j):
            if a <= b:
                banded[2 * j - 1 + a - b, b::j] = diagonal[:, a, b]
            banded[j - 1 + a - b, j + b :: j] = coupling[:, a, b]
    return np.asarray(solveh_banded(banded, slope.ravel(), check_finite=False)).reshape(k, j)


def _derivative(settings: CheckedSettings, refined: Refined, q: Array, value: Array) -> Array:
    """(k, n) derivative of the joint vectors by the parameter, NaN where there is none."""
    ends = []
    for side in (-DIFFERENCE, DIFFERENCE):
        moved, good = _solved(settings, refined, q, value + side, inside=False)
        ends.append(np.where(good[:, None], moved, np.nan))
    return np.asarray((ends[1] - ends[0]) / (2.0 * DIFFERENCE))


def _solved(
    settings: CheckedSettings, refined: Refined, near: Array, value: Array, *, inside: bool = True
) -> tuple[Array, NDArray[np.bool_]]:
    """The solutions nearest to joint vectors; and whether there is one near enough, inside the limits if asked."""
    parameter = settings.solver.parameter
    assert parameter is not None  # smoothing moves the parameter
    solutions = solve(settings.solver, refined.T, redundancy=parameter.wrapped(value))
    steps = settings.joints.step(near[:, None], solutions.q)
    distance = np.where(solutions.valid, np.abs(steps).max(axis=2), np.inf)
    column = np.argmin(distance, axis=1)
    rows = np.arange(len(near))
    q = near + steps[rows, column]
    good = distance[rows, column] < SAME_BRANCH
    if inside:
        low, high = settings.solver.limits.T
        good &= ((q >= low) & (q <= high)).all(axis=1)
    return q, good


def _inside(settings: CheckedSettings, value: Array) -> Array:
    parameter = settings.solver.parameter
    assert parameter is not None  # smoothing moves the parameter
    return value if parameter.round else np.clip(value, *parameter.range)
