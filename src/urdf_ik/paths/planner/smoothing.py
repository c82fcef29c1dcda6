"""A way along which the sum of squared steps is least: Newton's method on the values of the redundancy parameter.

Along its self-motion each joint vector is q + t d, t being its derivative by the parameter. The sum of squared steps is
then a quadratic function of all d, in which only neighbours meet: its minimum is the solution of a tridiagonal system
(Gauss-Newton). What leaves the limits, or touches something, stays where it was.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import solveh_banded

from urdf_ik.ik.pose_solving import solve
from urdf_ik.paths.checked_settings import CheckedSettings
from urdf_ik.paths.planner.assembly import Refined
from urdf_ik.paths.planner.obstacles import Obstacles
from urdf_ik.typing import Array

ROUNDS = 12
"""Steps of Newton's method at most."""
BETTER = 0.999
"""It goes on while the sum falls below so much of what it was."""
DIFFERENCE = 1e-5
"""rad or m: half the difference of the values from which a derivative is taken."""
LONGEST = 0.1
"""rad or m: the greatest step of a value."""
NEAR = 0.3
"""rad: a solution that is farther from where the step should lead is another branch."""


def smoothed(settings: CheckedSettings, refined: Refined, q: Array, value: Array) -> tuple[Array, Array]:
    """Joint vectors (k, n) and values (k,) of a way, moved to where the sum of squared steps is least nearby.

    Args:
        settings: arm, joints, weights and obstacles; a start and an end that are given stay.
        refined: the waypoints.
        q: (k, n) rad or m, without jumps, clear of the obstacles.
        value: (k,) of the redundancy parameter.
    """
    least = _least(settings, refined, q, value, None)
    # Most ways are clear when they are done; only where one is not, every step is asked about.
    if settings.obstacles is None or settings.obstacles.free(least[0]).all():
        return least
    return _least(settings, refined, q, value, settings.obstacles)


def _least(
    settings: CheckedSettings, refined: Refined, q: Array, value: Array, obstacles: Obstacles | None
) -> tuple[Array, Array]:
    """The same, clear of these obstacles."""
    inverse = np.sqrt(settings.weights) * np.sqrt(refined.pieces)[:, None]
    fixed = np.zeros(len(q), dtype=np.bool_)
    fixed[0], fixed[-1] = settings.start is not None, settings.end is not None
    least = _sum(q, inverse)
    for _ in range(ROUNDS):
        t = _derivative(settings, refined, q, value)
        step = _newton(q, t, inverse, fixed | np.isnan(t).any(axis=1)).clip(-LONGEST, LONGEST)
        best = None
        for share in (1.0, 0.5, 0.25):
            tried_value = _inside(settings, value + share * step)
            moved = np.nan_to_num(t) * (tried_value - value)[:, None]
            tried, good = _solved(settings, refined, q + moved, tried_value)
            if obstacles is not None:
                good[good] = obstacles.free(tried[good])
            tried, tried_value = np.where(good[:, None], tried, q), np.where(good, tried_value, value)
            total = _sum(tried, inverse)
            if total < least:
                best = total, tried, tried_value
                break
        if best is None:
            break
        before, (least, q, value) = least, best
        if not least < BETTER * before:
            break
    return q, value


def _sum(q: Array, inverse: Array) -> float:
    return float(((np.diff(q, axis=0) * inverse) ** 2).sum())


def _newton(q: Array, t: Array, inverse: Array, fixed: NDArray[np.bool_]) -> Array:
    """The values' step to the minimum."""
    gap = np.diff(q, axis=0) * inverse
    left, right = np.where(fixed[:-1, None], 0.0, t[:-1] * inverse), np.where(fixed[1:, None], 0.0, t[1:] * inverse)
    diagonal = np.zeros(len(q))
    diagonal[:-1] += (left * left).sum(axis=1)
    diagonal[1:] += (right * right).sum(axis=1)
    off = -(left * right).sum(axis=1)
    towards = np.zeros(len(q))
    towards[:-1] += (left * gap).sum(axis=1)
    towards[1:] -= (right * gap).sum(axis=1)
    # A value that no step depends on stays; the small share keeps the system solvable where a whole way can slide.
    diagonal = np.where(diagonal > 0.0, diagonal * (1.0 + 1e-9), 1.0)
    return np.asarray(solveh_banded(np.vstack([np.append(0.0, off), diagonal]), towards, check_finite=False))


def _derivative(settings: CheckedSettings, refined: Refined, q: Array, value: Array) -> Array:
    """(k, n) of the joint vectors by the parameter, NaN where there is none."""
    beside = []
    for side in (-DIFFERENCE, DIFFERENCE):
        moved, good = _solved(settings, refined, q, value + side, inside=False)
        beside.append(np.where(good[:, None], moved, np.nan))
    return np.asarray((beside[1] - beside[0]) / (2.0 * DIFFERENCE))


def _solved(
    settings: CheckedSettings, refined: Refined, near: Array, value: Array, *, inside: bool = True
) -> tuple[Array, NDArray[np.bool_]]:
    """The solutions nearest to joint vectors, and whether there is one, inside the limits."""
    parameter = settings.solver.parameter
    assert parameter is not None  # only such arms have values to move
    solutions = solve(settings.solver, refined.T, redundancy=parameter.wrapped(value))
    steps = settings.joints.step(near[:, None], solutions.q)
    apart = np.where(solutions.valid, np.abs(steps).max(axis=2), np.inf)
    column = np.argmin(apart, axis=1)
    rows = np.arange(len(near))
    found = near + steps[rows, column]
    good = apart[rows, column] < NEAR
    if inside:
        low, high = settings.solver.limits.T
        good &= ((found >= low) & (found <= high)).all(axis=1)
    return found, good


def _inside(settings: CheckedSettings, value: Array) -> Array:
    parameter = settings.solver.parameter
    assert parameter is not None  # see above
    return value if parameter.round else np.clip(value, *parameter.range)
