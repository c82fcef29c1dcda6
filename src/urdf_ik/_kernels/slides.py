"""Six joints of which some slide, in closed form: three turns that make the orientation, three joints the position.

Two cases. A spherical wrist: the first three joints, of any kind, place the point where the last three axes meet (see
``slide_position``), and the wrist does the rest. Three slides: they turn nothing, so the three turning joints follow
from the orientation, wherever they stand, and the slides from a linear system. What is found is polished and verified
on the arm as written, as for few joints.
"""

from __future__ import annotations

import math

import numpy as np

from urdf_ik._kernels import few_joints as few
from urdf_ik._kernels import layout
from urdf_ik._kernels import slide_position as step
from urdf_ik._kernels.compile import kernel
from urdf_ik._kernels.general_6r import sort_columns
from urdf_ik._kernels.refine import damped_step
from urdf_ik._kernels.slide_position import cross, dot, rotated, solve_position, turned
from urdf_ik._kernels.subproblems import wrist_bend, wrist_turns
from urdf_ik._kernels.target import check_target, project_rotation
from urdf_ik._kernels.thresholds import AROUND, CONVERGED, ROUGH
from urdf_ik._kernels.trig import wrap

# Behind a few joints' numbers: a position step; whether there is one; which joints make the orientation; frames on the
# first and the last of them at q = 0, as columns; cosine and sine of the angles between them and the bend at q = 0; the
# wrist's centre in the tip [share of size].
STEP = few.FIRST_VARIANT
BY_WRIST, TURNS = STEP + step.LENGTH, STEP + 26
FIRST_FRAME, LAST_FRAME, ANGLES, IN_TIP = STEP + 29, STEP + 38, STEP + 47, STEP + 52
LENGTH = STEP + 55


@kernel
def _wrist(arm, E, sign, q_ref, q):
    """The three turns that make the rotation ``E`` (3, 3), measured from home, into their places of ``q`` (6,).

    ``sign`` chooses the flip. Returns whether there is one: not beyond the reach of a wrist with oblique axes, nor
    twice where the target leaves the first turn free; that is then shared with the last one as ``q_ref`` would have it.
    """
    first = arm[FIRST_FRAME : FIRST_FRAME + 9].reshape(3, 3)
    last = arm[LAST_FRAME : LAST_FRAME + 9].reshape(3, 3)
    ca, sa, cb, sb, home = arm[ANGLES], arm[ANGLES + 1], arm[ANGLES + 2], arm[ANGLES + 3], arm[ANGLES + 4]
    a, b, c = int(arm[TURNS]), int(arm[TURNS + 1]), int(arm[TURNS + 2])
    M = first.T @ E @ last
    bend_c, bend_s, margin = wrist_bend(M[0, 2], M[1, 2], M[2, 2], ca, sa, cb, sb, sign)
    if margin < -max(ROUGH, arm[layout.CLAMP]):
        return False
    cf, sf, cl, sl, fixed, _ = wrist_turns(
        M[0, 0], M[1, 0], M[2, 0], M[0, 1], M[1, 1], M[2, 1], M[0, 2], M[1, 2], M[2, 2],
        bend_c, bend_s, ca, sa, cb, sb, False, 1.0, 0.0,
    )  # fmt: skip
    if fixed <= arm[layout.CONTINUUM]:
        if sign < 0.0:
            return False
        held = q_ref[a]
        for _ in range(2):
            cf, sf, cl, sl, _, _ = wrist_turns(
                M[0, 0], M[1, 0], M[2, 0], M[0, 1], M[1, 1], M[2, 1], M[0, 2], M[1, 2], M[2, 2],
                bend_c, bend_s, ca, sa, cb, sb, True, math.cos(held), math.sin(held),
            )  # fmt: skip
            aligned = 1.0 if ca * cb - sa * sb * bend_c > 0.0 else -1.0
            held += 0.5 * q_ref[6] * aligned * wrap(math.atan2(sl, cl) - q_ref[c])
    q[a], q[b], q[c] = math.atan2(sf, cf), wrap(math.atan2(bend_s, bend_c) - home), math.atan2(sl, cl)
    return True


@kernel
def _from_home(arm, R):
    """The rotation (3, 3) from the tip's home to ``R`` (3 or 4 rows)."""
    home, E = arm[layout.R_TIP : layout.R_TIP + 9].reshape(3, 3), np.empty((3, 3))
    for c in range(3):
        E[:, c] = rotated(R, home[c])
    return E


@kernel
def _candidate(arm, target, three, sign, q_ref, q):
    """The joint vector of a place of the first three joints and one flip of the wrist; whether there is one."""
    E = _from_home(arm, target)
    for k in range(3):
        slides = arm[STEP + step.SLIDES + k] != 0.0
        if not slides:
            h = arm[STEP + step.DIRECTIONS + 3 * k : STEP + step.DIRECTIONS + 3 * k + 3]
            for c in range(3):
                E[:, c] = turned(E[:, c], h, -three[k])
        q[k] = three[k] * arm[layout.SIZE] if slides else wrap(three[k])
    return _wrist(arm, E, sign, q_ref, q)


@kernel
def by_wrist(arm, target, q_ref, Q, flags):
    """Solutions by the place of the wrist, then both its flips; returns whether a joint was all but free in it."""
    size = arm[layout.SIZE]
    p = rotated(target, arm[IN_TIP : IN_TIP + 3]) + target[:3, 3] / size
    ref, out, q = np.empty(3), np.empty((step.MOST, step.COLUMNS)), np.empty(6)
    for k in range(3):
        ref[k] = q_ref[k] / size if arm[few.SLIDING + k] else q_ref[k]
    three, doubt = np.empty(3), False
    for c in range(solve_position(arm[STEP : STEP + step.LENGTH], p, ref, out)):
        free = int(out[c, step.FREE_JOINTS])
        for flip in range(2):
            sign = 1.0 if flip == 0 else -1.0
            if not _candidate(arm, target, out[c, :3], sign, q_ref, q):
                continue
            origin = few.DOUBTFUL if free or arm[layout.IMPERFECTION] > 0.0 else few.COMPUTED
            sigma = few.take(arm, target, q, origin, arm[layout.REACH], Q, flags)
            if free == 0 or sigma <= arm[layout.SINGULAR]:
                continue
            doubt = True
            for k in range(2):
                for a in range(2 * AROUND if free & (1 << k) else 0):
                    three[:] = out[c, :3]
                    three[k] = math.pi * a / AROUND
                    if _candidate(arm, target, three, sign, q_ref, q):
                        few.take(arm, target, q, few.SEARCHED, CONVERGED, Q, flags)
    return doubt


@kernel
def _by_slides(arm, target, q_ref, Q, flags):
    """Solutions of an arm with three slides: the turns by the orientation, the slides by a linear system."""
    T, e, delta, q = np.empty((4, 4)), np.zeros(6), np.empty(3), np.empty(6)
    axes, points, J = np.empty((6, 3)), np.empty((6, 3)), np.zeros((6, 3))
    for flip in range(2):
        q[:] = 0.0
        if not _wrist(arm, _from_home(arm, target), 1.0 if flip == 0 else -1.0, q_ref, q):
            continue
        few.place_few(arm, q, T, axes, points)
        k = 0
        for j in range(6):
            if arm[few.SLIDING + j]:
                J[:3, k] = axes[j]
                k += 1
        e[:3] = target[:3, 3] - T[:3, 3]
        # At a singularity, where slides come into a plane, the shortest.
        damped_step(J, e, CONVERGED, delta)
        k = 0
        for j in range(6):
            if arm[few.SLIDING + j]:
                q[j] = delta[k]
                k += 1
        few.take(arm, target, q, few.DOUBTFUL, arm[layout.REACH], Q, flags)


@kernel
def name_singular(arm, Q, flags):
    """Mark those singular solutions as the wrist's whose three turns have axes in a plane."""
    T, axes, points = np.empty((4, 4)), np.empty((6, 3)), np.empty((6, 3))
    a, b, c = int(arm[TURNS]), int(arm[TURNS + 1]), int(arm[TURNS + 2])
    for k in range(Q.shape[0]):
        if flags[k] & layout.OTHER:
            few.place_few(arm, Q[k], T, axes, points)
            if abs(dot(axes[a], cross(axes[b], axes[c]))) <= arm[layout.SINGULAR]:
                flags[k] = layout.VALID | layout.WRIST


@kernel
def solve(T, arm, q_ref, Q, flags):
    """All solutions of poses ``T`` (m, 4, 4) to ``Q`` (m, B, 6) and ``flags`` (m, B).

    Arguments and result as those of ``spherical_wrist.solve``.
    """
    proper = np.empty((4, 4))
    for i in range(T.shape[0]):
        if not check_target(T[i]) <= arm[layout.ROTATION]:
            return i
        project_rotation(T[i], proper)
        Q[i, :, :] = math.nan
        flags[i, :] = 0
        if arm[BY_WRIST]:
            by_wrist(arm, proper, q_ref, Q[i], flags[i])
        else:
            _by_slides(arm, proper, q_ref, Q[i], flags[i])
        name_singular(arm, Q[i], flags[i])
        sort_columns(Q[i], flags[i])
    return -1
