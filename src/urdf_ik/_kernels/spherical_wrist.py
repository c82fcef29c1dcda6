"""All solutions of a 6R arm whose last three axes meet: up to four places of the first three joints, two wrists."""

from __future__ import annotations

import math

import numpy as np

from urdf_ik._kernels import layout
from urdf_ik._kernels import wrist_position as shoulder
from urdf_ik._kernels.batch import OUT_ROWS, PAIRS, spread, store
from urdf_ik._kernels.compile import inlined, kernel, step
from urdf_ik._kernels.layout import BLOCK, COS_ALPHA, OFFSET, ROWS, SIN_ALPHA
from urdf_ik._kernels.polynomials import root_gap
from urdf_ik._kernels.refine import accept
from urdf_ik._kernels.subproblems import is_double, unturn, wrist_bend, wrist_turns
from urdf_ik._kernels.target import load, project_rotation, to_frame_1
from urdf_ik._kernels.thresholds import ALMOST_FREE, NEAR, NEAR_BY_ARM, NEAR_BY_SINE, ROUGH, ROUNDING
from urdf_ik._kernels.trig import atan2, wrap


@step
def wrist_rotation(r0, r3, r6, arm, c1, s1, c2, s2, c3, s3):
    """One column of the target's rotation, seen from frame 3."""
    x, y = unturn(r0, r3, c1, s1)
    y, z = unturn(y, r6, arm[COS_ALPHA], arm[SIN_ALPHA])
    x, y = unturn(x, y, c2, s2)
    y, z = unturn(y, z, arm[COS_ALPHA + 1], arm[SIN_ALPHA + 1])
    x, y = unturn(x, y, c3, s3)
    y, z = unturn(y, z, arm[COS_ALPHA + 2], arm[SIN_ALPHA + 2])
    return x, y, z


@inlined
def branches(kind, W, out, m, arm):
    """Both wrists of one place of the first three joints, for a block of poses, as ``batch.store`` reads them."""
    ca, sa, cb, sb = arm[COS_ALPHA + 3], arm[SIN_ALPHA + 3], arm[COS_ALPHA + 4], arm[SIN_ALPHA + 4]
    edge, reach = arm[layout.EDGE], arm[layout.REACH] * arm[layout.REACH] * 1e-2
    for i in range(m):
        c1, s1, c2, s2, c3, s3, m1, m2, arm1, arm2, error = shoulder.position(
            kind, W[9, i], W[10, i], W[11, i], arm, W[13, i], W[14, i], False, 1.0, 0.0, False, 1.0, 0.0, 1.0, 0.0
        )
        m00, m10, m20 = wrist_rotation(W[0, i], W[3, i], W[6, i], arm, c1, s1, c2, s2, c3, s3)
        m01, m11, m21 = wrist_rotation(W[1, i], W[4, i], W[7, i], arm, c1, s1, c2, s2, c3, s3)
        m02, m12, m22 = wrist_rotation(W[2, i], W[5, i], W[8, i], arm, c1, s1, c2, s2, c3, s3)
        c5, s5, m3 = wrist_bend(m02, m12, m22, ca, sa, cb, sb, W[15, i])
        c4, s4, c6, s6, fixed, turned = wrist_turns(
            m00, m10, m20, m01, m11, m21, m02, m12, m22, c5, s5, ca, sa, cb, sb, False, 1.0, 0.0
        )
        c4f, s4f, c6f, s6f, _, turned_too = wrist_turns(
            m00, m10, m20, m01, m11, m21, m02, m12, m22, c5, -s5, ca, sa, cb, sb, False, 1.0, 0.0
        )
        lost = (m1 < -edge) | (m2 < -edge) | (m3 < -edge)
        doubt = (min(m1, m2) <= edge) | (min(m3, fixed) <= edge) | (min(arm1, arm2) <= edge)
        doubt = doubt | (not (error + max(turned, turned_too) <= reach))
        q1, q2 = wrap(atan2(s1, c1) - arm[OFFSET]), wrap(atan2(s2, c2) - arm[OFFSET + 1])
        q3, bend = wrap(atan2(s3, c3) - arm[OFFSET + 2]), atan2(s5, c5)
        state = 0.0 if lost else (2.0 if doubt else 1.0)
        out[0, i], out[1, i], out[2, i] = q1, q2, q3
        out[3, i] = wrap(atan2(s4, c4) - arm[OFFSET + 3])
        out[4, i] = wrap(bend - arm[OFFSET + 4])
        out[5, i] = wrap(atan2(s6, c6) - arm[OFFSET + 5])
        out[6, i] = state
        out[7, i], out[8, i], out[9, i] = q1, q2, q3
        out[10, i] = wrap(atan2(s4f, c4f) - arm[OFFSET + 3])
        out[11, i] = wrap(-bend - arm[OFFSET + 4])
        out[12, i] = wrap(atan2(s6f, c6f) - arm[OFFSET + 5])
        out[13, i] = state
        out[14, i], out[15, i], out[16, i] = m1, m2, m3
        out[17, i], out[18, i], out[19, i] = fixed, arm1, arm2


@kernel
def solve_with_care(kind, target, arm, q_ref, Q, flags, continuum, beside):
    """One pose near a singularity, at the edge of reach, or of an imperfect arm; adds to its rows.

    ``beside`` lets an imperfect arm's candidates near singularities be followed from starts beside them too.
    Returns 0 where nothing is near a singularity, 1 where a solution, or a place where one might be, is, and 2
    where an imperfect arm all but leaves a joint free.

    A margin within ``fold`` of zero is a double root, of which one branch is kept; a joint that the target
    leaves free (squared arm below ``continuum``) takes ``q_ref``'s value, or zero.
    """
    fold, clamp = arm[layout.FOLD], arm[layout.CLAMP]
    near_zone = max(NEAR, NEAR_BY_SINE * arm[layout.IMPERFECTION])
    near_axis = max(NEAR, (NEAR_BY_ARM * arm[layout.IMPERFECTION]) ** 2)
    almost_free = (ALMOST_FREE * arm[layout.IMPERFECTION]) ** 2
    close, loose = False, False
    scale = 1.0 / (arm[layout.SIZE] * arm[layout.SIZE])
    ca, sa, cb, sb = arm[COS_ALPHA + 3], arm[SIN_ALPHA + 3], arm[COS_ALPHA + 4], arm[SIN_ALPHA + 4]
    X, q, roots = np.empty(12), np.empty(6), np.empty((4, 2))
    to_frame_1(target, arm, X)
    found = 4
    if kind == shoulder.GENERAL:
        found = shoulder.general_roots(X[9], X[10], X[11], arm, roots)
    c1h, s1h = math.cos(q_ref[0] + arm[OFFSET]), math.sin(q_ref[0] + arm[OFFSET])
    c2h, s2h = math.cos(q_ref[1] + arm[OFFSET + 1]), math.sin(q_ref[1] + arm[OFFSET + 1])
    for b in range(8):
        if b // 2 >= found:
            break
        front, up, flip = arm[layout.SIGNS + 3 * b], arm[layout.SIGNS + 3 * b + 1], arm[layout.SIGNS + 3 * b + 2]
        c3r, s3r = roots[b // 2, 0], roots[b // 2, 1]
        c1, s1, c2, s2, c3, s3, m1, m2, arm1, arm2, _ = shoulder.position(
            kind, X[9], X[10], X[11], arm, front, up, False, 1.0, 0.0, False, 1.0, 0.0, c3r, s3r
        )
        if kind == shoulder.GENERAL:
            m1 = root_gap(roots, found, b // 2)
        near = min(abs(m1), abs(m2)) < near_zone or min(arm1, arm2) < near_axis
        close = close or near
        loose = loose or min(arm1, arm2) < almost_free
        if m1 < -clamp or m2 < -clamp:
            continue
        marks = 0
        free1, free2 = arm1 <= continuum, arm2 <= continuum
        by_height = kind == shoulder.PARALLEL_23
        if (m1 <= fold and kind != shoulder.GENERAL) or free1 or (free2 and not by_height):
            marks |= layout.SHOULDER
        if m2 <= fold or (free2 and by_height):
            marks |= layout.ELBOW
        if kind != shoulder.GENERAL:
            # Of two signs that stand for the same root, or the same continuum, the positive one is kept, as zero.
            swung = arm1 if by_height else (min(arm1, arm2) if kind == shoulder.INTERSECTING_12 else 1.0)
            double1 = is_double(m1, swung, ROUNDING)
            links = 2.0 * arm[layout.A + 1] * arm[layout.RHO] * scale if by_height else 1.0
            double2 = is_double(m2, arm2 if by_height else 1.0, ROUNDING / links)
            if front < 0.0 and (double1 or free1 or (free2 and not by_height)):
                continue
            if up < 0.0 and (double2 or (free2 and by_height)):
                continue
            front, up = (0.0 if double1 else front), (0.0 if double2 else up)
        if free1 or free2 or front == 0.0 or up == 0.0:
            c1, s1, c2, s2, c3, s3, _, _, _, _, _ = shoulder.position(
                kind, X[9], X[10], X[11], arm, front, up, free1, c1h, s1h, free2, c2h, s2h, c3r, s3r
            )
        m00, m10, m20 = wrist_rotation(X[0], X[3], X[6], arm, c1, s1, c2, s2, c3, s3)
        m01, m11, m21 = wrist_rotation(X[1], X[4], X[7], arm, c1, s1, c2, s2, c3, s3)
        m02, m12, m22 = wrist_rotation(X[2], X[5], X[8], arm, c1, s1, c2, s2, c3, s3)
        c5, s5, m3 = wrist_bend(m02, m12, m22, ca, sa, cb, sb, flip)
        near = near or abs(m3) < near_zone
        close = close or near
        # The quartic's roots are rough where it is ill-conditioned: let Newton's method decide.
        if m3 < (-max(clamp, ROUGH) if kind == shoulder.GENERAL else -clamp):
            continue
        c4, s4, c6, s6, fixed, _ = wrist_turns(
            m00, m10, m20, m01, m11, m21, m02, m12, m22, c5, s5, ca, sa, cb, sb, False, 1.0, 0.0
        )
        if fixed <= fold or m3 <= fold:
            marks |= layout.WRIST
        double3 = is_double(m3, fixed, ROUNDING / (sb * sb))
        if flip < 0.0 and (double3 or fixed <= continuum):
            continue
        if double3:
            c5, s5, _ = wrist_bend(m02, m12, m22, ca, sa, cb, sb, 0.0)
            c4, s4, c6, s6, fixed, _ = wrist_turns(
                m00, m10, m20, m01, m11, m21, m02, m12, m22, c5, s5, ca, sa, cb, sb, False, 1.0, 0.0
            )
        if fixed <= continuum:
            # The sum (or difference) of the turns is what counts: share its distance from the reference.
            a4 = q_ref[3] + arm[OFFSET + 3]
            for _ in range(2):
                c4, s4 = math.cos(a4), math.sin(a4)
                c4, s4, c6, s6, fixed, _ = wrist_turns(
                    m00, m10, m20, m01, m11, m21, m02, m12, m22, c5, s5, ca, sa, cb, sb, True, c4, s4
                )
                rest = wrap(wrap(math.atan2(s6, c6) - arm[OFFSET + 5]) - q_ref[5])
                aligned = 1.0 if ca * cb - sa * sb * c5 > 0.0 else -1.0
                a4 += 0.5 * q_ref[6] * aligned * rest
        q[0] = wrap(math.atan2(s1, c1) - arm[OFFSET])
        q[1] = wrap(math.atan2(s2, c2) - arm[OFFSET + 1])
        q[2] = wrap(math.atan2(s3, c3) - arm[OFFSET + 2])
        q[3] = wrap(math.atan2(s4, c4) - arm[OFFSET + 3])
        q[4] = wrap(math.atan2(s5, c5) - arm[OFFSET + 4])
        q[5] = wrap(math.atan2(s6, c6) - arm[OFFSET + 5])
        near = near or fixed < near_axis
        loose = loose or fixed < almost_free
        close = close or near
        accept(arm, target, q, b, marks, near, beside, Q, flags)
    return 2 if loose else (1 if close else 0)


@inlined
def solve(kind, T, arm, q_ref, Q, flags):
    """All solutions of poses ``T`` (m, 4, 4) to ``Q`` (m, 8, 6) and ``flags`` (m, 8).

    ``q_ref`` (7,): the joint vector that representatives are taken near, and 1 where it was given, 0 where it
    stands for zeros. Returns the index of the first target that is no pose, -1 where all are.
    """
    W, out = np.empty((ROWS, BLOCK)), np.empty((OUT_ROWS, BLOCK))
    proper = np.empty((4, 4))
    care = np.empty(BLOCK, np.bool_)
    single = T.shape[0] == 1
    for start in range(0, T.shape[0], BLOCK):
        m = min(BLOCK, T.shape[0] - start)
        load(W, T, start, m, arm)
        for i in range(m):
            if not W[12, i] <= arm[layout.ROTATION]:
                return start + i
            care[i] = W[12, i] > arm[layout.EXACT_ROTATION] or kind == shoulder.GENERAL
        if kind != shoulder.GENERAL:
            for pair in range(1 if single else PAIRS):
                columns, wanted = spread(W, arm, pair, 1, m, single)
                branches(kind, W, out, columns, arm)
                store(out, pair, 1, start, wanted, single, care, Q, flags)
        for i in range(m):
            if care[i]:
                project_rotation(T[start + i], proper)
                Q[start + i, :, :] = math.nan
                flags[start + i, :] = 0
                solve_with_care(kind, proper, arm, q_ref, Q[start + i], flags[start + i], arm[layout.CONTINUUM], True)
    return -1


@kernel
def solve_parallel_23(T, arm, q_ref, Q, flags):
    """Axes 2 and 3 parallel; see ``solve``."""
    return solve(shoulder.PARALLEL_23, T, arm, q_ref, Q, flags)


@kernel
def solve_intersecting_12(T, arm, q_ref, Q, flags):
    """Axes 1 and 2 intersect; see ``solve``."""
    return solve(shoulder.INTERSECTING_12, T, arm, q_ref, Q, flags)


@kernel
def solve_parallel_12(T, arm, q_ref, Q, flags):
    """Axes 1 and 2 parallel; see ``solve``."""
    return solve(shoulder.PARALLEL_12, T, arm, q_ref, Q, flags)


@kernel
def solve_general_shoulder(T, arm, q_ref, Q, flags):
    """No relation among the first three axes; see ``solve``."""
    return solve(shoulder.GENERAL, T, arm, q_ref, Q, flags)
