"""Blocks of poses: one branch of many poses side by side, or all branches of a single one."""

from __future__ import annotations

import math

from urdf_ik._kernels import layout
from urdf_ik._kernels.compile import inlined


@inlined
def spread(W, arm, b, m, single):
    """Write the signs of branch ``b`` over the block; of a single pose, all eight branches side by side.

    Returns the number of columns in use.
    """
    if single:
        for r in range(12):
            for i in range(1, 8):
                W[r, i] = W[r, 0]
        for i in range(8):
            W[13, i], W[14, i], W[15, i] = (
                arm[layout.SIGNS + 3 * i],
                arm[layout.SIGNS + 3 * i + 1],
                arm[layout.SIGNS + 3 * i + 2],
            )
        return 8
    front, up, flip = arm[layout.SIGNS + 3 * b], arm[layout.SIGNS + 3 * b + 1], arm[layout.SIGNS + 3 * b + 2]
    for i in range(m):
        W[13, i], W[14, i], W[15, i] = front, up, flip
    return m


@inlined
def store(out, b, start, columns, single, care, Q, flags):
    """Copy the angles of a block to the answer, NaN where there is no solution, and mark poses in doubt."""
    for i in range(columns):
        pose, branch, k = (start, i, 0) if single else (start + i, b, i)
        if out[6, i] == 1.0:
            for j in range(6):
                Q[pose, branch, j] = out[j, i]
            flags[pose, branch] = layout.VALID
        else:
            for j in range(6):
                Q[pose, branch, j] = math.nan
            flags[pose, branch] = 0
            if out[6, i] == 2.0:
                care[k] = True
