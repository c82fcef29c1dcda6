"""All solutions of a 6R arm whose axes 2, 3 and 4 are parallel.

Seen along the parallel axes, joints 2 to 4 only shift the wrist across them and turn it by one angle phi. The
component along them fixes joints 1 and 5, phi and joint 6 follow like a wrist's two turns, and a planar
two-link arm is left. Sources: Hawkins 2013 (Universal Robots); Elias and Wen 2022 (three parallel axes).
"""

from __future__ import annotations

import math

import numpy as np

from urdf_ik._kernels import layout
from urdf_ik._kernels.batch import OUT_ROWS, PAIRS, spread, store
from urdf_ik._kernels.compile import inlined, kernel, step
from urdf_ik._kernels.layout import (
    ALONG,
    BLOCK,
    COS_ALPHA,
    COS_FIRST,
    OFFSET,
    ROWS,
    SIN_ALPHA,
    SIN_FIRST,
    TURN_3,
    TURN_4,
    A,
    D,
)
from urdf_ik._kernels.linked_angles import linked_roots, sharpen_roots
from urdf_ik._kernels.polynomials import root_gap
from urdf_ik._kernels.refine import accept
from urdf_ik._kernels.subproblems import (
    elbow,
    free_turn,
    is_double,
    swing_to_offset,
    unit,
    unturn,
    wrist_bend,
    wrist_turns,
)
from urdf_ik._kernels.target import load, project_rotation, to_frame_1
from urdf_ik._kernels.thresholds import ALMOST_FREE, NEAR, NEAR_BY_ARM, NEAR_BY_SINE, ROUNDING
from urdf_ik._kernels.trig import atan2, wrap

INTERSECTING_56, GENERAL = 0, 1


@step
def seen_along(x, y, z, arm, c1, s1):
    """A vector of frame 1 before joint 1 turns, in the frame whose z is the parallel axes' direction."""
    x, y = unturn(x, y, c1, s1)
    y, z = unturn(y, z, arm[COS_ALPHA], arm[SIN_ALPHA])
    return x, y, z


@step
def forearm(arm, c5, s5):
    """Step from axis 4 to the origin of frame 6, across the parallel axes, before the turn phi."""
    return arm[A + 3] + arm[A + 4] * c5, arm[COS_FIRST] * arm[A + 4] * s5 - arm[SIN_FIRST] * arm[D + 3]


@inlined
def branches(W, out, m, arm):
    """Both elbows of one shoulder and wrist, for a block of poses, as ``batch.store`` reads them."""
    ca, sa, cb, sb = arm[COS_FIRST], arm[SIN_FIRST], arm[COS_ALPHA + 4], arm[SIN_ALPHA + 4]
    edge, reach = arm[layout.EDGE], arm[layout.REACH] * arm[layout.REACH] * 1e-2
    scale = 1.0 / (arm[layout.SIZE] * arm[layout.SIZE])
    upper, lower, side = arm[A + 1], arm[A + 2], arm[TURN_3]
    for i in range(m):
        px, py, pz = W[9, i], W[10, i], W[11, i]
        k = (arm[COS_ALPHA] * pz - arm[ALONG]) / arm[SIN_ALPHA]
        c1, s1, _, m1 = swing_to_offset(px, py, k, W[13, i])
        m00, m10, m20 = seen_along(W[0, i], W[3, i], W[6, i], arm, c1, s1)
        m01, m11, m21 = seen_along(W[1, i], W[4, i], W[7, i], arm, c1, s1)
        m02, m12, m22 = seen_along(W[2, i], W[5, i], W[8, i], arm, c1, s1)
        c5, s5, m3 = wrist_bend(m02, m12, m22, ca, sa, cb, sb, W[15, i])
        cf, sf, c6, s6, fixed, turned = wrist_turns(
            m00, m10, m20, m01, m11, m21, m02, m12, m22, c5, s5, ca, sa, cb, sb, False, 1.0, 0.0
        )
        qx, qy = unturn(px, py, c1, s1)
        qx -= arm[A]
        ox, oy, oz = qx, arm[COS_ALPHA] * qy + arm[SIN_ALPHA] * pz, arm[COS_ALPHA] * pz - arm[SIN_ALPHA] * qy
        fx, fy = forearm(arm, c5, s5)
        ux, uy = ox - (cf * fx - sf * fy), oy - (sf * fx + cf * fy)
        c2, s2, c3, s3, m2 = elbow(ux, uy, upper, lower, side, W[14, i])
        c2d, s2d, _, _, _ = elbow(ux, uy, upper, lower, side, -W[14, i])
        wx, wy = upper + lower * c3, side * lower * s3
        ex, ey, ez = c2 * wx - s2 * wy - ux, s2 * wx + c2 * wy - uy, oz - arm[ALONG]
        dx, dy = c2d * wx + s2d * wy - ux, s2d * wx - c2d * wy - uy
        error = (max(ex * ex + ey * ey, dx * dx + dy * dy) + ez * ez) * scale
        m1 *= scale
        arm1, arm2 = (px * px + py * py) * scale, (ux * ux + uy * uy) * scale
        # Where the wrist leaves phi free, another phi may bring the elbow within reach.
        lost = (m1 < -edge) | (m3 < -edge) | ((m2 < -edge) & (fixed > edge))
        doubt = (min(m1, m2) <= edge) | (min(m3, fixed) <= edge) | (min(arm1, arm2) <= edge)
        doubt = doubt | (not (error + turned <= reach))
        phi, t2, t3, t2d = atan2(sf, cf), atan2(s2, c2), atan2(s3, c3), atan2(s2d, c2d)
        q1, q5 = wrap(atan2(s1, c1) - arm[OFFSET]), wrap(atan2(s5, c5) - arm[OFFSET + 4])
        q6 = wrap(atan2(s6, c6) - arm[OFFSET + 5])
        state = 0.0 if lost else (2.0 if doubt else 1.0)
        out[0, i] = q1
        out[1, i] = wrap(t2 - arm[OFFSET + 1])
        out[2, i] = wrap(t3 - arm[OFFSET + 2])
        out[3, i] = wrap(wrap(arm[TURN_4] * (phi - t2 - side * t3) - arm[OFFSET + 3]))
        out[4, i], out[5, i], out[6, i] = q5, q6, state
        out[7, i] = q1
        out[8, i] = wrap(t2d - arm[OFFSET + 1])
        out[9, i] = wrap(-t3 - arm[OFFSET + 2])
        out[10, i] = wrap(wrap(arm[TURN_4] * (phi - t2d + side * t3) - arm[OFFSET + 3]))
        out[11, i], out[12, i], out[13, i] = q5, q6, state
        out[14, i], out[15, i], out[16, i] = m1, m2 if (fixed > edge) | (m2 > 0.0) else 0.0, m3
        out[17, i], out[18, i], out[19, i] = fixed, arm1, arm2


@kernel
def shoulder_roots(X, arm, roots):
    """First angles of an arm whose axes 5 and 6 do not meet, as (cos, sin) rows of ``roots``; returns how many.

    Direction and height of axis 6 along the parallel axes give cos t5 and sin t5, both affine in (cos, sin) of
    the first angle; their squares add up to one.
    """
    ca, sa, cb, sb = arm[COS_FIRST], arm[SIN_FIRST], arm[COS_ALPHA + 4], arm[SIN_ALPHA + 4]
    c0, cc, cs = _along(X[2], X[5], X[8], arm)
    s0, sc, ss = _along(X[9], X[10], X[11], arm)
    w = -1.0 / (sa * sb)
    c0, cc, cs = (c0 - ca * cb) * w, cc * w, cs * w
    w = 1.0 / (sa * arm[A + 4])
    s0, sc, ss = (s0 - arm[ALONG]) * w, sc * w, ss * w
    return linked_roots(c0, cc, cs, s0, sc, ss, roots)


@kernel
def sharpen_shoulder_roots(X, arm, roots, found):
    """Make the roots exact at which axis 6 is almost parallel to axes 2-4; ``roots`` is changed in place."""
    ca, sa, cb, sb = arm[COS_FIRST], arm[SIN_FIRST], arm[COS_ALPHA + 4], arm[SIN_ALPHA + 4]
    _, dc, ds = _along(X[2], X[5], X[8], arm)
    level, hc, hs = _along(X[9], X[10], X[11], arm)
    w = 1.0 / (sa * arm[A + 4])
    for side in (1.0, -1.0):
        ce, se = unit(side * dc, side * ds)
        mx, my, mz = seen_along(X[2], X[5], X[8], arm, ce, se)
        c5, _, m = wrist_bend(mx, my, mz, ca, sa, cb, sb, 1.0)
        slope = (dc * ce + ds * se) / (sa * sb)
        sharpen_roots(ce, se, c5, m, slope, (level - arm[ALONG]) * w, hc * w, hs * w, roots, found)


@kernel
def _along(x, y, z, arm):
    """Component along the parallel axes as constant, cos t1 and sin t1 coefficients."""
    return arm[COS_ALPHA] * z, -arm[SIN_ALPHA] * y, arm[SIN_ALPHA] * x


@kernel
def solve_with_care(kind, target, arm, q_ref, Q, flags, continuum, beside):
    """One pose near a singularity, at the edge of reach, or of an imperfect arm; adds to its rows.

    ``beside`` lets an imperfect arm's candidates near singularities be followed from starts beside them too.
    Returns 0 where nothing is near a singularity, 1 where a solution, or a place where one might be, is, and 2
    where an imperfect arm all but leaves a joint free.

    A margin within ``fold`` of zero is a double root, of which one branch is kept; a joint that the target
    leaves free (squared arm below ``continuum``) takes ``q_ref``'s value, or zero, or what is nearest to it
    within reach.
    """
    fold, clamp = arm[layout.FOLD], arm[layout.CLAMP]
    near_zone = max(NEAR, NEAR_BY_SINE * arm[layout.IMPERFECTION])
    near_axis = max(NEAR, (NEAR_BY_ARM * arm[layout.IMPERFECTION]) ** 2)
    almost_free = (ALMOST_FREE * arm[layout.IMPERFECTION]) ** 2
    close, loose = False, False
    ca, sa, cb, sb = arm[COS_FIRST], arm[SIN_FIRST], arm[COS_ALPHA + 4], arm[SIN_ALPHA + 4]
    scale = 1.0 / (arm[layout.SIZE] * arm[layout.SIZE])
    X, q, roots = np.empty(12), np.empty(6), np.empty((4, 2))
    to_frame_1(target, arm, X)
    px, py, pz = X[9], X[10], X[11]
    found = 0
    if kind == GENERAL:
        found = shoulder_roots(X, arm, roots)
        sharpen_shoulder_roots(X, arm, roots, found)
    slack = 0.5 * clamp * arm[layout.SIZE] * arm[layout.SIZE]
    k = (arm[COS_ALPHA] * pz - arm[ALONG]) / arm[SIN_ALPHA]
    arm1 = (px * px + py * py) * scale
    for b in range(8):
        front, up, flip = arm[layout.SIGNS + 3 * b], arm[layout.SIGNS + 3 * b + 1], arm[layout.SIGNS + 3 * b + 2]
        marks = 0
        m1 = 1.0
        if kind == GENERAL:
            root = (0 if front > 0.0 else 2) + (0 if flip > 0.0 else 1)
            if root >= found:
                continue
            c1, s1 = roots[root, 0], roots[root, 1]
            m1 = root_gap(roots, found, root)
        else:
            c1, s1, _, m1 = swing_to_offset(px, py, k, front)
            m1 *= scale
            close = close or abs(m1) < near_zone or arm1 < near_axis
            if m1 < -clamp:
                continue
            if m1 <= fold or arm1 <= fold:
                marks |= layout.SHOULDER
            double1 = is_double(m1, arm1, ROUNDING)
            if front < 0.0 and (double1 or arm1 <= continuum):
                continue
            if double1:
                c1, s1, _, _ = swing_to_offset(px, py, k, 0.0)
            if arm1 <= continuum:
                c1, s1 = math.cos(q_ref[0] + arm[OFFSET]), math.sin(q_ref[0] + arm[OFFSET])
        m00, m10, m20 = seen_along(X[0], X[3], X[6], arm, c1, s1)
        m01, m11, m21 = seen_along(X[1], X[4], X[7], arm, c1, s1)
        m02, m12, m22 = seen_along(X[2], X[5], X[8], arm, c1, s1)
        qx, qy = unturn(px, py, c1, s1)
        qx -= arm[A]
        ox, oy, oz = qx, arm[COS_ALPHA] * qy + arm[SIN_ALPHA] * pz, arm[COS_ALPHA] * pz - arm[SIN_ALPHA] * qy
        if kind == GENERAL:
            c5, s5 = unit((ca * cb - m22) / (sa * sb), (oz - arm[ALONG]) / (sa * arm[A + 4]))
            m3 = 1.0
        else:
            c5, s5, m3 = wrist_bend(m02, m12, m22, ca, sa, cb, sb, flip)
        close = close or abs(m3) < near_zone
        if m3 < -clamp:
            continue
        cf, sf, c6, s6, fixed, _ = wrist_turns(
            m00, m10, m20, m01, m11, m21, m02, m12, m22, c5, s5, ca, sa, cb, sb, False, 1.0, 0.0
        )
        if fixed <= fold or m3 <= fold:
            marks |= layout.WRIST
        if kind != GENERAL:
            double3 = is_double(m3, fixed, ROUNDING / (sb * sb))
            if flip < 0.0 and (double3 or fixed <= continuum):
                continue
            if double3:
                c5, s5, _ = wrist_bend(m02, m12, m22, ca, sa, cb, sb, 0.0)
                cf, sf, c6, s6, fixed, _ = wrist_turns(
                    m00, m10, m20, m01, m11, m21, m02, m12, m22, c5, s5, ca, sa, cb, sb, False, 1.0, 0.0
                )
        fx, fy = forearm(arm, c5, s5)
        if fixed <= continuum:
            _, _, c6, s6, _, _ = wrist_turns(
                m00, m10, m20, m01, m11, m21, m02, m12, m22, c5, s5, ca, sa, cb, sb, True, 1.0, 0.0
            )
            aligned = 1.0 if ca * cb - sa * sb * c5 > 0.0 else -1.0
            wanted = aligned * (math.atan2(s6, c6) - arm[OFFSET + 5] - q_ref[5])
            phi = free_turn(wanted, ox, oy, fx, fy, arm[A + 1] + arm[A + 2], arm[A + 1] - arm[A + 2], slack)
            if math.isnan(phi):
                continue
            cf, sf, c6, s6, _, _ = wrist_turns(
                m00, m10, m20, m01, m11, m21, m02, m12, m22, c5, s5, ca, sa, cb, sb, True, math.cos(phi), math.sin(phi)
            )
        ux, uy = ox - (cf * fx - sf * fy), oy - (sf * fx + cf * fy)
        c2, s2, c3, s3, m2 = elbow(ux, uy, arm[A + 1], arm[A + 2], arm[TURN_3], up)
        arm2 = (ux * ux + uy * uy) * scale
        near = min(abs(m1), min(abs(m2), abs(m3))) < near_zone or min(fixed, min(arm1, arm2)) < near_axis
        close = close or near
        loose = loose or min(fixed, min(arm1, arm2)) < almost_free
        # A root next to an aligned wrist is rough, and phi with it: let Newton's method decide.
        if m2 < (-max(clamp, 1e-9 / (fixed + 1e-8)) if kind == GENERAL else -clamp):
            continue
        if m2 <= fold or arm2 <= fold:
            marks |= layout.ELBOW
        double2 = is_double(m2, arm2, ROUNDING / (2.0 * arm[A + 1] * arm[A + 2] * scale))
        if up < 0.0 and (double2 or arm2 <= continuum):
            continue
        if double2:
            c2, s2, c3, s3, _ = elbow(ux, uy, arm[A + 1], arm[A + 2], arm[TURN_3], 0.0)
        if arm2 <= continuum:
            c2, s2 = math.cos(q_ref[1] + arm[OFFSET + 1]), math.sin(q_ref[1] + arm[OFFSET + 1])
        t2, t3 = math.atan2(s2, c2), math.atan2(s3, c3)
        t4 = arm[TURN_4] * (math.atan2(sf, cf) - t2 - arm[TURN_3] * t3)
        q[0] = wrap(math.atan2(s1, c1) - arm[OFFSET])
        q[1] = wrap(t2 - arm[OFFSET + 1])
        q[2] = wrap(t3 - arm[OFFSET + 2])
        q[3] = wrap(wrap(t4 - arm[OFFSET + 3]))
        q[4] = wrap(math.atan2(s5, c5) - arm[OFFSET + 4])
        q[5] = wrap(math.atan2(s6, c6) - arm[OFFSET + 5])
        accept(arm, target, q, b, marks, near, beside, Q, flags)
    return 2 if loose else (1 if close else 0)


@kernel
def elbow_distances(kind, arm, rotation, point, distances):
    """How far apart each shoulder and wrist would bring axes 2 and 4 [m], to ``distances`` (4,); NaN: there is none.

    The target is given in frame 1, as rotation (3, 3) and point (3,).
    """
    ca, sa, cb, sb = arm[COS_FIRST], arm[SIN_FIRST], arm[COS_ALPHA + 4], arm[SIN_ALPHA + 4]
    X, roots = np.empty(12), np.empty((4, 2))
    X[:9], X[9:] = rotation.ravel(), point
    found = shoulder_roots(X, arm, roots) if kind == GENERAL else 4
    k = (arm[COS_ALPHA] * X[11] - arm[ALONG]) / arm[SIN_ALPHA]
    for i in range(found):
        m1, m3 = 0.0, 0.0
        if kind == GENERAL:
            c1, s1 = roots[i, 0], roots[i, 1]
        else:
            c1, s1, _, m1 = swing_to_offset(X[9], X[10], k, 1.0 - 2.0 * (i // 2))
        m00, m10, m20 = seen_along(X[0], X[3], X[6], arm, c1, s1)
        m01, m11, m21 = seen_along(X[1], X[4], X[7], arm, c1, s1)
        m02, m12, m22 = seen_along(X[2], X[5], X[8], arm, c1, s1)
        ox, oy, oz = seen_along(X[9], X[10], X[11], arm, c1, s1)
        if kind == GENERAL:
            c5, s5 = unit((ca * cb - m22) / (sa * sb), (oz - arm[ALONG]) / (sa * arm[A + 4]))
        else:
            c5, s5, m3 = wrist_bend(m02, m12, m22, ca, sa, cb, sb, 1.0 - 2.0 * (i % 2))
        cf, sf, _, _, _, _ = wrist_turns(
            m00, m10, m20, m01, m11, m21, m02, m12, m22, c5, s5, ca, sa, cb, sb, False, 1.0, 0.0
        )
        fx, fy = forearm(arm, c5, s5)
        if m1 >= 0.0 and m3 >= -arm[layout.CLAMP]:
            distances[i] = math.hypot(ox - arm[A] - (cf * fx - sf * fy), oy - (sf * fx + cf * fy))


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
            care[i] = W[12, i] > arm[layout.EXACT_ROTATION] or kind == GENERAL
        if kind != GENERAL:
            for pair in range(1 if single else PAIRS):
                columns, wanted = spread(W, arm, pair, 2, m, single)
                branches(W, out, columns, arm)
                store(out, pair, 2, start, wanted, single, care, Q, flags)
        for i in range(m):
            if care[i]:
                project_rotation(T[start + i], proper)
                Q[start + i, :, :] = math.nan
                flags[start + i, :] = 0
                solve_with_care(kind, proper, arm, q_ref, Q[start + i], flags[start + i], arm[layout.CONTINUUM], True)
    return -1


@kernel
def solve_intersecting_56(T, arm, q_ref, Q, flags):
    """Axes 5 and 6 intersect; see ``solve``."""
    return solve(INTERSECTING_56, T, arm, q_ref, Q, flags)


@kernel
def solve_general_wrist(T, arm, q_ref, Q, flags):
    """Axes 5 and 6 are skew; see ``solve``."""
    return solve(GENERAL, T, arm, q_ref, Q, flags)
