"""Arm: what :func:`load` returns. It joins reading, chain, structure, family and solutions."""

from __future__ import annotations

import re
import sys
import threading
from contextlib import contextmanager
from dataclasses import replace
from functools import cached_property
from pathlib import Path
from typing import IO, TYPE_CHECKING, Any

import numpy as np

from urdf_ik import families
from urdf_ik._kernels.layout import BLOCK
from urdf_ik._kernels.target import to_frame_1
from urdf_ik.chain import Chain
from urdf_ik.errors import JointVectorError, PoseError, UnsupportedArm
from urdf_ik.poses import as_pose_array, check_poses
from urdf_ik.solutions import IKSolutions
from urdf_ik.structure import Structure, analyse

if TYPE_CHECKING:
    import os
    from collections.abc import Iterator, Sequence

    from numpy.typing import ArrayLike, NDArray

    from urdf_ik.collision import CollisionModel
    from urdf_ik.families.plan import Plan
    from urdf_ik.plane import Plane
    from urdf_ik.tasks import Control
    from urdf_ik.urdf import UrdfModel


class Arm:
    """A serial arm, read from a URDF and ready to be solved.

    Attributes:
        model: the URDF as it was read.
        chain: screw axes of the joints from base to tip.
        structure: relations of the axes, family, method and branches; ``str()`` reads like a sentence.
    """

    def __init__(self, model: UrdfModel, chain: Chain) -> None:
        self.model = model
        self.chain = chain
        self.structure: Structure = analyse(chain)
        self._no_reference = np.zeros(7)
        self._task_arms: dict[str, Arm] = {}
        self._plan: Plan | None = families.choose(self.structure, chain)
        if self._plan is not None:
            plan = self._plan
            self.structure = replace(
                self.structure,
                family=plan.family,
                method=plan.method,
                branches=plan.branches,
                imperfection=plan.imperfection,
            )
            self._adopt(plan)

    def _adopt(self, plan: Plan) -> None:
        self._solver, self._kernel, self._numbers = plan.solve, self._first_solve, plan.arm
        self._branches, self._shape = plan.branches, (1, len(plan.branches), self.chain.n)

    def __repr__(self) -> str:
        return f"<Arm {self.name!r}: {self.base} to {self.tip}, {self.structure.family or f'{self.dof} joints'}>"

    def __reduce__(self) -> tuple[type[Arm], tuple[UrdfModel, Chain]]:
        return Arm, (self.model, self.chain)

    @property
    def name(self) -> str:
        """The robot's name in the URDF."""
        return self.model.name

    @property
    def base(self) -> str:
        """Base link; poses are expressed in it."""
        return self.chain.base

    @property
    def tip(self) -> str:
        """Tip link, whose pose is solved for."""
        return self.chain.tip

    @property
    def joint_names(self) -> tuple[str, ...]:
        """Movable joints, base to tip."""
        return self.chain.joint_names

    @property
    def dof(self) -> int:
        """Number of movable joints."""
        return self.chain.n

    @property
    def limits(self) -> NDArray[np.float64]:
        """(n, 2) rad or m; a continuous joint has (-inf, inf)."""
        return self.chain.limits

    @cached_property
    def control(self) -> Control:
        """What the arm can control of its tip: the task, the plane, the tip's axis that is aimed."""
        from urdf_ik.tasks import control_of

        return control_of(self.chain)

    @property
    def task(self) -> str:
        """What the arm can control: 'pose', 'position', 'position and axis', 'planar position' or 'planar pose'."""
        return self.control.task

    @property
    def plane(self) -> Plane | None:
        """The plane in which a planar arm of two or three joints moves its tip, with its coordinates; else None."""
        return self.control.plane

    def for_task(self, task: str) -> Arm:
        """This arm, its ``ik`` and ``explain`` taking targets of a task; see :meth:`ik`.

        Raises:
            TaskError: there is no such task, or the arm cannot control it.
            UnsupportedArm: no solver takes this arm.
        """
        from urdf_ik.tasks import TaskArm

        if task == "pose":
            return self
        if task not in self._task_arms:
            self._task_arms[task] = TaskArm(self, task)
        return self._task_arms[task]

    @cached_property
    def collision_model(self) -> CollisionModel:
        """Self-collision of this URDF through Pinocchio and coal, built when first asked for."""
        from urdf_ik.collision import CollisionModel

        return CollisionModel(self.model, self.base, self.tip)

    def fk(self, q: ArrayLike) -> NDArray[np.float64]:
        """Pose of the tip in the base: (..., n) rad or m to (..., 4, 4); see :meth:`Chain.fk`."""
        return self.chain.fk(q)

    def jacobian(self, q: ArrayLike) -> NDArray[np.float64]:
        """Geometric Jacobian at the tip in base axes: (..., n) to (..., 6, n); see :meth:`Chain.jacobian`."""
        return self.chain.jacobian(q)

    def link_poses(self, q: ArrayLike) -> dict[str, NDArray[np.float64]]:
        """Pose of every link in the base: (..., n) to (..., 4, 4) each; see :meth:`Chain.link_poses`."""
        return self.chain.link_poses(q)

    def ik(
        self, T: Any, q_ref: ArrayLike | None = None, *, threads: int = 1, task: str | None = None
    ) -> IKSolutions:
        """Every joint vector that brings the tip to ``T``.

        Each solution was verified against the URDF as written: position and rotation errors are below 1e-9 m
        and rad. A pose out of reach gives an empty answer, which :meth:`IKSolutions.explain` explains. At a
        singularity that leaves a joint free, the answer holds one representative, marked in ``singular``: the
        free joint (of the shoulder or the wrist) stands at zero, or near ``q_ref`` where that is given.

        Args:
            T: (..., 4, 4) pose of the tip in the base [m], a ``pinocchio.SE3`` or a list of them. A rotation
                that is off by rounding (up to 1e-5) is replaced by the nearest one. The answer keeps a stack
                of poses by reference, for ``explain``; a single pose is copied.
            q_ref: (n,) rad, joint vector near which representatives of a continuum are chosen.
            threads: number of threads that share a batch.
            task: what ``T`` is; default: a pose. An arm with few joints controls less, and takes that as target too,
                see :attr:`task`: 'position' (..., 3) m in the base; 'position and axis' (..., 6), position and a
                direction in the base for the tip's z axis (its x axis, else y, where the joints do not control z: see
                ``arm.control.aimed``), or a pair of these; 'planar position' (..., 2) m and 'planar pose' (..., 3) m,
                m, rad in the arm's plane, see :attr:`plane`.

        Returns:
            The solutions, (..., B, n), one column a branch.

        Raises:
            PoseError: a target is no pose, or no target of the task; the error holds its index in the batch.
            TaskError: there is no such task, or the arm cannot control it.
            UnsupportedArm: no solver takes this arm.
        """
        if task is not None and task != "pose":
            return self.for_task(task).ik(T, q_ref, threads=threads)
        if self._plan is None:
            raise UnsupportedArm(f"{self.name}: no solver for this arm yet. {self.structure}")
        if type(T) is np.ndarray and T.shape == (4, 4) and T.dtype == np.float64:
            # A copy, so that the answer does not change when the caller's array does.
            target = T.copy()
        else:
            target = as_pose_array(T)
            target = target.copy() if target is T and target.ndim == 2 else target
        reference = self._no_reference if q_ref is None else self._reference(q_ref)
        if target.ndim == 2:
            q, flags = np.empty(self._shape), np.empty(self._shape[:2], np.uint8)
            if self._kernel(target[None], self._numbers, reference, q, flags) >= 0:
                self._refuse(target)
            return IKSolutions(self, target, q[0], flags[0], self._branches)
        batch = target.shape[:-2]
        stack = target.reshape(-1, 4, 4)
        q, flags = np.empty((len(stack), *self._shape[1:])), np.empty((len(stack), self._shape[1]), np.uint8)
        if self._solve_stack(stack, reference, q, flags, threads) >= 0:
            self._refuse(target)
        return IKSolutions(
            self, target, q.reshape(*batch, *q.shape[1:]), flags.reshape(*batch, flags.shape[1]), self._branches
        )

    def explain(self, T: Any) -> str:
        """Why the single pose ``T`` (4, 4) has no solution, with the number that is out of range.

        Raises:
            PoseError: ``T`` is no pose, or more than one.
            UnsupportedArm: no solver takes this arm.
        """
        target = check_poses(T)
        if target.ndim != 2:
            raise PoseError(f"an array of shape {target.shape} given; explain takes a single pose (4, 4)")
        if self._plan is None:
            raise UnsupportedArm(f"{self.name}: no solver for this arm yet. {self.structure}")
        seen = np.empty(12)
        to_frame_1(np.linalg.inv(target) if self._plan.mirrored else target, self._numbers, seen)
        return self._plan.explain(seen[:9].reshape(3, 3), seen[9:])

    def _solve_stack(
        self,
        T: NDArray[np.float64],
        reference: NDArray[np.float64],
        q: NDArray[np.float64],
        flags: NDArray[np.uint8],
        threads: int,
    ) -> int:
        """Solve (m, 4, 4) into ``q`` and ``flags``; index of the first bad pose, or -1."""
        if threads <= 1 or len(T) < 2 * BLOCK * threads:
            return self._kernel(T, self._numbers, reference, q, flags)
        bad = [-1] * threads
        failed: list[BaseException] = []
        # Shares of whole blocks: every pose is solved by the same instructions, however many threads there are.
        edges = [BLOCK * (k * (len(T) // BLOCK) // threads) for k in range(threads)] + [len(T)]

        def share(k: int) -> None:
            part = slice(edges[k], edges[k + 1])
            try:
                found = self._kernel(T[part], self._numbers, reference, q[part], flags[part])
            except BaseException as error:  # a thread would swallow it, and leave its share unsolved
                failed.append(error)
                return
            bad[k] = edges[k] + found if found >= 0 else -1

        helpers = [threading.Thread(target=share, args=(k,)) for k in range(1, threads)]
        for helper in helpers:
            helper.start()
        share(0)
        for helper in helpers:
            helper.join()
        if failed:
            raise failed[0]
        return min((index for index in bad if index >= 0), default=-1)

    def _reference(self, q_ref: ArrayLike) -> NDArray[np.float64]:
        reference = np.ones(self.dof + 1)
        q = self.chain.check(q_ref)
        if q.shape != (self.dof,):
            raise JointVectorError(f"q_ref of shape {q.shape} given; one joint vector ({self.dof},) is needed")
        # Turns do not matter to an answer in (-pi, pi].
        reference[:-1] = np.where(self.chain.prismatic, q, np.remainder(q + np.pi, 2.0 * np.pi) - np.pi)
        return reference

    def _refuse(self, T: NDArray[np.float64]) -> None:
        """Raise the error that says what is wrong with the first bad pose."""
        check_poses(T)
        raise PoseError("a rotation that is neither orthonormal nor near it")

    def _first_solve(self, *arguments: Any) -> int:
        """Solve, and say so should the compiler take long; from then on the kernel is called directly."""
        solve = self._solver
        with _patience(self.structure.family):
            bad = solve(*arguments)
        self._kernel = solve
        return bad


@contextmanager
def _patience(family: str) -> Iterator[None]:
    """Say on stderr what takes so long, should it take over two seconds."""
    text = f"urdf-ik: compiling the solver for {family!r} (once on this machine, up to half a minute) ..."
    timer = threading.Timer(2.0, lambda: print(text, file=sys.stderr, flush=True))
    timer.daemon = True
    timer.start()
    try:
        yield
    finally:
        timer.cancel()


def load(
    source: str | os.PathLike[str] | IO[Any],
    base: str | None = None,
    tip: str | None = None,
    *,
    mesh_roots: Sequence[str | os.PathLike[str]] = (),
) -> Arm:
    """Read a URDF and prepare its solver.

    Args:
        source: a path, XML text, an open file, or a catalogue name such as 'zyyzyz_6r' or 'ur5'.
        base: base link; default: the root, where only one chain comes into question.
        tip: tip link; default: the end of the only movable chain.
        mesh_roots: folders that meshes may be read from, besides the URDF's own.

    Raises:
        UrdfError: the URDF is broken; the error names line, element and mend.
        ChainError: base or tip is unknown or ambiguous; the error lists the candidates.
        CatalogueError: a name that the catalogue does not hold.
        UnsupportedArm: a joint of the chain cannot be handled.
    """
    from urdf_ik import catalogue, urdf

    if isinstance(source, str) and _is_name(source):
        entry = catalogue.resolve(source)
        source, base, tip = entry.path, base or entry.base, tip or entry.tip
        mesh_roots = (*mesh_roots, *entry.package_dirs)
    model = urdf.read(source, mesh_roots=mesh_roots)
    return Arm(model, Chain.from_urdf(model, base, tip))


def _is_name(source: str) -> bool:
    """Whether ``source`` can only be meant as a catalogue name: no markup, no folder, no ending, no such file."""
    return bool(re.fullmatch(r"[\w-]+", source)) and not Path(source).exists()
