"""Arms with at most five joints, turning or sliding: a position step, the turns left over, verified as written.

An arm of so few joints reaches a pose only where the six numbers of the pose agree, so its Jacobian is a tall matrix
and Newton's method one of least squares. What is asked for is a ``KIND``: the pose, the tip's position, position and
the direction of one axis of the tip, position in a plane, or position in a plane and the direction there of one axis
of the tip. The target is a pose (4, 4) in each case, of which only so much counts.
"""

from __future__ import annotations

import math

import numpy as np

from urdf_ik._kernels import layout
from urdf_ik._kernels import slide_position as step
from urdf_ik._kernels.compile import kernel
from urdf_ik._kernels.general_6r import sort_columns
from urdf_ik._kernels.mirror import invert_poses
from urdf_ik._kernels.refine import damped_step, keep, least_stretch, pose_error
from urdf_ik._kernels.screws import jacobian_from_axes, place_axes
from urdf_ik._kernels.slide_position import angle_about, cross, dot, rotated, solve_position, turned
from urdf_ik._kernels.target import check_target, project_rotation
from urdf_ik._kernels.thresholds import AROUND, CONVERGED, FINISHED, NEAR_FOLD
from urdf_ik._kernels.trig import wrap

POSE, POSITION, AXIS, PLANAR_POSITION, PLANAR_POSE = range(5)

# Behind an arm's common numbers: joints, kind, the tip's axis that is aimed, the plane's normal, which joints slide,
# the number of variants.
JOINTS, KIND, AIMED, NORMAL, SLIDING, VARIANTS, FIRST_VARIANT = layout.FRAMES, 149, 150, 153, 156, 162, 163
# A variant: a position step of three joints; whether it is the chain from tip to base; how many turns follow it, about
# which axes; which joint of the arm each of the five is (-1: added to it, and to stay at zero); the tip's home
# rotation; the point in the tip.
REVERSED, TURNS, AXES, INDEX, HOME, IN_TIP = step.LENGTH, 25, 26, 32, 37, 46
VARIANT = 49

# Where a candidate comes from: a closed form, one in which a joint was all but free, a search.
COMPUTED, DOUBTFUL, SEARCHED = 0, 1, 2
# An error [rad, share of size] from which no candidate of a closed form comes to be a solution.
_HOPELESS = 0.05


@kernel
def place_few(arm, q, T, axes, points):
    """``place_axes`` of an arm of q.size joints as written."""
    n = q.size
    H = arm[layout.H : layout.H + 3 * n].reshape(n, 3)
    P = arm[layout.P : layout.P + 3 * n + 3].reshape(n + 1, 3)
    place_axes(H, P, arm[layout.R_TIP : layout.R_TIP + 9].reshape(3, 3), arm[SLIDING : SLIDING + n] != 0.0, q, T, axes,
               points)  # fmt: skip


@kernel
def task_error(arm, target, T, e):
    """Twist (6,) from ``T`` to ``target`` in what the arm's kind asks for; returns its greatest entry."""
    scale = 1.0 / arm[layout.SIZE]
    if arm[KIND] == POSE:
        return pose_error(target, T, scale, e)
    for i in range(3):
        e[i] = (target[i, 3] - T[i, 3]) * scale
        e[3 + i] = 0.0
    normal = arm[NORMAL : NORMAL + 3]
    if arm[KIND] >= PLANAR_POSITION:
        e[:3] -= dot(normal, e[:3]) * normal
    ahead = True
    if arm[KIND] == AXIS or arm[KIND] == PLANAR_POSE:
        now, wanted = aimed(arm, T), aimed(arm, target)
        if arm[KIND] == PLANAR_POSE:
            now -= dot(normal, now) * normal
            wanted -= dot(normal, wanted) * normal
        e[3:] = cross(now, wanted)
        ahead = dot(now, wanted) > 0.0
    worst = 0.0
    for i in range(6):
        worst = max(worst, abs(e[i]))
    return worst if ahead else 2.0


@kernel
def aimed(arm, T):
    """Direction (3,) in the base of the tip's axis that is aimed, at the pose ``T``."""
    return rotated(T, arm[AIMED : AIMED + 3])


@kernel
def task_jacobian(arm, axes, points, T, J):
    """Jacobian (6, n) of what the kind asks for; lengths, those of slides too, as shares of the arm's size."""
    n = axes.shape[0]
    jacobian_from_axes(arm[SLIDING : SLIDING + n] != 0.0, axes, points, T[:3, 3], J)
    along, normal = aimed(arm, T), arm[NORMAL : NORMAL + 3]
    for j in range(n):
        if not arm[SLIDING + j]:
            for i in range(3):
                J[i, j] /= arm[layout.SIZE]
        if arm[KIND] == POSITION or arm[KIND] == PLANAR_POSITION:
            J[3:, j] = 0.0
        elif arm[KIND] == AXIS:
            J[3:, j] -= dot(along, J[3:, j]) * along
        elif arm[KIND] == PLANAR_POSE:
            J[3:, j] = dot(normal, J[3:, j]) * normal
        if arm[KIND] >= PLANAR_POSITION:
            J[:3, j] -= dot(normal, J[:3, j]) * normal


@kernel
def advance(arm, q, delta, factor):
    """Add factor times ``delta`` (rad, shares of the size) to ``q`` (n,)."""
    for j in range(q.size):
        if arm[SLIDING + j]:
            q[j] += factor * delta[j] * arm[layout.SIZE]
        else:
            q[j] = wrap(q[j] + factor * delta[j])


@kernel
def polish(arm, target, q, rounds):
    """Newton's method of least squares, damped; ``q`` (n,) is replaced by the best vector met. Returns its error."""
    n = q.size
    T, J, e, delta = np.empty((4, 4)), np.empty((6, n)), np.empty(6), np.empty(n)
    axes, points, best = np.empty((n, 3)), np.empty((n, 3)), q.copy()
    least = math.inf
    for k in range(rounds + 1):
        place_few(arm, q, T, axes, points)
        error = task_error(arm, target, T, e)
        if error < least:
            least = error
            best[:] = q
        elif k > 3 and error > 0.5 * least and least < CONVERGED:
            break
        if error < FINISHED or k == rounds:
            break
        task_jacobian(arm, axes, points, T, J)
        damped_step(J, e, min(1e-2 * error, 1e-2) + 1e-12, delta)
        longest = 0.0
        for j in range(n):
            longest = max(longest, abs(delta[j]))
        advance(arm, q, delta, min(1.0, 0.5 / (longest + 1e-300)))
    q[:] = best
    return least


@kernel
def stretch(arm, q, x):
    """Smallest singular value of the Jacobian at ``q`` and its direction ``x`` (n,)."""
    n = q.size
    T, J, axes, points = np.empty((4, 4)), np.empty((6, n)), np.empty((n, 3)), np.empty((n, 3))
    place_few(arm, q, T, axes, points)
    task_jacobian(arm, axes, points, T, J)
    return least_stretch(J, x)


@kernel
def is_other(arm, target, Q, flags, q):
    """Whether ``q`` differs from every valid row of ``Q`` (B, n); as ``refine.is_new``."""
    n = q.size
    T, e, axes, points = np.empty((4, 4)), np.empty(6), np.empty((n, 3)), np.empty((n, 3))
    middle = np.empty(n)
    for b in range(Q.shape[0]):
        if flags[b] & layout.VALID:
            apart = 0.0
            for j in range(n):
                gap = q[j] - Q[b, j]
                gap = gap if arm[SLIDING + j] else wrap(gap)
                middle[j] = Q[b, j] + 0.5 * gap
                apart = max(apart, abs(gap) / (arm[layout.SIZE] if arm[SLIDING + j] else 1.0))
            if apart <= arm[layout.DUPLICATE]:
                return False
            if apart < 1e-3:
                place_few(arm, middle, T, axes, points)
                if task_error(arm, target, T, e) <= arm[layout.FOLD]:
                    return False
    return True


@kernel
def take(arm, target, q, origin, enough, Q, flags):
    """Polish the candidate ``q``, keep it if it is verified to ``enough`` and new, and look beside it near a fold.

    Of ``origin`` COMPUTED it is given up at once where it is far off; SEARCHED, it is dropped where the arm is singular
    and a singular solution is known already: it belongs to the same continuum. Returns the smallest singular value
    there, and infinity where it is no solution.
    """
    n = q.size
    T, e, axes, points = np.empty((4, 4)), np.empty(6), np.empty((n, 3)), np.empty((n, 3))
    if origin == COMPUTED:
        place_few(arm, q, T, axes, points)
        if task_error(arm, target, T, e) > _HOPELESS:
            return math.inf
    if polish(arm, target, q, 15 if origin == COMPUTED else 30) > enough:
        return math.inf
    x, unused, start = np.empty(n), np.empty(n), np.empty(n)
    sigma = stretch(arm, q, x)
    if origin == SEARCHED and sigma <= arm[layout.SINGULAR]:
        for b in range(flags.size):
            if flags[b] & layout.OTHER:
                return sigma
    if not is_other(arm, target, Q, flags, q):
        return sigma
    keep(Q, flags, 0, q, layout.OTHER if sigma <= arm[layout.SINGULAR] else 0)
    if sigma <= NEAR_FOLD:
        for k in range(16):
            start[:] = q
            advance(arm, start, x, (1.0 if k % 2 else -1.0) * 0.1 * 10.0 ** (-(k // 2)))
            # What is singular again belongs to the same double root, or to the same continuum.
            if (
                polish(arm, target, start, 20) <= CONVERGED
                and is_other(arm, target, Q, flags, start)
                and stretch(arm, start, unused) > arm[layout.SINGULAR]
            ):
                keep(Q, flags, 0, start, 0)
    return sigma


@kernel
def _last_turns(row, R, five):
    """The turns behind the position step, for a tip of rotation ``R`` (3 or 4 rows): into ``five`` (5,)."""
    turns = int(row[TURNS])
    if turns == 0:
        return
    # The tip's rotation from home, and what is left of it when the first three joints are undone.
    home = row[HOME : HOME + 9].reshape(3, 3)
    E = np.empty((3, 3))
    for c in range(3):
        E[:, c] = rotated(R, home[c])
    for k in range(3):
        if not row[step.SLIDES + k]:
            h = row[step.DIRECTIONS + 3 * k : step.DIRECTIONS + 3 * k + 3]
            for c in range(3):
                E[:, c] = turned(E[:, c], h, -five[k])
    for k in range(turns):
        h = row[AXES + 3 * k : AXES + 3 * k + 3]
        if k + 1 < turns:
            mark = row[AXES + 3 * k + 3 : AXES + 3 * k + 6].copy()
        else:
            # Any direction across: the greater one of two that are never both short.
            mark = np.array([h[1], -h[0], 0.0])
            if abs(h[2]) > 0.8:
                mark = np.array([0.0, h[2], -h[1]])
        five[3 + k], _ = angle_about(h, mark, rotated(E, mark))
        for c in range(3):
            E[:, c] = turned(E[:, c], h, -five[3 + k])


@kernel
def _gather(row, size, R, five, q):
    """The arm's own joint vector of a candidate, its last turns computed."""
    _last_turns(row, R, five)
    for k in range(5):
        i = int(row[INDEX + k])
        if i >= 0:
            slides = k < 3 and row[step.SLIDES + k] != 0.0
            q[i] = five[k] * size if slides else wrap(five[k])


@kernel
def _by_variant(arm, row, target, seen, q_ref, Q, flags):
    """Solutions that one position step leads to; returns whether a joint was all but free in it."""
    n, size = Q.shape[1], arm[layout.SIZE]
    p = rotated(seen, row[IN_TIP : IN_TIP + 3]) + seen[:3, 3] / size
    ref, out, five, q = np.zeros(3), np.empty((step.MOST, step.COLUMNS)), np.zeros(5), np.zeros(n)
    for k in range(3):
        i = int(row[INDEX + k])
        if i >= 0:
            ref[k] = q_ref[i] / size if row[step.SLIDES + k] else q_ref[i]
    doubt = False
    for c in range(solve_position(row, p, ref, out)):
        free = int(out[c, step.FREE_JOINTS])
        five[:3] = out[c, :3]
        _gather(row, size, seen, five, q)
        sigma = take(arm, target, q, DOUBTFUL if free else COMPUTED, arm[layout.REACH], Q, flags)
        if free == 0 or sigma <= arm[layout.SINGULAR]:
            continue
        doubt = True
        for k in range(2):
            if free & (1 << k):
                for a in range(2 * AROUND):
                    five[:3] = out[c, :3]
                    five[k] = math.pi * a / AROUND
                    _gather(row, size, seen, five, q)
                    take(arm, target, q, SEARCHED, CONVERGED, Q, flags)
    return doubt


@kernel
def solve(T, arm, q_ref, Q, flags):
    """All solutions of targets ``T`` (m, 4, 4) to ``Q`` (m, B, n) and ``flags`` (m, B).

    Arguments and result as those of ``spherical_wrist.solve``. A variant that does not come first is asked where the
    ones before found a joint all but free.
    """
    proper, inverse = np.empty((4, 4)), np.empty((4, 4))
    for i in range(T.shape[0]):
        if not check_target(T[i]) <= arm[layout.ROTATION]:
            return i
        project_rotation(T[i], proper)
        invert_poses(proper.reshape(1, 4, 4), inverse.reshape(1, 4, 4))
        Q[i, :, :] = math.nan
        flags[i, :] = 0
        for v in range(int(arm[VARIANTS])):
            row = arm[FIRST_VARIANT + v * VARIANT : FIRST_VARIANT + (v + 1) * VARIANT]
            if not _by_variant(arm, row, proper, inverse if row[REVERSED] else proper, q_ref, Q[i], flags[i]):
                break
        sort_columns(Q[i], flags[i])
    return -1
