"""Representatives of continua, each chosen near the reference joint vector of its own pose."""

from __future__ import annotations

from typing import Any

import numpy as np

from urdf_ik.ik.pose_solving import solve
from urdf_ik.ik.solutions import distances
from urdf_ik.ik.solutions.ik_solutions import IKSolutions
from urdf_ik.typing import Array


def near_each(solutions: IKSolutions, q_ref: Array) -> IKSolutions:
    """A batch as it was solved, singular poses solved again, each near its own joint vector of ``q_ref`` (..., n).

    Raises:
        ArgumentError: ``q_ref`` does not fit the poses.
    """
    solver = solutions.solver
    reference = distances.reference(q_ref, solver.joint_names, solutions.shape)
    reference = np.broadcast_to(reference, (*solutions.shape, reference.shape[-1]))
    q, info = solutions._q.copy(), solutions._info.copy()
    values: Any = solutions._redundancy
    for place in map(tuple, np.argwhere(solutions.singular.any(axis=-1))):
        at = {} if values is None else {"redundancy": values[place]}
        one = solve(solver, solutions._poses[place], np.array(reference[place]), **at)
        q[place], info[place] = one._q, one._info
    return IKSolutions(solver, solutions._poses, q, info, solutions._branches, redundancy=values)
