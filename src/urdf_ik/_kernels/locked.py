"""Seven joints, the first or the last of which is given: the same six-joint arm for every value, other targets."""

from __future__ import annotations

import math

from urdf_ik._kernels.compile import kernel


@kernel
def move_targets(T, values, motion, turns, last, out):
    """Targets ``T`` (m, 4, 4) as the six other joints see them when the seventh stands at ``values`` (m,), to ``out``.

    ``motion`` (3, 3, 4): the joint's motion back is their sum times (1, cos, sin) of its value, or, where it does
    not turn, the first plus the value times the second. It stands before a target in the base's frame, or behind
    it in the tip's where the joint is the ``last``. The last row is kept, for whoever checks it.
    """
    for m in range(T.shape[0]):
        c, s = values[m], 0.0
        if turns:
            c, s = math.cos(values[m]), math.sin(values[m])
        for i in range(3):
            for j in range(4):
                moved = 0.0
                if last:
                    for k in range(3):
                        moved += T[m, i, k] * (motion[0, k, j] + c * motion[1, k, j] + s * motion[2, k, j])
                    moved += T[m, i, 3] if j == 3 else 0.0
                else:
                    for k in range(3):
                        moved += (motion[0, i, k] + c * motion[1, i, k] + s * motion[2, i, k]) * T[m, k, j]
                    moved += motion[0, i, 3] + c * motion[1, i, 3] + s * motion[2, i, 3] if j == 3 else 0.0
                out[m, i, j] = moved
        for j in range(4):
            out[m, 3, j] = T[m, 3, j]


@kernel
def insert_column(six, values, flags, turns, last, Q):
    """Joint vectors ``six`` (m, B, 6) with ``values`` (m,) before or behind them to ``Q`` (m, B, 7).

    Angles are brought to (-pi, pi].
    """
    shift = 0 if last else 1
    for m in range(six.shape[0]):
        value = values[m]
        if turns and not abs(value) < math.pi:
            value -= 2.0 * math.pi * math.ceil((value - math.pi) / (2.0 * math.pi))
        for b in range(six.shape[1]):
            Q[m, b, 6 if last else 0] = value if flags[m, b] else math.nan
            for j in range(6):
                Q[m, b, j + shift] = six[m, b, j]
