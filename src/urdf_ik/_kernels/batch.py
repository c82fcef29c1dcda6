"""Blocks of poses: two branches of many poses side by side, or all branches of a single one.

The branches are taken in pairs that share most of their angles: ``apart`` is the distance between the columns of
a pair, so that pair p has the columns ``first_of(p, apart)`` and that plus ``apart``.
"""

from __future__ import annotations

import math

from urdf_ik._kernels import layout
from urdf_ik._kernels.compile import inlined, step
from urdf_ik._kernels.layout import BLOCK

PAIRS = 4
# Rows of a block's answer; see ``store``.
OUT_ROWS = 20


@step
def first_of(pair, apart):
    """Column of the first branch of a pair."""
    return (pair // apart) * 2 * apart + pair % apart


@inlined
def spread(W, arm, pair, apart, m, single):
    """Write the signs of a pair's first branch over the block; of a single pose, those of all pairs side by side.

    A block of fewer poses is filled up with its last one: whatever a pose's place in a batch, the same
    instructions then handle it and give the same digits.
    Returns the number of columns to solve, and how many of them to store.
    """
    if single:
        for r in range(12):
            for i in range(1, PAIRS):
                W[r, i] = W[r, 0]
        for i in range(PAIRS):
            b = layout.SIGNS + 3 * first_of(i, apart)
            W[13, i], W[14, i], W[15, i] = arm[b], arm[b + 1], arm[b + 2]
        return PAIRS, PAIRS
    b = layout.SIGNS + 3 * first_of(pair, apart)
    front, up, flip = arm[b], arm[b + 1], arm[b + 2]
    for i in range(BLOCK):
        W[13, i], W[14, i], W[15, i] = front, up, flip
    if pair == 0:
        for r in range(12):
            for i in range(m, BLOCK):
                W[r, i] = W[r, m - 1]
    return BLOCK, m


@inlined
def store(out, pair, apart, start, columns, single, care, Q, flags):
    """Copy the angles of a block to the answer, NaN where there is no solution, and mark poses in doubt.

    Rows 0-5 of ``out`` are the first branch's angles, row 6 its state (0 none, 1 valid, 2 in doubt), rows 7-13 the
    second one's; rows 14 to 19, for imperfect arms, the margins of shoulder, elbow and wrist, and the squared
    arms that fix the wrist's turns, the shoulder's and the elbow's.
    """
    for i in range(columns):
        pose, k = (start, 0) if single else (start + i, i)
        first = first_of(i if single else pair, apart)
        for second in range(2):
            b, row = first + second * apart, 7 * second
            if out[row + 6, i] == 1.0:
                for j in range(6):
                    Q[pose, b, j] = out[row + j, i]
                flags[pose, b] = layout.VALID
            else:
                for j in range(6):
                    Q[pose, b, j] = math.nan
                flags[pose, b] = 0
                if out[row + 6, i] == 2.0:
                    care[k] = True
