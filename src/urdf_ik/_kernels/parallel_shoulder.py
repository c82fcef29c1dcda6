"""All solutions of a 6R arm whose axes 1, 2 and 3 are parallel.

Joints 1 to 3 move the wrist across the parallel direction h and turn it about h by psi; they change neither its
height along h nor the angle under which it sees h. Seen from the last axis, h is known: its angle to axis 5 and the
height of the last axis are two equations in joints 4 and 6. Joint 5 and psi follow by plain turns, and a planar
two-link arm is left. Where a pair of the wrist's axes meets or is parallel the two equations fall apart into two
steps; else they end in a quartic in joint 6. Source: Elias and Wen 2022 (three parallel axes, subproblem 6).
"""

from __future__ import annotations

import math

import numpy as np

from urdf_ik._kernels import layout
from urdf_ik._kernels.compile import inlined, kernel, step
from urdf_ik._kernels.general_6r import search_beside
from urdf_ik._kernels.layout import COS_ALPHA, OFFSET, SIN_ALPHA, A, D
from urdf_ik._kernels.linked_angles import linked_roots, sharpen_roots
from urdf_ik._kernels.polynomials import root_gap
from urdf_ik._kernels.refine import accept, holds
from urdf_ik._kernels.subproblems import (
    elbow,
    free_turn,
    is_double,
    swing_to_offset,
    swing_to_tilt,
    unit,
    unturn,
    wrist_bend,
)
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
    ROUNDING,
)
from urdf_ik._kernels.trig import wrap

INTERSECTING_56, PARALLEL_56, INTERSECTING_45, PARALLEL_45, GENERAL = 0, 1, 2, 3, 4
# How often another joint 6 is tried where two joints are free and the elbow asks for a part of their range only.
_PLACES = 24


@step
def through_joint(x, y, z, c, s, ca, sa):
    """A row vector times Rz(t) Rx(alpha): a vector of one frame, seen from the next."""
    x, y = unturn(x, y, c, s)
    y, z = unturn(y, z, ca, sa)
    return x, y, z


@step
def seen_from_5(mx, my, mz, arm, c6, s6):
    """The parallel direction (mx, my, mz) of frame 6, in frame 5 after its joint has turned."""
    x, y = unturn(mx, my, c6, -s6)
    y, z = unturn(y, mz, arm[COS_ALPHA + 4], -arm[SIN_ALPHA + 4])
    return x, y, z


@kernel
def level_of(X, arm):
    """Height of the last axis above axis 4's foot, along axis 3 [m], for the target ``X`` (12,) in frame 1."""
    return arm[COS_ALPHA] * arm[COS_ALPHA + 1] * X[11] - arm[D + 1] - arm[COS_ALPHA + 2] * arm[D + 2]


@step
def wrist_angles(kind, mx, my, mz, level, arm, front, flip, c6, s6):
    """Joints 4 and 6 of one branch: cos and sin of both, and the margins of their two roots.

    ``level`` is the height of the last axis above axis 4's foot [m]; ``c6, s6`` the quartic's root, which the other
    kinds ignore. With u the angle between axis 5 and the parallel direction (mx, my, mz) of frame 6:
    cos u = ca3 ca4 - sa3 sa4 cos t4 = ca5 mz + sa5 (mx sin t6 + my cos t6) and
    level = a4 sa3 sin t4 + d5 cos u + a5 (mx cos t6 - my sin t6).
    """
    a4, a5, d5 = arm[A + 3], arm[A + 4], arm[D + 3]
    ca3, sa3, ca4, sa4 = arm[COS_ALPHA + 2], arm[SIN_ALPHA + 2], arm[COS_ALPHA + 3], arm[SIN_ALPHA + 3]
    ca5, sa5 = arm[COS_ALPHA + 4], arm[SIN_ALPHA + 4]
    c4, s4, first, second = 1.0, 0.0, 1.0, 1.0
    if kind == INTERSECTING_56:
        square = a4 * a4 + d5 * d5 * sa4 * sa4
        c4, s4, _, first = swing_to_offset(-a4, -d5 * sa4, (level - d5 * ca3 * ca4) / sa3, front)
        first /= square
        wx, wy, wz = through_joint(0.0, sa3, ca3, c4, s4, ca4, sa4)
        c6, s6, second = swing_to_tilt(mx, my, mz, ca5, sa5, wz, wx * wx + wy * wy, flip)
    elif kind == PARALLEL_56:
        c4, s4, first = wrist_bend(mx, my, ca5 * mz, ca4, sa4, ca3, sa3, front)
        c6, s6, _, second = swing_to_offset(my, mx, (level - a4 * sa3 * s4) / a5, flip)
    elif kind == INTERSECTING_45:
        x, y = a5 * my - d5 * sa5 * mx, d5 * sa5 * my + a5 * mx
        c6, s6, _, first = swing_to_offset(x, y, level - d5 * ca5 * mz, front)
        first /= a5 * a5 + d5 * d5 * sa5 * sa5
        vx, vy, vz = seen_from_5(mx, my, mz, arm, c6, s6)
        c4, s4, second = wrist_bend(vx, vy, vz, ca4, sa4, ca3, sa3, flip)
    elif kind == PARALLEL_45:
        c6, s6, first = swing_to_tilt(mx, my, mz, ca5, sa5, ca3 * ca4, sa3 * sa3, front)
        vx, _, vz = seen_from_5(mx, my, mz, arm, c6, s6)
        s4 = (level - d5 * vz - a5 * vx) / (a4 * sa3)
        second = (1.0 - s4) * (1.0 + s4)
        c4, s4 = unit(flip * math.sqrt(max(second, 0.0)), s4)
    else:
        vx, _, vz = seen_from_5(mx, my, mz, arm, c6, s6)
        c4, s4 = unit((ca3 * ca4 - vz) / (sa3 * sa4), (level - d5 * vz - a5 * vx) / (a4 * sa3))
    return c4, s4, c6, s6, first, second


@kernel
def wrist_roots(mx, my, mz, level, arm, roots):
    """Angles of joint 6 of an arm of the general kind, as (cos, sin) rows of ``roots`` (4, 2); returns how many."""
    a4, a5, d5 = arm[A + 3], arm[A + 4], arm[D + 3]
    ca3, sa3, ca4, sa4 = arm[COS_ALPHA + 2], arm[SIN_ALPHA + 2], arm[COS_ALPHA + 3], arm[SIN_ALPHA + 3]
    ca5, sa5 = arm[COS_ALPHA + 4], arm[SIN_ALPHA + 4]
    w, h = -1.0 / (sa3 * sa4), 1.0 / (a4 * sa3)
    c0, cc, cs = (ca5 * mz - ca3 * ca4) * w, sa5 * my * w, sa5 * mx * w
    s0 = (level - d5 * ca5 * mz) * h
    sc, ss = -(d5 * sa5 * my + a5 * mx) * h, -(d5 * sa5 * mx - a5 * my) * h
    found = linked_roots(c0, cc, cs, s0, sc, ss, roots)
    # Where axis 5 is almost parallel to axes 1-3.
    for side in (1.0, -1.0):
        ce, se = unit(side * my, side * mx)
        vx, vy, vz = seen_from_5(mx, my, mz, arm, ce, se)
        c4, _, m = wrist_bend(vx, vy, vz, ca4, sa4, ca3, sa3, 1.0)
        sharpen_roots(ce, se, c4, m, -(cc * ce + cs * se), s0, sc, ss, roots, found)
    return found


@step
def turn_of_hand(X, arm, c4, s4, c5, s5, c6, s6):
    """The turn psi about the parallel axes that joints 1 to 3 make together, from all of the rotation: cos, sin."""
    turn = arm[COS_ALPHA] * arm[COS_ALPHA + 1]
    ca3, sa3, ca4, sa4 = arm[COS_ALPHA + 2], arm[SIN_ALPHA + 2], arm[COS_ALPHA + 3], arm[SIN_ALPHA + 3]
    ca5, sa5 = arm[COS_ALPHA + 4], arm[SIN_ALPHA + 4]
    x0, x1, x2 = through_joint(1.0, 0.0, 0.0, c4, s4, ca4, sa4)
    x0, x1, x2 = through_joint(x0, x1, x2, c5, s5, ca5, sa5)
    x0, x1 = unturn(x0, x1, c6, s6)
    y0, y1, y2 = through_joint(0.0, ca3, -sa3, c4, s4, ca4, sa4)
    y0, y1, y2 = through_joint(y0, y1, y2, c5, s5, ca5, sa5)
    y0, y1 = unturn(y0, y1, c6, s6)
    y0, y1, y2 = turn * y0, turn * y1, turn * y2
    c = X[0] * x0 + X[1] * x1 + X[2] * x2 + X[3] * y0 + X[4] * y1 + X[5] * y2
    s = X[3] * x0 + X[4] * x1 + X[5] * x2 - X[0] * y0 - X[1] * y1 - X[2] * y2
    return unit(c, s)


@step
def hand_across(arm, c4, s4):
    """From axis 3 to the origin of frame 5, across the parallel axes, before the turn psi [m]."""
    turn = arm[COS_ALPHA] * arm[COS_ALPHA + 1]
    ca4, sa4, a4, d5 = arm[COS_ALPHA + 3], arm[SIN_ALPHA + 3], arm[A + 3], arm[D + 3]
    x = a4 * c4 + d5 * sa4 * s4
    y, z = a4 * s4 - d5 * sa4 * c4, arm[D + 2] + d5 * ca4
    return arm[A + 2] + x, turn * (arm[COS_ALPHA + 2] * y - arm[SIN_ALPHA + 2] * z)


@step
def last_across(arm, c4, s4, c5, s5):
    """From axis 3 to the origin of frame 6, across the parallel axes, before the turn psi [m]."""
    turn = arm[COS_ALPHA] * arm[COS_ALPHA + 1]
    ca4, sa4, a5 = arm[COS_ALPHA + 3], arm[SIN_ALPHA + 3], arm[A + 4]
    x0, x1, _ = through_joint(1.0, 0.0, 0.0, c4, s4, ca4, sa4)
    y0, y1, _ = through_joint(0.0, arm[COS_ALPHA + 2], -arm[SIN_ALPHA + 2], c4, s4, ca4, sa4)
    fx, fy = hand_across(arm, c4, s4)
    return fx + a5 * (c5 * x0 + s5 * x1), fy + turn * a5 * (c5 * y0 + s5 * y1)


@kernel
def solve_with_care(kind, target, arm, q_ref, Q, flags, continuum, beside):
    """One pose; adds to its rows of ``Q`` and ``flags``.

    ``beside`` lets an imperfect arm's candidates near singularities be followed from starts beside them too.
    Returns 0 where nothing is near a singularity, 1 where a solution, or a place where one might be, is, and 2
    where an imperfect arm all but leaves a joint free.

    A joint that the target leaves free (squared arm below ``continuum``) takes ``q_ref``'s value, or zero, or what
    is nearest to it within the elbow's reach.
    """
    fold, clamp = arm[layout.FOLD], arm[layout.CLAMP]
    near_zone = max(NEAR, NEAR_BY_SINE * arm[layout.IMPERFECTION])
    near_axis = max(NEAR, (NEAR_BY_ARM * arm[layout.IMPERFECTION]) ** 2)
    almost_free = (ALMOST_FREE * arm[layout.IMPERFECTION]) ** 2
    rough = max(clamp, ROUGH)
    close, loose, crowded, free = False, False, False, False
    size = arm[layout.SIZE]
    scale = 1.0 / (size * size)
    slack = 0.5 * clamp * size * size
    side, turn = arm[COS_ALPHA], arm[COS_ALPHA] * arm[COS_ALPHA + 1]
    ca3, sa3, ca4, sa4 = arm[COS_ALPHA + 2], arm[SIN_ALPHA + 2], arm[COS_ALPHA + 3], arm[SIN_ALPHA + 3]
    upper, lower = arm[A], arm[A + 1]
    X, q, roots = np.empty(12), np.empty(6), np.empty((4, 2))
    to_frame_1(target, arm, X)
    mx, my, mz = turn * X[6], turn * X[7], turn * X[8]
    level = level_of(X, arm)
    arm6 = mx * mx + my * my
    c6h, s6h = math.cos(q_ref[5] + arm[OFFSET + 5]), math.sin(q_ref[5] + arm[OFFSET + 5])
    free6 = arm6 <= continuum
    close, loose = arm6 < near_axis, arm6 < almost_free
    found = 4
    if kind == GENERAL:
        found = 1 if free6 else wrist_roots(mx, my, mz, level, arm, roots)
    for b in range(8):
        front, up, flip = arm[layout.SIGNS + 3 * b], arm[layout.SIGNS + 3 * b + 1], arm[layout.SIGNS + 3 * b + 2]
        root = (0 if front > 0.0 else 2) + (0 if flip > 0.0 else 1)
        if root >= found:
            continue
        c6, s6 = (c6h, s6h) if free6 else (roots[root, 0], roots[root, 1])
        c4, s4, c6, s6, m1, m3 = wrist_angles(kind, mx, my, mz, level, arm, front, flip, c6, s6)
        if kind == GENERAL:
            m1 = root_gap(roots, found, root)
            crowded = crowded or m1 < ROOTS_CROWDED
        close = close or min(abs(m1), abs(m3)) < near_zone
        if m1 < -clamp or m3 < -max(rough, ROUGH_BY_MARGIN / (max(m1, 0.0) + 1e-12)):
            continue
        if kind == INTERSECTING_56 and is_double(m1, 1.0, ROUNDING):
            # Of two signs that stand for the same root the positive one is kept, as zero.
            if front < 0.0:
                continue
            c4, s4, c6, s6, m1, m3 = wrist_angles(kind, mx, my, mz, level, arm, 0.0, flip, c6, s6)
        if free6:
            c6, s6 = c6h, s6h
        wx, wy, _ = through_joint(0.0, sa3, ca3, c4, s4, ca4, sa4)
        vx, vy, vz = seen_from_5(mx, my, mz, arm, c6, s6)
        c5, s5 = unit(wx * vx + wy * vy, wy * vx - wx * vy)
        arm5 = wx * wx + wy * wy
        free5 = arm5 <= continuum
        marks = layout.WRIST if free5 or free6 or min(m1, m3) <= fold else 0
        for place in range(_PLACES if free5 and free6 else 1):
            if place > 0:
                c6, s6 = unturn(c6, s6, math.cos(2.0 * math.pi / _PLACES), math.sin(2.0 * math.pi / _PLACES))
            t5, t6 = math.atan2(s5, c5), math.atan2(s6, c6)
            if free5:
                t5 = q_ref[4] + arm[OFFSET + 4]
            cf, sf = turn_of_hand(X, arm, c4, s4, math.cos(t5), math.sin(t5), c6, s6)
            # From axis 1 to axis 3 across the parallel axes, by way of the last point that no free joint moves.
            ox, oy = X[9], X[10]
            if free6 and not arm5 < ALMOST_ALIGNED:
                fx, fy = last_across(arm, c4, s4, c5, s5)
            else:
                ox -= arm[A + 4] * (X[0] * c6 - X[1] * s6)
                oy -= arm[A + 4] * (X[3] * c6 - X[4] * s6)
                fx, fy = hand_across(arm, c4, s4)
            if free6 or arm5 < ALMOST_ALIGNED:
                given = math.atan2(sf, cf)
                # Rounding alone may put the elbow out of reach here.
                psi = free_turn(given, ox, oy, fx, fy, upper + lower, upper - lower, slack)
                if math.isnan(psi):
                    continue
                # The free joint turns with or against psi.
                if arm5 < ALMOST_ALIGNED:
                    t5 -= turn * math.copysign(1.0, vz) * (psi - given)
                else:
                    t6 -= turn * math.copysign(1.0, mz) * (psi - given)
                cf, sf = math.cos(psi), math.sin(psi)
            ux, uy = ox - (cf * fx - sf * fy), oy - (sf * fx + cf * fy)
            c1, s1, c2, s2, m2 = elbow(ux, uy, upper, lower, side, up)
            arm1 = (ux * ux + uy * uy) * scale
            near = min(abs(m1), min(abs(m2), abs(m3))) < near_zone or min(arm1, min(arm5, arm6)) < near_axis
            close = close or near
            loose = loose or min(arm1, arm5) < almost_free
            free = free or min(arm1, min(arm5, arm6)) < ALMOST_ALIGNED
            # Next to a fold or an aligned wrist the angles are rough: let Newton's method decide.
            least = max(min(m1, min(m3, arm5)), 0.0)
            if m2 < -max(rough, (1e-9 if kind == GENERAL else ROUGH_BY_MARGIN) / (least + 1e-12)):
                continue
            if m2 <= fold or arm1 <= fold:
                marks |= layout.ELBOW
            if arm1 <= continuum:
                c1, s1 = math.cos(q_ref[0] + arm[OFFSET]), math.sin(q_ref[0] + arm[OFFSET])
            t1, t2 = math.atan2(s1, c1), math.atan2(s2, c2)
            q[0] = wrap(t1 - arm[OFFSET])
            q[1] = wrap(t2 - arm[OFFSET + 1])
            q[2] = _wrapped(turn * (math.atan2(sf, cf) - t1 - side * t2) - arm[OFFSET + 2])
            q[3] = wrap(math.atan2(s4, c4) - arm[OFFSET + 3])
            q[4] = _wrapped(t5 - arm[OFFSET + 4])
            q[5] = _wrapped(t6 - arm[OFFSET + 5])
            sure = min(m1, min(m2, m3)) >= -clamp and (free5 or free6 or arm5 >= ALMOST_ALIGNED)
            if sure or holds(arm, target, q):
                accept(arm, target, q, b, marks, near, beside, Q, flags)
            break
    # Two roots of the quartic are so close that both may have led to the same solution.
    if crowded and not free and arm[layout.IMPERFECTION] <= arm[layout.EXACT_STRUCTURE]:
        search_beside(arm, target, Q, flags, False)
    return 2 if loose else (1 if close else 0)


@kernel
def elbow_distances(kind, X, arm, distances):
    """How far apart each wrist would bring axes 1 and 3 [m], to ``distances`` (4,); NaN: there is none.

    ``X`` (12,): the target in frame 1, rotation and point.
    """
    roots = np.empty((4, 2))
    turn = arm[COS_ALPHA] * arm[COS_ALPHA + 1]
    mx, my, mz, level = turn * X[6], turn * X[7], turn * X[8], level_of(X, arm)
    found = wrist_roots(mx, my, mz, level, arm, roots) if kind == GENERAL else 4
    for i in range(found):
        front, flip = 1.0 - 2.0 * (i // 2), 1.0 - 2.0 * (i % 2)
        c4, s4, c6, s6, m1, m3 = wrist_angles(kind, mx, my, mz, level, arm, front, flip, roots[i, 0], roots[i, 1])
        wx, wy, _ = through_joint(
            0.0, arm[SIN_ALPHA + 2], arm[COS_ALPHA + 2], c4, s4, arm[COS_ALPHA + 3], arm[SIN_ALPHA + 3]
        )
        vx, vy, _ = seen_from_5(mx, my, mz, arm, c6, s6)
        c5, s5 = unit(wx * vx + wy * vy, wy * vx - wx * vy)
        cf, sf = turn_of_hand(X, arm, c4, s4, c5, s5, c6, s6)
        fx, fy = last_across(arm, c4, s4, c5, s5)
        if min(m1, m3) >= -arm[layout.CLAMP]:
            distances[i] = math.hypot(X[9] - (cf * fx - sf * fy), X[10] - (sf * fx + cf * fy))


@step
def _wrapped(a):
    """An angle up to a few turns off in (-pi, pi]."""
    return wrap(wrap(wrap(a)))


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
def solve_intersecting_45(T, arm, q_ref, Q, flags):
    """Axes 4 and 5 intersect; see ``solve``."""
    return solve(INTERSECTING_45, T, arm, q_ref, Q, flags)


@kernel
def solve_parallel_45(T, arm, q_ref, Q, flags):
    """Axes 4 and 5 are parallel; see ``solve``."""
    return solve(PARALLEL_45, T, arm, q_ref, Q, flags)


@kernel
def solve_general_wrist(T, arm, q_ref, Q, flags):
    """Axes 4, 5 and 6 are skew; see ``solve``."""
    return solve(GENERAL, T, arm, q_ref, Q, flags)
