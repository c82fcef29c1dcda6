"""The arm: its kinematics, its solutions, and what it reaches of higher rooms when asked."""

from __future__ import annotations

from dataclasses import replace
from functools import cached_property
from typing import TYPE_CHECKING, Any, Self

import numpy as np

from urdf_ik.arm.freedom import Free
from urdf_ik.arm.html import html
from urdf_ik.errors import ArgumentError, PoseError, UnsupportedArm
from urdf_ik.ik import families
from urdf_ik.ik.families import FamilyMember, RedundantMember
from urdf_ik.ik.families.wrappers import axis_free
from urdf_ik.ik.redundancy import nearest, region_search, sweep
from urdf_ik.ik.refusals import check_free_axis, check_given, unsupported
from urdf_ik.ik.solutions import IKSolutions
from urdf_ik.ik.solutions.representatives import near_each
from urdf_ik.ik.tasks import TASKS, Targets
from urdf_ik.kinematics.chain.redundancy import spread
from urdf_ik.kinematics.structure import Structure, analyse
from urdf_ik.model.poses import as_pose_array, check_poses
from urdf_ik.support import inputs
from urdf_ik.support.angles import shortest
from urdf_ik.support.text import quoted

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

    from urdf_ik._core import Solver
    from urdf_ik.ik.redundancy import Region
    from urdf_ik.ik.solutions.distances import Metric
    from urdf_ik.kinematics.chain import Chain
    from urdf_ik.kinematics.chain.free_axis import FreeAxis
    from urdf_ik.model.urdf import UrdfModel

    Array = NDArray[np.float64]

_LINE = 8  # numbers in a cache line


class Arm(Free):
    """A serial arm, read from a URDF and ready to be solved.

    Attributes:
        model: the URDF as it was read.
        chain: screw axes of the joints from base to tip.
        structure: relations of the axes, family, method and branches; ``str()`` reads like a sentence.

    Example:
        >>> import urdf_ik
        >>> arm = urdf_ik.load("zyyzyz_6r")
        >>> arm.dof, arm.task, arm.structure.family
        (6, 'pose', '6R spherical wrist, 2||3 and 1x2')
    """

    def __init__(
        self,
        model: UrdfModel,
        chain: Chain,
        task: str = "pose",
        free_axis: FreeAxis | None = None,
        given: tuple[str, ...] = (),
    ) -> None:
        """Analyse the chain and prepare its solver.

        Args:
            model: the URDF.
            chain: the joints from base to tip.
            task: what ``ik`` takes as target where it is not said there; see :meth:`ik`.
            free_axis: a line in the tip about which it may be turned; see :meth:`with_free_axis`.
            given: names of joints whose values are the redundancy parameters; see :meth:`with_redundancy`.

        Raises:
            ChainError: one of ``given`` is no joint of the chain.
            ArgumentError: more joints are given than a pose leaves free, or ``free_axis`` is no axis.
            ArgumentError: there is no such task, or the arm cannot control it, or its tip cannot turn about an axis.
            UnsupportedArm: no solver takes this arm for a task other than 'pose'.
        """
        inputs.kind(model, "joints", "model", "a URDF, as urdf_ik.load(...).model is,")
        inputs.kind(chain, "image_turns", "chain", "a chain, as urdf_ik.load(...).chain is,")
        super().__init__(model, chain, free_axis)
        given = check_given(self.name, chain, given)
        if not isinstance(task, str):
            raise ArgumentError(f"task={quoted(task)} given; one of {', '.join(map(repr, TASKS))} is needed")
        self.structure: Structure = analyse(chain)
        self._by_task: dict[str, Arm] = {task: self}
        self._core: Solver | None = None
        self._task, self._given = task, given
        # How targets of a task other than a pose are read.
        self._targets: Targets | None = None if task == "pose" else Targets(self.name, chain, self.control, task)
        plan = self._targets.plan(self.structure) if self._targets else families.choose(self.structure, chain, given)
        if plan is None and given:
            raise UnsupportedArm(f"{self.name}: no solver for the other joints with {', '.join(given)} given")
        if free_axis is not None:
            check_free_axis(self.name, chain, free_axis, plan, self.task if task == "pose" else task)
        if plan is not None and free_axis is not None:
            plan = axis_free.prepare(chain, plan, free_axis)
        self._plan: FamilyMember | None = plan
        if plan is not None:
            self.structure = replace(
                self.structure,
                family=plan.name,
                reason=plan.reason,
                method=plan.method,
                branches=plan.branches,
                imperfection=plan.imperfection,
                error=plan.error,
                is_general=plan.family.by_elimination and chain.n == 6,
                by_quadratics=plan.by_quadratics,
            )
            self._core = plan.solver
            self._branches, self._shape = plan.branches, (1, len(plan.branches), chain.n)
        # The solver where targets are poses: it takes a single one without detours.
        self._of_single_poses = None if self._targets else self._core

    def _repr_html_(self) -> str:
        return html(self)

    def __repr__(self) -> str:
        return f"<Arm {self.name!r}: {self.base} to {self.tip}, {self.structure.family or f'{self.dof} joints'}>"

    def __reduce__(self) -> tuple[type[Arm], tuple[Any, ...], dict[str, Any] | None]:
        # The collision model is built when it is asked for; only what a user changed of it must not be lost.
        own = self.__dict__.get("collision_model")
        kept = {"collision_model": own} if own is not None and own.is_changed else None
        return Arm, (self.model, self.chain, self._task, self._free_axis, self._given), kept

    def _again(self, **changed: Any) -> Self:
        make: Any = type(self)
        settings: dict[str, Any] = {"free_axis": self._free_axis, "given": self._given, **changed}
        model, chain = settings.pop("model", self.model), settings.pop("chain", self.chain)
        made: Self = make(model, chain, self._task, **settings)
        return made

    def for_task(self, task: str) -> Arm:
        """This arm, its ``ik`` and ``explain`` taking targets of a task; see :meth:`ik`.

        Raises:
            ArgumentError: there is no such task, or the arm cannot control it.
            UnsupportedArm: no solver takes this arm.

        Example:
            >>> import urdf_ik
            >>> arm = urdf_ik.load("planar_2r").for_task("planar position")
            >>> len(arm.ik([0.1, 0.1]))
            2
        """
        if not isinstance(task, str):
            raise ArgumentError(f"task={quoted(task)} given; one of {', '.join(map(repr, TASKS))} is needed")
        if task not in self._by_task:
            if self._free_axis is not None:
                raise ArgumentError(
                    f"{self.name}: with {self._free_axis} free, targets are poses, of which the rotation about it does "
                    f"not matter; {quoted(task)} is a task of the arm without a free axis"
                )
            self._by_task[task] = arm = Arm(self.model, self.chain, task)
            arm._by_task = self._by_task
        return self._by_task[task]

    @cached_property
    def cuspidal(self) -> bool | None:
        """Whether the arm can change from one solution of a pose to another without crossing a singularity.

        False and True are proven, joint limits aside; None where neither a proof nor a path was found, and where no
        solver takes the arm. Found when first asked for, which takes up to a second; see :mod:`urdf_ik.ik.cuspidality`.
        """
        from urdf_ik.ik.cuspidality import is_cuspidal

        return is_cuspidal(self)

    def ik(
        self,
        T: Any,
        q_ref: ArrayLike | None = None,
        *,
        redundancy: ArrayLike | None = None,
        threads: int = 1,
        task: str | None = None,
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
            redundancy: (...) rad or m, values of the redundancy parameter of an arm with seven joints or a free axis,
                which broadcast against the poses: ``ik(T[:, None], redundancy=values)`` solves every pose at every
                value. Default: ``self.redundancy.default``. (..., k) for an arm with k parameters.
            threads: number of threads that share a batch.
            task: what ``T`` is; default: a pose. An arm with few joints controls less, and takes that as target too,
                see :attr:`task`: 'position' (..., 3) m in the base; 'position and axis' (..., 6), position and a
                direction in the base for the tip's z axis (its x axis, else y, where the joints do not control z: see
                ``arm.control.aimed``), or a pair of these; 'planar position' (..., 2) m and 'planar pose' (..., 3) m,
                m, rad in the arm's plane, see :attr:`plane`.

        Returns:
            The solutions, (..., B, n), one column a branch. Those of seven joints are all there are at the value that
            is given, and ``singular`` says where the Jacobian drops rank while it is kept.

        Raises:
            PoseError: a target is no pose, or no target of the task; the error holds its index in the batch.
            ArgumentError: ``q_ref`` or ``redundancy`` does not fit.
            ArgumentError: there is no such task, or the arm cannot control it.
            UnsupportedArm: no solver takes this arm.

        Example:
            >>> import urdf_ik
            >>> arm = urdf_ik.load("zyyzyz_6r")
            >>> s = arm.ik(arm.fk([0.3, -0.5, 0.8, 0.4, 0.7, -0.2]))
            >>> for solution in s.within_limits():
            ...     print(solution.branch)
            shoulder front, elbow up, wrist noflip
            shoulder front, elbow up, wrist flip
            shoulder front, elbow down, wrist noflip
            shoulder front, elbow down, wrist flip
            shoulder back, elbow up, wrist noflip
            shoulder back, elbow up, wrist flip
            shoulder back, elbow down, wrist noflip
            shoulder back, elbow down, wrist flip
        """
        if task is not None and not (isinstance(task, str) and task == self._task):
            return self.for_task(task).ik(T, q_ref, redundancy=redundancy, threads=threads)
        single: Any = self._of_single_poses
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
                solutions = single.one(IKSolutions, self, self._branches, T)
            else:
                solutions = single.one_near(IKSolutions, self, self._branches, T, self._reference(q_ref))
            if solutions is not None:
                return solutions
        if self._plan is None:
            raise unsupported(self.name, self.chain, self.structure)
        threads = inputs.threads(threads)
        if self._targets is not None:
            if redundancy is not None:
                raise UnsupportedArm(f"{self.name}: targets of the task {self._task!r} leave nothing free")
            return self._ik_of_task(self._targets, T, q_ref, threads)
        if type(T) is np.ndarray and T.shape == (4, 4) and T.dtype == np.float64:
            # A copy, so that the answer does not change when the caller's array does.
            target = T.copy()
        else:
            target = as_pose_array(T)
            target = target.copy() if target is T and target.ndim == 2 else target
        reference = None if q_ref is None else self._reference(q_ref)
        values = None
        if redundancy is not None:
            target, values = spread(self._redundant_plan().parameters, target, redundancy)
        batch = target.shape[:-2]
        stack = target.reshape(-1, 4, 4)
        q, flags = self._room(len(stack))

        if self._fill(stack, values, reference, q, flags, threads) >= 0:
            self._refuse(target)
        q, flags = q.reshape(*batch, *q.shape[1:]), flags.reshape(*batch, flags.shape[1])
        return IKSolutions(self, target, q, flags, self._branches, redundancy=values)

    def _ik_of_task(self, targets: Targets, T: Any, q_ref: ArrayLike | None, threads: int) -> IKSolutions:
        """The solutions of targets of a task."""
        target = targets.read(T)
        batch = target.shape[:-1]
        stack = targets.for_solver(target.reshape(-1, target.shape[-1]))
        reference = None if q_ref is None else self._reference(q_ref)
        q, flags = self._room(len(stack))
        if self._fill(stack, None, reference, q, flags, threads) >= 0:
            raise PoseError(f"a target for the task {targets.task!r} is not finite, or its direction has no length")
        q, flags = q.reshape(*batch, *q.shape[1:]), flags.reshape(*batch, flags.shape[1])
        return IKSolutions(self, target, q, flags, self._branches)

    def _room(self, m: int) -> tuple[Array, NDArray[np.uint8]]:
        """Arrays for the answers of m poses: joint vectors (m, B, n) that begin at a cache line, and flags (m, B).

        Stores across cache lines cost a batch half of its speed.
        """
        size = m * self._shape[1] * self._shape[2]
        numbers = np.empty(size + _LINE)
        start = -(numbers.__array_interface__["data"][0] // numbers.itemsize) % _LINE
        q = numbers[start : start + size].reshape(m, *self._shape[1:])
        return q, np.empty((m, self._shape[1]), np.uint8)

    def _fill(
        self,
        stack: Array,
        values: Array | None,
        q_ref: Array | None,
        q: Array,
        flags: NDArray[np.uint8],
        threads: int,
    ) -> int:
        """Solve targets (m, ...), at these values of the redundancy parameter; index of the first bad one or -1."""
        assert self._core is not None  # an arm without a solver is refused before
        return self._core.solve(stack, q_ref, q, flags, None if values is None else values.reshape(-1), threads)

    def ik_nearest(
        self,
        T: Any,
        q_ref: ArrayLike,
        *,
        metric: Metric = "l2",
        weights: ArrayLike | None = None,
        within: ArrayLike | None = None,
        within_limits: bool = True,
        region: Region | None = None,
        threads: int = 1,
        task: str | None = None,
    ) -> IKSolutions:
        """The joint vector nearest to ``q_ref``: of all solutions, and over all values of a redundancy parameter.

        Args:
            T: as in ``ik``.
            q_ref: (n,), or one for each pose (..., n), rad or m.
            metric: 'l2', 'max' or 'time', the distance; see :meth:`IKSolutions.nearest`, also for the next three.
            weights: (n,) of the joints in the distance.
            within: rad or m that no joint may be further away, one number or one a joint.
            within_limits: whether only what lies inside the joint limits counts.
            region: how far the tip may be from ``T``, see :class:`urdf_ik.Region`; the ``poses`` of the answer are
                those that were chosen in it. The optimum is local, see
                :mod:`urdf_ik.ik.redundancy.region_search`; so it is for an arm with several redundancy parameters.
            threads: number of threads that share the work.
            task: what ``T`` is; see ``ik``.

        Returns:
            One column a pose; of a continuum what ``ik`` gives near ``q_ref``, its free joint there. With seven
            joints, ``redundancy`` holds the values of the parameter, of all in :meth:`intervals`, to 1e-8.

        Raises:
            PoseError: a target is no pose.
            ArgumentError: ``q_ref``, ``weights`` or ``within`` does not fit.
            ArgumentError: there is no such metric, or ``within`` is negative.
            ArgumentError: there is no such task, or the arm cannot control it.
            UnsupportedArm: no solver takes this arm.

        Example:
            >>> import urdf_ik
            >>> arm = urdf_ik.load("zyyzyz_6r")
            >>> q = [0.3, -0.5, 0.8, 0.4, 0.7, -0.2]
            >>> arm.ik_nearest(arm.fk(q), q).q.round(6).tolist()
            [[0.3, -0.5, 0.8, 0.4, 0.7, -0.2]]
        """
        if task is not None and not (isinstance(task, str) and task == self._task):
            arm = self.for_task(task)
            return arm.ik_nearest(
                T, q_ref, metric=metric, weights=weights, within=within, within_limits=within_limits, threads=threads
            )
        options: Any = {"metric": metric, "weights": weights, "within": within, "within_limits": within_limits}
        if region is not None or len(self.redundancies) > 1:
            if self._plan is None:
                raise unsupported(self.name, self.chain, self.structure)
            if self._targets is not None:
                raise ArgumentError(f"{self.name}: a region is one of poses, not of the task {self._task!r}")
            if region is not None and self._free_axis is not None:
                raise ArgumentError(f"{self.name}: {self._free_axis} is free; a region has rotation=pi for that")
            return region_search.nearest(self, T, q_ref, region, threads=threads, **options)
        if isinstance(self._plan, RedundantMember):
            return nearest.nearest(self, self._plan, T, q_ref, threads=threads, **options)
        reference = self.chain.check(q_ref)
        near = reference if reference.ndim == 1 else None
        solutions = self.ik(T, near, threads=threads)
        solutions = near_each(solutions, reference) if near is None else solutions
        return solutions.nearest(reference, **options)

    def explain(self, T: Any, redundancy: ArrayLike | None = None) -> str:
        """Why the single pose ``T`` (4, 4) has no solution inside the joint limits, with what is out of range.

        '' where it has one, with seven joints at any value of the parameter. Limits are named only where there are
        solutions outside them.

        Args:
            T: the pose.
            redundancy: the redundancy parameter, (k,) of k of them; default: their defaults.

        Raises:
            PoseError: ``T`` is no pose, or more than one.
            UnsupportedArm: no solver takes this arm.

        Example:
            >>> import urdf_ik
            >>> arm = urdf_ik.load("zyyzyz_6r")
            >>> arm.explain(urdf_ik.pose([0.0, 0.0, 4.0]))
            'wrist centre 2.8 m from the shoulder (axis 2), reach 2.1 m'
            >>> arm.explain(arm.fk([0.3, -0.5, 0.8, 0.4, 0.7, -0.2]))
            ''
        """
        found = self.ik(T, redundancy=redundancy)
        if not found.shape and found.count:
            why = found.within_limits().explain()
            elsewhere = why and redundancy is None and len(self.redundancies) == 1
            return "" if elsewhere and len(self.intervals(T)) else why
        if self._targets is not None:
            target = self._targets.read(T)
            if target.ndim != 1:
                raise PoseError(f"an array of shape {target.shape} given; explain takes a single target")
            assert self._plan is not None  # a task without a solver is refused when it is chosen
            return self._plan.explain(self._targets.poses(target[None])[0])
        target = check_poses(T)
        if target.ndim != 2:
            raise PoseError(f"an array of shape {target.shape} given; explain takes a single pose (4, 4)")
        if self._plan is None:
            raise unsupported(self.name, self.chain, self.structure)
        if redundancy is None and not isinstance(self._plan, RedundantMember):
            return self._plan.explain(target)
        plan = self._redundant_plan()
        if len(plan.parameters) == 1:
            return sweep.explanation(self, plan, target, redundancy)
        _, values = spread(plan.parameters, target, plan.defaults if redundancy is None else redundancy)
        if values.ndim != 1:
            raise ArgumentError(
                f"redundancy of shape {values.shape} given; explain takes one value of each of the "
                f"{len(plan.parameters)} parameters"
            )
        return plan.explain_at(target, values)

    def _reference(self, q_ref: ArrayLike) -> Array:
        q = self.chain.check(q_ref)
        if q.shape != (self.dof,):
            raise ArgumentError(f"q_ref of shape {q.shape} given; one joint vector ({self.dof},) is needed")
        return np.where(self.chain.prismatic, q, shortest(q))  # turns do not matter to an answer in (-pi, pi]

    def _refuse(self, T: Array) -> None:
        """Raise the error that says what is wrong with the first bad pose."""
        check_poses(T)
        raise PoseError("a rotation that is neither orthonormal nor near it")
