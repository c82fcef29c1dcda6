"""Intervals in closed form for a tip that may turn about the axis of the last joint.

With the target turned by v, the last joint turns by v or by -v, as the two axes point, and the others stay. So each
branch has the solutions of v = 0 all round, and the limits of the last joint cut out one interval.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from urdf_ik import _core
from urdf_ik.ik.families.parts.family import RedundantMember
from urdf_ik.ik.pose_solving import solve
from urdf_ik.ik.redundancy.interval_arrays import End, Found
from urdf_ik.ik.redundancy.limit_bounds import Bounds
from urdf_ik.ik.solver import Solver
from urdf_ik.support import tolerances
from urdf_ik.support.angles import wrapped
from urdf_ik.typing import Array

Columns = NDArray[np.intp]


def sense(solver: Solver, plan: RedundantMember) -> float:
    """1 or -1: how the last joint turns with the tip; 0 where the free axis is not the last joint's, or there is none.

    Arms whose branches have no names are left to the search: their columns change along the value.
    """
    if solver.free_axis is None or plan.family.by_elimination or not isinstance(plan.solver, _core.Solver):
        return 0.0
    if solver.chain.prismatic.any() or solver.dof != 6 or len(plan.parameters) != 1:
        return 0.0
    home = np.zeros(solver.dof)
    # The last joint's twist in the tip.
    J = solver.chain.jacobian(home)[:, -1].reshape(2, 3) @ solver.chain.fk(home)[:3, :3]
    direction, at = np.array(solver.free_axis.direction), np.array(solver.free_axis.at)
    way = 1.0 if J[1] @ direction > 0.0 else -1.0
    off = np.abs([(J[0] - way * np.cross(at, direction)) / solver.chain.size, J[1] - way * direction]).max()
    return way if off <= tolerances.DEFAULT.reach else 0.0


def intervals(solver: Solver, way: float, T: Array, limits: Array) -> tuple[Found, Columns]:
    """The intervals of poses (m, 4, 4) inside limits (n, 2), without samples; and the poses that it does not decide.

    These are poses with a singular solution, beside which there may be others.

    Args:
        solver: with the free axis.
        way: of :func:`sense`.
        T: (m, 4, 4) m.
        limits: (n, 2) rad, infinite where there is none.
    """
    bounds = Bounds(limits)
    solutions = solve(solver, T, redundancy=np.zeros(len(T)))
    singular = (solutions.valid & (solutions.singular != 0)).any(axis=-1)
    kept = solutions.valid & ~singular[:, None]
    kept &= bounds.inside(slice(solver.dof - 1), solutions.q[..., :-1]).all(axis=-1)
    pose, column = np.nonzero(kept)
    last = solver.dof - 1
    if bounds.matter[last]:
        middle = way * (bounds.middle[last] - solutions.q[pose, column, last])
        low = wrapped(middle - bounds.half[last])
        high = low + 2.0 * bounds.half[last]
        both = [End("limit", solver.joint_names[last], upper=upper) for upper in (way < 0.0, way > 0.0)]
    else:
        low, high = np.full(len(pose), -np.pi), np.full(len(pose), np.pi)
        both = [End("none")] * 2
    ends = np.tile(np.array(both), (len(pose), 1))
    nothing = np.zeros(len(pose), dtype=np.intp)
    empty = np.zeros(0), np.zeros((0, solver.dof)), np.zeros((0, 17))
    found = Found(pose, low, high, column, ends, nothing, nothing, *empty)
    return found, np.flatnonzero(singular)
