"""All solutions of an S-R-S arm for given swivel angles; see ``swivel`` for what these are.

The target fixes W, and with it the elbow's bend: |W - S| depends on joint 4 alone (law of cosines). What is left of the
upper arm is a turn about the line SW, the swivel angle. Upper arm and forearm then have known rotations, and each of
the two triples of meeting axes brings its own about in two ways. Subproblems as in ``subproblems``.
"""

from __future__ import annotations

import math

import numpy as np

from urdf_ik._kernels import layout
from urdf_ik._kernels.compile import inlined, kernel, step
from urdf_ik._kernels.layout import BLOCK, ROWS
from urdf_ik._kernels.refine import pose_error
from urdf_ik._kernels.subproblems import is_double, unturn, wrist_bend, wrist_turns
from urdf_ik._kernels.swivel import FORE, FROM_FRAME_5, SHOULDER, TO_FRAME_3, UPPER, WRIST, ZERO_4, place, upper_arm
from urdf_ik._kernels.target import load, project_rotation, to_frame_1
from urdf_ik._kernels.thresholds import ROUNDING
from urdf_ik._kernels.trig import atan2, wrap

_OUT = 14


@step
def times(a00, a01, a02, a10, a11, a12, a20, a21, a22, arm, at):
    """A matrix times the constant one that stands at ``at``."""
    return (
        a00 * arm[at] + a01 * arm[at + 3] + a02 * arm[at + 6],
        a00 * arm[at + 1] + a01 * arm[at + 4] + a02 * arm[at + 7],
        a00 * arm[at + 2] + a01 * arm[at + 5] + a02 * arm[at + 8],
        a10 * arm[at] + a11 * arm[at + 3] + a12 * arm[at + 6],
        a10 * arm[at + 1] + a11 * arm[at + 4] + a12 * arm[at + 7],
        a10 * arm[at + 2] + a11 * arm[at + 5] + a12 * arm[at + 8],
        a20 * arm[at] + a21 * arm[at + 3] + a22 * arm[at + 6],
        a20 * arm[at + 1] + a21 * arm[at + 4] + a22 * arm[at + 7],
        a20 * arm[at + 2] + a21 * arm[at + 5] + a22 * arm[at + 8],
    )


@step
def forearm_column(u0, v0, w0, u1, v1, w1, u2, v2, w2, c4, s4, x, y, z, arm):
    """One column of the target's rotation, seen from frame 5."""
    ex = u0 * x + u1 * y + u2 * z
    ey = v0 * x + v1 * y + v2 * z
    ez = w0 * x + w1 * y + w2 * z
    ex, ey = unturn(ex, ey, c4, s4)
    k = FROM_FRAME_5
    return (
        arm[k] * ex + arm[k + 1] * ey + arm[k + 2] * ez,
        arm[k + 3] * ex + arm[k + 4] * ey + arm[k + 5] * ez,
        arm[k + 6] * ex + arm[k + 7] * ey + arm[k + 8] * ez,
    )


@inlined
def branches(W, swivel, out, arm, up):
    """Both shoulders and both wrists of one elbow, for a block.

    To ``out``: row 0 joint 4, 1-3 and 4-6 joints 1 to 3 of either shoulder, 7-9 and 10-12 joints 5 to 7 of either
    wrist, 13 the state (0 none, 1 valid, 2 in doubt).
    """
    edge, reach = arm[layout.EDGE], arm[layout.REACH] * arm[layout.REACH] * 1e-2
    scale = 1.0 / (arm[layout.SIZE] * arm[layout.SIZE])
    c0, s0 = math.cos(arm[ZERO_4]), math.sin(arm[ZERO_4])
    ca, sa, cb, sb, shift = arm[SHOULDER], arm[SHOULDER + 1], arm[SHOULDER + 2], arm[SHOULDER + 3], arm[SHOULDER + 4]
    cd, sd, ce, se, turn = arm[WRIST], arm[WRIST + 1], arm[WRIST + 2], arm[WRIST + 3], arm[WRIST + 4]
    for i in range(BLOCK):
        cg, sg, u0, v0, w0, u1, v1, w1, u2, v2, w2, m4, _, error = upper_arm(
            W[9, i], W[10, i], W[11, i], swivel[0, i], swivel[1, i], arm, up
        )
        c4, s4 = unturn(cg, sg, c0, s0)
        m00, m01, m02, m10, m11, m12, m20, m21, m22 = times(u0, v0, w0, u1, v1, w1, u2, v2, w2, arm, TO_FRAME_3)
        c2, s2, ms = wrist_bend(m02, m12, m22, ca, sa, cb, sb, 1.0)
        c1, s1, c3, s3, fixed, t1 = wrist_turns(
            m00, m10, m20, m01, m11, m21, m02, m12, m22, c2, s2, ca, sa, cb, sb, False, 1.0, 0.0
        )
        c1f, s1f, c3f, s3f, _, t2 = wrist_turns(
            m00, m10, m20, m01, m11, m21, m02, m12, m22, c2, -s2, ca, sa, cb, sb, False, 1.0, 0.0
        )
        bend = atan2(s2, c2)
        out[1, i], out[2, i], out[3, i] = atan2(s1, c1), wrap(bend - shift), atan2(s3, c3)
        out[4, i], out[5, i], out[6, i] = atan2(s1f, c1f), wrap(-bend - shift), atan2(s3f, c3f)
        m00, m10, m20 = forearm_column(u0, v0, w0, u1, v1, w1, u2, v2, w2, c4, s4, W[0, i], W[3, i], W[6, i], arm)
        m01, m11, m21 = forearm_column(u0, v0, w0, u1, v1, w1, u2, v2, w2, c4, s4, W[1, i], W[4, i], W[7, i], arm)
        m02, m12, m22 = forearm_column(u0, v0, w0, u1, v1, w1, u2, v2, w2, c4, s4, W[2, i], W[5, i], W[8, i], arm)
        c6, s6, mw = wrist_bend(m02, m12, m22, cd, sd, ce, se, 1.0)
        c5, s5, c7, s7, held, t3 = wrist_turns(
            m00, m10, m20, m01, m11, m21, m02, m12, m22, c6, s6, cd, sd, ce, se, False, 1.0, 0.0
        )
        c5f, s5f, c7f, s7f, _, t4 = wrist_turns(
            m00, m10, m20, m01, m11, m21, m02, m12, m22, c6, -s6, cd, sd, ce, se, False, 1.0, 0.0
        )
        bend = atan2(s6, c6)
        out[7, i], out[8, i], out[9, i] = atan2(s5, c5), wrap(bend - turn), atan2(s7, c7)
        out[10, i], out[11, i], out[12, i] = atan2(s5f, c5f), wrap(-bend - turn), atan2(s7f, c7f)
        out[0, i] = atan2(s4, c4)
        lost = (m4 < -edge) | (ms < -edge) | (mw < -edge)
        square = W[9, i] * W[9, i] + W[10, i] * W[10, i]
        aside = square <= edge * (square + W[11, i] * W[11, i])
        doubt = (m4 <= edge) | (min(ms, fixed) <= edge) | (min(mw, held) <= edge) | aside
        doubt = doubt | (not (error * scale + max(t1, t2) + max(t3, t4) <= reach))
        out[13, i] = 0.0 if lost else (2.0 if doubt else 1.0)


@inlined
def store(out, elbow_column, start, m, care, Q, flags):
    """Combine the shoulders and wrists of one elbow; mark poses in doubt."""
    for i in range(m):
        pose, state = start + i, out[13, i]
        care[i] = care[i] or state == 2.0
        for shoulder in range(2):
            for wrist in range(2):
                b = 4 * shoulder + 2 * elbow_column + wrist
                flags[pose, b] = layout.VALID if state == 1.0 else 0
                for j in range(3):
                    Q[pose, b, j] = out[1 + 3 * shoulder + j, i] if state == 1.0 else math.nan
                    Q[pose, b, 4 + j] = out[7 + 3 * wrist + j, i] if state == 1.0 else math.nan
                Q[pose, b, 3] = out[0, i] if state == 1.0 else math.nan


@kernel
def triple_with_care(M, arm, at, flip, refs, given, q):
    """One of the two ways in which three meeting axes bring the rotation ``M`` (3, 3) about, to ``q`` (3,).

    ``at``: where the triple's numbers stand; ``refs``: first and last angle near which a representative is taken,
    ``given``: 1 where they were given. Returns -1 for none, or one that the other way gives, 1 near a singularity,
    else 0.
    """
    fold, clamp = arm[layout.FOLD], arm[layout.CLAMP]
    ca, sa, cb, sb, shift = arm[at], arm[at + 1], arm[at + 2], arm[at + 3], arm[at + 4]
    m00, m01, m02 = M[0, 0], M[0, 1], M[0, 2]
    m10, m11, m12 = M[1, 0], M[1, 1], M[1, 2]
    m20, m21, m22 = M[2, 0], M[2, 1], M[2, 2]
    c, s, margin = wrist_bend(m02, m12, m22, ca, sa, cb, sb, flip)
    if margin < -clamp:
        return -1
    cf, sf, cl, sl, fixed, _ = wrist_turns(
        m00, m10, m20, m01, m11, m21, m02, m12, m22, c, s, ca, sa, cb, sb, False, 1.0, 0.0
    )
    double = is_double(margin, fixed, ROUNDING / (sb * sb))
    if flip < 0.0 and (double or fixed <= arm[layout.CONTINUUM]):
        return -1
    singular = arm[layout.SINGULAR] * arm[layout.SINGULAR]
    marked = 1 if min(margin, fixed) <= max(singular, fold) else 0
    if double:
        c, s, _ = wrist_bend(m02, m12, m22, ca, sa, cb, sb, 0.0)
        cf, sf, cl, sl, fixed, _ = wrist_turns(
            m00, m10, m20, m01, m11, m21, m02, m12, m22, c, s, ca, sa, cb, sb, False, 1.0, 0.0
        )
    if fixed <= arm[layout.CONTINUUM]:
        # The sum (or difference) of the turns is what counts: share its distance from the reference.
        first = refs[0]
        for _ in range(2):
            cf, sf, cl, sl, fixed, _ = wrist_turns(
                m00, m10, m20, m01, m11, m21, m02, m12, m22, c, s, ca, sa, cb, sb, True,
                math.cos(first), math.sin(first),
            )  # fmt: skip
            aligned = 1.0 if ca * cb - sa * sb * c > 0.0 else -1.0
            first += 0.5 * given * aligned * wrap(math.atan2(sl, cl) - refs[1])
    q[0] = wrap(math.atan2(sf, cf))
    q[1] = wrap(math.atan2(s, c) - shift)
    q[2] = wrap(math.atan2(sl, cl))
    return marked


@kernel
def keep_if_new(arm, target, q, b, marks, Q, flags):
    """Keep the candidate ``q`` (7,) of column ``b`` if it reaches the target and is none of those kept before.

    As in ``refine.is_new``, two vectors half way between which the arm still is in the pose are one double root.
    """
    axes, points, T = np.empty((7, 3)), np.empty((7, 3)), np.empty((4, 4))
    prismatic, middle, e = np.zeros(7, np.bool_), np.empty(7), np.empty(6)
    scale = 1.0 / arm[layout.SIZE]
    place(arm, prismatic, q, T, axes, points)
    if not pose_error(target, T, scale, e) <= arm[layout.REACH]:
        return
    for k in range(Q.shape[0]):
        if flags[k] & layout.VALID:
            apart = 0.0
            for j in range(7):
                way = wrap(q[j] - Q[k, j])
                middle[j] = Q[k, j] + 0.5 * way
                apart = max(apart, abs(way))
            if apart <= arm[layout.DUPLICATE]:
                return
            if apart < 1e-3:
                place(arm, prismatic, middle, T, axes, points)
                if pose_error(target, T, scale, e) <= arm[layout.FOLD]:
                    return
    for j in range(7):
        Q[b, j] = q[j]
    flags[b] = layout.VALID | marks


@kernel
def solve_with_care(target, value, arm, q_ref, Q, flags):
    """One pose near a singularity or at the edge of reach, to its rows.

    As in ``spherical_wrist.solve_with_care``: a margin within rounding of zero is a double root, of which one branch
    is kept; axes that the target lets turn against each other take ``q_ref``'s values, or zero.
    """
    X, M, q = np.empty(12), np.empty((3, 3)), np.empty(7)
    to_frame_1(target, arm, X)
    scale = 1.0 / (arm[layout.SIZE] * arm[layout.SIZE])
    singular = arm[layout.SINGULAR] * arm[layout.SINGULAR]
    cp, sp = math.cos(value), math.sin(value)
    square = X[9] * X[9] + X[10] * X[10]
    aside = layout.SHOULDER if square <= singular * (square + X[11] * X[11]) else 0
    for elbow_column in range(2):
        up = 1.0 - 2.0 * elbow_column
        _, _, _, _, _, _, _, _, _, _, _, m4, reach, _ = upper_arm(X[9], X[10], X[11], cp, sp, arm, up)
        if m4 < -arm[layout.CLAMP]:
            continue
        links = 2.0 * arm[UPPER] * arm[FORE] * scale
        double = is_double(m4, max(reach, 0.0) * scale, ROUNDING / links)
        if double and up < 0.0:
            continue
        cg, sg, u0, v0, w0, u1, v1, w1, u2, v2, w2, _, _, _ = upper_arm(
            X[9], X[10], X[11], cp, sp, arm, 0.0 if double else up
        )
        free = m4 <= max(singular, arm[layout.FOLD]) or reach * scale <= singular
        bent = aside | (layout.ELBOW if free else 0)
        c4, s4 = unturn(cg, sg, math.cos(arm[ZERO_4]), math.sin(arm[ZERO_4]))
        q[3] = wrap(math.atan2(s4, c4))
        for shoulder in range(2):
            M[0, 0], M[0, 1], M[0, 2], M[1, 0], M[1, 1], M[1, 2], M[2, 0], M[2, 1], M[2, 2] = times(
                u0, v0, w0, u1, v1, w1, u2, v2, w2, arm, TO_FRAME_3
            )
            marked = triple_with_care(M, arm, SHOULDER, 1.0 - 2.0 * shoulder, q_ref[0:3:2], q_ref[7], q[:3])
            if marked < 0:
                continue
            marks = bent | (layout.SHOULDER if marked else 0)
            for wrist in range(2):
                for j in range(3):
                    M[0, j], M[1, j], M[2, j] = forearm_column(
                        u0, v0, w0, u1, v1, w1, u2, v2, w2, c4, s4, X[j], X[3 + j], X[6 + j], arm
                    )
                marked = triple_with_care(M, arm, WRIST, 1.0 - 2.0 * wrist, q_ref[4:7:2], q_ref[7], q[4:])
                if marked >= 0:
                    b = 4 * shoulder + 2 * elbow_column + wrist
                    keep_if_new(arm, target, q, b, marks | (layout.WRIST if marked else 0), Q, flags)


@kernel
def solve(T, values, arm, q_ref, Q, flags):
    """All solutions of poses ``T`` (m, 4, 4) at swivel angles ``values`` (m,) to ``Q`` (m, 8, 7), ``flags`` (m, 8).

    ``q_ref`` (8,): the joint vector that representatives are taken near, and 1 where it was given, 0 where it stands
    for zeros. Returns the index of the first target that is no pose, -1 where all are.
    """
    W, out, swivel = np.empty((ROWS, BLOCK)), np.empty((_OUT, BLOCK)), np.empty((2, BLOCK))
    proper, care = np.empty((4, 4)), np.empty(BLOCK, np.bool_)
    for start in range(0, T.shape[0], BLOCK):
        m = min(BLOCK, T.shape[0] - start)
        load(W, T, start, m, arm)
        for i in range(m):
            if not W[12, i] <= arm[layout.ROTATION]:
                return start + i
            care[i] = W[12, i] > arm[layout.EXACT_ROTATION]
            swivel[0, i], swivel[1, i] = math.cos(values[start + i]), math.sin(values[start + i])
        # Filled up with the last pose, so that the same instructions handle every one; see ``batch.spread``.
        for i in range(m, BLOCK):
            for r in range(12):
                W[r, i] = W[r, m - 1]
            swivel[0, i], swivel[1, i] = swivel[0, m - 1], swivel[1, m - 1]
        for elbow_column in range(2):
            branches(W, swivel, out, arm, 1.0 - 2.0 * elbow_column)
            store(out, elbow_column, start, m, care, Q, flags)
        for i in range(m):
            if care[i]:
                k = start + i
                project_rotation(T[k], proper)
                Q[k, :, :] = math.nan
                flags[k, :] = 0
                solve_with_care(proper, values[k], arm, q_ref, Q[k], flags[k])
    return -1
