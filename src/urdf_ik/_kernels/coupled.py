"""Arms whose joints drive several axes each, by bisection: every part of the joint space is excluded or solved.

In the scaled joints x (rad, or shares of the size for one that slides) the error of the tip is
f(x) = ((p - p_target) / size, (R - R_target) / sqrt 2), twelve numbers. In a box |x - c| <= w it is
f(c) + J (x - c) + r with |r| <= rho(w), since second derivatives of a product of exponentials are bounded by its links'
lengths and their rates of turning. The box holds no solution if even so f cannot vanish: not by its size, not across
the range of J, not where its least squares lead. It holds at most one, to which Newton's method leads from the middle,
if that step contracts (Neumaier, Interval Methods for Systems of Equations, 1990, chapter 5). What is left is halved.
At double roots and on continua boxes come to no end: the smallest are starting points.
"""

from __future__ import annotations

import math

import numpy as np

from urdf_ik._kernels import layout
from urdf_ik._kernels.compile import kernel
from urdf_ik._kernels.general_6r import sort_columns
from urdf_ik._kernels.refine import damped_step, keep, least_stretch, pose_error
from urdf_ik._kernels.screws import jacobian_from_axes, place_axes
from urdf_ik._kernels.target import check_target, project_rotation
from urdf_ik._kernels.thresholds import CONVERGED, FINISHED, NEAR_FOLD

# Behind an arm's common numbers: axes and joints; of each joint its unit (rad or m), the period of x (0: none), the
# middle and half the width of where it is looked for; then H, P, which axes slide, the gain of
# the axes by the joints, the greatest rates at which the joints turn what is behind each axis.
AXES, JOINTS, UNIT, PERIOD, MIDDLE, HALF, DATA = layout.FRAMES, 149, 150, 156, 162, 168, 174
# Boxes of one level at most; starts taken from them if they are more; the reach of the last ones [rad].
_ROOM, _STARTS, _SMALLEST = 60000, 400, 2e-4
# Two solutions beside a fold are two as long as their singular values are above this share of a singular one's; on a
# continuum they vanish.
_APART = 0.1
# Rounding of a squared error, and what makes up for a bound that only just holds.
_ROUNDING, _SLACK = 1e-13, 1.0 + 1e-9
_CONTRACTING = 0.25


@kernel
def _place(chain, x, T, axes, points):
    """``place_axes`` of the arm as written for scaled joints ``x`` (n,)."""
    H, P, R_tip, slides, gain, _ = chain
    full = np.zeros(gain.shape[0])
    for k in range(gain.shape[0]):
        for j in range(gain.shape[1]):
            full[k] += gain[k, j] * x[j]
    place_axes(H, P, R_tip, slides, full, T, axes, points)


@kernel
def _jacobian(chain, size, axes, points, T, J):
    """Jacobian (6, n) by scaled joints, lengths as shares of the size: the sum of the columns of what each drives."""
    slides, gain = chain[3], chain[4]
    m, n = gain.shape
    each = np.empty((6, m))
    jacobian_from_axes(slides, axes, points, T[:3, 3], each)
    J[:, :] = 0.0
    for k in range(m):
        for j in range(n):
            if gain[k, j] != 0.0:
                for i in range(6):
                    J[i, j] += gain[k, j] * each[i, k] / (size if i < 3 else 1.0)


@kernel
def _gap(arm, j, a, b):
    """Difference of two values of joint ``j``, the nearest one of its images."""
    gap, period = a - b, arm[PERIOD + j]
    return gap - period * np.round(gap / period) if period > 0.0 else gap


@kernel
def _polish(arm, chain, target, x, rounds):
    """Newton's method of least squares, damped; ``x`` (n,) is replaced by the best met. Returns its error."""
    n, m, size = x.size, chain[0].shape[0], arm[layout.SIZE]
    T, J, e, step = np.empty((4, 4)), np.empty((6, n)), np.empty(6), np.empty(n)
    axes, points, best = np.empty((m, 3)), np.empty((m, 3)), x.copy()
    least = math.inf
    for k in range(rounds + 1):
        _place(chain, x, T, axes, points)
        error = pose_error(target, T, 1.0 / size, e)
        if error < least:
            least = error
            best[:] = x
        elif k > 3 and error > 0.5 * least and least < CONVERGED:
            break
        if error < FINISHED or k == rounds:
            break
        _jacobian(chain, size, axes, points, T, J)
        damped_step(J, e, min(1e-2 * error, 1e-2) + 1e-12, step)
        shrink = min(1.0, 0.5 / (np.abs(step).max() + 1e-300))
        for j in range(n):
            x[j] += shrink * step[j]
    for j in range(n):
        x[j] = _gap(arm, j, best[j], 0.0)
    return least


@kernel
def _stretch(arm, chain, x, direction):
    """Smallest singular value of the Jacobian at ``x``, and its direction (n,)."""
    m = chain[0].shape[0]
    T, J, axes, points = np.empty((4, 4)), np.empty((6, x.size)), np.empty((m, 3)), np.empty((m, 3))
    _place(chain, x, T, axes, points)
    _jacobian(chain, arm[layout.SIZE], axes, points, T, J)
    return least_stretch(J, direction)


@kernel
def _is_other(arm, chain, target, X, flags, x):
    """Whether ``x`` differs from every valid row of ``X`` (B, n); as ``refine.is_new``."""
    n, m = x.size, chain[0].shape[0]
    T, e, axes, points, middle = np.empty((4, 4)), np.empty(6), np.empty((m, 3)), np.empty((m, 3)), np.empty(n)
    for b in range(X.shape[0]):
        if flags[b] & layout.VALID:
            apart = 0.0
            for j in range(n):
                gap = _gap(arm, j, x[j], X[b, j])
                middle[j] = X[b, j] + 0.5 * gap
                apart = max(apart, abs(gap))
            if apart <= arm[layout.DUPLICATE]:
                return False
            if apart < 1e-3:
                _place(chain, middle, T, axes, points)
                if pose_error(target, T, 1.0 / arm[layout.SIZE], e) <= arm[layout.FOLD]:
                    return False
    return True


@kernel
def _take(arm, chain, target, x, searched, X, flags):
    """Polish ``x``, keep it if it is verified and new, and look beside it near a fold; as ``few_joints.take``."""
    n = x.size
    if _polish(arm, chain, target, x, 40) > (CONVERGED if searched else arm[layout.REACH]):
        return
    direction, unused, start = np.empty(n), np.empty(n), np.empty(n)
    sigma = _stretch(arm, chain, x, direction)
    singular = sigma <= arm[layout.SINGULAR]
    if searched and singular:
        for b in range(flags.size):
            if flags[b] & layout.OTHER:
                return
    if not _is_other(arm, chain, target, X, flags, x):
        return
    keep(X, flags, 0, x, layout.OTHER if singular else 0)
    if sigma > NEAR_FOLD:
        return
    for k in range(16):
        shift = (1.0 if k % 2 else -1.0) * 0.1 * 10.0 ** (-(k // 2))
        for j in range(n):
            start[j] = x[j] + shift * direction[j]
        if (
            _polish(arm, chain, target, start, 20) <= CONVERGED
            and _is_other(arm, chain, target, X, flags, start)
            and _stretch(arm, chain, start, unused) > _APART * arm[layout.SINGULAR]
        ):
            keep(X, flags, 0, start, 0)


@kernel
def _bound(arm, chain, w):
    """rho: what second and higher orders can make of the error in a box of half widths ``w`` (n,) anywhere.

    The tip is the sum of the links, each turned by all axes before it: the second derivative of a rotation is at most
    the square of its rate, ``rates`` (m, n) behind each axis per joint.
    """
    _, P, _, slides, gain, rates = chain
    m, n = gain.shape
    place, rate = 0.0, 0.0
    for k in range(m):
        rate, slide, extent = 0.0, 0.0, 0.0
        for j in range(n):
            rate += rates[k, j] * w[j]
            if slides[k]:
                slide += abs(gain[k, j]) * w[j]
                extent += abs(gain[k, j]) * (abs(arm[MIDDLE + j]) + arm[HALF + j])
        link = math.sqrt(P[k + 1, 0] ** 2 + P[k + 1, 1] ** 2 + P[k + 1, 2] ** 2) + extent
        place += link * rate * rate + 2.0 * slide * rate
    place /= arm[layout.SIZE]
    return 0.5 * math.sqrt(place * place + rate**4) * _SLACK


@kernel
def _judge(arm, chain, target, c, w, rho, start):
    """0: the box about ``c`` (n,) holds no solution; 1: at most one, that ``start`` (n,) leads to; 2: halve it."""
    n, m, size = c.size, chain[0].shape[0], arm[layout.SIZE]
    T, J, e = np.empty((4, 4)), np.empty((6, n)), np.empty(6)
    axes, points = np.empty((m, 3)), np.empty((m, 3))
    _place(chain, c, T, axes, points)
    pose_error(target, T, 1.0 / size, e)
    # |R - R_target|^2 / 2 = 3 - tr(R' R_target).
    square = e[0] * e[0] + e[1] * e[1] + e[2] * e[2]
    for i in range(3):
        for j in range(3):
            square += 0.5 * (T[i, j] - target[i, j]) ** 2
    _jacobian(chain, size, axes, points, T, J)
    reach = rho
    for j in range(n):
        norm = 0.0
        for i in range(6):
            norm += J[i, j] * J[i, j]
        reach += math.sqrt(norm) * w[j]
    if square > reach * reach + _ROUNDING:
        return 0
    # The twelve-row Jacobian has the same products with itself and with the error as the geometric one.
    L, g = np.empty((n, n)), np.empty(n)
    for a in range(n):
        g[a] = 0.0
        for i in range(6):
            g[a] += J[i, a] * e[i]
        for b in range(a + 1):
            s = 0.0
            for i in range(6):
                s += J[i, a] * J[i, b]
            whole = s
            for k in range(b):
                s -= L[a, k] * L[b, k]
            if a > b:
                L[a, b] = s / L[b, b]
            elif s < 1e-10 * whole or whole == 0.0:
                return 2
            else:
                L[a, a] = math.sqrt(s)
    # Rows of the inverse of L, whose columns' squares add up to the diagonal of the inverse of J'J.
    inverse = np.zeros((n, n))
    for a in range(n):
        inverse[a, a] = 1.0 / L[a, a]
        for b in range(a):
            s = 0.0
            for k in range(b, a):
                s -= L[a, k] * inverse[k, b]
            inverse[a, b] = s / L[a, a]
    along = 0.0
    y = np.zeros(n)
    for a in range(n):
        for b in range(a + 1):
            y[a] += inverse[a, b] * g[b]
        along += y[a] * y[a]
    if square - along > rho * rho + _ROUNDING:
        return 0
    alone = True
    for j in range(n):
        step, row = 0.0, 0.0
        for a in range(j, n):
            step += inverse[a, j] * y[a]
            row += inverse[a, j] * inverse[a, j]
        row = math.sqrt(row)
        if abs(step) > w[j] + row * rho + 1e-9:
            return 0
        start[j] = c[j] + step
        if 2.0 * row * rho > _CONTRACTING * w[j]:
            alone = False
    return 1 if alone else 2


@kernel
def _widest(arm, chain, w, shares):
    """The joint whose halving lowers the bound most."""
    best, least = 0, math.inf
    for j in range(w.size):
        shares[:] = w
        shares[j] *= 0.5
        bound = _bound(arm, chain, shares)
        if bound < least:
            least = bound
            best = j
    return best


@kernel
def _search(arm, chain, target, boxes, halves, X, flags):
    """All solutions of one pose to ``X`` (B, n); ``boxes`` and ``halves`` (room, n) are scratch."""
    n = X.shape[1]
    w, x, shares = arm[HALF : HALF + n].copy(), np.empty(n), np.empty(n)
    boxes[0] = arm[MIDDLE : MIDDLE + n]
    count = 1
    while count > 0:
        rho = _bound(arm, chain, w)
        last = rho < _SMALLEST * _SMALLEST or 2 * count > _ROOM
        split = _widest(arm, chain, w, shares)
        stride = 1 + count // _STARTS if last else 1
        more = 0
        for i in range(0, count, stride):
            verdict = _judge(arm, chain, target, boxes[i], w, rho, x)
            if verdict == 1:
                _take(arm, chain, target, x, False, X, flags)
            elif verdict == 2 and last:
                x[:] = boxes[i]
                _take(arm, chain, target, x, True, X, flags)
            elif verdict == 2:
                halves[more] = boxes[i]
                halves[more + 1] = boxes[i]
                halves[more, split] -= 0.5 * w[split]
                halves[more + 1, split] += 0.5 * w[split]
                more += 2
        if last:
            break
        w[split] *= 0.5
        boxes, halves = halves, boxes
        count = more


@kernel
def solve(T, arm, q_ref, Q, flags):
    """All solutions of targets ``T`` (m, 4, 4) to ``Q`` (m, B, n) and ``flags`` (m, B).

    Arguments and result as those of ``spherical_wrist.solve``; of a continuum the representative is any one.
    """
    m, n = int(arm[AXES]), int(arm[JOINTS])
    at = DATA + 3 * m
    behind = at + 3 * m + 3
    chain = (
        arm[DATA:at].copy().reshape(m, 3),
        arm[at:behind].copy().reshape(m + 1, 3),
        arm[layout.R_TIP : layout.R_TIP + 9].copy().reshape(3, 3),
        arm[behind : behind + m] != 0.0,
        arm[behind + m : behind + m + m * n].copy().reshape(m, n),
        arm[behind + m + m * n : behind + m + 2 * m * n].copy().reshape(m, n),
    )
    proper = np.empty((4, 4))
    boxes, halves = np.empty((_ROOM, n)), np.empty((_ROOM, n))
    for i in range(T.shape[0]):
        if not check_target(T[i]) <= arm[layout.ROTATION]:
            return i
        project_rotation(T[i], proper)
        Q[i, :, :] = math.nan
        flags[i, :] = 0
        _search(arm, chain, proper, boxes, halves, Q[i], flags[i])
        sort_columns(Q[i], flags[i])
        for j in range(n):
            for b in range(Q.shape[1]):
                Q[i, b, j] *= arm[UNIT + j]
    return -1
