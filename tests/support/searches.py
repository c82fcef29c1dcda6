"""Searches that know no family: Newton's method from many starts, and where the Jacobian's determinant changes sign."""

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def newton(
    fk: Callable[[Array], Array],
    jacobian: Callable[[Array], Array],
    size: float,
    T: Array,
    Q: Array,
    least: float = 1e-4,
) -> Array:
    """Regular joint vectors (k, n) that damped least squares leads to from starts (m, n), and that reach the pose."""
    for _ in range(60):
        M, J = np.array(fk(Q)), np.array(jacobian(Q))
        turn = T[:3, :3] @ np.swapaxes(M[:, :3, :3], 1, 2)
        skew = [turn[:, 2, 1] - turn[:, 1, 2], turn[:, 0, 2] - turn[:, 2, 0], turn[:, 1, 0] - turn[:, 0, 1]]
        e = np.concatenate([(T[:3, 3] - M[:, :3, 3]) / size, 0.5 * np.stack(skew, axis=1)], axis=1)
        J[:, :3] /= size
        off, back = np.abs(e).max(axis=1), np.swapaxes(J, 1, 2)
        damping = np.minimum(1e-2 * off, 1e-2) ** 2 + 1e-15
        step = np.linalg.solve(back @ J + damping[:, None, None] * np.eye(Q.shape[1]), back @ e[:, :, None])[:, :, 0]
        Q = Q + np.minimum(1.0, 0.5 / (np.abs(step).max(axis=1) + 1e-300))[:, None] * step
    regular = np.linalg.svd(J, compute_uv=False)[:, -1] > least
    return Q[(off < 1e-11) & (np.trace(turn, axis1=1, axis2=2) > 1.0) & regular]


def folds(arm: Any, count: int, rng: np.random.Generator) -> Array:
    """Joint vectors (count, n) at which the Jacobian's determinant changes sign, on lines between random ones."""
    out: list[Array] = []
    while len(out) < count:
        line = np.linspace(*rng.uniform(-np.pi, np.pi, (2, arm.dof)), 121)
        signs = np.sign(np.linalg.det(arm.jacobian(line)))
        for k in np.flatnonzero(signs[:-1] * signs[1:] < 0)[:1]:
            low, high = line[k], line[k + 1]
            for _ in range(60):
                middle = 0.5 * (low + high)
                same = np.sign(np.linalg.det(arm.jacobian(middle))) == signs[k]
                low, high = (middle, high) if same else (low, middle)
            out.append(low)
    return np.array(out)
