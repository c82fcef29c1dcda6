"""The poses that would tell most if they were measured next."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from urdf_ik.calibration.measurements import Measurements
from urdf_ik.calibration.report import Calibration
from urdf_ik.errors import ArgumentError
from urdf_ik.support import inputs
from urdf_ik.typing import Array

_CANDIDATES = 500
_NO_LIMIT = np.pi  # rad: an angle without limits is drawn from one turn


@dataclass(frozen=True, eq=False)
class BestPoses:
    """Joint vectors to measure next.

    Attributes:
        q: (k, n) rad or m, the most useful one first.
        gains: (k,) by how much each raises the logarithm of the information's determinant, the earlier ones measured.
        unchecked: why contacts were not checked; '' where they were, or where the candidates were given.
    """

    q: Array
    gains: Array
    unchecked: str


def best_poses(
    calibration: Calibration, count: int = 10, candidates: ArrayLike | None = None, *, seed: int = 0
) -> BestPoses:
    """The joint vectors whose measurement would determine the fitted numbers best, in the sense of D-optimality.

    Each is the one that raises the determinant of the information matrix most when the earlier ones are measured
    (Fedorov, Theory of Optimal Experiments, 1972), along the directions that can be told apart.

    Args:
        calibration: the fit so far.
        count: how many.
        candidates: (m, n) rad or m to choose from; default: 500 drawn within the limits, free of contact where the
            arm's shapes can be read.
        seed: of the drawing.

    Raises:
        ArgumentError: candidates do not fit, or are fewer than asked for.

    Example:
        >>> import numpy as np
        >>> import urdf_ik
        >>> arm = urdf_ik.load("zyyzyz_6r")
        >>> q = np.random.default_rng(0).uniform(-0.3, 0.3, (20, 6))
        >>> found = best_poses(urdf_ik.calibrate(arm, q, arm.fk(q)), 3)
        >>> found.q.shape, bool((np.diff(found.gains) <= 1e-9).all())
        ((3, 6), True)
    """
    inputs.kind(calibration, "equations", "calibration", "the result of urdf_ik.calibrate")
    wanted = inputs.whole(count, "count", low=1, high=10_000)
    arm, given = calibration.arm, calibration.given
    unchecked = ""
    if candidates is None:
        q, unchecked = _drawn(calibration, max(_CANDIDATES, 2 * wanted), np.random.default_rng(seed))
    else:
        q = arm.chain.check(candidates)
    if q.ndim != 2 or len(q) < wanted:
        raise ArgumentError(f"candidates of shape {q.shape} given; at least {wanted} joint vectors are needed")
    eq, x = calibration.equations, calibration.x
    noise = np.repeat(calibration.noise, [3, 3] if given.kind == "pose" else [given.numbers])
    told = _basis(calibration.covariance)
    poses = eq.chain.fk(q, eq.values(x))
    values = {"pose": poses, "position": poses[:, :3, 3], "distance": np.zeros(len(q))}.get(
        given.kind, np.zeros((len(q), 0))
    )
    G = (eq.derivatives(x, Measurements(given.kind, q, values)) / noise[:, None]) @ told
    P = told.T @ calibration.covariance @ told
    chosen: list[int] = []
    gains: list[float] = []
    for _ in range(wanted):
        S = np.eye(given.numbers) + G @ P @ np.swapaxes(G, 1, 2)
        gain = np.linalg.slogdet(S)[1]
        gain[chosen] = -np.inf
        best = int(np.argmax(gain))
        chosen.append(best)
        gains.append(float(gain[best]))
        K = P @ G[best].T
        P = P - K @ np.linalg.solve(S[best], K.T)
    return BestPoses(q[chosen], np.array(gains), unchecked)


def _basis(covariance: Array) -> Array:
    """The directions (k, r) along which a covariance is not zero."""
    values, vectors = np.linalg.eigh(covariance)
    return np.asarray(vectors[:, values > 1e-14 * values.max(initial=0.0)])


def _drawn(calibration: Calibration, count: int, rng: np.random.Generator) -> tuple[Array, str]:
    """Joint vectors within the limits, free of contact where that can be checked."""
    arm = calibration.arm
    low, high = (
        np.where(np.isfinite(side), side, sign * _NO_LIMIT) for sign, side in zip((-1, 1), arm.limits.T, strict=True)
    )
    q = rng.uniform(low, high, (count, arm.dof))
    bodies = arm.cell.in_world(None)
    if bodies.unchecked or not bodies.has_geometry:
        return q, bodies.unchecked or "the URDF has no collision shapes"
    free = ~np.asarray(bodies.in_collision(q), dtype=np.bool_)
    return q[free], ""
