"""What of the solutions of a completed arm holds for the real one."""

from __future__ import annotations

import math

import numpy as np

from urdf_ik._kernels import layout
from urdf_ik._kernels.compile import kernel
from urdf_ik._kernels.few_joints import COMPUTED, KIND, POSE, SEARCHED, SLIDING, take
from urdf_ik._kernels.general_6r import sort_columns
from urdf_ik._kernels.target import project_rotation
from urdf_ik._kernels.thresholds import CONVERGED

_NET = 96


@kernel
def take_real(T, arm, whole, whole_flags, at, Q, flags):
    """Verify solutions ``whole`` (m, b, 6) of the completed arm on the real one, whose joints begin at ``at``.

    Into ``Q`` (m, B, n) and ``flags`` (m, B). At a singularity of the completed arm the added joint may take part in a
    continuum of which the real arm has single members: then fixed starts all over find those.
    """
    n = Q.shape[2]
    q, proper = np.empty(n), np.empty((4, 4))
    for i in range(T.shape[0]):
        project_rotation(T[i], proper)
        Q[i, :, :] = math.nan
        flags[i, :] = 0
        free = False
        for b in range(whole.shape[1]):
            if not whole_flags[i, b] & layout.VALID:
                continue
            free = free or whole_flags[i, b] != layout.VALID
            q[:] = whole[i, b, at : at + n]
            take(arm, proper, q, COMPUTED, arm[layout.REACH], Q[i], flags[i])
        if free and arm[KIND] == POSE:
            net(arm, proper, Q[i], flags[i])
        sort_columns(Q[i], flags[i])


@kernel
def net(arm, target, Q, flags):
    """Solutions from fixed starts all over the angles of the joints."""
    q = np.empty(Q.shape[1])
    seed = 12345
    for _ in range(_NET):
        for j in range(q.size):
            seed = (seed * 1103515245 + 12345) % 2147483648
            q[j] = 0.0 if arm[SLIDING + j] else math.pi * (seed / 1073741824.0 - 1.0)
        take(arm, target, q, SEARCHED, CONVERGED, Q, flags)
