"""From targets to their solutions."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from urdf_ik.errors import ArgumentError, PoseError, UnsupportedArm
from urdf_ik.ik.solutions import IKSolutions
from urdf_ik.kinematics.chain.redundancy import spread
from urdf_ik.model.poses import as_pose_array, check_poses
from urdf_ik.support import inputs
from urdf_ik.support.angles import shortest

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

    from urdf_ik.ik.solver import Solver
    from urdf_ik.ik.tasks import Targets

    Array = NDArray[np.float64]

_LINE = 8  # numbers in a cache line


def solve(
    solver: Solver, T: Any, q_ref: ArrayLike | None = None, redundancy: ArrayLike | None = None, threads: int = 1
) -> IKSolutions:
    """Every joint vector that brings the tip to ``T``; see :meth:`urdf_ik.Arm.ik`."""
    single: Any = solver.single
    if (
        single is not None
        and redundancy is None
        and type(threads) is int
        and threads == 1
        and T is not None
        and (q_ref is None or type(T) is np.ndarray)
    ):
        solutions: IKSolutions | None  # which the compiled core makes; None where the target is a batch or no array
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
        return _solve_task(solver, solver.targets, T, q_ref, threads)
    if type(T) is np.ndarray and T.shape == (4, 4) and T.dtype == np.float64:
        # A copy, so that the answer does not change when the caller's array does.
        target = T.copy()
    else:
        target = as_pose_array(T)
        target = target.copy() if target is T and target.ndim == 2 else target
    reference = None if q_ref is None else _reference(solver, q_ref)
    values = None
    if redundancy is not None:
        target, values = spread(solver.redundant_member.parameters, target, redundancy)
    batch = target.shape[:-2]
    q, flags, bad = _solve_stack(solver, target.reshape(-1, 4, 4), values, reference, threads)
    if bad >= 0:
        check_poses(target)  # names the first bad pose
        raise PoseError("a rotation that is neither orthonormal nor near it")
    q, flags = q.reshape(*batch, *q.shape[1:]), flags.reshape(*batch, flags.shape[1])
    return IKSolutions(solver, target, q, flags, solver.branches, redundancy=values)


def for_task(solver: Solver, task: str | None) -> Solver:
    """The solver of the same chain whose targets are those of a task; None: the solver itself.

    Raises:
        ArgumentError: there is no such task, or the arm cannot control it.
        UnsupportedArm: no solver takes this arm.
    """
    if task is None or task in solver.by_task:
        return solver if task is None else solver.by_task[task]
    if solver.free_axis is not None:
        raise ArgumentError(
            f"{solver.name}: with {solver.free_axis} free, targets are poses, and the rotation about it does not "
            f"matter; {task!r} is a task of the arm without a free axis"
        )
    made = solver.again(task=task)
    solver.by_task[task] = made
    made.by_task.update(solver.by_task)
    return made


def _solve_task(solver: Solver, targets: Targets, T: Any, q_ref: ArrayLike | None, threads: int) -> IKSolutions:
    """The solutions of targets of a task."""
    target = targets.read(T)
    batch = target.shape[:-1]
    stack = targets.for_solver(target.reshape(-1, target.shape[-1]))
    reference = None if q_ref is None else _reference(solver, q_ref)
    q, flags, bad = _solve_stack(solver, stack, None, reference, threads)
    if bad >= 0:
        raise PoseError(f"a target for the task {targets.task!r} is not finite, or its direction has no length")
    q, flags = q.reshape(*batch, *q.shape[1:]), flags.reshape(*batch, flags.shape[1])
    return IKSolutions(solver, target, q, flags, solver.branches)


def _solve_stack(
    solver: Solver, stack: Array, values: Array | None, q_ref: Array | None, threads: int
) -> tuple[Array, NDArray[np.uint8], int]:
    """Joint vectors (m, B, n) and flags (m, B) of targets (m, ...), and the index of the first bad target or -1.

    The numbers begin at a cache line: stores across cache lines cost a batch half of its speed.
    """
    core: Any = solver.core  # a solver without one was refused before
    shape = (len(stack), len(solver.branches), solver.dof)
    size = shape[0] * shape[1] * shape[2]
    numbers = np.empty(size + _LINE)
    start = -(numbers.__array_interface__["data"][0] // numbers.itemsize) % _LINE
    q, flags = numbers[start : start + size].reshape(shape), np.empty(shape[:2], np.uint8)
    bad = core.solve(stack, q_ref, q, flags, None if values is None else values.reshape(-1), threads)
    return q, flags, int(bad)


def _reference(solver: Solver, q_ref: ArrayLike) -> Array:
    q = solver.chain.check(q_ref)
    if q.shape != (solver.dof,):
        raise ArgumentError(f"q_ref of shape {q.shape} given; one joint vector ({solver.dof},) is needed")
    return np.where(solver.chain.prismatic, q, shortest(q))  # turns do not matter to an answer in (-pi, pi]
