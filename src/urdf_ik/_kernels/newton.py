"""Newton's method on the arm as written, one joint vector or sixteen side by side.

The arm is a chain of frames whose z axes are the joints: T = F0 Rz(q1) F1 Rz(q2) ... Rz(q6) F6, each F a rotation
(9 numbers) and a translation (3). The step solves J x = e with the geometric Jacobian by modified Gram-Schmidt on
the columns of [J e], which is backward stable for x (Bjorck 1967). It is written without loops and arrays, so that
the compiler runs one step on as many columns as a vector register holds.
"""

from __future__ import annotations

import math

import numpy as np

from urdf_ik._kernels import layout
from urdf_ik._kernels.compile import inlined, kernel, step
from urdf_ik._kernels.sixes import dot, inverse_length, largest, less, times
from urdf_ik._kernels.thresholds import CONVERGED, FINISHED
from urdf_ik._kernels.trig import cos_sin, wrap

LANES = 16
_TINY = 1e-300


@step
def _beyond(F, f, R, p, angle):
    """Frame (R, p) moved by a turn ``angle`` about its z axis and the step that stands at ``f`` in ``F``."""
    r00, r01, r02, r10, r11, r12, r20, r21, r22 = R
    c, s = cos_sin(angle)
    x0, y0 = c * r00 + s * r01, c * r01 - s * r00
    x1, y1 = c * r10 + s * r11, c * r11 - s * r10
    x2, y2 = c * r20 + s * r21, c * r21 - s * r20
    a, b, d = F[f], F[f + 3], F[f + 6]
    n00, n10, n20 = x0 * a + y0 * b + r02 * d, x1 * a + y1 * b + r12 * d, x2 * a + y2 * b + r22 * d
    a, b, d = F[f + 1], F[f + 4], F[f + 7]
    n01, n11, n21 = x0 * a + y0 * b + r02 * d, x1 * a + y1 * b + r12 * d, x2 * a + y2 * b + r22 * d
    a, b, d = F[f + 2], F[f + 5], F[f + 8]
    n02, n12, n22 = x0 * a + y0 * b + r02 * d, x1 * a + y1 * b + r12 * d, x2 * a + y2 * b + r22 * d
    a, b, d = F[f + 9], F[f + 10], F[f + 11]
    p = p[0] + (x0 * a + y0 * b + r02 * d), p[1] + (x1 * a + y1 * b + r12 * d), p[2] + (x2 * a + y2 * b + r22 * d)
    return (n00, n01, n02, n10, n11, n12, n20, n21, n22), p


@step
def _first(F, f):
    """The frame on axis 1."""
    R = F[f], F[f + 1], F[f + 2], F[f + 3], F[f + 4], F[f + 5], F[f + 6], F[f + 7], F[f + 8]
    return R, (F[f + 9], F[f + 10], F[f + 11])


@step
def _screw(R, p, tip, scale):
    """Column of the Jacobian for a turn about the z axis of frame (R, p), lengths times ``scale``."""
    x, y, z = R[2], R[5], R[8]
    u, v, w = (tip[0] - p[0]) * scale, (tip[1] - p[1]) * scale, (tip[2] - p[2]) * scale
    return y * w - z * v, z * u - x * w, x * v - y * u, x, y, z


@step
def _solved(j0, j1, j2, j3, j4, j5, e):
    """Solve J x = e for the columns j0 ... j5 of J, and a bound from below on its smallest singular value.

    The bound is one over the Frobenius norm of the inverse, at most a factor of sqrt(6) off.
    """
    w0 = inverse_length(j0)
    j0 = times(j0, w0)
    r01, r02, r03, r04, r05, y0 = dot(j0, j1), dot(j0, j2), dot(j0, j3), dot(j0, j4), dot(j0, j5), dot(j0, e)
    j1, j2, j3 = less(j1, r01, j0), less(j2, r02, j0), less(j3, r03, j0)
    j4, j5, e = less(j4, r04, j0), less(j5, r05, j0), less(e, y0, j0)
    w1 = inverse_length(j1)
    j1 = times(j1, w1)
    r12, r13, r14, r15, y1 = dot(j1, j2), dot(j1, j3), dot(j1, j4), dot(j1, j5), dot(j1, e)
    j2, j3, j4, j5, e = less(j2, r12, j1), less(j3, r13, j1), less(j4, r14, j1), less(j5, r15, j1), less(e, y1, j1)
    w2 = inverse_length(j2)
    j2 = times(j2, w2)
    r23, r24, r25, y2 = dot(j2, j3), dot(j2, j4), dot(j2, j5), dot(j2, e)
    j3, j4, j5, e = less(j3, r23, j2), less(j4, r24, j2), less(j5, r25, j2), less(e, y2, j2)
    w3 = inverse_length(j3)
    j3 = times(j3, w3)
    r34, r35, y3 = dot(j3, j4), dot(j3, j5), dot(j3, e)
    j4, j5, e = less(j4, r34, j3), less(j5, r35, j3), less(e, y3, j3)
    w4 = inverse_length(j4)
    j4 = times(j4, w4)
    r45, y4 = dot(j4, j5), dot(j4, e)
    j5, e = less(j5, r45, j4), less(e, y4, j4)
    w5 = inverse_length(j5)
    x5 = dot(j5, e) * w5 * w5
    x4 = (y4 - r45 * x5) * w4
    x3 = (y3 - r34 * x4 - r35 * x5) * w3
    x2 = (y2 - r23 * x3 - r24 * x4 - r25 * x5) * w2
    x1 = (y1 - r12 * x2 - r13 * x3 - r14 * x4 - r15 * x5) * w1
    x0 = (y0 - r01 * x1 - r02 * x2 - r03 * x3 - r04 * x4 - r05 * x5) * w0
    # Columns of the triangular factor's inverse: their length is at most 1 / the smallest singular value.
    s01, s12, s23, s34, s45 = -w0 * r01 * w1, -w1 * r12 * w2, -w2 * r23 * w3, -w3 * r34 * w4, -w4 * r45 * w5
    s02, s13 = -w0 * (r01 * s12 + r02 * w2), -w1 * (r12 * s23 + r13 * w3)
    s24, s35 = -w2 * (r23 * s34 + r24 * w4), -w3 * (r34 * s45 + r35 * w5)
    s03, s14 = -w0 * (r01 * s13 + r02 * s23 + r03 * w3), -w1 * (r12 * s24 + r13 * s34 + r14 * w4)
    s25 = -w2 * (r23 * s35 + r24 * s45 + r25 * w5)
    s04 = -w0 * (r01 * s14 + r02 * s24 + r03 * s34 + r04 * w4)
    s15 = -w1 * (r12 * s25 + r13 * s35 + r14 * s45 + r15 * w5)
    s05 = -w0 * (r01 * s15 + r02 * s25 + r03 * s35 + r04 * s45 + r05 * w5)
    square = w0 * w0 + dot((w1, w2, w3, w4, w5, 0.0), (w1, w2, w3, w4, w5, 0.0))
    square += dot((s01, s02, s03, s04, s05, s12), (s01, s02, s03, s04, s05, s12))
    square += dot((s13, s14, s15, s23, s24, s25), (s13, s14, s15, s23, s24, s25))
    square += s34 * s34 + s35 * s35 + s45 * s45
    return (x0, x1, x2, x3, x4, x5), 1.0 / math.sqrt(square)


@step
def forward(F, f, q):
    """Rotation (9) and point (3) of the tip at ``q`` (6 angles)."""
    R, p = _first(F, f)
    R, p = _beyond(F, f + 12, R, p, q[0])
    R, p = _beyond(F, f + 24, R, p, q[1])
    R, p = _beyond(F, f + 36, R, p, q[2])
    R, p = _beyond(F, f + 48, R, p, q[3])
    R, p = _beyond(F, f + 60, R, p, q[4])
    return _beyond(F, f + 72, R, p, q[5])


@step
def newton_step(F, f, G, p, q):
    """Pose error at ``q`` (6 angles) towards the rotation ``G`` (9) and point ``p`` (3), and the step that mends it.

    The arm's frames stand at ``f`` in ``F``.
    Returns the greatest entry of the twist (see ``refine.pose_error``), the step clamped to half a radian, and a
    bound from below on the Jacobian's smallest singular value (see ``_solved``).
    """
    scale = F[layout.INVERSE_SIZE]
    R1, p1 = _first(F, f)
    R2, p2 = _beyond(F, f + 12, R1, p1, q[0])
    R3, p3 = _beyond(F, f + 24, R2, p2, q[1])
    R4, p4 = _beyond(F, f + 36, R3, p3, q[2])
    R5, p5 = _beyond(F, f + 48, R4, p4, q[3])
    R6, p6 = _beyond(F, f + 60, R5, p5, q[4])
    R, tip = _beyond(F, f + 72, R6, p6, q[5])
    e0, e1, e2 = (p[0] - tip[0]) * scale, (p[1] - tip[1]) * scale, (p[2] - tip[2]) * scale
    e3 = 0.5 * (R[3] * G[6] - R[6] * G[3] + R[4] * G[7] - R[7] * G[4] + R[5] * G[8] - R[8] * G[5])
    e4 = 0.5 * (R[6] * G[0] - R[0] * G[6] + R[7] * G[1] - R[1] * G[7] + R[8] * G[2] - R[2] * G[8])
    e5 = 0.5 * (R[0] * G[3] - R[3] * G[0] + R[1] * G[4] - R[4] * G[1] + R[2] * G[5] - R[5] * G[2])
    e = e0, e1, e2, e3, e4, e5
    error = largest(e)
    # The skew part vanishes at half a turn too.
    trace = R[0] * G[0] + R[1] * G[1] + R[2] * G[2] + R[3] * G[3] + R[4] * G[4] + R[5] * G[5]
    trace += R[6] * G[6] + R[7] * G[7] + R[8] * G[8]
    error = error if trace > 1.0 else 2.0
    x, least = _solved(
        _screw(R1, p1, tip, scale),
        _screw(R2, p2, tip, scale),
        _screw(R3, p3, tip, scale),
        _screw(R4, p4, tip, scale),
        _screw(R5, p5, tip, scale),
        _screw(R6, p6, tip, scale),
        e,
    )
    return error, times(x, min(1.0, 0.5 / (largest(x) + _TINY))), least


@kernel
def newton(arm, target, q, rounds):
    """Newton's method from ``q`` (6,), which is replaced by the last vector; for starts near a regular solution.

    Returns its error (see ``newton_step``).
    """
    G = (
        target[0, 0],
        target[0, 1],
        target[0, 2],
        target[1, 0],
        target[1, 1],
        target[1, 2],
        target[2, 0],
        target[2, 1],
        target[2, 2],
    )
    p = target[0, 3], target[1, 3], target[2, 3]
    previous = math.inf
    for k in range(rounds + 1):
        error, x, _ = newton_step(arm, layout.FRAMES, G, p, (q[0], q[1], q[2], q[3], q[4], q[5]))
        if k == rounds or error < FINISHED or (error < CONVERGED and error > 0.1 * previous):
            return error
        previous = error
        for j in range(6):
            q[j] = wrap(q[j] + x[j])
    return math.inf


# Rows of ``newton_columns``: joint vector, rotation and point of the target, error and least stretch, and whether the
# column is to move (1.0) or has come to rest (0.0).
ANGLES, ROTATION, POINT, ERROR, LEAST, MOVES, _NEXT, COLUMN_ROWS = 0, 6, 15, 18, 19, 20, 21, 29


@inlined
def newton_columns(arm, frames, W, rounds):
    """``newton`` on the columns of ``W`` (COLUMN_ROWS, LANES) side by side, until none gains by another round.

    ``frames``: where the arm's frames stand in ``arm``.
    """
    for i in range(LANES):
        W[ERROR, i] = math.inf
    for k in range(rounds + 1):
        for i in range(LANES):
            error, x, least = newton_step(
                arm,
                frames,
                (W[6, i], W[7, i], W[8, i], W[9, i], W[10, i], W[11, i], W[12, i], W[13, i], W[14, i]),
                (W[15, i], W[16, i], W[17, i]),
                (W[0, i], W[1, i], W[2, i], W[3, i], W[4, i], W[5, i]),
            )
            W[_NEXT, i] = wrap(W[0, i] + x[0])
            W[_NEXT + 1, i] = wrap(W[1, i] + x[1])
            W[_NEXT + 2, i] = wrap(W[2, i] + x[2])
            W[_NEXT + 3, i] = wrap(W[3, i] + x[3])
            W[_NEXT + 4, i] = wrap(W[4, i] + x[4])
            W[_NEXT + 5, i] = wrap(W[5, i] + x[5])
            W[_NEXT + 6, i] = error
            W[_NEXT + 7, i] = least
        moving = 0.0
        for i in range(LANES):
            error, previous = W[_NEXT + 6, i], W[ERROR, i]
            # A column at rest stays where it is: near a singularity further steps would only carry rounding about.
            W[MOVES, i] *= 1.0 if (error >= FINISHED) & ((error >= CONVERGED) | (error <= 0.1 * previous)) else 0.0
            moving = max(moving, W[MOVES, i])
            W[ERROR, i], W[LEAST, i] = error, W[_NEXT + 7, i]
        if k == rounds or moving == 0.0:
            break
        for j in range(6):
            for i in range(LANES):
                W[j, i] = W[_NEXT + j, i] if W[MOVES, i] == 1.0 else W[j, i]


@kernel
def newton_on_starts(arm, target, starts, many, rounds, found, errors, stretches):
    """``newton`` on the rows of ``starts`` (many <= LANES, 6) side by side, for one target.

    Joint vectors to ``found``, errors to ``errors``, bounds from below on the smallest singular values there to
    ``stretches``.
    """
    W = np.empty((COLUMN_ROWS, LANES))
    for i in range(LANES):
        for j in range(6):
            W[j, i] = starts[min(i, many - 1), j]
        for r in range(3):
            for c in range(3):
                W[ROTATION + 3 * r + c, i] = target[r, c]
            W[POINT + r, i] = target[r, 3]
        W[MOVES, i] = 1.0
    newton_columns(arm, layout.FRAMES, W, rounds)
    for i in range(many):
        for j in range(6):
            found[i, j] = W[j, i]
        errors[i], stretches[i] = W[ERROR, i], W[LEAST, i]
