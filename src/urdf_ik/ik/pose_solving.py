"""From targets to their solutions."""

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from urdf_ik.errors import ArgumentError, PoseError, UnsupportedArm
from urdf_ik.ik.solutions import IKSolutions, distances
from urdf_ik.ik.solver import Solver
from urdf_ik.ik.task import POSE
from urdf_ik.ik.tasks import Targets
from urdf_ik.kinematics.chain.redundancy import spread
from urdf_ik.model.poses import as_pose_array, check_poses
from urdf_ik.support import inputs
from urdf_ik.support.angles import shortest
from urdf_ik.support.text import quoted
from urdf_ik.typing import Array, Threads


def solve(
    solver: Solver,
    T: Any,
    q_ref: ArrayLike | None = None,
    redundancy: ArrayLike | None = None,
    threads: Threads = 1,
    out: IKSolutions | None = None,
) -> IKSolutions:
    """Every joint vector that brings the tip to ``T``; see :meth:`urdf_ik.Arm.ik`."""
    single: Any = solver.single
    if (
        single is not None
        and redundancy is None
        and out is None
        and type(threads) is int
        and threads == 1
        and T is not None
        and (q_ref is None or type(T) is np.ndarray)
    ):
        solutions: IKSolutions | None  # which the compiled core makes; None where the targets are no array of poses
        if q_ref is None:
            solutions = single.one(IKSolutions, solver, solver.branches, T)
        else:
            solutions = single.one_near(IKSolutions, solver, solver.branches, T, _reference(solver, q_ref))
        if solutions is not None:
            return solutions
    solver.require_member()
    threads = inputs.threads(threads)
    if solver.targets is not None:
        if redundancy is not None:
            raise UnsupportedArm(f"{solver.name}: targets of the task {solver.task!r} leave nothing free")
        return _solve_task(solver, solver.targets, T, q_ref, threads, out)
    if solver.asked != POSE:
        T = solver.asked.read_targets(T)
    if type(T) is np.ndarray and T.shape == (4, 4) and T.dtype == np.float64:
        # A copy, so that the answer does not change when the caller's array does.
        target = T.copy()
    else:
        target = as_pose_array(T)
        target = target.copy() if target is T and target.ndim == 2 else target
    values = None
    if redundancy is not None:
        target, values = spread(solver.redundant_member.parameters, target, redundancy)
    solved = _solve_array(solver, target, target.shape[:-2], values, q_ref, threads, out)
    if solved is None:
        check_poses(target)  # names the first bad pose
        raise PoseError("a rotation that is neither orthonormal nor near it")
    return solved


def _solve_task(
    solver: Solver, targets: Targets, T: Any, q_ref: ArrayLike | None, threads: int, out: IKSolutions | None
) -> IKSolutions:
    """The solutions of targets of a task."""
    target = targets.read(T)
    batch = target.shape[:-1]
    stack = targets.for_solver(target.reshape(-1, target.shape[-1]))
    solved = _solve_array(solver, stack.reshape(*batch, *stack.shape[1:]), batch, None, q_ref, threads, out)
    if solved is None:
        raise PoseError(f"a target for the task {targets.task!r} is not finite, or its direction has no length")
    solved._poses = target
    return solved


def _solve_array(
    solver: Solver,
    targets: Array,
    batch: tuple[int, ...],
    values: Array | None,
    q_ref: ArrayLike | None,
    threads: int,
    out: IKSolutions | None,
) -> IKSolutions | None:
    """The solutions of an array of the core's targets; None where one of them is invalid."""
    core: Any = solver.core  # a solver without one was refused before
    if out is not None:
        _check_memory(solver, out, batch)
    reference = None if q_ref is None else _reference(solver, q_ref)
    targets = np.asarray(targets, order="C")
    values = None if values is None else np.asarray(values, order="C")  # also of no dimension
    solved: IKSolutions | None = core.many(
        IKSolutions, solver, solver.branches, targets, reference, values, threads, out
    )
    return solved


def _check_memory(solver: Solver, out: Any, batch: tuple[int, ...]) -> None:
    if not isinstance(out, IKSolutions) or out.solver is not solver or out.step is not None or out.shape != batch:
        shown = f"solutions of shape {out.shape}" if isinstance(out, IKSolutions) else quoted(out)
        raise ArgumentError(
            f"out={shown} given; what an earlier ik of this arm returned for targets of shape {batch}, unfiltered, is "
            "needed"
        )
    if not batch:
        raise ArgumentError("out given for a single target; it takes the solutions of a batch")


def _reference(solver: Solver, q_ref: ArrayLike) -> Array:
    q = solver.chain.check(q_ref)
    if q.shape != (solver.dof,):
        raise ArgumentError(f"q_ref of shape {q.shape} given; one joint vector ({solver.dof},) is needed")
    return np.where(solver.chain.prismatic, q, shortest(q))  # turns do not matter to an answer in (-pi, pi]


def near_each(solutions: IKSolutions, q_ref: Array) -> IKSolutions:
    """A batch as it was solved, singular poses solved again, each near its own joint vector of ``q_ref`` (..., n)."""
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
