"""Streaming: one target a control cycle, the joints continuous with where they were, within their limits.

A cycle starts from the last joint vector and looks for no other: steps of least squares (Newton's method with a trust
region; Nocedal and Wright, Numerical Optimization, 2006, chapters 4 and 10) inside the box that the cycle's limits of
position and velocity make. The joint motion of a cycle is proven to meet no singularity, by bounds on how much the
Jacobian changes along it (Weyl's inequality), or it is cut into pieces of at most 0.05 rad, and where one has crossed
a fold (a singularity at which two branches merge) it is moved back. So the joints stay on their branch, unless they
pass through a wrist or a shoulder singularity, which branches on both sides of it share. Only the first of these is a
proof: where singularities lie closer to each other than a piece is long, a fold may be crossed unseen.
"""

from types import SimpleNamespace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from urdf_ik._core import Step
from urdf_ik._core import Tracker as CoreTracker
from urdf_ik.errors import ArgumentError, PoseError, UnsupportedArm
from urdf_ik.ik.descent import Wanted, constrained, descended
from urdf_ik.ik.families.parts import written as task
from urdf_ik.ik.solutions.distances import per_joint
from urdf_ik.ik.solutions.limits import check_inside
from urdf_ik.ik.solver import Solver
from urdf_ik.ik.task import POSE, Task
from urdf_ik.kinematics.chain import CoupledChain, velocity_limits
from urdf_ik.model.poses import check_poses
from urdf_ik.support import inputs
from urdf_ik.typing import Array

RECENTRING = 1.0
"""1/s: the rate at which the joints of a redundant arm leave the outer tenth of their ranges, by default."""
MOST_JOINTS = 7
EXACT = 1e-9
"""m, rad: a tip this near to a target is at it."""
_HARD = 100.0
"""Weight of the part that counts first where it is out of reach."""
_ROUNDS = 6
"""Newton's rounds of a cycle to the nearest posture; the next cycle goes on from where it led."""

_KINDS = {
    "pose": task.POSE,
    "position": task.POSITION,
    "position and axis": task.AXIS,
    "planar position": task.PLANAR_POSITION,
    "planar pose": task.PLANAR_POSE,
}


class PartialStep(NamedTuple):
    """What a cycle answers to a part of a pose, or to a pose that the joints do not control: see ``Tracker.step``."""

    q: Array
    velocity: Array
    status: str
    why: str | None
    distance: float
    angle: float


class Tracker:
    """An arm that follows targets, one a control cycle; made by :meth:`urdf_ik.Arm.tracker`.

    One tracker must not be stepped from several threads at once; different trackers may.

    Attributes:
        solver: the solver of the arm.
        dt: s, length of a cycle.
        velocity_limits: (n,) rad/s or m/s, infinite for a joint without one.
        acceleration_limits: (n,) rad/s^2 or m/s^2, infinite for a joint without one.

    Example:
        >>> import urdf_ik
        >>> arm = urdf_ik.load("zyyzyz_6r")
        >>> tracker = arm.tracker([0.3, -0.5, 0.8, 0.4, 0.7, -0.2], dt=0.004, velocity=1.0)
        >>> step = tracker.step(arm.fk([0.5, -0.5, 0.8, 0.4, 0.7, -0.2]))
        >>> step.status, step.why, bool(abs(step.velocity).max() < 1.0 + 1e-9)
        ('limited', 'velocity', True)
    """

    def __init__(
        self,
        solver: Solver,
        q0: ArrayLike,
        dt: float,
        *,
        velocity: ArrayLike | None = None,
        acceleration: ArrayLike | None = None,
        recentring: float | None = None,
        first: str | None = None,
        world: Any = None,
        margin: float = 0.0,
    ) -> None:
        """Start at a joint vector.

        Args:
            solver: the solver of the arm.
            q0: (n,) rad or m, the present joint vector, within the limits.
            dt: s, length of a cycle.
            velocity: greatest speed of each joint (n,), or of all, rad/s or m/s; default: the URDF's, and no
                limit for a joint for which the URDF states no speed, or zero.
            acceleration: greatest acceleration of each joint (n,), or of all, rad/s^2 or m/s^2; default: the URDF's
                (1.2), and no limit for a joint without one. The jerk is not limited.
            recentring: 1/s, the rate at which seven joints leave the outer tenth of their ranges (at most 0.2 rad, or
                0.2 of the arm's size) while the tip moves, as far as the target allows; default: ``RECENTRING``; 0: the
                joints move as little as possible.
            first: what counts first where the joints do not control all of a pose: 'position', the default of arms with
                fewer than six joints, 'orientation', or 'both' (the least sum of squares, rad and shares of the size).
                The joints go to the nearest posture of :func:`urdf_ik.ik.closest.closest` on this branch.
            world: obstacles to stay clear of, see :class:`urdf_ik.World`; the arm is checked against itself too.
            margin: m, clearance to keep.

        Raises:
            ArgumentError: ``q0`` does not fit the arm, or is outside the limits.
            ArgumentError: ``first``, ``dt``, ``recentring`` or ``margin`` is out of its range.
            ArgumentError: a limit of velocity or acceleration is not positive.
            UnsupportedArm: the arm has more than seven joints, joints that mimic others, or a free axis.
        """
        chain = solver.chain
        if isinstance(chain, CoupledChain):
            raise UnsupportedArm(
                f"{solver.name}: joints that mimic others ({chain.followers[0]}, ...) are not tracked yet"
            )
        if not 1 <= chain.n <= MOST_JOINTS:
            raise UnsupportedArm(f"{solver.name}: arms of 1 to {MOST_JOINTS} joints are tracked, and it has {chain.n}")
        if solver.free_axis is not None:
            raise UnsupportedArm(
                f"{solver.name}: {solver.free_axis} is free, and targets are tracked as whole poses; the arm without "
                "it tracks them with the rotation that they have"
            )
        self.solver = solver
        self.dt = inputs.number(dt, "dt", above=0.0, unit="s")
        speed = solver.velocity_limits if velocity is None else per_joint("velocity", velocity, solver.joint_names)
        self.velocity_limits = speed.copy()
        if acceleration is None:
            self.acceleration_limits = velocity_limits(solver.arm.model, chain, "acceleration").copy()
        else:
            self.acceleration_limits = per_joint("acceleration", acceleration, solver.joint_names)
        self.velocity_limits.setflags(write=False)
        self.acceleration_limits.setflags(write=False)
        self._targets, aim = solver.targets, _aim(solver)
        self._core = CoreTracker(
            SimpleNamespace(  # fields of the core's TrackedArm
                joints=chain.n,
                written=task.written(chain, aim),
                lower=chain.limits[:, 0].copy(),
                upper=chain.limits[:, 1].copy(),
                velocity=self.velocity_limits,
                acceleration=self.acceleration_limits,
                dt=self.dt,
                recentring=inputs.number(RECENTRING if recentring is None else recentring, "recentring", low=0.0),
            )
        )
        self._margin = inputs.number(margin, "margin", low=0.0, unit="m")
        self._collision: Any = None if world is None else solver.arm.cell.in_world(world)
        # A pose is tracked and no collision is checked: the core does the whole cycle.
        chosen = inputs.choice(first or "position", "first", ("position", "orientation", "both"))
        few = chain.n < 6 and aim.kind == task.POSE and solver.asked.has_place and solver.asked.has_turn
        self._first = chosen if few else "both"
        self._partial = aim.kind == task.POSE and (solver.asked != POSE or self._first != "both")
        whole = self._targets is None and not self._partial
        self._quick = self._core.step if whole and self._collision is None else None
        self.reset(q0)

    def __repr__(self) -> str:
        return f"<Tracker of {self.solver.name!r}: {1.0 / self.dt:g} cycles a second>"

    @property
    def q(self) -> Array:
        """The commanded joint vector (n,) rad or m, from the last step or from the start; a copy."""
        return self._start.copy() if self._last is None else self._last.q

    @property
    def velocity(self) -> Array:
        """The joints' speeds (n,) rad/s or m/s in the last cycle; a copy."""
        return self._start_velocity.copy() if self._last is None else self._last.velocity

    def reset(self, q: ArrayLike, velocity: ArrayLike | None = None) -> None:
        """Start anew, from where the robot is measured to be.

        Args:
            q: (n,) rad or m, within the joint limits.
            velocity: (n,) rad/s or m/s, at rest where left out. It only matters to limits on the acceleration.

        Raises:
            ArgumentError: a vector does not fit the arm, or ``q`` is outside the limits.
        """
        chain, n = self.solver.chain, self.solver.dof
        place, speed = chain.check(q), np.zeros(n) if velocity is None else chain.check(velocity)
        for vector in (place, speed):
            if vector.shape != (n,):
                raise ArgumentError(f"an array of shape {vector.shape} given; one joint vector ({n},) is needed")
        check_inside(place, chain.limits, chain.joint_names, "tracking begins inside them")
        self._start, self._start_velocity = np.clip(place, *chain.limits.T), speed.copy()
        self._core.reset(self._start, self._start_velocity)
        self._last: Step | PartialStep | None = None

    def step(self, T: Any) -> Step | PartialStep:
        """One cycle: move towards a target, as far as the limits allow.

        Args:
            T: (4, 4) pose of the tip in the base [m], or a ``pinocchio.SE3``; for ``arm.for_task(...)`` one
                target of that task.

        Returns:
            ``q`` (n,), the joint vector to command for the end of the cycle, and ``velocity``; each access makes a new
            array. ``status`` and ``why``:

            - ``'ok'``: the tip is at the target, to 1e-9 m and rad; ``why`` is None. An arm that does not control the
              whole target and is at its nearest posture is ``'limited'`` by ``'reach'``.
            - ``'limited'``: the joints moved, but the tip is not at the target. ``why`` is ``'velocity'`` where they
              would exceed their speeds: the tip moved straight towards the target, as far as the speeds allow. At a
              joint limit (``'limit'``), out of reach (``'reach'``) or near a singularity, they moved to where the
              squared distance from the target (rad, and lengths as shares of the arm's size) is least. ``why`` is
              ``'acceleration'`` where only the limits of acceleration kept them from the target.
            - ``'held'``: the joints do not move, since no motion brings the tip nearer: ``'limit'``, ``'reach'``,
              ``'singularity'``; or ``'collision'``, where the motion would not be free of contact.

            ``distance`` [m] and ``angle`` [rad] remain to the target.

        Raises:
            PoseError: ``T`` is not a pose or not a target of the task. The joints did not move.

        Example:
            >>> import urdf_ik
            >>> arm = urdf_ik.load("scara_rrpr")
            >>> tracker = arm.tracker([0.3, 0.5, 0.1, 0.2], dt=0.004)
            >>> step = tracker.step(arm.fk([0.301, 0.499, 0.1, 0.2]))
            >>> step.status, step.q.round(6).tolist()
            ('ok', [0.301, 0.499, 0.1, 0.2])
        """
        if self._quick is not None and T is not None:
            step = self._quick(T)
            if step is not None:
                self._last = step
                return step
        target = self._pose(T)
        before, speed = self.q, self.velocity
        step = self._core.step(target)
        if self._partial and step is not None and (step.status != "ok" or self.solver.asked != POSE):
            self._core.reset(before, speed)
            step = self._core.step(self._reachable(target))
        if step is None:
            check_poses(target)
            raise PoseError("a rotation that is neither orthonormal nor near it")
        if self._collision is not None:
            motion = self._collision.motions_free(before[None], step.q[None], margin=self._margin)
            if not motion.free[0]:
                step = self._core.back("collision")
        self._last = self._measured(step, target) if self._partial else step
        return self._last

    def _reachable(self, T: Array) -> Array:
        """The tip's pose in the nearest posture on this branch."""
        asked, chain, q = self.solver.asked, self.solver.chain, self.q
        seen = asked.chain(chain)
        here = chain.fk(q)
        along = (T[:3, 3] - here[:3, 3]) @ here[:3, :3] @ np.array(asked.axis or (0.0, 0.0, 1.0))
        start = np.append(q, max(along, 0.0))[None, : seen.n]
        wanted = Wanted(seen, T[None, :3, 3], *asked.matrix(T[None]))
        if self._first == "both":
            found = descended(wanted, start, seen.limits, float(asked.has_place), float(asked.has_turn), _ROUNDS)
        else:
            found, good = constrained(wanted, start, seen.limits, self._first, _ROUNDS)
            if not good[0]:
                pair = (_HARD, 1.0) if self._first == "position" else (1.0, _HARD)
                found = descended(wanted, start, seen.limits, *pair, _ROUNDS)
        return chain.fk(found[0, : chain.n])

    def _measured(self, step: Step, T: Array) -> PartialStep:
        """A step towards the nearest posture, as one towards its target: what is missed of what was asked."""
        off, angle = (float(each) for each in self.solver.asked.errors(T, self.solver.chain.fk(step.q)))
        short = step.status == "ok" and max(off, angle) > EXACT
        status, why = ("limited", "reach") if short else (step.status, step.why)
        return PartialStep(step.q, step.velocity, status, why, off, angle)

    def _pose(self, T: Any) -> Array:
        """A target as a pose (4, 4), of which the core uses what the task controls."""
        if self._targets is None:
            pose = check_poses(T) if self.solver.asked == POSE else self.solver.asked.read_targets(T)
            if pose.ndim != 2:
                raise PoseError(f"an array of shape {pose.shape} given; a cycle takes a single pose (4, 4)")
            return pose
        target = self._targets.read(T)
        if target.ndim != 1:
            raise PoseError(f"an array of shape {target.shape} given; a cycle takes a single target")
        poses: Array = self._targets.poses(target[None])
        return np.ascontiguousarray(poses[0])


def _aim(solver: Solver) -> task.Aim:
    """The core tracks the task alone where the joints control exactly that, else whole poses."""
    control = solver.control
    if solver.targets is not None and control.plane is not None:
        return task.Aim(_KINDS[control.task], normal=control.plane.normal)
    x, y, z = np.zeros(3) if control.aimed is None else control.aimed.tolist()
    own = Task(control.task, None if control.aimed is None else (x, y, z))
    return task.Aim(_KINDS[control.task], control.aimed) if solver.asked == own else task.Aim()
