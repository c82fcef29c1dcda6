"""What a pose leaves free: the redundancy parameters of an arm, and a rotation of the tip that does not matter."""

from __future__ import annotations

from functools import cached_property
from typing import TYPE_CHECKING, Any, Self

import numpy as np

from urdf_ik.arm.moving import Moving
from urdf_ik.errors import ArgumentError, UnsupportedArm
from urdf_ik.ik.families import FamilyMember, RedundantMember
from urdf_ik.ik.redundancy import interval_search, sweep
from urdf_ik.ik.refusals import unsupported
from urdf_ik.kinematics.chain import from_urdf
from urdf_ik.kinematics.chain.free_axis import FreeAxis
from urdf_ik.model.merging import joined
from urdf_ik.model.poses import as_pose_array, check_poses
from urdf_ik.model.xml import require_name
from urdf_ik.support import inputs

if TYPE_CHECKING:
    from collections.abc import Mapping

    from numpy.typing import ArrayLike, NDArray

    from urdf_ik.arm.kinematics import Kinematics
    from urdf_ik.ik.redundancy import Intervals, Sweep
    from urdf_ik.kinematics.chain.redundancy import Redundancy
    from urdf_ik.kinematics.structure import Structure

    Array = NDArray[np.float64]

REACHED = 1e-6
"""m and rad: a joint vector whose pose is farther from a target, whatever the rotation about a free axis, misses it."""


class Free(Moving):
    """An arm that may reach a pose in infinitely many ways."""

    structure: Structure
    _plan: FamilyMember | None
    _task: str

    @property
    def redundancy(self) -> Redundancy | None:
        """What a pose leaves free, of an arm with seven joints or a free axis; None where it leaves nothing free.

        The first parameter of an arm with several.
        """
        return self.redundancies[0] if self.redundancies else None

    @property
    def redundancies(self) -> tuple[Redundancy, ...]:
        """Every redundancy parameter, in the order in which ``ik`` takes their values; () for most arms.

        Example:
            >>> import urdf_ik
            >>> [each.kind for each in urdf_ik.load("srs_7r").with_free_axis("z").redundancies]
            ['free axis', 'swivel']
        """
        return self._plan.parameters if isinstance(self._plan, RedundantMember) else ()

    @cached_property
    def fixed(self) -> Self:
        """This arm without a free axis: the rotation about it counts."""
        return self if self._free_axis is None else self._again(free_axis=None)

    def with_free_axis(self, axis: Any, at: ArrayLike | None = None) -> Self:
        """This arm, its tip free to turn about an axis: a new arm with one redundancy parameter more.

        For tools that are round: welding, spraying, drilling, gripping a cylinder. The parameter's value v [rad] says
        how far the tip is turned from the target: ``ik(T, redundancy=v)`` solves the target turned by v about the axis,
        ``T @ arm.free_axis.rotation(v)``; ``ik(T)`` is v = 0. Joint vectors stay those of the arm. ``ik_nearest`` and
        ``follow`` choose the rotation.

        The axis belongs to the tip link: mount a tool first. An arm with seven joints has two parameters then, this one
        first and its own second, and takes values ``redundancy=(..., 2)``. Intervals of the second at a value v of the
        first: ``arm.fixed.intervals(T @ arm.free_axis.rotation(v))``; ``arm.fixed`` is the arm without the free axis.

        Args:
            axis: 'x', 'y' or 'z' of the tip, or a direction (3,) in the tip's frame.
            at: (3,) m, a point on the axis in the tip's frame; default: the tip's origin.

        Raises:
            ArgumentError: no axis, the arm has a free axis already, or a joint in its middle is given.
            ArgumentError: the arm has less than six joints, or controls less than a pose, which leaves more free.
            UnsupportedArm: no solver takes this arm.

        Example:
            >>> import urdf_ik
            >>> arm = urdf_ik.load("puma_560").with_free_axis("z")
            >>> T = arm.fk([0.3, -0.5, 0.8, 0.4, 0.7, -0.2])
            >>> s = arm.ik(T, redundancy=0.5)
            >>> arm.redundancy_of(s.to_array(), T).round(6).tolist()
            [0.5, 0.5, 0.5, 0.5, 0.5, 0.5, 0.5, 0.5]
        """
        free: Any = FreeAxis.read(axis, at)
        if self._free_axis is not None:
            raise ArgumentError(f"{self.name} may already turn about {self._free_axis}; only one axis can be free")
        made = self._again(free_axis=free)
        if self._plan is None:
            raise unsupported(self.name, self.chain, self.structure)
        made.__dict__["fixed"] = self
        return made

    def with_redundancy(self, *joints: str) -> Self:
        """This arm, the values of these joints being its redundancy parameters: a new arm.

        A rail, the joint of a positioner, or any other of seven joints or more. An end joint costs what the six others
        cost, whatever its value. One in the middle makes another arm of every value, which is prepared when the value
        is first asked for: a fraction of a millisecond for closed forms, up to a second for an elimination, after which
        it is kept; searches over many values (``ik_nearest``, ``follow``) take that many times as long. Which parameter
        an arm has by itself, and why, says ``arm.structure.reason``.

        Args:
            joints: names, as many as a pose leaves free, or fewer, to which others are added. ``arm.redundancies``
                says in which order ``ik`` takes their values.

        Raises:
            ChainError: the chain has no such joint; the error lists those it has.
            ArgumentError: more joints than a pose leaves free.
            UnsupportedArm: no solver takes the other joints, or joints mimic others.

        Example:
            >>> import urdf_ik
            >>> arm = urdf_ik.load("srs_7r").with_redundancy("joint_1")
            >>> arm.redundancy.joint, arm.redundancy.kind
            ('joint_1', 'locked joint')
        """
        return self._again(given=joints)

    def with_locked(self, values: Mapping[str, float]) -> Self:
        """This arm, joints being held at these values [rad or m]: a new arm of the other joints.

        Joints of the chain become part of the fixed geometry; those beside it, such as the joints of a second arm,
        stand there as obstacles. What is held already stays held, those that are named anew at their new values.

        Raises:
            ChainError: the URDF has no such joint; the error lists those that it has.
            ArgumentError: a value is no finite number.

        Example:
            >>> import urdf_ik
            >>> left = urdf_ik.load("dual_6r", tip="left_tool0")
            >>> q = [-1.2, 0.4, -2.6, 2.3, -0.9, -2.5]
            >>> crossed = left.with_locked({"right_joint_1": 1.6, "right_joint_2": 0.4, "right_joint_3": -2.6})
            >>> bool(left.clearance(q) > 0.02), float(crossed.clearance(q))
            (True, 0.0)
        """
        given = inputs.mapping(values, "values", "a value for each joint by name")
        chain = from_urdf(self.model, self.base, self.tip).lock({**self.locked, **given})
        return self._again(chain=chain)

    def with_positioner(self, positioner: Kinematics, pose: Any, name: str = "positioner") -> Self:
        """This arm with a positioner of another URDF, whose tip carries the workpiece: poses are in its tip's frame.

        The new arm is the chain from the positioner's tip, back to its base, and up this arm: its base is the link
        ``f"{name}_{positioner.tip}"``, its first joints are the positioner's, the last one first, and what they leave
        free are redundancy parameters. A positioner in the same URDF needs no more than ``load(..., base=workpiece)``.

        Args:
            positioner: its chain from base to the link that carries the workpiece, as ``load`` gives it.
            pose: (4, 4) m of the positioner's root link in this arm's base, or a ``pinocchio.SE3``.
            name: stands before the names of its links and joints.

        Raises:
            PoseError: an invalid pose.
            ArgumentError: a name is taken, or ``name`` cannot stand in a URDF.
            UnsupportedArm: no solver takes the joints.

        Example:
            >>> import urdf_ik
            >>> table = urdf_ik.load("planar_2r", tip="link_1")
            >>> cell = urdf_ik.load("puma_560").with_positioner(table, urdf_ik.pose([0.6, 0.0, 0.2]), name="table")
            >>> cell.base, cell.dof, cell.redundancy.joint
            ('table_link_1', 7, 'table_joint_1')
        """
        inputs.arm(positioner, "positioner")
        at = check_poses(pose)
        if at.ndim != 2:
            raise ArgumentError(f"a pose of shape {at.shape} given; one pose (4, 4) is needed")
        require_name(name, "the positioner")
        model = joined(self.model, positioner.model, self.base, at, f"{name}_")
        held = {**self.locked, **{f"{name}_{joint}": value for joint, value in positioner.locked.items()}}
        chain = from_urdf(model, f"{name}_{positioner.tip}", self.tip).lock(held)
        return self._again(model=model, chain=chain)

    def _again(self, **changed: Any) -> Self:
        """This arm, made again with other settings."""
        raise NotImplementedError

    def redundancy_of(self, q: ArrayLike, T: Any = None) -> Array:
        """Values of the redundancy parameters at joint vectors: ``ik`` finds them again at these.

        Args:
            q: (..., n) rad or m.
            T: (..., 4, 4) m, the poses that they are to reach, which say what the rotation about a free axis is;
                default: the poses that the tip has, so that this rotation is zero. Other parameters follow from ``q``.

        Returns:
            (...) of one parameter, (..., k) of k of them.

        Raises:
            ArgumentError: the last dimension is not n, a value is not finite, or ``q`` does not reach ``T``,
                whatever the rotation about the free axis.
            PoseError: ``T`` holds what is no pose.
            UnsupportedArm: the arm has no such parameter.

        Example:
            >>> import urdf_ik
            >>> arm = urdf_ik.load("srs_7r")
            >>> q = [0.3, 0.5, -0.4, 0.9, 0.2, -0.6, 0.1]
            >>> value = arm.redundancy_of(q)
            >>> arm.ik(arm.fk(q), redundancy=value).nearest(q).to_array().round(6).tolist()
            [[0.3, 0.5, -0.4, 0.9, 0.2, -0.6, 0.1]]
        """
        plan = self._redundant_plan()
        Q = self.chain.check(q)
        reached = np.asarray(self.fk(Q))
        target = reached if T is None else check_poses(T)
        try:
            batch = np.broadcast_shapes(Q.shape[:-1], target.shape[:-2])
        except ValueError:
            raise ArgumentError(
                f"joint vectors of shape {Q.shape} and poses of shape {target.shape} given; the shapes do not fit"
            ) from None
        target = np.broadcast_to(target, (*batch, 4, 4))
        if T is not None and self._free_axis is not None:
            self._require_reached(np.broadcast_to(reached, target.shape), target)
        Q = np.broadcast_to(Q, (*batch, self.dof))
        values = plan.value_of(Q.reshape(-1, self.dof), target.reshape(-1, 4, 4))
        if T is None and self._free_axis is not None:
            values[:, 0] = 0.0  # not what rounding makes of it
        return values.reshape(batch if len(plan.parameters) == 1 else (*batch, len(plan.parameters)))

    def nearest_values(self, q: Array, T: Array) -> Array:
        """(m, k) values of the parameters at joint vectors (m, n), whose poses need not be the targets (m, 4, 4).

        The rotation about a free axis is the one that comes nearest.

        Example:
            >>> import urdf_ik
            >>> arm = urdf_ik.load("srs_7r")
            >>> q = np.array([[0.3, 0.5, -0.4, 0.9, 0.2, -0.6, 0.1]])
            >>> bool(arm.nearest_values(q, arm.fk(q))[0, 0] == arm.redundancy_of(q[0]))
            True
        """
        plan = self._redundant_plan()
        Q, target = self.chain.check(q), check_poses(T)
        many = (len(Q),) if Q.ndim == 2 else None
        if many is None or target.shape[:-2] not in ((), many):
            raise ArgumentError(
                f"joint vectors of shape {Q.shape} and poses of shape {target.shape} given; (m, {self.dof}) and "
                "(m, 4, 4) are needed"
            )
        return plan.value_of(Q, np.broadcast_to(target, (*many, 4, 4)))

    def intervals(self, T: Any, within_limits: bool = True, world: Any = None, *, threads: int = 1) -> Intervals:
        """Where along the redundancy parameter each branch has solutions, and what ends them.

        Every solution at the values of a grid is followed along its curve to both sides, and every solution must be met
        from both; ends are computed to 1e-9. Of S-R-S arms with axes at right angles they are roots of the limits,
        in closed form, as they are where the tip turns about the axis of the last of six joints. An interval that lies
        between two values of the grid is found where a branch of the closed form, taken beyond its ends, comes near, or
        by Newton's method from starts all over the joints: that is no proof that none is missed. Where a pose's
        solutions are surfaces, as those of a straight S-R-S arm, some of the curves on them are followed, not all; and
        solutions along which the parameter keeps its value are in no interval.

        Args:
            T: (..., 4, 4) poses of the tip in the base [m], or a ``pinocchio.SE3``.
            within_limits: only solutions inside the joint limits count.
            world: a :class:`urdf_ik.World`; only solutions count that touch neither it nor the arm itself. Between two
                contacts, what is free for less than 1e-5 rad or m of the parameter may be missed.
            threads: number of threads that share the solving.

        Returns:
            The intervals: of a single pose a sequence of :class:`urdf_ik.Interval`, by branch and by value; of a batch,
            ``intervals[i]`` are those of one pose.

        Raises:
            PoseError: a target is no pose.
            UnsupportedArm: the arm has no redundancy parameter.
            UrdfError: a world is given, and the URDF's collision shapes are missing or cannot be read.

        Example:
            >>> import urdf_ik
            >>> arm = urdf_ik.load("srs_7r")
            >>> first = arm.intervals(arm.fk([0.3, 0.5, -0.4, 0.9, 0.2, -0.6, 0.1]))[0]
            >>> round(first.low, 6), round(first.high, 6), str(first.ends[0])
            (-2.588603, -1.49593, "lower limit of joint 'joint_3'")
        """
        arm: Any = self
        return interval_search.intervals(
            arm,
            self._only_parameter("intervals"),
            as_pose_array(T),
            within_limits=within_limits,
            world=world,
            threads=threads,
        )

    def sweep(self, T: Any, n: int = 64, *, within_limits: bool = False, threads: int = 1) -> Sweep:
        """The solutions of one pose at ``n`` values of the redundancy parameter, and where there are any.

        Args:
            T: (4, 4) pose of the tip in the base [m], or a ``pinocchio.SE3``.
            n: number of values, shared among the intervals in which there are solutions by their lengths.
            within_limits: only solutions inside the joint limits count.
            threads: number of threads that share the work.

        Raises:
            PoseError: ``T`` is no pose, or more than one.
            UnsupportedArm: the arm has no redundancy parameter.

        Example:
            >>> import urdf_ik
            >>> arm = urdf_ik.load("srs_7r")
            >>> sweep = arm.sweep(arm.fk([0.3, 0.5, -0.4, 0.9, 0.2, -0.6, 0.1]), n=16)
            >>> sweep.solutions.q.shape, sweep.intervals.round(3).tolist()
            ((16, 8, 7), [[-3.142, 3.142]])
        """
        arm: Any = self
        return sweep.sweep(arm, self._only_parameter("sweep"), T, n, within_limits, threads)

    def _require_reached(self, reached: Array, target: Array) -> None:
        assert self._free_axis is not None  # else the pose is none of the joint vector's business
        far, turned = self._free_axis.apart(reached, target)
        if not far.size:
            return
        worst = np.unravel_index(np.argmax(np.maximum(far, turned)), far.shape)
        if max(far[worst], turned[worst]) > REACHED:
            raise ArgumentError(
                f"joint vector{[int(k) for k in worst] or ''} does not reach the pose, whatever the rotation about "
                f"{self._free_axis}: it is {far[worst]:.3g} m and {turned[worst]:.3g} rad off"
            )

    def _only_parameter(self, what: str) -> RedundantMember:
        """The plan, for what takes one redundancy parameter.

        Raises:
            UnsupportedArm: the arm has none, or several.
        """
        plan = self._redundant_plan()
        first, *rest = plan.parameters
        if rest:
            raise UnsupportedArm(
                f"{self.name}: {what} takes one redundancy parameter, and this arm has {1 + len(rest)}: "
                f"{', '.join(each.label for each in (first, *rest))}; hold a joint, arm.with_locked({{...}}), or give "
                f"the rotation about a free axis, arm.fixed.{what}(T @ arm.free_axis.rotation(value))"
            )
        return plan

    def _redundant_plan(self) -> RedundantMember:
        """The plan of an arm with a redundancy parameter."""
        if self._plan is None:
            raise unsupported(self.name, self.chain, self.structure)
        if isinstance(self._plan, RedundantMember):
            return self._plan
        raise UnsupportedArm(
            f"{self.name}: {self.dof} joints ({', '.join(self.joint_names)}) leave nothing free in a pose; only arms "
            "with seven, or with a free axis (Arm.with_free_axis), have a redundancy parameter"
        )
