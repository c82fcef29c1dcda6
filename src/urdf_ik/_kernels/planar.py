"""Two or three parallel turning joints and at most one slide along them: planar 2R and 3R arms, and SCARA robots.

In the plane a e(psi1) + b e(psi2) = (x, y), with psi the links' angles against the plane's first axis; the third joint
takes up the rest of the tip's turn, the slide the height. Blocks of poses, as in the other families; what is near the
edge of reach, or is no exact rotation, goes to ``few_joints.solve``.
"""

from __future__ import annotations

import math

import numpy as np

from urdf_ik._kernels import few_joints, layout
from urdf_ik._kernels.compile import inlined, kernel, step
from urdf_ik._kernels.layout import BLOCK, ROWS
from urdf_ik._kernels.subproblems import elbow
from urdf_ik._kernels.target import load
from urdf_ik._kernels.trig import atan2, wrap

# In the place of the signs of other families: link lengths, their angles at q = 0 and the difference of these, the
# signs and columns of joints 1, 2, 3 and of the slide (column -1: there is none).
LINK, ANGLE, BEND, SIGN, COLUMN = layout.SIGNS, 78, 80, 81, 85
# Rows of a block's answer: angles of the branches, height, state (0 none, 1 valid, 2 in doubt) of the branches.
_Q1, _Q2, _Q3, _HEIGHT, _STATE, _OUT = 0, 2, 4, 6, 7, 9


@step
def _turned(a):
    """``a``, up to two turns off, in (-pi, pi]."""
    return wrap(wrap(a))


@inlined
def _links(x, y, i, arm, out):
    """Both elbows for the point (x, y): rows _Q1 and _Q2 of column i; returns psi2 of both and whether to doubt."""
    a, b = arm[LINK], arm[LINK + 1]
    c, s, cg, sg, margin = elbow(x, y, a, b, 1.0, 1.0)
    # Of the two links the one branch is the other one's mirror image in the line to the point.
    first, middle, bend = atan2(s, c), atan2(y, x), atan2(sg, cg)
    other = 2.0 * middle - first
    out[_Q1, i] = arm[SIGN] * _turned(other - arm[ANGLE])
    out[_Q1 + 1, i] = arm[SIGN] * _turned(first - arm[ANGLE])
    out[_Q2, i] = arm[SIGN + 1] * _turned(-bend - arm[BEND])
    out[_Q2 + 1, i] = arm[SIGN + 1] * _turned(bend - arm[BEND])
    edge = arm[layout.EDGE]
    near = abs(margin) <= edge or x * x + y * y <= edge * arm[layout.SIZE] * arm[layout.SIZE]
    return other - bend, first + bend, 2.0 if near else (1.0 if margin > 0.0 else 0.0)


@inlined
def _block(W, arm, out):
    """All angles of a block of poses in the frame of the plane, as ``target.load`` writes them."""
    size = arm[layout.SIZE]
    reach = arm[layout.REACH]
    # A third joint turns the tip as it likes, a slide lifts it; otherwise both have to fit.
    free_turn = 2.0 if arm[COLUMN + 2] >= 0.0 else reach
    free_height = 1e300 if arm[COLUMN + 3] >= 0.0 else reach * size
    for i in range(BLOCK):
        left, right, state = _links(W[9, i], W[10, i], i, arm, out)
        theta = atan2(W[3, i], W[0, i])
        tilt = max(max(abs(W[2, i]), abs(W[5, i])), max(abs(W[6, i]), abs(W[7, i])))
        upright = tilt <= reach and W[8, i] > 0.0 and abs(W[11, i]) <= free_height
        rest_0 = _turned(theta - left + arm[ANGLE + 1])
        rest_1 = _turned(theta - right + arm[ANGLE + 1])
        out[_Q3, i], out[_Q3 + 1, i] = arm[SIGN + 2] * rest_0, arm[SIGN + 2] * rest_1
        out[_HEIGHT, i] = arm[SIGN + 3] * W[11, i]
        near = state == 2.0 and tilt <= 2.0 * reach
        doubt = near or W[12, i] > arm[layout.EXACT_ROTATION]
        free = free_turn > 1.0
        out[_STATE, i] = 2.0 if doubt else (state if upright and (free or abs(rest_0) <= free_turn) else 0.0)
        out[_STATE + 1, i] = 2.0 if doubt else (state if upright and (free or abs(rest_1) <= free_turn) else 0.0)


@inlined
def _store(out, start, m, arm, Q, flags):
    """Copy a block's angles to the answer."""
    columns = (int(arm[COLUMN]), int(arm[COLUMN + 1]), int(arm[COLUMN + 2]), int(arm[COLUMN + 3]))
    for i in range(m):
        for b in range(2):
            valid = out[_STATE + b, i] == 1.0
            flags[start + i, b] = layout.VALID if valid else 0
            # -0.0 and -pi are told as 0.0 and pi.
            Q[start + i, b, columns[0]] = wrap(out[_Q1 + b, i]) if valid else math.nan
            Q[start + i, b, columns[1]] = wrap(out[_Q2 + b, i]) if valid else math.nan
            if columns[2] >= 0:
                Q[start + i, b, columns[2]] = wrap(out[_Q3 + b, i]) if valid else math.nan
            if columns[3] >= 0:
                Q[start + i, b, columns[3]] = out[_HEIGHT, i] if valid else math.nan


@kernel
def _with_care(T, arm, q_ref, Q, flags):
    """One pose (1, 4, 4) by the general way, its solutions sorted into the columns of the elbow."""
    few_joints.solve(T, arm, q_ref, Q, flags)
    second = int(arm[COLUMN + 1])
    # Which way the elbow bends; where it does not, the first column has it.
    if flags[0, 0] & layout.VALID and wrap(arm[SIGN + 1] * Q[0, 0, second] + arm[BEND]) > 0.0:
        both = flags[0, 1] & layout.VALID
        if not both or wrap(arm[SIGN + 1] * Q[0, 1, second] + arm[BEND]) <= 0.0:
            for j in range(Q.shape[2]):
                Q[0, 0, j], Q[0, 1, j] = Q[0, 1, j], Q[0, 0, j]
            flags[0, 0], flags[0, 1] = flags[0, 1], flags[0, 0]
    for b in range(2):
        if flags[0, b] & layout.OTHER:
            flags[0, b] = layout.VALID | layout.ELBOW


@kernel
def solve(T, arm, q_ref, Q, flags):
    """All solutions of poses ``T`` (m, 4, 4) to ``Q`` (m, 2, n) and ``flags`` (m, 2); elbow left, elbow right.

    Arguments and result as those of ``spherical_wrist.solve``.
    """
    W, out = np.empty((ROWS, BLOCK)), np.empty((_OUT, BLOCK))
    total = T.shape[0]
    for start in range(0, total, BLOCK):
        m = min(BLOCK, total - start)
        load(W, T, start, m, arm)
        for r in range(13):
            for i in range(m, BLOCK):
                W[r, i] = W[r, m - 1]
        for i in range(m):
            if not W[12, i] <= arm[layout.ROTATION]:
                return start + i
        _block(W, arm, out)
        _store(out, start, m, arm, Q, flags)
        for i in range(m):
            if out[_STATE, i] == 2.0:
                k = start + i
                _with_care(T[k : k + 1], arm, q_ref, Q[k : k + 1], flags[k : k + 1])
    return -1


@kernel
def solve_points(points, arm, q_ref, Q, flags):
    """All solutions of points ``points`` (m, 2) m in the plane, for two joints; else as ``solve``."""
    W, out, T = np.empty((2, BLOCK)), np.empty((_OUT, BLOCK)), np.zeros((1, 4, 4))
    total = points.shape[0]
    for i in range(4):
        T[0, i, i] = 1.0
    # The point of the plane that is measured from: the first axis.
    B = arm[layout.BASE_ROTATION : layout.BASE_ROTATION + 9].reshape(3, 3)
    o = arm[layout.BASE_ORIGIN : layout.BASE_ORIGIN + 3]
    x0 = B[0, 0] * o[0] + B[0, 1] * o[1] + B[0, 2] * o[2]
    y0 = B[1, 0] * o[0] + B[1, 1] * o[1] + B[1, 2] * o[2]
    for start in range(0, total, BLOCK):
        m = min(BLOCK, total - start)
        for i in range(BLOCK):
            k = start + min(i, m - 1)
            W[0, i], W[1, i] = points[k, 0] - x0, points[k, 1] - y0
        lost = 0.0
        for i in range(BLOCK):
            # A product with zero carries a NaN or an infinity on.
            lost += 0.0 * (W[0, i] + W[1, i])
        if lost != 0.0:
            for i in range(m):
                if 0.0 * (W[0, i] + W[1, i]) != 0.0:
                    return start + i
        for i in range(BLOCK):
            _, _, state = _links(W[0, i], W[1, i], i, arm, out)
            out[_STATE, i] = state
            out[_STATE + 1, i] = state
        _store(out, start, m, arm, Q, flags)
        for i in range(m):
            if out[_STATE, i] == 2.0:
                k = start + i
                for j in range(3):
                    T[0, j, 3] = B[0, j] * points[k, 0] + B[1, j] * points[k, 1]
                _with_care(T, arm, q_ref, Q[k : k + 1], flags[k : k + 1])
    return -1
