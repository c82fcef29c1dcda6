"""What it takes to solve an arm from its other end."""

from __future__ import annotations

from urdf_ik._kernels import layout
from urdf_ik._kernels.compile import kernel


@kernel
def invert_poses(T, out):
    """The inverses of rigid motions ``T`` (m, 4, 4) to ``out``; the last row is kept, for whoever checks it."""
    for m in range(T.shape[0]):
        for i in range(3):
            s = 0.0
            for j in range(3):
                out[m, i, j] = T[m, j, i]
                s -= T[m, j, i] * T[m, j, 3]
            out[m, i, 3] = s
        for j in range(4):
            out[m, 3, j] = T[m, 3, j]


@kernel
def turn_round(Q, flags):
    """Joint vectors ``Q`` (m, B, n) the other way round, in place; shoulder and wrist change places in ``flags``."""
    n = Q.shape[2]
    for m in range(Q.shape[0]):
        for b in range(Q.shape[1]):
            for j in range(n // 2):
                Q[m, b, j], Q[m, b, n - 1 - j] = Q[m, b, n - 1 - j], Q[m, b, j]
            f = flags[m, b]
            kept = f & (layout.VALID | layout.ELBOW | layout.OTHER)
            wrist = layout.WRIST if f & layout.SHOULDER else 0
            flags[m, b] = kept | wrist | (layout.SHOULDER if f & layout.WRIST else 0)
