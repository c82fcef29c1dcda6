"""The answers of ``ik`` that torch and jax differentiate: joint vectors, and the inverses that lead on from them."""

from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from urdf_ik.arm import Arm
from urdf_ik.errors import ArgumentError, UnsupportedArm
from urdf_ik.ik.pose_solving import solve
from urdf_ik.ik.solutions import IKSolutions
from urdf_ik.ik.solutions.derivatives import inverse, no_swivel
from urdf_ik.ik.solver import Solver
from urdf_ik.kinematics.chain.free_axis import FreeAxis
from urdf_ik.kinematics.chain.redundancy import FREE_AXIS
from urdf_ik.kinematics.derivatives import WrittenChain, written
from urdf_ik.support import inputs
from urdf_ik.support.tolerances import DEFAULT
from urdf_ik.typing import Array

FOLDS = ("raise", "nan", "clip")
"""What happens to the derivative at a singular solution: refused in words, NaN, or that of damped least squares."""


KEPT = 32
"""Arms whose functions are kept."""


class Branches(NamedTuple):
    """Joint vectors of every branch, as arrays of torch or of jax.

    Attributes:
        q: (..., B, n) rad or m, NaN where there is no solution.
        valid: (..., B) truth values.
    """

    q: Any
    valid: Any


class Answers(NamedTuple):
    """Joint vectors of every branch and what their derivatives follow from.

    Attributes:
        q: (..., B, n) rad or m, zeros where there is no solution.
        inverse: (..., B, n, 6 + k) joints by the target's twist and by redundancy parameters, zeros likewise.
        valid: (..., B) whether there is a solution.
    """

    q: Array
    inverse: Array
    valid: NDArray[np.bool_]


class Differentiable:
    """An arm as a function of poses, of redundancy parameters, and of its URDF's numbers.

    Attributes:
        geometry: the chain by the numbers of its URDF.
        free_axis: the line about which the target may turn, where its angle is the first redundancy parameter.
        held: indices of the joints that are redundancy parameters.
        count: number of redundancy parameters.
        defaults: (count,) their values where none are given.
        branches: number of columns.
    """

    def __init__(self, arm: Arm, at_folds: str) -> None:
        """Take an arm.

        Raises:
            ArgumentError: an unknown ``at_folds``.
            UnsupportedArm: a swivel angle is a redundancy parameter.
        """
        self._at_folds = inputs.choice(at_folds, "at_folds", FOLDS)
        self._solver: Solver = arm.solver
        self._solver.require_member()
        parameters = arm.solver.parameters
        others = [each for each in parameters if each.kind != FREE_AXIS]
        no_swivel(self._solver, "derivatives in torch and jax")
        self.geometry: WrittenChain = written(arm.chain)
        self.free_axis: FreeAxis | None = arm.solver.free_axis if len(others) < len(parameters) else None
        self.held = [arm.joint_names.index(each.joint) for each in others]
        self.count = len(parameters)
        self.defaults: Array = arm.solver.redundant_member.defaults if parameters else np.zeros(0)
        self.branches = len(self._solver.branches)

    def answers(self, T: Any, values: Any = None, redundancy: Any = None) -> Answers:
        """Every solution of poses (..., 4, 4).

        Args:
            T: poses [m].
            values: (p,) numbers of the URDF; None: as written.
            redundancy: (...) or (..., k) values of the redundancy parameters; None: the defaults.

        Raises:
            PoseError: an invalid pose.
            ArgumentError: a solution is singular, and ``at_folds`` is 'raise'.
            UnsupportedArm: the changed arm has other branches.
        """
        solver = self._solver if values is None else self._changed(np.asarray(values, dtype=np.float64))
        poses = np.ascontiguousarray(T, dtype=np.float64)
        found = solve(solver, poses, None, redundancy)
        columns = self._columns(solver)
        X = inverse(found)[..., : 6 + len(self.held)]
        folded = found.valid & np.isnan(X).any(axis=(-2, -1))
        if folded.any():
            X = self._at_fold(found, X, folded)
        q, X = (np.take(each, columns, axis=len(found.shape)) for each in (found.q, X))
        valid = np.take(found.valid, columns, axis=-1)
        return Answers(np.where(valid[..., None], q, 0.0), np.where(valid[..., None, None], X, 0.0), valid)

    def mapped(self, ranks: tuple[int, ...], T: Array, numbers: Array, *at: Array) -> Answers:
        """The answers under ``vmap``, of all poses in one call; of several geometries in one call each.

        ``vmap`` puts its axes before those of every argument, of length 1 where the argument is the same for all.

        Args:
            ranks: numbers of batch axes of the poses and of the redundancy parameters without ``vmap``.
            T: poses.
            numbers: the URDF's numbers, whose last axis alone is not from ``vmap``.
            *at: values of the redundancy parameters, if any.
        """
        mapped = numbers.ndim - 1
        most = max(ranks)
        T, *at_all = (
            array.reshape((*array.shape[:mapped], *(1,) * (most - rank), *array.shape[mapped:]))
            for array, rank in zip((T, *at), ranks, strict=True)
        )
        if numbers.size == numbers.shape[-1]:
            return self.answers(T, numbers.ravel(), *at_all)
        size = np.broadcast_shapes(*(array.shape[:mapped] for array in (T, numbers, *at_all)))
        T, numbers, *at_all = (
            np.broadcast_to(array, (*size, *array.shape[mapped:])) for array in (T, numbers, *at_all)
        )
        parts = [
            self.answers(T[place], numbers[place], *(values[place] for values in at_all)) for place in np.ndindex(size)
        ]
        return Answers(*(np.stack(column).reshape(*size, *column[0].shape) for column in zip(*parts, strict=True)))

    def _at_fold(self, found: IKSolutions, X: Array, folded: NDArray[np.bool_]) -> Array:
        """The inverses with those at singular solutions as asked."""
        if self._at_folds == "nan":
            return X
        if self._at_folds == "raise":
            *place, column = (int(k) for k in np.argwhere(folded)[0])
            where = f"pose {place}: " if place else ""
            raise ArgumentError(
                f"{where}the solution {found.branches[column]!r} is singular and has no derivative; at_folds='clip' "
                f"takes that of damped least squares, 'nan' leaves it open ({int(folded.sum())} such solutions)"
            )
        chain = found.solver.chain
        share = np.where(np.arange(6) < 3, 1.0 / chain.size, 1.0)
        own = np.where(chain.prismatic, chain.size, 1.0)
        A = chain.jacobian(found.q[folded]) * share[:, None]
        rows = np.broadcast_to(np.eye(chain.n)[self.held], (len(A), len(self.held), chain.n))
        U, s, Vt = np.linalg.svd(np.concatenate([A, rows], axis=1) * own, full_matrices=False)
        damped = np.swapaxes(Vt, 1, 2) @ ((s / (s**2 + DEFAULT.damped**2))[..., None] * np.swapaxes(U, 1, 2))
        damped = damped * own[:, None]
        damped[..., :6] *= share
        out = X.copy()
        out[folded] = damped
        return out

    def _changed(self, values: Array) -> Solver:
        """The solver of the arm with other numbers."""
        if values.shape != self.geometry.values.shape or not np.isfinite(values).all():
            raise ArgumentError(
                f"geometry of shape {values.shape} given; {len(self.geometry.values)} numbers are needed"
            )
        if np.array_equal(values, self.geometry.values):
            return self._solver
        return self._solver.again(chain=self._solver.chain.with_screws(*self.geometry.screws(values)))

    def _columns(self, solver: Solver) -> list[int]:
        """The columns of the arm's own branches in the answers of a changed one."""
        names = list(solver.branches)
        lost = [name for name in self._solver.branches if name not in names]
        if lost:
            raise UnsupportedArm(
                f"{solver.name}: with these numbers it is solved as {solver.structure.family}, which has no branch "
                f"{lost[0]!r}; keep its structure, or take smaller changes"
            )
        return [names.index(name) for name in self._solver.branches]


@lru_cache(maxsize=KEPT)
def differentiable(arm: Arm, at_folds: str) -> Differentiable:
    """The arm as a function, made once."""
    return Differentiable(arm, at_folds)
