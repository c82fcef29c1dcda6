"""A second method for all solutions of a six-joint arm; it shares only forward kinematics with the solvers.

Elimination after Raghavan and Roth ("Inverse kinematics of the general 6R manipulator and related linkages", ASME
Journal of Mechanical Design 115(3), 1993), its equations fitted to sampled angles instead of written out, set up at
three places of the loop; and Newton's method from random starts, which needs no structure. Both only propose joint
vectors; each is then polished on the arm as written.
"""

import math
from contextlib import suppress

import numpy as np
from numpy.typing import NDArray

from urdf_ik.kinematics.chain import Chain
from urdf_ik.support.angles import largest_apart, shortest
from urdf_ik.support.tolerances import DEFAULT
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


STARTS = 200
_CUTS = (1, 3, 5)
# Solutions nearer to each other than this [rad] are one, or may be a double root.
_SAME, _BESIDE = 1e-6, 1e-3
# A root's half tangent counts as real up to this imaginary part, relative to 1 + its square; the polish decides.
_REAL = 0.05
# (1, cos, sin) at three angles that are a third of a turn apart fix a trigonometric polynomial of degree one.
_THIRDS = 2.0 * np.pi / 3.0 * np.arange(3)
_FIT = np.linalg.inv(np.stack([np.ones(3), np.cos(_THIRDS), np.sin(_THIRDS)], axis=1))
# (1, cos, sin) times 1 + x^2 by powers of the half tangent x.
_HALF = np.array([[1.0, 0.0, 1.0], [1.0, 0.0, -1.0], [0.0, 2.0, 0.0]])


NAME = f"the elimination of Raghavan and Roth, and Newton's method from {STARTS} random starts"


def solutions(chain: Chain, T: Array, rng: np.random.Generator) -> Array:
    """Solutions (k, 6) [rad] of one pose (4, 4), verified on the arm as written."""
    starts = rng.uniform(-math.pi, math.pi, (STARTS, 6))
    tried = np.concatenate([*(_eliminated(chain, T, cut, rng) for cut in _CUTS), starts])
    q, error = descend(chain, T, tried)
    kept: list[Array] = []
    for candidate in q[error <= CONVERGED]:
        if _is_new(chain, T, candidate, np.array(kept).reshape(-1, 6)):
            kept.append(candidate)
    return np.array(kept).reshape(-1, 6)


def _is_new(chain: Chain, T: Array, q: Array, others: Array) -> bool:
    """Whether q (6,) is neither among the others (k, 6) nor a double root with one of them."""
    far = largest_apart(others, q)
    if (far <= _SAME).any():
        return False
    near = others[far < _BESIDE]
    return not (errors(chain, T, q + 0.5 * shortest(near - q))[1] <= DEFAULT.fold).any()


def _eliminated(chain: Chain, T: Array, cut: int, rng: np.random.Generator) -> Array:
    """Candidates (k, 6) for the pose T (4, 4), with the loop of joints opened before joint ``cut``, counted from 0."""
    home = np.eye(4)
    home[:3, :3], home[:3, 3] = chain.R_tip, chain.P.sum(axis=0)
    # E1 ... E6 = G; where the loop starts later, the joints before are moved behind by the inverse of G.
    G = T @ np.linalg.inv(home)
    back = np.linalg.inv(G)
    h, a = chain.H.copy(), chain.points / chain.size
    G[:3, 3] /= chain.size
    back[:3, 3] /= chain.size
    h[:cut], a[:cut] = h[:cut] @ back[:3, :3].T, a[:cut] @ back[:3, :3].T + back[:3, 3]
    order = np.roll(np.arange(6), -cut)
    found = np.empty((0, 6))
    with suppress(np.linalg.LinAlgError):  # where the elimination degenerates at this cut of this arm
        found = _roots(h[order], a[order], G, rng.uniform(-np.pi, np.pi, 3))
    q = np.empty_like(found)
    q[:, order] = found
    return q[np.isfinite(q).all(axis=1)]


def _roots(h: Array, a: Array, G: Array, shifts: Array) -> Array:
    """Candidates (k, 6) of E1 ... E6 = G for axes along h (6, 3) through a (6, 3).

    The sixth joint leaves its own axis where it is, so E3 E4 E5 (axis 6) = E2^-1 E1^-1 G (axis 6): fourteen equations
    (see ``_equations``), whose right side has eight terms in joints 1 and 2. The six combinations of them without these
    are, times the half tangent x4 too, twelve equations for twelve products of powers of x4 and x5, and their matrix is
    quadratic in x3. Half tangents are taken from ``shifts``, of joints 3 to 5.
    """
    o = a[2]
    left = np.stack(np.meshgrid(_THIRDS, _THIRDS, _THIRDS, indexing="ij"), axis=-1).reshape(-1, 3)
    right = np.stack(np.meshgrid(_THIRDS, _THIRDS, indexing="ij"), axis=-1).reshape(-1, 2)
    p, d = _moved(h[2:5], a[2:5], left, a[5], h[5])
    L = np.einsum("ai,bj,ck,ijke->abce", _FIT, _FIT, _FIT, _equations(p - o, d).reshape(3, 3, 3, 14))
    p, d = _moved(h[1::-1], a[1::-1], -right[:, ::-1], G[:3, :3] @ a[5] + G[:3, 3], G[:3, :3] @ h[5])
    R = np.einsum("ai,bj,ije->abe", _FIT, _FIT, _equations(p - o, d).reshape(3, 3, 14)).reshape(9, 14)
    L[0, 0, 0] -= R[0]
    without = np.linalg.svd(R[1:])[2][8:]
    turned = [_HALF.T @ _turned(shift).T for shift in shifts[1:]]
    D = np.einsum("abce,ke,jb,lc->akjl", L, without, *turned)
    M = np.zeros((3, 2, 6, 4, 3))
    M[:, 0, :, :3], M[:, 1, :, 1:] = D, D
    M = np.einsum("ab,akjl->bkjl", _turned(shifts[0]), M.reshape(3, 12, 4, 3)).reshape(3, 12, 12)
    # (1 + x^2) (M0 + M1 cos + M2 sin) = (M0 - M1) x^2 + 2 M2 x + M0 + M1.
    step = np.linalg.solve(M[0] - M[1], np.concatenate([M[0] + M[1], 2.0 * M[2]], axis=1))
    x, V = np.linalg.eig(np.block([[np.zeros((12, 12)), np.eye(12)], [-step]]))
    real = np.abs(x.imag) < _REAL * (1.0 + np.abs(x) ** 2)
    x, W = x[real].real, V[:12, real].T.reshape(-1, 4, 3)
    q = np.empty((len(x), 6))
    q[:, 2] = 2.0 * np.arctan(x) + shifts[0]
    # Powers of x4 go along the first direction, of x5 along the second; each ratio where its numbers are large.
    q[:, 3] = 2.0 * np.arctan(_ratio(W[:, :3].reshape(-1, 9), W[:, 1:].reshape(-1, 9))) + shifts[1]
    q[:, 4] = 2.0 * np.arctan(_ratio(W[:, :, :2].reshape(-1, 8), W[:, :, 1:].reshape(-1, 8))) + shifts[2]
    # The angles 3 to 5 give the eight terms of the right side, and these the first two.
    p, d = _moved(h[2:5], a[2:5], q[:, 2:5], a[5], h[5])
    terms = (_equations(p - o, d) - R[0]) @ np.linalg.pinv(R[1:])
    q[:, 0], q[:, 1] = np.arctan2(terms[:, 5], terms[:, 2]), np.arctan2(terms[:, 1], terms[:, 0])
    # The last: how far a direction across its axis is turned.
    across = np.cross(h[5], np.eye(3)[np.argmin(np.abs(h[5]))])
    goal = np.tile(G[:3, :3] @ across, (len(q), 1))
    for k in range(5):
        goal = _rotated(h[k], -q[:, k], goal)
    q[:, 5] = np.arctan2(np.cross(across, goal) @ h[5], goal @ across)
    return shortest(q)


def _equations(p: Array, d: Array) -> Array:
    """(m, 14) of points p and directions d (m, 3): p, d, p.p, p.d, p x d, (p.p) d - 2 (p.d) p."""
    pp, pd = (np.einsum("ij,ij->i", p, other)[:, None] for other in (p, d))
    return np.concatenate([p, d, pp, pd, np.cross(p, d), pp * d - 2.0 * pd * p], axis=1)


def _moved(h: Array, a: Array, q: Array, point: Array, direction: Array) -> tuple[Array, Array]:
    """Where joints (n) at angles q (m, n), the last first, move a point and a direction (3,): (m, 3) each."""
    p, d = np.tile(point, (len(q), 1)), np.tile(direction, (len(q), 1))
    for k in reversed(range(len(h))):
        p, d = a[k] + _rotated(h[k], q[:, k], p - a[k]), _rotated(h[k], q[:, k], d)
    return p, d


def _rotated(h: Array, q: Array, v: Array) -> Array:
    """Vectors v (m, 3) turned by q (m,) about unit h (3,)."""
    along = (v @ h)[:, None] * h
    return along + np.cos(q)[:, None] * (v - along) + np.sin(q)[:, None] * np.cross(h, v)


def _turned(shift: float) -> Array:
    """(3, 3): (1, cos, sin) of an angle plus ``shift`` from those of the angle, column by column to the latter's."""
    c, s = math.cos(shift), math.sin(shift)
    return np.array([[1.0, 0.0, 0.0], [0.0, c, -s], [0.0, s, c]])


def _ratio(low: NDArray[np.complex128], high: NDArray[np.complex128]) -> Array:
    """Of each row, high / low in the sense of least squares; real."""
    square = (np.abs(low) ** 2).sum(axis=1)
    with np.errstate(divide="ignore", invalid="ignore"):
        ratio: Array = (low.conj() * high).sum(axis=1).real / square
    return ratio
