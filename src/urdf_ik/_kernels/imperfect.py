"""Arms near a family: its closed form gives starting points, the general elimination adds what they cannot tell.

Away from singularities the ideal arm and the arm as written have the same solutions, a small step apart. Near
them their numbers differ: there, and wherever solutions do not come in pairs, the elimination looks too. How near
is near is plain where each angle has a margin of its own; the other kinds are always looked at twice.
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
from urdf_ik._kernels.compile import inlined, kernel
from urdf_ik._kernels.general_6r import complete, count
from urdf_ik._kernels.target import check_target, project_rotation
from urdf_ik._kernels.thresholds import ALMOST_FREE, AROUND, FAR_OFF

_WRIST, _PARALLEL, _SHOULDER, _MIDDLE = 0, 1, 2, 3


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
def solve(family, kind, T, arm, q_ref, Q, flags):
    """All solutions of poses ``T`` (m, 4, 4) to ``Q`` (m, 16, 6) and ``flags`` (m, 16).

    Arguments and result as those of ``spherical_wrist.solve``.
    """
    proper, around = np.empty((4, 4)), np.zeros(7)
    almost_free = (ALMOST_FREE * arm[layout.IMPERFECTION]) ** 2
    plain = kind == (wrist_position.PARALLEL_23 if family == _WRIST else three_parallel.INTERSECTING_56)
    plain = plain and family in (_WRIST, _PARALLEL)
    # Far enough from the ideal arm the elimination is in its element; next to it, starts beside the candidates are.
    beside = arm[layout.IMPERFECTION] < FAR_OFF
    for i in range(T.shape[0]):
        if not check_target(T[i]) <= arm[layout.ROTATION]:
            return i
        project_rotation(T[i], proper)
        Q[i, :, :] = math.nan
        flags[i, :] = 0
        near = _closed_form(family, kind, proper, arm, q_ref, Q[i], flags[i], arm[layout.CONTINUUM], beside)
        if near == 2:
            # The ideal arm's free joint is not free: its few true values lie anywhere on the circle.
            for k in range(AROUND):
                around[:6] = math.pi * (2.0 * k / AROUND - 1.0)
                _closed_form(family, kind, proper, arm, around, Q[i], flags[i], almost_free, False)
        found = count(flags[i])
        if near > 0 or found == 0 or found % 2 == 1 or not plain:
            complete(arm, proper, Q[i], flags[i])
    return -1


@kernel
def near_parallel_23(T, arm, q_ref, Q, flags):
    """Spherical wrist, axes 2 and 3 parallel; see ``solve``."""
    return solve(_WRIST, wrist_position.PARALLEL_23, T, arm, q_ref, Q, flags)


@kernel
def near_intersecting_12(T, arm, q_ref, Q, flags):
    """Spherical wrist, axes 1 and 2 intersect; see ``solve``."""
    return solve(_WRIST, wrist_position.INTERSECTING_12, T, arm, q_ref, Q, flags)


@kernel
def near_parallel_12(T, arm, q_ref, Q, flags):
    """Spherical wrist, axes 1 and 2 parallel; see ``solve``."""
    return solve(_WRIST, wrist_position.PARALLEL_12, T, arm, q_ref, Q, flags)


@kernel
def near_general_shoulder(T, arm, q_ref, Q, flags):
    """Spherical wrist, no relation among the first three axes; see ``solve``."""
    return solve(_WRIST, wrist_position.GENERAL, T, arm, q_ref, Q, flags)


@kernel
def near_intersecting_56(T, arm, q_ref, Q, flags):
    """Three parallel axes, 5 and 6 intersect; see ``solve``."""
    return solve(_PARALLEL, three_parallel.INTERSECTING_56, T, arm, q_ref, Q, flags)


@kernel
def near_general_wrist(T, arm, q_ref, Q, flags):
    """Three parallel axes, 5 and 6 skew; see ``solve``."""
    return solve(_PARALLEL, three_parallel.GENERAL, T, arm, q_ref, Q, flags)


@kernel
def near_shoulder_intersecting_56(T, arm, q_ref, Q, flags):
    """Axes 1 to 3 parallel, axes 5 and 6 intersect; see ``solve``."""
    return solve(_SHOULDER, parallel_shoulder.INTERSECTING_56, T, arm, q_ref, Q, flags)


@kernel
def near_shoulder_parallel_56(T, arm, q_ref, Q, flags):
    """Axes 1 to 3 parallel, axes 5 and 6 are parallel; see ``solve``."""
    return solve(_SHOULDER, parallel_shoulder.PARALLEL_56, T, arm, q_ref, Q, flags)


@kernel
def near_shoulder_intersecting_45(T, arm, q_ref, Q, flags):
    """Axes 1 to 3 parallel, axes 4 and 5 intersect; see ``solve``."""
    return solve(_SHOULDER, parallel_shoulder.INTERSECTING_45, T, arm, q_ref, Q, flags)


@kernel
def near_shoulder_parallel_45(T, arm, q_ref, Q, flags):
    """Axes 1 to 3 parallel, axes 4 and 5 are parallel; see ``solve``."""
    return solve(_SHOULDER, parallel_shoulder.PARALLEL_45, T, arm, q_ref, Q, flags)


@kernel
def near_shoulder_general_wrist(T, arm, q_ref, Q, flags):
    """Axes 1 to 3 parallel, axes 4, 5 and 6 are skew; see ``solve``."""
    return solve(_SHOULDER, parallel_shoulder.GENERAL, T, arm, q_ref, Q, flags)


@kernel
def near_middle_intersecting_56(T, arm, q_ref, Q, flags):
    """Axes 2 to 4 meet, axes 5 and 6 intersect; see ``solve``."""
    return solve(_MIDDLE, spherical_middle.INTERSECTING_56, T, arm, q_ref, Q, flags)


@kernel
def near_middle_parallel_56(T, arm, q_ref, Q, flags):
    """Axes 2 to 4 meet, axes 5 and 6 are parallel; see ``solve``."""
    return solve(_MIDDLE, spherical_middle.PARALLEL_56, T, arm, q_ref, Q, flags)


@kernel
def near_middle_general_wrist(T, arm, q_ref, Q, flags):
    """Axes 2 to 4 meet, axes 5 and 6 are skew; see ``solve``."""
    return solve(_MIDDLE, spherical_middle.GENERAL, T, arm, q_ref, Q, flags)
