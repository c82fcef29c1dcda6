"""All solutions of a 6R arm whose axes 2, 3 and 4 meet in a point C.

Only joint 1 moves C as seen from the base, only joints 5 and 6 as seen from the tip: C runs on a circle about
axis 1 and on a torus about axes 5 and 6. Its height along axis 6 and its distance from it are two equations, each
affine in (cos, sin) of joint 1 and of joint 5. Where axes 5 and 6 meet (the torus is a sphere) or are parallel (a
plane) one of them holds joint 1 alone; else they end in a quartic in joint 1. Joint 6 follows by a plain turn, and
joints 2 to 4 give the rotation that is left like a wrist. Source: Pieper 1968, whose decoupling does not ask where
in the arm the three axes are.
"""

from __future__ import annotations

import math

import numpy as np

from urdf_ik._kernels import layout
from urdf_ik._kernels.compile import inlined, kernel, step
from urdf_ik._kernels.general_6r import search_beside
from urdf_ik._kernels.layout import CENTRE, CENTRE_5, COS_ALPHA, OFFSET, SIN_ALPHA, A
from urdf_ik._kernels.linked_angles import linked_roots
from urdf_ik._kernels.polynomials import root_gap
from urdf_ik._kernels.refine import accept, holds
from urdf_ik._kernels.subproblems import nearest_between, swing_to_offset, unit, unturn, wrist_bend, wrist_turns
from urdf_ik._kernels.target import check_target, project_rotation, to_frame_1
from urdf_ik._kernels.thresholds import (
    ALMOST_ALIGNED,
    ALMOST_FREE,
    NEAR,
    NEAR_BY_ARM,
    NEAR_BY_SINE,
    ROOTS_CROWDED,
    ROUGH,
    ROUGH_BY_MARGIN,
)
from urdf_ik._kernels.trig import wrap

INTERSECTING_56, PARALLEL_56, GENERAL = 0, 1, 2


@step
def height_of_centre(X, arm):
    """Height of C along axis 6 above the origin of frame 6 as constant, cos t1 and sin t1 coefficients [m]."""
    x, y, z = arm[CENTRE], arm[CENTRE + 1], arm[CENTRE + 2]
    h0 = X[8] * (z - X[11]) - X[2] * X[9] - X[5] * X[10]
    return h0, X[2] * x + X[5] * y, X[5] * x - X[2] * y


@step
def square_of_centre(X, arm):
    """Squared distance of C from the origin of frame 6 as constant, cos t1 and sin t1 coefficients [m^2]."""
    x, y, z = arm[CENTRE], arm[CENTRE + 1], arm[CENTRE + 2]
    s0 = x * x + y * y + X[9] * X[9] + X[10] * X[10] + (z - X[11]) * (z - X[11])
    return s0, -2.0 * (X[9] * x + X[10] * y), -2.0 * (X[10] * x - X[9] * y)


@step
def first_angle(kind, X, arm, front):
    """Joint 1 where one equation holds it alone: cos, sin, margin, squared arm that fixes it (both dimensionless)."""
    gx, gy, gz = arm[CENTRE_5], arm[CENTRE_5 + 1], arm[CENTRE_5 + 2]
    w = 1.0 / (arm[CENTRE] * arm[CENTRE] + arm[CENTRE + 1] * arm[CENTRE + 1])
    if kind == INTERSECTING_56:
        k, kc, ks = square_of_centre(X, arm)
        k, kc, ks = 0.5 * (gx * gx + gy * gy + gz * gz - k), 0.5 * kc, 0.5 * ks
        w /= arm[layout.SIZE] * arm[layout.SIZE]
    else:
        k, kc, ks = height_of_centre(X, arm)
        k = arm[COS_ALPHA + 4] * gz - k
    c, s, _, margin = swing_to_offset(-ks, kc, k, front)
    return c, s, margin * w, (kc * kc + ks * ks) * w


@step
def centre_seen_from_6(X, arm, c1, s1):
    """C in frame 6 for a given joint 1 [m]."""
    x, y = unturn(arm[CENTRE], arm[CENTRE + 1], c1, -s1)
    x, y, z = x - X[9], y - X[10], arm[CENTRE + 2] - X[11]
    return (
        X[0] * x + X[3] * y + X[6] * z,
        X[1] * x + X[4] * y + X[7] * z,
        X[2] * x + X[5] * y + X[8] * z,
    )


@step
def last_angles(kind, ux, uy, uz, arm, up):
    """Joints 5 and 6 that have C at (ux, uy, uz) of frame 6: cos and sin of both, margin [share of squared radius].

    C is Rz(-t5) g = f in frame 5, and e = Rx(-alpha5) (f - a5 x) in frame 6 before joint 6 turns.
    """
    gx, gy, gz = arm[CENTRE_5], arm[CENTRE_5 + 1], arm[CENTRE_5 + 2]
    a5, ca5, sa5 = arm[A + 4], arm[COS_ALPHA + 4], arm[SIN_ALPHA + 4]
    square = gx * gx + gy * gy
    rr = ux * ux + uy * uy
    if kind == INTERSECTING_56:
        fy = (ca5 * gz - uz) / sa5
        ey = ca5 * fy + sa5 * gz
        margin = (rr - ey * ey) / square
        fx = up * math.sqrt(max(margin, 0.0) * square)
        ex = fx
    elif kind == PARALLEL_56:
        r = math.sqrt(square)
        w = 0.5 / (a5 * r)
        near, far = (rr - (a5 - r) * (a5 - r)) * w, ((a5 + r) * (a5 + r) - rr) * w
        margin = near * far
        fx, fy = 0.5 * r * (far - near), up * r * math.sqrt(max(margin, 0.0))
        ex, ey = ((r - a5) * (r + a5) - rr) / (2.0 * a5), ca5 * fy
    else:
        margin = 1.0
        fy = (ca5 * gz - uz) / sa5
        ex = (square + gz * gz - a5 * a5 - rr - uz * uz) / (2.0 * a5)
        fx, ey = ex + a5, ca5 * fy + sa5 * gz
    c5, s5 = unit(gx * fx + gy * fy, gy * fx - gx * fy)
    c6, s6 = unit(ex * ux + ey * uy, ey * ux - ex * uy)
    return c5, s5, c6, s6, margin


@kernel
def first_roots(X, arm, roots):
    """Angles of joint 1 of an arm of the general kind, as (cos, sin) rows of ``roots`` (4, 2); returns how many."""
    gx, gy, gz = arm[CENTRE_5], arm[CENTRE_5 + 1], arm[CENTRE_5 + 2]
    a5, ca5, sa5 = arm[A + 4], arm[COS_ALPHA + 4], arm[SIN_ALPHA + 4]
    r = math.sqrt(gx * gx + gy * gy)
    h, hc, hs = height_of_centre(X, arm)
    k, kc, ks = square_of_centre(X, arm)
    w, v = -1.0 / (2.0 * a5 * r), -1.0 / (sa5 * r)
    return linked_roots((k - r * r - gz * gz - a5 * a5) * w, kc * w, ks * w, (h - ca5 * gz) * v, hc * v, hs * v, roots)


@step
def middle_rotation(x, y, z, arm, c1, s1):
    """One column of a rotation in frame 1, seen from frame 2 before joint 2 turns."""
    x, y = unturn(x, y, c1, s1)
    y, z = unturn(y, z, arm[COS_ALPHA], arm[SIN_ALPHA])
    return x, y, z


@kernel
def rotation_of_4(X, arm, c5, s5, c6, s6, M):
    """Rotation of frame 4 in frame 1, for given joints 5 and 6, to ``M`` (9,) by rows."""
    for i in range(3):
        x, y = unturn(X[3 * i], X[3 * i + 1], c6, -s6)
        y, z = unturn(y, X[3 * i + 2], arm[COS_ALPHA + 4], -arm[SIN_ALPHA + 4])
        x, y = unturn(x, y, c5, -s5)
        y, z = unturn(y, z, arm[COS_ALPHA + 3], -arm[SIN_ALPHA + 3])
        M[3 * i], M[3 * i + 1], M[3 * i + 2] = x, y, z


@kernel
def free_first(kind, X, arm, wanted, slack):
    """The angle of a free joint 1 nearest to ``wanted`` that leaves joint 5 a solution; NaN: there is none."""
    gx, gy, gz = arm[CENTRE_5], arm[CENTRE_5 + 1], arm[CENTRE_5 + 2]
    a5, ca5, sa5 = arm[A + 4], arm[COS_ALPHA + 4], arm[SIN_ALPHA + 4]
    r = math.sqrt(gx * gx + gy * gy)
    if kind == INTERSECTING_56:
        h, hc, hs = height_of_centre(X, arm)
        middle, half = ca5 * gz - h, abs(sa5) * r
        return nearest_between(wanted, hc, hs, middle - half, middle + half, slack / arm[layout.SIZE])
    k, kc, ks = square_of_centre(X, arm)
    k -= gz * gz
    return nearest_between(wanted, kc, ks, (a5 - r) * (a5 - r) - k, (a5 + r) * (a5 + r) - k, slack)


@kernel
def reach_of_joint_1(kind, X, arm):
    """Least and greatest value that joint 1 gives the one equation that holds it alone.

    The squared distance of C from the origin of frame 6 [m^2]; of parallel axes 5 and 6 its height along them [m].
    """
    if kind == PARALLEL_56:
        k, kc, ks = height_of_centre(X, arm)
    else:
        k, kc, ks = square_of_centre(X, arm)
    swing = math.hypot(kc, ks)
    return k - swing, k + swing


@kernel
def solve_with_care(kind, target, arm, q_ref, Q, flags, continuum, beside):
    """One pose; adds to its rows of ``Q`` and ``flags``.

    ``beside`` lets an imperfect arm's candidates near singularities be followed from starts beside them too.
    Returns 0 where nothing is near a singularity, 1 where a solution, or a place where one might be, is, and 2
    where an imperfect arm all but leaves a joint free.

    A joint that the target leaves free (squared arm below ``continuum``) takes ``q_ref``'s value, or zero, or what
    is nearest to it within reach.
    """
    fold, clamp = arm[layout.FOLD], arm[layout.CLAMP]
    near_zone = max(NEAR, NEAR_BY_SINE * arm[layout.IMPERFECTION])
    near_axis = max(NEAR, (NEAR_BY_ARM * arm[layout.IMPERFECTION]) ** 2)
    almost_free = (ALMOST_FREE * arm[layout.IMPERFECTION]) ** 2
    rough = max(clamp, ROUGH)
    close, loose, crowded, free = False, False, False, False
    size = arm[layout.SIZE]
    scale = 1.0 / (size * size)
    ca, sa, cb, sb = arm[COS_ALPHA + 1], arm[SIN_ALPHA + 1], arm[COS_ALPHA + 2], arm[SIN_ALPHA + 2]
    X, M, q, roots = np.empty(12), np.empty(9), np.empty(6), np.empty((4, 2))
    to_frame_1(target, arm, X)
    found = first_roots(X, arm, roots) if kind == GENERAL else 4
    for b in range(8):
        front, up, flip = arm[layout.SIGNS + 3 * b], arm[layout.SIGNS + 3 * b + 1], arm[layout.SIGNS + 3 * b + 2]
        if b // 2 >= found:
            break
        marks = 0
        if kind == GENERAL:
            c1, s1, m1, arm1 = roots[b // 2, 0], roots[b // 2, 1], root_gap(roots, found, b // 2), 1.0
            crowded = crowded or m1 < ROOTS_CROWDED
        else:
            c1, s1, m1, arm1 = first_angle(kind, X, arm, front)
            if m1 < fold or arm1 < fold:
                marks |= layout.SHOULDER
        close = close or abs(m1) < near_zone or arm1 < near_axis
        loose = loose or arm1 < almost_free
        if m1 < -clamp:
            continue
        if arm1 <= continuum:
            t1 = free_first(kind, X, arm, q_ref[0] + arm[OFFSET], clamp * size * size)
            if math.isnan(t1):
                continue
            c1, s1 = math.cos(t1), math.sin(t1)
        ux, uy, uz = centre_seen_from_6(X, arm, c1, s1)
        c5, s5, c6, s6, m2 = last_angles(kind, ux, uy, uz, arm, up)
        arm6 = (ux * ux + uy * uy) * scale
        near = min(abs(m1), abs(m2)) < near_zone or min(arm1, arm6) < near_axis
        close = close or near
        loose = loose or arm6 < almost_free
        # Next to a fold, or to an axis that nothing turns about, angles are rough: let Newton's method decide.
        if m2 < -max(rough, ROUGH_BY_MARGIN / (max(min(m1, arm1), 0.0) + 1e-12)):
            continue
        if arm6 <= continuum:
            c6, s6 = math.cos(q_ref[5] + arm[OFFSET + 5]), math.sin(q_ref[5] + arm[OFFSET + 5])
        if m2 <= fold or arm6 <= fold:
            marks |= layout.WRIST
        rotation_of_4(X, arm, c5, s5, c6, s6, M)
        m00, m10, m20 = middle_rotation(M[0], M[3], M[6], arm, c1, s1)
        m01, m11, m21 = middle_rotation(M[1], M[4], M[7], arm, c1, s1)
        m02, m12, m22 = middle_rotation(M[2], M[5], M[8], arm, c1, s1)
        c3, s3, m3 = wrist_bend(m02, m12, m22, ca, sa, cb, sb, flip)
        near = near or abs(m3) < near_zone
        least = max(min(min(m1, m2), min(arm1, arm6)), 0.0)
        if m3 < -max(rough, (1e-9 if kind == GENERAL else ROUGH_BY_MARGIN) / (least + 1e-12)):
            close = close or near
            continue
        c2, s2, c4, s4, fixed, _ = wrist_turns(
            m00, m10, m20, m01, m11, m21, m02, m12, m22, c3, s3, ca, sa, cb, sb, False, 1.0, 0.0
        )
        if fixed <= fold or m3 <= fold:
            marks |= layout.ELBOW
        if fixed <= continuum:
            # The sum (or difference) of the turns is what counts: share its distance from the reference.
            t2 = q_ref[1] + arm[OFFSET + 1]
            for _ in range(2):
                c2, s2 = math.cos(t2), math.sin(t2)
                c2, s2, c4, s4, fixed, _ = wrist_turns(
                    m00, m10, m20, m01, m11, m21, m02, m12, m22, c3, s3, ca, sa, cb, sb, True, c2, s2
                )
                rest = wrap(wrap(math.atan2(s4, c4) - arm[OFFSET + 3]) - q_ref[3])
                t2 += 0.5 * q_ref[6] * (1.0 if ca * cb - sa * sb * c3 > 0.0 else -1.0) * rest
        q[0] = wrap(math.atan2(s1, c1) - arm[OFFSET])
        q[1] = wrap(math.atan2(s2, c2) - arm[OFFSET + 1])
        q[2] = wrap(math.atan2(s3, c3) - arm[OFFSET + 2])
        q[3] = wrap(math.atan2(s4, c4) - arm[OFFSET + 3])
        q[4] = wrap(math.atan2(s5, c5) - arm[OFFSET + 4])
        q[5] = wrap(math.atan2(s6, c6) - arm[OFFSET + 5])
        near = near or fixed < near_axis
        close = close or near
        loose = loose or fixed < almost_free
        free = free or min(fixed, min(arm1, arm6)) < ALMOST_ALIGNED
        if min(m1, min(m2, m3)) >= -clamp or holds(arm, target, q):
            accept(arm, target, q, b, marks, near, beside, Q, flags)
    # Two roots of the quartic are so close that both may have led to the same solution.
    if crowded and not free and arm[layout.IMPERFECTION] <= arm[layout.EXACT_STRUCTURE]:
        search_beside(arm, target, Q, flags, False)
    return 2 if loose else (1 if close else 0)


@inlined
def solve(kind, T, arm, q_ref, Q, flags):
    """All solutions of poses ``T`` (m, 4, 4) to ``Q`` (m, 8, 6) and ``flags`` (m, 8).

    ``q_ref`` (7,): the joint vector that representatives are taken near, and 1 where it was given, 0 where it
    stands for zeros. Returns the index of the first target that is no pose, -1 where all are.
    """
    proper = np.empty((4, 4))
    for i in range(T.shape[0]):
        if not check_target(T[i]) <= arm[layout.ROTATION]:
            return i
        project_rotation(T[i], proper)
        Q[i, :, :] = math.nan
        flags[i, :] = 0
        solve_with_care(kind, proper, arm, q_ref, Q[i], flags[i], arm[layout.CONTINUUM], True)
    return -1


@kernel
def solve_intersecting_56(T, arm, q_ref, Q, flags):
    """Axes 5 and 6 intersect; see ``solve``."""
    return solve(INTERSECTING_56, T, arm, q_ref, Q, flags)


@kernel
def solve_parallel_56(T, arm, q_ref, Q, flags):
    """Axes 5 and 6 are parallel; see ``solve``."""
    return solve(PARALLEL_56, T, arm, q_ref, Q, flags)


@kernel
def solve_general_wrist(T, arm, q_ref, Q, flags):
    """Axes 5 and 6 are skew; see ``solve``."""
    return solve(GENERAL, T, arm, q_ref, Q, flags)
