"""Newton's method on a chain, for many joint vectors at a time; the second method polishes its solutions with it.

It shares only the chain's forward kinematics with the solvers, so a fault of a solver is not repeated here.
"""

from __future__ import annotations

import numpy as np

from urdf_ik.kinematics.chain import Chain
from urdf_ik.support.angles import shortest
from urdf_ik.typing import Array

CONVERGED = 2e-14
"""Error [rad, share of the arm's size] that a regular solution has after Newton's method, with room to spare."""

FINISHED = 1.8e-15
"""Error below which a further step only stirs rounding."""

_HALF_TURN = 2.0  # the error of a rotation by more than 90 degrees, whose skew part may vanish
_LEAST_DAMPING = 1e-12
_STRONG = 1e-4  # damping from which the normal equations keep enough digits


def errors(chain: Chain, T: Array, Q: Array) -> tuple[Array, Array]:
    """Twists (m, 6) from the poses of Q (m, n) to T (4, 4), lengths as shares of the size; their greatest entries (m,).

    The rotation's part is the vector of the skew part of T R^T, exact to second order.
    """
    P = chain.fk(Q)
    E = T[:3, :3] @ P[:, :3, :3].swapaxes(1, 2)
    skew = 0.5 * (E - E.swapaxes(1, 2))
    e = np.concatenate([(T[:3, 3] - P[:, :3, 3]) / chain.size, skew[:, [2, 0, 1], [1, 2, 0]]], axis=1)
    far = np.trace(E, axis1=1, axis2=2) <= 1.0
    return e, np.where(far, _HALF_TURN, np.abs(e).max(axis=1))


def descend(
    chain: Chain, T: Array, Q: Array, rounds: int = 40, enough: float = FINISHED, patience: int = 60
) -> tuple[Array, Array]:
    """Joint vectors (m, n) [rad] nearer to the pose T (4, 4) than Q, and the errors (m,) that they leave.

    The damping falls with the error, so that convergence is quadratic at regular solutions and steps stay bounded at
    singular ones. Each goes on until its error is ``enough``, grows by half again where it was small, or has not lost
    a third in ``patience`` rounds; the best that it met is returned.
    """
    best, least = Q.copy(), np.full(len(Q), np.inf)
    q, at = Q.copy(), np.arange(len(Q))
    mark, since = least.copy(), np.zeros(len(Q), np.intp)
    for k in range(rounds + 1):
        e, error = errors(chain, T, q)
        better = error < least[at]
        stirred = ~better & (k > 3) & (error > 0.5 * least[at]) & (least[at] < CONVERGED)
        best[at[better]], least[at[better]] = q[better], error[better]
        gained = error < 0.7 * mark[at]
        since[at] += 1
        mark[at[gained]], since[at[gained]] = error[gained], 0
        on = ~stirred & (error >= enough) & (since[at] <= patience)
        if k == rounds or not on.any():
            break
        q, at = q[on], at[on]
        J = chain.jacobian(q)
        J[:, :3] /= chain.size
        step = _damped(J, e[on], np.minimum(1e-2 * error[on], 1e-2) + _LEAST_DAMPING)
        step *= np.minimum(1.0, 0.5 / (np.abs(step).max(axis=1, keepdims=True) + 1e-300))
        q = shortest(q + step)
    return best, least


def _damped(J: Array, e: Array, damping: Array) -> Array:
    """Least-squares solutions (m, n) of [J; damping 1] step = [e; 0]."""
    step = np.empty_like(e)
    strong = damping > _STRONG
    if strong.any():
        Js, back = J[strong], J[strong].swapaxes(1, 2)
        normal = back @ Js + (damping[strong] ** 2)[:, None, None] * np.eye(J.shape[2])
        step[strong] = np.linalg.solve(normal, back @ e[strong, :, None])[..., 0]
    if not strong.all():
        weak = ~strong
        U, s, V = np.linalg.svd(J[weak])
        along = (e[weak, None, :] @ U)[:, 0] * s / (s**2 + damping[weak, None] ** 2)
        step[weak] = (along[:, None, :] @ V)[:, 0]
    return step
