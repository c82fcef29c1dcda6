"""Solutions that miss their poses by no more than a tolerance: for poses that were rounded."""

from dataclasses import replace
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from urdf_ik._core import Solver as CoreSolver
from urdf_ik.errors import ArgumentError
from urdf_ik.ik.closest import closest
from urdf_ik.ik.families.parts.written import Numbers
from urdf_ik.ik.pose_solving import solve
from urdf_ik.ik.solutions import IKSolutions
from urdf_ik.ik.solver import Solver
from urdf_ik.ik.task import POSE
from urdf_ik.support import inputs
from urdf_ik.support.tolerances import DEFAULT
from urdf_ik.typing import Array


def solve_within(solver: Solver, T: Any, tolerance: ArrayLike, **options: Any) -> IKSolutions:
    """Every joint vector that misses ``T`` by at most ``tolerance`` m and rad; see :meth:`urdf_ik.Arm.ik`.

    Joints that are fewer than the numbers of a pose reach few poses exactly; of the joint vectors near one the one with
    the least squared error is returned. More joints reach poses exactly but at the ends of their reach: there, and
    wherever the solver has none, the nearest postures are searched.
    """
    pair = inputs.array(tolerance, "tolerance", (2,))
    if not (pair > 0.0).all():
        raise ArgumentError(f"tolerance={tolerance!r} given; (m, rad) is needed, two positive numbers")
    if solver.targets is not None or solver.free_axis is not None:
        raise ArgumentError(f"{solver.name}: a tolerance is one of whole poses")
    few = solver.dof < 6 and solver.member is not None and solver.asked == POSE
    found = solve(_loose(solver, float(min(*pair / [solver.chain.size, 1.0]))) if few else solver, T, **options)
    kept = _within(found, pair)
    if solver.parameters or bool((kept.count > 0).all()):
        return kept
    poses = found._poses.reshape(-1, 4, 4)
    open_ = np.flatnonzero(np.asarray(kept.count).reshape(-1) == 0)
    near = _within(closest(solver, poses[open_], 1.0 / pair, unsolved=True), pair)
    return joined(kept, open_, near)


def _within(found: IKSolutions, pair: Array) -> IKSolutions:
    """The solutions that miss no more than a pair m, rad."""
    error = found.error
    good = (error.position <= pair[0] * _ROUNDING) & (error.rotation <= pair[1] * _ROUNDING)
    info = np.where(good, found._info, found._info & np.uint8(_STATUS_BITS))
    q = np.where(good[..., None], found.q, np.nan)
    return IKSolutions(found.solver, found._poses, q, info, found.branches, redundancy=found._redundancy)


_ROUNDING = 1.0 + 1e-6
_STATUS_BITS = 96


def joined(kept: IKSolutions, at: Any, near: IKSolutions) -> IKSolutions:
    """Solutions of a batch, those of the poses numbered ``at`` replaced by the nearest postures."""
    shape, n = kept.shape, kept.solver.dof
    count = max(kept.q.shape[-2], near.q.shape[-2])
    q, info = np.full((int(np.prod(shape)), count, n), np.nan), np.zeros((int(np.prod(shape)), count), np.uint8)
    q[:, : kept.q.shape[-2]] = kept.q.reshape(len(q), -1, n)
    info[:, : kept.q.shape[-2]] = kept._info.reshape(len(q), -1)
    q[at, : near.q.shape[-2]], info[at, : near.q.shape[-2]] = near.q, near._info
    names = kept.branches if count == len(kept.branches) else tuple(f"solution {k + 1}" for k in range(count))
    return IKSolutions(kept.solver, kept._poses, q.reshape(*shape, count, n), info.reshape(*shape, count), names)


@lru_cache(maxsize=64)
def _loose(solver: Solver, reach: float) -> Solver:
    """The same solver, whose solutions are verified to ``reach`` [share of size, rad]."""
    core: Any = solver.core
    made = CoreSolver(_with_reach(core.arm, max(reach, DEFAULT.reach)))
    return replace(solver, core=made, single=None)


def _with_reach(part: Numbers, reach: float) -> Numbers:
    inner = {name: _with_reach(value, reach) for name, value in vars(part).items() if isinstance(value, Numbers)}
    if hasattr(part, "tolerances"):
        inner["tolerances"] = replace(part.tolerances, reach=reach)
    return part.but(**inner)
