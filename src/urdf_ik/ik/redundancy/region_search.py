"""The nearest joint vector in a target region, or over several redundancy parameters: a local search from many starts.

The region, and the redundancy parameters of the arm, are sampled; every branch of every sample that is inside the joint
limits is a start, the nearest ones first and no two alike. From each, sequential quadratic programming (Kraft's SLSQP,
1988, in SciPy) moves the joints to where the squared distance from the reference is least, the tip staying in the
region and the joints inside their limits. What is found is solved anew, so that it is as exact as any solution. The
optimum is local: the best of those that the starts lead to. A region is only called empty where no start leads into it.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from urdf_ik.errors import ArgumentError
from urdf_ik.ik.pose_solving import solve
from urdf_ik.ik.redundancy.interval_search import span
from urdf_ik.ik.redundancy.region import Region
from urdf_ik.ik.redundancy.values import nearest_values
from urdf_ik.ik.solutions import IKSolutions, distances, limits
from urdf_ik.ik.solver import Solver
from urdf_ik.model.poses import as_pose_array
from urdf_ik.support import inputs
from urdf_ik.support.text import quoted
from urdf_ik.typing import Array

SAMPLES = 64
"""Samples along one direction; twice as many with every direction more, up to ``MOST_SAMPLES``."""
MOST_SAMPLES = 1024
STARTS = 10
"""Starts of the search, at most."""
APART = 0.2
"""rad or m: starts that differ by less in every joint are one."""
INSIDE = 1e-8
"""rad or m that the search keeps from the joint limits, so that rounding does not lead beyond them."""


def nearest(
    solver: Solver,
    T: Any,
    q_ref: ArrayLike,
    region: Region | None,
    *,
    metric: str,
    weights: ArrayLike | None,
    within: ArrayLike | None,
    within_limits: bool,
    threads: inputs.Threads,
) -> IKSolutions:
    """See :meth:`urdf_ik.Arm.ik_nearest`.

    Raises:
        ArgumentError: another metric than 'l2'.
        ArgumentError: ``q_ref`` does not fit.
    """
    if inputs.choice(metric, "metric", distances.METRICS) != "l2":
        what = "a region" if region is not None else "several redundancy parameters"
        raise ArgumentError(f"metric={quoted(metric)} given; with {what} the distance is metric='l2'")
    measure = distances.measure(solver, metric, weights, within)
    within_limits, threads = inputs.flag(within_limits, "within_limits"), inputs.threads(threads)
    target = as_pose_array(T)
    shape = target.shape[:-2]
    reference = solver.chain.check(q_ref)
    try:
        reference = np.broadcast_to(reference, (*shape, solver.dof))
    except ValueError:
        raise ArgumentError(
            f"q_ref of shape {reference.shape} and poses of shape {shape} given: one joint vector, or one a pose"
        ) from None
    bounds = solver.limits if within_limits else np.tile([-np.inf, np.inf], (solver.dof, 1))
    free = solver.free_axis
    if region is not None:
        inputs.kind(region, "sampled", "region", "a urdf_ik.Region")
    sought = region or Region()
    if free is not None:
        sought = Region(rotation=np.pi, axis=free)
    stack, near = target.reshape(-1, 4, 4).copy(), reference.reshape(-1, solver.dof)
    values = np.tile([parameter.default for parameter in solver.parameters], (len(stack), 1))
    for k, (pose, q) in enumerate(zip(stack, near, strict=True)):
        found = _nearest(solver.fixed, pose, q, sought, bounds, measure.factors, threads)
        if found is not None:
            stack[k] = pose if region is None else sought.clipped(pose, solver.chain.fk(found))
            values[k] = nearest_values(solver, found[None], stack[k][None])[0] if solver.parameters else []
    count = len(solver.parameters)
    at = values.reshape(shape if count == 1 else (*shape, count)) if count else None
    solutions = solve(solver, stack.reshape(*shape, 4, 4), redundancy=at, threads=threads)
    chosen: IKSolutions = solutions.nearest(reference, weights, metric="l2", within=within, within_limits=within_limits)
    return chosen


def _nearest(
    solver: Solver, T: Array, q_ref: Array, region: Region, bounds: Array, factors: Array, threads: int
) -> Array | None:
    """The joint vector (n,) in a region around a pose (4, 4) that is nearest to ``q_ref``; None where none is found."""
    from scipy.optimize import minimize

    low, high = bounds[:, 0] + INSIDE, bounds[:, 1] - INSIDE
    tight = low > high
    low, high = np.where(tight, bounds[:, 0], low), np.where(tight, bounds[:, 1], high)
    scale = np.sqrt(np.maximum(factors, 1e-6))
    conditions = _Conditions(solver, T, region)
    best: Array | None = None
    least = np.inf
    for start in _starts(solver, T, q_ref, region, bounds, scale, threads):
        answer = minimize(
            lambda q: 0.5 * float(((q - q_ref) * scale) @ ((q - q_ref) * scale)),
            start.clip(low, high),
            jac=lambda q: (q - q_ref) * scale**2,
            method="SLSQP",
            bounds=list(zip(low, high, strict=True)),
            constraints=conditions.for_scipy(),
            options={"maxiter": 100, "ftol": 1e-11},
        )
        q = answer.x
        if answer.fun < least * (1.0 - 1e-9) and region.contains(T, solver.chain.fk(q), 1e-7):
            best, least = q, float(answer.fun)
    return best


def _starts(solver: Solver, T: Array, q_ref: Array, region: Region, bounds: Array, scale: Array, threads: int) -> Array:
    """(k, n) joint vectors from which to search: of all branches of all samples, the nearest, no two alike."""
    spread = region.widths > 0.0
    parameters = solver.parameters
    wide = int(spread.sum()) + len(parameters)
    count = 1 if not wide else min(SAMPLES << (wide - 1), MOST_SAMPLES)
    shares = np.full((count, 6 + len(parameters)), 0.5)
    shares[:, np.flatnonzero(np.append(spread, [True] * len(parameters)))] = _spread(count, wide)
    shares[:, 3] = np.where(spread[3], shares[:, 3], 0.0)
    poses = region.sampled(T, shares[:, :6])
    poses[0] = T
    values: Any = None
    if parameters:
        ends = np.array([span(solver, parameter, poses) for parameter in parameters])
        grid = ends[:, 0] + shares[:, 6:] * (ends[:, 1] - ends[:, 0])
        values = grid if len(parameters) > 1 else grid[:, 0]
    solutions = solve(solver, poses, redundancy=values, threads=threads)
    q = solutions.q[solutions.valid]
    turning = ~solver.chain.prismatic
    image, inside = limits.image_near(q, q_ref, bounds, turning)
    if not inside.any():
        _, out = limits.excess(q, bounds, turning)
        order = np.argsort(np.abs(out).max(axis=-1), kind="stable")[: 16 * STARTS]
        candidates = q[order].clip(bounds[:, 0], bounds[:, 1])
    else:
        image = image[inside]
        candidates = image[np.argsort((((image - q_ref) * scale) ** 2).sum(axis=-1), kind="stable")]
    chosen: list[Array] = []
    for each in candidates:
        if all(np.abs(each - other).max() > APART for other in chosen):
            chosen.append(each)
            if len(chosen) == STARTS:
                break
    return np.array(chosen).reshape(-1, solver.dof)


def _spread(count: int, wide: int) -> Array:
    """(count, wide) shares of a unit cube, evenly spread: multiples of powers of a root of x^(wide + 1) = x + 1."""
    if not wide:
        return np.empty((count, 0))
    root = 2.0
    for _ in range(60):
        root = (1.0 + root) ** (1.0 / (wide + 1))
    steps = root ** -np.arange(1.0, wide + 1.0)
    return np.asarray((0.5 + np.arange(count)[:, None] * steps) % 1.0)


class _Conditions:
    """What keeps the tip in a region, as functions of the joint vector and their derivatives."""

    def __init__(self, solver: Solver, T: Array, region: Region) -> None:
        self._arm, self._T, self._region = solver, T, region
        self._a = np.array(region.axis.direction)
        self._across = region.across
        low, high = np.array(region.box).T
        self._low, self._high = low, high
        self._exact = low == high
        self._last: tuple[bytes, tuple[Array, Array, Array, Array]] | None = None

    def for_scipy(self) -> list[dict[str, Any]]:
        """Equations and inequalities."""
        out: list[dict[str, Any]] = []
        for kind, parts in (("eq", (0, 1)), ("ineq", (2, 3))):
            value: Callable[[Array], Array] = lambda q, k=parts[0]: self._at(q)[k]  # type: ignore[misc] # noqa: E731
            slope: Callable[[Array], Array] = lambda q, k=parts[1]: self._at(q)[k]  # type: ignore[misc] # noqa: E731
            if len(value(np.zeros(self._arm.dof))):
                out.append({"type": kind, "fun": value, "jac": slope})
        return out

    def _at(self, q: Array) -> tuple[Array, Array, Array, Array]:
        """Equations (e,), their derivatives (e, n), inequalities (i,), theirs."""
        key = q.tobytes()
        if self._last is None or self._last[0] != key:
            self._last = key, self._computed(q)
        return self._last[1]

    def _computed(self, q: Array) -> tuple[Array, Array, Array, Array]:
        solver, region, a = self._arm, self._region, self._a
        reached, J = solver.chain.fk(q), solver.chain.jacobian(q)
        back = self._T[:3, :3].T
        place, d, turn = region.measured(self._T, reached)
        angular = back @ J[3:]
        lever = back @ reached[:3, :3] @ np.array(region.axis.at)
        linear = back @ J[:3] + np.cross(angular, lever[:, None], axis=0)
        tilting = np.cross(angular, d[:, None], axis=0)
        equal = [place[self._exact] - self._low[self._exact]]
        equal_slope = [linear[self._exact]]
        wide = ~self._exact
        less = [place[wide] - self._low[wide], self._high[wide] - place[wide]]
        less_slope = [linear[wide], -linear[wide]]
        if region.cone == 0.0:
            equal.append(self._across @ d)
            equal_slope.append(self._across @ tilting)
        else:
            unit = 1.0 - np.cos(region.cone)
            less.append(np.array([(a @ d - np.cos(region.cone)) / unit]))
            less_slope.append((a @ tilting / unit)[None])
        if region.rotation < np.pi:
            slope = self._turning(back @ reached[:3, :3], angular)
            if region.rotation == 0.0:
                equal.append(np.array([turn]))
                equal_slope.append(slope[None])
            else:
                less.append(np.array([region.rotation - turn, region.rotation + turn]))
                less_slope.append(np.stack([-slope, slope]))
        return tuple(np.concatenate(part) for part in (equal, equal_slope, less, less_slope))  # type: ignore[return-value]

    def _turning(self, R: Array, angular: Array) -> Array:
        """(n,) derivative of the rotation about the axis, from angular velocities (3, n) in the target's frame."""
        a = self._a
        cross = np.array([[0.0, -a[2], a[1]], [a[2], 0.0, -a[0]], [-a[1], a[0], 0.0]])
        rest = np.eye(3) - np.outer(a, a)
        sine, cosine = -np.trace(cross @ R), np.trace(rest @ R)
        turned = np.cross(np.eye(3)[:, :, None], R[None], axisa=1, axisb=1, axisc=1)  # e_i x each column of R
        along = (cosine * -np.einsum("ij,kji->k", cross, turned) - sine * np.einsum("ij,kji->k", rest, turned)) / (
            sine * sine + cosine * cosine
        )
        return np.asarray(along @ angular)
