"""Arms near a family: its closed form, corrected for the arm as written, and the elimination where that cannot tell.

The closed form answers for the ideal arm. Given the pose that the ideal arm must take for the arm as written to be
in the target, it answers exactly; that pose differs from the target by what the two arms differ at the solution,
which changes slowly, so putting the first answer's difference into the target makes the second answer better by
about the imperfection, next to folds too. Newton's method then starts close. A branch is decided if Newton's method
must have a single solution there (Kantorovich), or if its margin is clearly negative. A pose with a branch that is
not decided goes on to a closer look, which the elimination has part in. How clear a margin is, is plain where each
angle has a margin of its own; the other kinds are always looked at closely.
"""

from __future__ import annotations

import math

import numpy as np

from urdf_ik._kernels import (
    layout,
    parallel_shoulder,
    spherical_middle,
    spherical_wrist,
    three_parallel,
    wrist_position,
)
from urdf_ik._kernels.batch import OUT_ROWS
from urdf_ik._kernels.compile import inlined, kernel, step
from urdf_ik._kernels.general_6r import complete, count
from urdf_ik._kernels.newton import (
    ANGLES,
    COLUMN_ROWS,
    ERROR,
    LANES,
    LEAST,
    MOVES,
    POINT,
    ROTATION,
    forward,
    newton_columns,
)
from urdf_ik._kernels.refine import is_new, keep, refine, singular_marks
from urdf_ik._kernels.target import check_target, project_rotation, to_frame_1
from urdf_ik._kernels.thresholds import (
    ALMOST_FREE,
    AROUND,
    CLOSE,
    CLOSE_BY,
    CONVERGED,
    CORRECTIONS,
    FAR_OFF,
    FINISHED,
    KANTOROVICH,
    LEVER,
    PATIENCE,
    SETTLED,
    SHORT_BY_DRIFT,
)
from urdf_ik._kernels.trig import wrap

_WRIST, _PARALLEL, _SHOULDER, _MIDDLE = 0, 1, 2, 3
_BRANCHES = 8
_POSES = LANES // _BRANCHES


@inlined
def _closed_form(family, kind, target, arm, q_ref, Q, flags, continuum, beside):
    if family == _WRIST:
        return spherical_wrist.solve_with_care(kind, target, arm, q_ref, Q, flags, continuum, beside)
    if family == _SHOULDER:
        return parallel_shoulder.solve_with_care(kind, target, arm, q_ref, Q, flags, continuum, beside)
    if family == _MIDDLE:
        return spherical_middle.solve_with_care(kind, target, arm, q_ref, Q, flags, continuum, beside)
    return three_parallel.solve_with_care(kind, target, arm, q_ref, Q, flags, continuum, beside)


@inlined
def _ideal(family, kind, W, out, arm):
    """The ideal arm's answers to the columns of ``W``, each for its own branch; see ``branches`` of the families."""
    if family == _WRIST:
        spherical_wrist.branches(kind, W, out, LANES, arm)
    else:
        three_parallel.branches(W, out, LANES, arm)


@inlined
def _correct(W, N, out, arm):
    """Give the ideal arm other targets, in ``W``: those in ``N``, moved by what the two arms differ at its answers."""
    for i in range(LANES):
        q = out[0, i], out[1, i], out[2, i], out[3, i], out[4, i], out[5, i]
        R, p = forward(arm, layout.INNER_FRAMES, q)
        S, o = forward(arm, layout.IDEAL_FRAMES, q)
        # The ideal arm's pose, the inverse of the real one's, and the target.
        e = _row_between(S[0], S[1], S[2], R), _row_between(S[3], S[4], S[5], R), _row_between(S[6], S[7], S[8], R)
        x, y, z = N[POINT, i] - p[0], N[POINT + 1, i] - p[1], N[POINT + 2, i] - p[2]
        for r in range(3):
            for c in range(3):
                W[3 * r + c, i] = (
                    e[r][0] * N[ROTATION + c, i] + e[r][1] * N[ROTATION + 3 + c, i] + e[r][2] * N[ROTATION + 6 + c, i]
                )
            W[9 + r, i] = o[r] + (e[r][0] * x + e[r][1] * y + e[r][2] * z)


@step
def _row_between(a, b, c, R):
    """The row (a, b, c) times the transposed of ``R`` (9)."""
    return a * R[0] + b * R[1] + c * R[2], a * R[3] + b * R[4] + c * R[5], a * R[6] + b * R[7] + c * R[8]


@inlined
def _fill(W, N, X, arm, first):
    """A pose in frame 1 (12,) and the signs of its branches to eight columns from ``first``."""
    for b in range(_BRANCHES):
        for r in range(12):
            W[r, first + b] = X[r]
            N[ROTATION + r, first + b] = X[r]
        for r in range(3):
            W[13 + r, first + b] = arm[layout.SIGNS + 3 * b + r]


@inlined
def _steepness(family, arm):
    """How fast the margins of shoulder, elbow and wrist change with the joint vector of the correction, per rad.

    A shoulder's squared length changes by up to four times what the pose changes by; a wrist's by that over the square
    of the sine of its last twist; an elbow's, by the law of cosines, by that times the distance between its ends, of
    which the least is the last number.
    """
    upper, lower = arm[layout.A + 1], arm[layout.RHO] if family == _WRIST else arm[layout.A + 2]
    steep = 4.0 * arm[layout.DRIFT]
    elbow = steep * arm[layout.SIZE] * arm[layout.SIZE] / (upper * lower)
    wrist = steep / (arm[layout.SIN_ALPHA + 4] * arm[layout.SIN_ALPHA + 4])
    return steep, elbow, wrist, abs(upper - lower) / arm[layout.SIZE]


@step
def _weakest(arms, one, other):
    """The shortest arm, from the least squared one and two margins."""
    return math.sqrt(min(arms, min(abs(one), abs(other))) + 1e-300)


@step
def _fold(margin, steep, square):
    """How far a fold may swing a joint: at x beside it the margin, ``square`` x^2, is less than here by steep x."""
    return 0.25 * steep / square if abs(margin) * square < steep * steep else 0.0


@step
def _is_beyond(margin, steep, swing, swung):
    """Whether a margin is so far below zero that no correction lifts it there.

    A solution may lie as far from the answer as the last correction moved it, and as far as folds swing it (``swung``);
    the rest of the arm follows by ``swing``, below 1, of what it moves itself.
    """
    free = 1.0 / (1.0 - min(swing, 0.999))
    return (margin < -steep * free * free * swung - 1e-12) & (swing < 1.0)


@inlined
def _decide(family, N, out, past, arm, answer):
    """Polish what is in doubt, and tell what can be told of it; returns how many columns another correction may help.

    ``answer`` (8, LANES): joint vector; 0 where there is no solution, 1 where there is one, 2 in doubt, 3 where the
    doubt stays, whatever becomes of the other columns; pose error.
    """
    drift = arm[layout.DRIFT]
    shoulder, elbow, wrist, folded = _steepness(family, arm)
    # Where an angle is fixed by an arm this short, the arm as written may have more solutions than the ideal one.
    short = SHORT_BY_DRIFT * drift
    for i in range(LANES):
        last = 0.0
        for j in range(6):
            last = max(last, abs(wrap(out[j, i] - past[j, i])))
            N[ANGLES + j, i] = out[j, i]
        m1, m2, m3 = out[14, i], out[15, i], out[16, i]
        turned, arm1, arm2 = out[17, i], out[18, i], out[19, i]
        ends, arms = max(math.sqrt(arm2), folded), min(turned, min(arm1, arm2))
        w1, w2, w3 = _weakest(arms, m2, m3), _weakest(arms, m1, m3), _weakest(arms, m1, m2)
        # What the pose changes by turns a later angle by that over the lengths of what the earlier ones hang on.
        lever = math.sqrt(min(LEVER * abs(m1), 1.0))
        if family == _WRIST:
            lever2, lever3 = lever, lever * _weakest(arm2, m2, 1.0)
        else:
            lever2, lever3 = lever * _weakest(turned, m3, 1.0), lever
        steep2, steep3 = elbow * ends / lever2, wrist / lever3
        x1, x2, x3 = _fold(m1, shoulder, arm1), _fold(m2, steep2, 1.0), _fold(m3, steep3, 1.0)
        none = _is_beyond(m1, shoulder, short / w1, last + 0.25 * shoulder / arm1 + x2 + x3)
        none |= _is_beyond(m2, steep2, short / min(w2, lever2), last + x1 + 0.25 * steep2 + x3)
        none |= _is_beyond(m3, steep3, short / min(w3, lever3), last + x1 + x2 + 0.25 * steep3)
        still_open = answer[6, i] == 2.0
        answer[6, i] = 0.0 if still_open & none else answer[6, i]
        N[MOVES, i] = 1.0 if still_open & (not none) else 0.0
        past[0, i] = last
    newton_columns(arm, layout.INNER_FRAMES, N, 5)
    open_columns = 0
    for i in range(LANES):
        if answer[6, i] == 2.0:
            moved = 0.0
            for j in range(6):
                moved = max(moved, abs(wrap(N[ANGLES + j, i] - out[j, i])))
                answer[j, i] = N[ANGLES + j, i]
            answer[7, i] = N[ERROR, i]
            regular = N[ERROR, i] <= CONVERGED and moved <= KANTOROVICH * N[LEAST, i]
            turned, arms = out[17, i], min(out[18, i], out[19, i])
            regular = regular and min(turned * min(LEVER * abs(out[14, i]), 1.0), arms) >= short * short
            if regular and min(out[14, i], min(out[15, i], out[16, i])) > 0.0:
                answer[6, i] = 1.0
            elif past[0, i] > SETTLED:
                open_columns += 1
            else:
                answer[6, i] = 3.0
    return open_columns


@inlined
def solve(family, kind, T, arm, q_ref, Q, flags):
    """All solutions of poses ``T`` (m, 4, 4) to ``Q`` (m, 16, 6) and ``flags`` (m, 16).

    Arguments and result as those of ``spherical_wrist.solve``.
    """
    W, out, N = np.empty((layout.ROWS, LANES)), np.empty((OUT_ROWS, LANES)), np.empty((COLUMN_ROWS, LANES))
    past, answer, X, proper = np.empty((6, LANES)), np.empty((8, LANES)), np.empty(12), np.empty((_POSES, 4, 4))
    for start in range(0, T.shape[0], _POSES):
        for k in range(_POSES):
            i = min(start + k, T.shape[0] - 1)
            if not check_target(T[i]) <= arm[layout.ROTATION]:
                return i
            project_rotation(T[i], proper[k])
            to_frame_1(proper[k], arm, X)
            _fill(W, N, X, arm, _BRANCHES * k)
        for i in range(LANES):
            answer[6, i] = 2.0
        _ideal(family, kind, W, out, arm)
        for _ in range(CORRECTIONS):
            for j in range(6):
                for i in range(LANES):
                    past[j, i] = out[j, i]
            _correct(W, N, out, arm)
            _ideal(family, kind, W, out, arm)
            if _decide(family, N, out, past, arm, answer) == 0:
                break
        for k in range(min(_POSES, T.shape[0] - start)):
            i, first = start + k, _BRANCHES * k
            found, decided = 0, True
            for b in range(_BRANCHES):
                state = answer[6, first + b]
                found += state == 1.0
                decided = decided and state < 2.0
                flags[i, b] = layout.VALID if state == 1.0 else 0
                for j in range(6):
                    Q[i, b, j] = answer[j, first + b] if state == 1.0 else math.nan
            for b in range(_BRANCHES, Q.shape[1]):
                flags[i, b] = 0
                for j in range(6):
                    Q[i, b, j] = math.nan
            if not decided or found % 2 == 1:
                for b in range(_BRANCHES):
                    if answer[6, first + b] >= 2.0 and answer[7, first + b] < CLOSE:
                        q, error = answer[:6, first + b].copy(), answer[7, first + b]
                        if error > CONVERGED:
                            error = refine(arm, proper[k], q, 40, FINISHED, PATIENCE)
                        if error <= CONVERGED and is_new(arm, proper[k], Q[i], flags[i], q):
                            keep(Q[i], flags[i], b, q, singular_marks(arm, q, 0))
                _look_closely(family, kind, True, proper[k], arm, q_ref, Q[i], flags[i])
    return -1


@inlined
def solve_closely(family, kind, T, arm, q_ref, Q, flags):
    """As ``solve``, for kinds whose margins do not tell how near a fold is: every pose is looked at closely."""
    proper = np.empty((4, 4))
    for i in range(T.shape[0]):
        if not check_target(T[i]) <= arm[layout.ROTATION]:
            return i
        project_rotation(T[i], proper)
        Q[i, :, :] = math.nan
        flags[i, :] = 0
        _look_closely(family, kind, False, proper, arm, q_ref, Q[i], flags[i])
    return -1


@inlined
def _look_closely(family, kind, plain, target, arm, q_ref, Q, flags):
    """Add what is missing to the solutions of one pose in ``Q`` (16, 6) and ``flags`` (16,)."""
    # Far enough from the ideal arm the elimination is in its element; close to it, starts beside the candidates are.
    beside = arm[layout.IMPERFECTION] < CLOSE_BY
    if plain and arm[layout.IMPERFECTION] > FAR_OFF:
        complete(arm, target, Q, flags, True)
        return
    near = _closed_form(family, kind, target, arm, q_ref, Q, flags, arm[layout.CONTINUUM], beside)
    if near == 2:
        # The ideal arm's free joint is not free: its few true values lie anywhere on the circle.
        around, almost_free = np.zeros(7), (ALMOST_FREE * arm[layout.IMPERFECTION]) ** 2
        for k in range(AROUND):
            around[:6] = math.pi * (2.0 * k / AROUND - 1.0)
            _closed_form(family, kind, target, arm, around, Q, flags, almost_free, False)
    found = count(flags)
    if near > 0 or found == 0 or found % 2 == 1 or not plain:
        complete(arm, target, Q, flags, False)


@kernel
def near_parallel_23(T, arm, q_ref, Q, flags):
    """Spherical wrist, axes 2 and 3 parallel; see ``solve``."""
    return solve(_WRIST, wrist_position.PARALLEL_23, T, arm, q_ref, Q, flags)


@kernel
def near_intersecting_12(T, arm, q_ref, Q, flags):
    """Spherical wrist, axes 1 and 2 intersect; see ``solve``."""
    return solve_closely(_WRIST, wrist_position.INTERSECTING_12, T, arm, q_ref, Q, flags)


@kernel
def near_parallel_12(T, arm, q_ref, Q, flags):
    """Spherical wrist, axes 1 and 2 parallel; see ``solve``."""
    return solve_closely(_WRIST, wrist_position.PARALLEL_12, T, arm, q_ref, Q, flags)


@kernel
def near_general_shoulder(T, arm, q_ref, Q, flags):
    """Spherical wrist, no relation among the first three axes; see ``solve``."""
    return solve_closely(_WRIST, wrist_position.GENERAL, T, arm, q_ref, Q, flags)


@kernel
def near_intersecting_56(T, arm, q_ref, Q, flags):
    """Three parallel axes, 5 and 6 intersect; see ``solve``."""
    return solve(_PARALLEL, three_parallel.INTERSECTING_56, T, arm, q_ref, Q, flags)


@kernel
def near_general_wrist(T, arm, q_ref, Q, flags):
    """Three parallel axes, 5 and 6 skew; see ``solve``."""
    return solve_closely(_PARALLEL, three_parallel.GENERAL, T, arm, q_ref, Q, flags)


@kernel
def near_shoulder_intersecting_56(T, arm, q_ref, Q, flags):
    """Axes 1 to 3 parallel, axes 5 and 6 intersect; see ``solve``."""
    return solve_closely(_SHOULDER, parallel_shoulder.INTERSECTING_56, T, arm, q_ref, Q, flags)


@kernel
def near_shoulder_parallel_56(T, arm, q_ref, Q, flags):
    """Axes 1 to 3 parallel, axes 5 and 6 are parallel; see ``solve``."""
    return solve_closely(_SHOULDER, parallel_shoulder.PARALLEL_56, T, arm, q_ref, Q, flags)


@kernel
def near_shoulder_intersecting_45(T, arm, q_ref, Q, flags):
    """Axes 1 to 3 parallel, axes 4 and 5 intersect; see ``solve``."""
    return solve_closely(_SHOULDER, parallel_shoulder.INTERSECTING_45, T, arm, q_ref, Q, flags)


@kernel
def near_shoulder_parallel_45(T, arm, q_ref, Q, flags):
    """Axes 1 to 3 parallel, axes 4 and 5 are parallel; see ``solve``."""
    return solve_closely(_SHOULDER, parallel_shoulder.PARALLEL_45, T, arm, q_ref, Q, flags)


@kernel
def near_shoulder_general_wrist(T, arm, q_ref, Q, flags):
    """Axes 1 to 3 parallel, axes 4, 5 and 6 are skew; see ``solve``."""
    return solve_closely(_SHOULDER, parallel_shoulder.GENERAL, T, arm, q_ref, Q, flags)


@kernel
def near_middle_intersecting_56(T, arm, q_ref, Q, flags):
    """Axes 2 to 4 meet, axes 5 and 6 intersect; see ``solve``."""
    return solve_closely(_MIDDLE, spherical_middle.INTERSECTING_56, T, arm, q_ref, Q, flags)


@kernel
def near_middle_parallel_56(T, arm, q_ref, Q, flags):
    """Axes 2 to 4 meet, axes 5 and 6 are parallel; see ``solve``."""
    return solve_closely(_MIDDLE, spherical_middle.PARALLEL_56, T, arm, q_ref, Q, flags)


@kernel
def near_middle_general_wrist(T, arm, q_ref, Q, flags):
    """Axes 2 to 4 meet, axes 5 and 6 are skew; see ``solve``."""
    return solve_closely(_MIDDLE, spherical_middle.GENERAL, T, arm, q_ref, Q, flags)
