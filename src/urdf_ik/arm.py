"""Arm: what :func:`load` returns. It joins reading, chain, structure, family and solutions."""

from __future__ import annotations

import re
from dataclasses import replace
from functools import cached_property, partial
from pathlib import Path
from typing import IO, TYPE_CHECKING, Any

import numpy as np

from urdf_ik import families, velocity
from urdf_ik.chain import Chain, from_urdf
from urdf_ik.chain.mimic import CoupledChain
from urdf_ik.cuspidality import is_cuspidal
from urdf_ik.errors import JointVectorError, PoseError, UnsupportedArm
from urdf_ik.families.few_joints import is_redundant, kinds_of
from urdf_ik.families.parts.plan import Plan, RedundantPlan
from urdf_ik.poses import as_pose_array, check_poses
from urdf_ik.redundancy import self_motion
from urdf_ik.solutions import IKSolutions
from urdf_ik.structure import Structure, analyse

if TYPE_CHECKING:
    import os
    from collections.abc import Mapping, Sequence

    from numpy.typing import ArrayLike, NDArray

    from urdf_ik._core import Solver
    from urdf_ik.chain.plane import Plane
    from urdf_ik.chain.redundancy import Redundancy
    from urdf_ik.collision import CollisionModel
    from urdf_ik.redundancy.self_motion import Sweep
    from urdf_ik.tasks import Control
    from urdf_ik.urdf import UrdfModel

# Numbers in a cache line.
_LINE = 8


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
        self._task_arms: dict[str, Arm] = {}
        self._core: Solver | None = None
        self._plan: Plan | RedundantPlan | None = families.choose(self.structure, chain)
        if self._plan is not None:
            plan = self._plan
            self.structure = replace(
                self.structure,
                family=plan.family,
                method=plan.method,
                branches=plan.branches,
                imperfection=plan.imperfection,
                error=plan.error,
                find_cuspidal=partial(is_cuspidal, self),
            )
            self._adopt(plan)

    def _adopt(self, plan: Plan | RedundantPlan) -> None:
        self._core = plan.solver
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

    @property
    def locked(self) -> dict[str, float]:
        """Joints that ``load`` was told to hold, with their values [rad or m]."""
        return dict(self.chain.locked)

    @property
    def redundancy(self) -> Redundancy | None:
        """What is free in a pose's solutions of an arm with seven joints; None for an arm without such a parameter."""
        return getattr(self._plan, "parameter", None)

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

        return CollisionModel(self.model, self.base, self.tip, locked=self.locked)

    def fk(self, q: ArrayLike) -> NDArray[np.float64]:
        """Pose of the tip in the base: (..., n) rad or m to (..., 4, 4); see :meth:`Chain.fk`."""
        return self.chain.fk(q)

    def jacobian(self, q: ArrayLike) -> NDArray[np.float64]:
        """Geometric Jacobian at the tip in base axes: (..., n) to (..., 6, n); see :meth:`Chain.jacobian`."""
        return self.chain.jacobian(q)

    def manipulability(self, q: ArrayLike, part: str = "all") -> NDArray[np.float64]:
        """Yoshikawa's manipulability: (..., n) to (...); see :func:`urdf_ik.velocity.manipulability`."""
        return velocity.manipulability(self.chain, q, part)

    def condition_number(self, q: ArrayLike, part: str = "all", length: float | None = None) -> NDArray[np.float64]:
        """Condition of the Jacobian: (..., n) to (...); see :func:`urdf_ik.velocity.condition_number`."""
        return velocity.condition_number(self.chain, q, part, length)

    def singular_directions(self, q: ArrayLike, **options: float) -> velocity.SingularDirections:
        """Twists lost, motions that do nothing at ``q`` (..., n); see :func:`urdf_ik.velocity.singular_directions`."""
        return velocity.singular_directions(self.chain, q, **options)

    def joint_velocities(self, q: ArrayLike, twist: ArrayLike, **options: Any) -> NDArray[np.float64]:
        """Joint velocities (..., n) for a twist (..., 6) of the tip; see :func:`urdf_ik.velocity.joint_velocities`."""
        return velocity.joint_velocities(self.chain, q, twist, **options)

    def link_poses(self, q: ArrayLike) -> dict[str, NDArray[np.float64]]:
        """Pose of every link in the base: (..., n) to (..., 4, 4) each; see :meth:`Chain.link_poses`."""
        return self.chain.link_poses(q)

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
            redundancy: (...) rad or m, values of the redundancy parameter of an arm with seven joints, which broadcast
                against the poses: ``ik(T[:, None], redundancy=values)`` solves every pose at every value. Default:
                ``self.redundancy.default``.
            threads: number of threads that share a batch.
            task: what ``T`` is; default: a pose. An arm with few joints controls less, and takes that as target too,
                see :attr:`task`: 'position' (..., 3) m in the base; 'position and axis' (..., 6), position and a
                direction in the base for the tip's z axis (its x axis, else y, where the joints do not control z: see
                ``arm.control.aimed``), or a pair of these; 'planar position' (..., 2) m and 'planar pose' (..., 3) m,
                m, rad in the arm's plane, see :attr:`plane`.

        Returns:
            The solutions, (..., B, n), one column a branch. Those of seven joints are all there are at the value that
            is given, and ``singular`` tells where the Jacobian drops rank while it is kept.

        Raises:
            PoseError: a target is no pose, or no target of the task; the error holds its index in the batch.
            JointVectorError: ``q_ref`` or ``redundancy`` does not fit.
            TaskError: there is no such task, or the arm cannot control it.
            UnsupportedArm: no solver takes this arm.
        """
        if task is not None and task != "pose":
            return self.for_task(task).ik(T, q_ref, threads=threads)
        core = self._core
        if core is not None and redundancy is None and T is not None and (q_ref is None or type(T) is np.ndarray):
            solutions: IKSolutions | None  # which the compiled core makes; None where the target is a batch or no array
            compiled: Any = core
            if q_ref is None:
                solutions = compiled.one(IKSolutions, self, self._branches, T)
            else:
                solutions = compiled.one_near(IKSolutions, self, self._branches, T, self._reference(q_ref))
            if solutions is not None:
                return solutions
        if self._plan is None:
            raise self._unsupported()
        if type(T) is np.ndarray and T.shape == (4, 4) and T.dtype == np.float64:
            # A copy, so that the answer does not change when the caller's array does.
            target = T.copy()
        else:
            target = as_pose_array(T)
            target = target.copy() if target is T and target.ndim == 2 else target
        reference = None if q_ref is None else self._reference(q_ref)
        values = None
        if redundancy is not None:
            target, values = self._redundant_plan().parameter.spread(target, redundancy)
        batch = target.shape[:-2]
        stack = target.reshape(-1, 4, 4)
        q, flags = self._room(len(stack))

        if self._fill(stack, values, reference, q, flags, threads) >= 0:
            self._refuse(target)
        q, flags = q.reshape(*batch, *q.shape[1:]), flags.reshape(*batch, flags.shape[1])
        return IKSolutions(self, target, q, flags, self._branches, redundancy=values)

    def _room(self, m: int) -> tuple[NDArray[np.float64], NDArray[np.uint8]]:
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
        stack: NDArray[np.float64],
        values: NDArray[np.float64] | None,
        q_ref: NDArray[np.float64] | None,
        q: NDArray[np.float64],
        flags: NDArray[np.uint8],
        threads: int,
    ) -> int:
        """Solve targets (m, ...), at these values of the redundancy parameter; index of the first bad one or -1."""
        assert self._core is not None  # an arm without a solver is refused before
        return self._core.solve(stack, q_ref, q, flags, None if values is None else values.reshape(-1), threads)

    def redundancy_of(self, q: ArrayLike) -> NDArray[np.float64]:
        """Value of the redundancy parameter at joint vectors (..., 7), (...): ``ik`` finds them again at it.

        Raises:
            JointVectorError: the last dimension is not 7, or a value is not finite.
            UnsupportedArm: the arm has no such parameter.
        """
        plan = self._redundant_plan()
        Q = self.chain.check(q)
        return plan.value_of(Q.reshape(-1, self.dof)).reshape(Q.shape[:-1])

    def ik_nearest(self, T: Any, q_ref: ArrayLike, *, threads: int = 1) -> IKSolutions:
        """The joint vector nearest to ``q_ref`` within the limits, over all values of the redundancy parameter.

        Args:
            T: as in ``ik``.
            q_ref: (7,), or one for each pose (..., 7), rad or m.
            threads: number of threads that share the work.

        Returns:
            One column a pose; its values of the parameter are ``redundancy``. See
            :mod:`urdf_ik.redundancy.self_motion` for how it is searched, and what may be missed.

        Raises:
            PoseError: a target is no pose.
            JointVectorError: ``q_ref`` does not fit.
            UnsupportedArm: the arm has no redundancy parameter.
        """
        return self_motion.nearest(self, self._redundant_plan().parameter, T, q_ref, threads)

    def sweep(self, T: Any, n: int = 64, *, within_limits: bool = False, threads: int = 1) -> Sweep:
        """The solutions of one pose at ``n`` values of the redundancy parameter, and where there are any.

        Args:
            T: (4, 4) pose of the tip in the base [m], or a ``pinocchio.SE3``.
            n: number of values, shared among the intervals in which there are solutions by their lengths.
            within_limits: only solutions inside the joint limits count.
            threads: number of threads that share the work.

        Returns:
            See :class:`urdf_ik.redundancy.Sweep`.

        Raises:
            PoseError: ``T`` is no pose, or more than one.
            UnsupportedArm: the arm has no redundancy parameter.
        """
        return self_motion.sweep(self, self._redundant_plan().parameter, T, n, within_limits, threads)

    def explain(self, T: Any, redundancy: float | None = None) -> str:
        """Why the single pose ``T`` (4, 4) has no solution, with the number that is out of range.

        Args:
            T: the pose.
            redundancy: the parameter of an arm with seven joints; default: its default.

        Raises:
            PoseError: ``T`` is no pose, or more than one.
            UnsupportedArm: no solver takes this arm.
        """
        target = check_poses(T)
        if target.ndim != 2:
            raise PoseError(f"an array of shape {target.shape} given; explain takes a single pose (4, 4)")
        if self._plan is None:
            raise self._unsupported()
        if redundancy is None and not isinstance(self._plan, RedundantPlan):
            return self._plan.explain(target)
        return self_motion.explanation(self, self._redundant_plan(), target, redundancy)

    def _redundant_plan(self) -> RedundantPlan:
        """The plan of an arm with a redundancy parameter."""
        if self._plan is None:
            raise self._unsupported()
        if isinstance(self._plan, RedundantPlan):
            return self._plan
        raise UnsupportedArm(
            f"{self.name}: {self.dof} joints ({', '.join(self.joint_names)}) leave nothing free in a pose; "
            "only arms with seven have a redundancy parameter"
        )

    def _unsupported(self) -> UnsupportedArm:
        """The error for an arm without a solver."""
        if isinstance(self.chain, CoupledChain):
            return UnsupportedArm(
                f"{self.name}: {families.coupled.why_not(self.chain)}; joints that mimic others: "
                f"{', '.join(map(str, self.chain.followers))}; independent: {', '.join(self.joint_names)}"
            )
        if self.dof == 0:
            return UnsupportedArm(f"{self.name}: no joint moves between {self.base!r} and {self.tip!r}")
        if is_redundant(self.chain) and self.dof <= 6:
            return UnsupportedArm(
                f"{self.name}: joints repeat one another at every joint vector, so that a pose has a continuum of "
                f"solutions or none: joints {', '.join(self.joint_names)} are {kinds_of(self.chain)}. {self.structure}"
            )
        if self.dof == 6:
            return UnsupportedArm(
                f"{self.name}: no solver for two slides three joints apart ({kinds_of(self.chain)}) without a "
                "spherical wrist at either end; one of them held at a value, as in "
                f"urdf_ik.load(..., locked={{name: 0.0}}), leaves five joints that are solved. {self.structure}"
            )
        if self.dof <= 7:
            return UnsupportedArm(f"{self.name}: no solver for this arm yet. {self.structure}")
        held = ", ".join(f"{name!r}: 0.0" for name in self.joint_names[: self.dof - 7])
        return UnsupportedArm(
            f"{self.name}: {self.dof} joints from {self.base!r} to {self.tip!r} ({', '.join(self.joint_names)}); at "
            f"most seven are solved: hold {self.dof - 7} or more of them, each at a value [rad or m], as in "
            f"urdf_ik.load(..., locked={{{held}}})"
        )

    def _reference(self, q_ref: ArrayLike) -> NDArray[np.float64]:
        q = self.chain.check(q_ref)
        if q.shape != (self.dof,):
            raise JointVectorError(f"q_ref of shape {q.shape} given; one joint vector ({self.dof},) is needed")
        # Turns do not matter to an answer in (-pi, pi].
        return np.where(self.chain.prismatic, q, np.remainder(q + np.pi, 2.0 * np.pi) - np.pi)

    def _refuse(self, T: NDArray[np.float64]) -> None:
        """Raise the error that says what is wrong with the first bad pose."""
        check_poses(T)
        raise PoseError("a rotation that is neither orthonormal nor near it")


def load(
    source: str | os.PathLike[str] | IO[Any],
    base: str | None = None,
    tip: str | None = None,
    *,
    locked: Mapping[str, float] | None = None,
    mesh_roots: Sequence[str | os.PathLike[str]] = (),
) -> Arm:
    """Read a URDF and prepare its solver.

    Args:
        source: a path, XML text, an open file, or a catalogue name such as 'zyyzyz_6r' or 'ur5'.
        base: base link; default: the root, where only one chain comes into question.
        tip: tip link; default: the end of the only movable chain.
        locked: joints of the chain that are held at these values [rad or m]; the arm is that of the others. An arm
            with more than seven joints needs it to be solved.
        mesh_roots: folders that meshes may be read from, besides the URDF's own.

    Raises:
        UrdfError: the URDF is broken; the error names line, element and mend.
        ChainError: base, tip or a locked joint is unknown, or base or tip ambiguous; the error lists the candidates.
        JointVectorError: a locked joint's value is no finite number.
        CatalogueError: a name that the catalogue does not hold.
        UnsupportedArm: a joint of the chain cannot be handled.
    """
    from urdf_ik import catalogue, urdf

    if isinstance(source, str) and _is_name(source):
        entry = catalogue.resolve(source)
        source = entry.path
        base, tip = entry.base if base is None else base, entry.tip if tip is None else tip
        mesh_roots = (*mesh_roots, *entry.package_dirs)
    model = urdf.read(source, mesh_roots=mesh_roots)
    return Arm(model, from_urdf(model, base, tip).lock(locked or {}))


def _is_name(source: str) -> bool:
    """Whether ``source`` can only be meant as a catalogue name: no markup, no folder, no ending, no such file."""
    return bool(re.fullmatch(r"[\w-]+", source)) and not Path(source).exists()
