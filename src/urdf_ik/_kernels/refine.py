"""Verify joint vectors on the arm as written, polish them there, and collect the different ones."""

from __future__ import annotations

import math

import numpy as np

from urdf_ik._kernels import layout
from urdf_ik._kernels.compile import kernel
from urdf_ik._kernels.newton import newton
from urdf_ik._kernels.screws import jacobian_from_axes, place_axes
from urdf_ik._kernels.thresholds import (
    CONVERGED,
    DOUBTFUL,
    FINISHED,
    HELD,
    LEAST_DAMPING,
    LONG_PATIENCE,
    NEARLY,
)
from urdf_ik._kernels.trig import wrap

STARTS = 13


@kernel
def pose_error(target, T, scale, e):
    """Twist from ``T`` to ``target``, linear part times ``scale``, to ``e`` (6,); returns its greatest entry.

    The rotation's part is the vector of the skew part of target T^T, exact to second order.
    """
    for i in range(3):
        e[i] = (target[i, 3] - T[i, 3]) * scale
    E = np.empty((3, 3))
    for i in range(3):
        for j in range(3):
            E[i, j] = target[i, 0] * T[j, 0] + target[i, 1] * T[j, 1] + target[i, 2] * T[j, 2]
    e[3] = 0.5 * (E[2, 1] - E[1, 2])
    e[4] = 0.5 * (E[0, 2] - E[2, 0])
    e[5] = 0.5 * (E[1, 0] - E[0, 1])
    worst = 0.0
    for i in range(6):
        worst = max(worst, abs(e[i]))
    # The skew part vanishes at half a turn too.
    return worst if E[0, 0] + E[1, 1] + E[2, 2] > 1.0 else 2.0


@kernel
def damped_step(J, e, damping, step):
    """Least-squares solution of [J; damping I] step = [e; 0] for J (6, n), by Householder reflections."""
    n = J.shape[1]
    M = np.zeros((6 + n, n + 1))
    for i in range(6):
        for j in range(n):
            M[i, j] = J[i, j]
        M[i, n] = e[i]
    for j in range(n):
        M[6 + j, j] = damping
    for k in range(n):
        norm = 0.0
        for i in range(k, 7 + k):
            norm += M[i, k] * M[i, k]
        norm = math.sqrt(norm)
        head = M[k, k]
        alpha = -norm if head > 0.0 else norm
        if alpha == 0.0:
            continue
        first = head - alpha
        w = 2.0 / (norm * norm - head * head + first * first)
        for j in range(k + 1, n + 1):
            dot = first * M[k, j]
            for i in range(k + 1, 7 + k):
                dot += M[i, k] * M[i, j]
            dot *= w
            M[k, j] -= dot * first
            for i in range(k + 1, 7 + k):
                M[i, j] -= dot * M[i, k]
        M[k, k] = alpha
    for k in range(n - 1, -1, -1):
        s = M[k, n]
        for j in range(k + 1, n):
            s -= M[k, j] * step[j]
        step[k] = s / M[k, k] if M[k, k] != 0.0 else 0.0


@kernel
def place(arm, prismatic, q, T, axes, points):
    """``place_axes`` of the arm as written."""
    H = arm[layout.H : layout.H + 18].reshape(6, 3)
    P = arm[layout.P : layout.P + 21].reshape(7, 3)
    R_tip = arm[layout.R_TIP : layout.R_TIP + 9].reshape(3, 3)
    place_axes(H, P, R_tip, prismatic, q, T, axes, points)


@kernel
def refine(arm, target, q, rounds, enough, patience):
    """Newton's method, damped, on the arm as written; ``q`` (6,) is replaced by the best vector met.

    It stops below ``enough``, or after ``patience`` rounds without the gain of a third, and returns the error left
    (see ``pose_error``). The damping falls with the error, so that convergence is quadratic at regular solutions and
    steps stay bounded at singular ones.
    """
    return _descend(arm, target, q, rounds, enough, patience, LEAST_DAMPING)


@kernel
def refine_held(arm, target, q):
    """``refine`` for the flat bottom of a double root, with the direction held in which the arm is singular.

    There rounding alone carries the arm along it further than the rest can follow. Returns the error left.
    """
    return _descend(arm, target, q, 8, FINISHED, LONG_PATIENCE, HELD)


@kernel
def _descend(arm, target, q, rounds, enough, patience, least_damping):
    """``refine`` with a given least damping."""
    scale = 1.0 / arm[layout.SIZE]
    prismatic = np.zeros(6, np.bool_)
    T, J = np.empty((4, 4)), np.empty((6, 6))
    axes, points, e, step = np.empty((6, 3)), np.empty((6, 3)), np.empty(6), np.empty(6)
    best = q.copy()
    least, mark, since = math.inf, math.inf, 0
    for k in range(rounds + 1):
        place(arm, prismatic, q, T, axes, points)
        error = pose_error(target, T, scale, e)
        if error < least:
            least = error
            best[:] = q
        elif k > 3 and error > 0.5 * least and least < CONVERGED:
            break
        since += 1
        if error < 0.7 * mark:
            mark, since = error, 0
        if error < enough or k == rounds or since > patience:
            break
        jacobian_from_axes(prismatic, axes, points, T[:3, 3], J)
        for j in range(6):
            for i in range(3):
                J[i, j] *= scale
        damped_step(J, e, min(1e-2 * error, 1e-2) + least_damping, step)
        longest = 0.0
        for j in range(6):
            longest = max(longest, abs(step[j]))
        shrink = min(1.0, 0.5 / (longest + 1e-300))
        for j in range(6):
            q[j] = wrap(q[j] + shrink * step[j])
    q[:] = best
    return least


@kernel
def holds(arm, target, q):
    """Whether Newton's method makes a solution of ``q`` (6,), a candidate whose margins say that there is none.

    That is for a margin below zero by what rounding may have done to it; ``q`` is replaced.
    """
    return refine(arm, target, q, 60, CONVERGED, LONG_PATIENCE) <= DOUBTFUL


@kernel
def least_stretch(J, x):
    """Smallest singular value of ``J`` (6, n) and its direction ``x`` (n,): inverse iteration on the QR factor."""
    rows, n = J.shape
    R = J.copy()
    for k in range(n):
        norm = 0.0
        for i in range(k, rows):
            norm += R[i, k] * R[i, k]
        norm = math.sqrt(norm)
        alpha = -norm if R[k, k] > 0.0 else norm
        first = R[k, k] - alpha
        square = norm * norm - R[k, k] * R[k, k] + first * first
        if square > 0.0:
            for j in range(k + 1, n):
                dot = first * R[k, j]
                for i in range(k + 1, rows):
                    dot += R[i, k] * R[i, j]
                dot *= 2.0 / square
                R[k, j] -= dot * first
                for i in range(k + 1, rows):
                    R[i, j] -= dot * R[i, k]
        R[k, k] = alpha
        if abs(alpha) < 1e-30:
            R[k, k] = 1e-30
    y = np.empty(n)
    x[:] = 1.0
    least = math.inf
    for _ in range(4):
        for i in range(n):
            rest = x[i]
            for j in range(i):
                rest -= R[j, i] * y[j]
            y[i] = rest / R[i, i]
        length = 0.0
        for i in range(n - 1, -1, -1):
            rest = y[i]
            for j in range(i + 1, n):
                rest -= R[i, j] * x[j]
            x[i] = rest / R[i, i]
        for i in range(n):
            length += x[i] * x[i]
        length = math.sqrt(length)
        for i in range(n):
            x[i] /= length
        least = 1.0 / math.sqrt(length)
    return least


@kernel
def singular_marks(arm, q, marks):
    """``marks`` if the Jacobian at ``q`` is singular (OTHER where they name no kind), else none."""
    axes, points, T, J = np.empty((6, 3)), np.empty((6, 3)), np.empty((4, 4)), np.empty((6, 6))
    prismatic = np.zeros(6, np.bool_)
    place(arm, prismatic, q, T, axes, points)
    jacobian_from_axes(prismatic, axes, points, T[:3, 3], J)
    for j in range(6):
        for i in range(3):
            J[i, j] /= arm[layout.SIZE]
    if least_stretch(J, q.copy()) > arm[layout.SINGULAR]:
        return 0
    return marks if marks else layout.OTHER


@kernel
def is_new(arm, target, Q, flags, q):
    """Whether ``q`` differs from every valid row of ``Q`` (B, n).

    Two vectors half way between which the arm is still in the pose, to rounding, are one double root.
    """
    middle, e = np.empty(q.size), np.empty(6)
    axes, points, T = np.empty((6, 3)), np.empty((6, 3)), np.empty((4, 4))
    prismatic = np.zeros(6, np.bool_)
    for b in range(Q.shape[0]):
        if flags[b] & layout.VALID:
            apart = 0.0
            for j in range(q.size):
                step = wrap(q[j] - Q[b, j])
                middle[j] = Q[b, j] + 0.5 * step
                apart = max(apart, abs(step))
            if apart <= arm[layout.DUPLICATE]:
                return False
            if apart < 1e-3:
                place(arm, prismatic, middle, T, axes, points)
                if pose_error(target, T, 1.0 / arm[layout.SIZE], e) <= arm[layout.FOLD]:
                    return False
    return True


@kernel
def keep(Q, flags, b, q, marks):
    """Store ``q`` in column ``b``, or the first free one if that is taken; a full table drops it."""
    if flags[b] & layout.VALID:
        for k in range(Q.shape[0]):
            if not flags[k] & layout.VALID:
                b = k
                break
        else:
            return
    for j in range(q.size):
        Q[b, j] = q[j]
    flags[b] = layout.VALID | marks


@kernel
def start_beside(q, k, start):
    """The k-th of ``STARTS`` fixed starting points around ``q``, to ``start``: itself, then 1e-2 to 1e-6 rad away."""
    seed = 12345 + 7919 * k
    width = 0.0 if k == 0 else 10.0 ** (-2.0 - 2.0 * (k % 3)) * (1.0 if k < 7 else 0.3)
    for j in range(q.size):
        seed = (seed * 1103515245 + 12345) % 2147483648
        start[j] = q[j] + width * (seed / 1073741824.0 - 1.0)


@kernel
def accept(arm, target, q, b, marks, near, beside, Q, flags):
    """Polish the candidate ``q`` of column ``b`` on the arm as written and keep it if it is verified and new.

    On an imperfect arm near a singularity (``near``) and where ``beside`` is set, the ideal candidate may stand for
    two solutions, or for none: starts beside it find both. Near a double root an error falls with the square of the
    distance, so only what has converged to rounding is a solution there; the best of the rest is kept where nothing
    has. Their offsets are fixed, so the same target always gives the same answer.
    """
    exact = arm[layout.IMPERFECTION] <= arm[layout.EXACT_STRUCTURE]
    # A closed form is not improved by a step along a singular direction that only rounding asks for.
    enough = CONVERGED if exact else FINISHED
    if exact or not near or not beside:
        start = q.copy()
        error = math.inf if exact else newton(arm, target, q, 8)
        if error > CONVERGED:
            q[:] = start
            error = refine(arm, target, q, 15 if exact else 60, enough, LONG_PATIENCE)
            if not exact and CONVERGED < error < NEARLY and not flags.any():
                error = refine_held(arm, target, q)
        if error <= (arm[layout.REACH] if exact else CONVERGED) and is_new(arm, target, Q, flags, q):
            keep(Q, flags, b, q, singular_marks(arm, q, marks) if near else 0)
        return
    start, best = q.copy(), q.copy()
    least, converged = math.inf, False
    for k in range(STARTS):
        start_beside(start, k, q)
        error = refine(arm, target, q, 40, FINISHED, LONG_PATIENCE)
        if error < least:
            least = error
            best[:] = q
        if error <= CONVERGED:
            converged = True
            if is_new(arm, target, Q, flags, q):
                keep(Q, flags, b, q, singular_marks(arm, q, marks))
    if not converged and least <= arm[layout.REACH] and is_new(arm, target, Q, flags, best):
        keep(Q, flags, b, best, singular_marks(arm, best, marks))
