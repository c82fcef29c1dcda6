"""From a stack of target poses to a block in the solver's own frames, one pose a column.

``arm`` begins, in every family, with the frames of the ideal arm: base rotation transposed (9), origin of
frame 1 in the base (3), tool rotation transposed (9), the solved point in the tip frame (3); see ``layout``.
"""

from __future__ import annotations

import math

from urdf_ik._kernels.compile import inlined, kernel


@inlined
def load(W, T, start, m, arm):
    """Write rotation (rows 0-8), solved point (9-11) and defect (12) of poses ``start``.. to ``W``.

    The defect is the greatest entry of R^T R - I and of the last row's error, infinite or NaN for what cannot be
    a rigid motion.
    """
    for i in range(m):
        for r in range(3):
            for c in range(4):
                W[13 + 4 * r + c, i] = T[start + i, r, c]
        a, b, c, d = T[start + i, 3, 0], T[start + i, 3, 1], T[start + i, 3, 2], T[start + i, 3, 3] - 1.0
        W[25, i] = max(max(abs(a), abs(b)), max(abs(c), abs(d))) + 0.0 * (a + b + c + d)
    for i in range(m):
        r00, r01, r02, tx = W[13, i], W[14, i], W[15, i], W[16, i]
        r10, r11, r12, ty = W[17, i], W[18, i], W[19, i], W[20, i]
        r20, r21, r22, tz = W[21, i], W[22, i], W[23, i], W[24, i]
        d0 = abs(r00 * r00 + r10 * r10 + r20 * r20 - 1.0)
        d1 = abs(r01 * r01 + r11 * r11 + r21 * r21 - 1.0)
        d2 = abs(r02 * r02 + r12 * r12 + r22 * r22 - 1.0)
        d3 = abs(r00 * r01 + r10 * r11 + r20 * r21)
        d4 = abs(r00 * r02 + r10 * r12 + r20 * r22)
        d5 = abs(r01 * r02 + r11 * r12 + r21 * r22)
        det = r00 * (r11 * r22 - r12 * r21) - r01 * (r10 * r22 - r12 * r20) + r02 * (r10 * r21 - r11 * r20)
        worst = max(max(max(d0, d1), max(d2, d3)), max(max(d4, d5), W[25, i]))
        # Products with zero carry a NaN or an infinity on, where max() would drop it.
        lost = 0.0 * (d0 + d1 + d2 + W[25, i]) + (0.0 * tx + 0.0 * ty + 0.0 * tz)
        W[12, i] = (worst if det > 0.0 else math.inf) + lost
        a0 = arm[0] * r00 + arm[1] * r10 + arm[2] * r20
        a1 = arm[0] * r01 + arm[1] * r11 + arm[2] * r21
        a2 = arm[0] * r02 + arm[1] * r12 + arm[2] * r22
        b0 = arm[3] * r00 + arm[4] * r10 + arm[5] * r20
        b1 = arm[3] * r01 + arm[4] * r11 + arm[5] * r21
        b2 = arm[3] * r02 + arm[4] * r12 + arm[5] * r22
        c0 = arm[6] * r00 + arm[7] * r10 + arm[8] * r20
        c1 = arm[6] * r01 + arm[7] * r11 + arm[8] * r21
        c2 = arm[6] * r02 + arm[7] * r12 + arm[8] * r22
        W[0, i] = a0 * arm[12] + a1 * arm[15] + a2 * arm[18]
        W[1, i] = a0 * arm[13] + a1 * arm[16] + a2 * arm[19]
        W[2, i] = a0 * arm[14] + a1 * arm[17] + a2 * arm[20]
        W[3, i] = b0 * arm[12] + b1 * arm[15] + b2 * arm[18]
        W[4, i] = b0 * arm[13] + b1 * arm[16] + b2 * arm[19]
        W[5, i] = b0 * arm[14] + b1 * arm[17] + b2 * arm[20]
        W[6, i] = c0 * arm[12] + c1 * arm[15] + c2 * arm[18]
        W[7, i] = c0 * arm[13] + c1 * arm[16] + c2 * arm[19]
        W[8, i] = c0 * arm[14] + c1 * arm[17] + c2 * arm[20]
        x = r00 * arm[21] + r01 * arm[22] + r02 * arm[23] + tx - arm[9]
        y = r10 * arm[21] + r11 * arm[22] + r12 * arm[23] + ty - arm[10]
        z = r20 * arm[21] + r21 * arm[22] + r22 * arm[23] + tz - arm[11]
        W[9, i] = arm[0] * x + arm[1] * y + arm[2] * z
        W[10, i] = arm[3] * x + arm[4] * y + arm[5] * z
        W[11, i] = arm[6] * x + arm[7] * y + arm[8] * z


@kernel
def to_frame_1(T, arm, X):
    """One target: rotation and solved point in frame 1 to ``X`` (12,), as ``load`` does for a block."""
    for r in range(3):
        for c in range(3):
            s = 0.0
            for k in range(3):
                for j in range(3):
                    s += arm[3 * r + k] * T[k, j] * arm[12 + 3 * j + c]
            X[3 * r + c] = s
        s = 0.0
        for k in range(3):
            s += arm[3 * r + k] * (T[k, 0] * arm[21] + T[k, 1] * arm[22] + T[k, 2] * arm[23] + T[k, 3] - arm[9 + k])
        X[9 + r] = s


@kernel
def project_rotation(T, out):
    """Write ``T`` (4, 4) with its rotation replaced by the nearest one to ``out`` (Newton's polar iteration)."""
    for r in range(4):
        for c in range(4):
            out[r, c] = T[r, c]
    for _ in range(6):
        a, b, c = out[0, 0], out[0, 1], out[0, 2]
        d, e, f = out[1, 0], out[1, 1], out[1, 2]
        g, h, k = out[2, 0], out[2, 1], out[2, 2]
        # The transposed inverse is the matrix of cofactors over the determinant.
        k00, k01, k02 = e * k - f * h, f * g - d * k, d * h - e * g
        k10, k11, k12 = c * h - b * k, a * k - c * g, b * g - a * h
        k20, k21, k22 = b * f - c * e, c * d - a * f, a * e - b * d
        w = 0.5 / (a * k00 + b * k01 + c * k02)
        out[0, 0], out[0, 1], out[0, 2] = 0.5 * a + w * k00, 0.5 * b + w * k01, 0.5 * c + w * k02
        out[1, 0], out[1, 1], out[1, 2] = 0.5 * d + w * k10, 0.5 * e + w * k11, 0.5 * f + w * k12
        out[2, 0], out[2, 1], out[2, 2] = 0.5 * g + w * k20, 0.5 * h + w * k21, 0.5 * k + w * k22
        if math.fabs(out[0, 0] - a) + math.fabs(out[1, 1] - e) + math.fabs(out[2, 2] - k) < 1e-16:
            break


@kernel
def check_target(T):
    """The defect of one pose (4, 4), as ``load`` measures it."""
    worst, lost = max(max(abs(T[3, 0]), abs(T[3, 1])), max(abs(T[3, 2]), abs(T[3, 3] - 1.0))), 0.0
    for i in range(3):
        lost += 0.0 * T[i, 3]
        for j in range(3):
            s = T[0, i] * T[0, j] + T[1, i] * T[1, j] + T[2, i] * T[2, j]
            worst = max(worst, abs(s - (1.0 if i == j else 0.0)))
            lost += 0.0 * T[i, j]
    lost += 0.0 * (T[3, 0] + T[3, 1] + T[3, 2] + T[3, 3])
    x = T[1, 1] * T[2, 2] - T[1, 2] * T[2, 1]
    y = T[1, 2] * T[2, 0] - T[1, 0] * T[2, 2]
    z = T[1, 0] * T[2, 1] - T[1, 1] * T[2, 0]
    det = T[0, 0] * x + T[0, 1] * y + T[0, 2] * z
    return (worst if det > 0.0 else math.inf) + lost
