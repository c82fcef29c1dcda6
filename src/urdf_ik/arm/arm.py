"""Arm: a URDF, its chain, its solver and its cell, as one record."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, Self

from urdf_ik.arm.html import html
from urdf_ik.cell import tool
from urdf_ik.cell.cell import Cell
from urdf_ik.errors import ArgumentError
from urdf_ik.ik import preparation, solve
from urdf_ik.ik.explanation import explain
from urdf_ik.ik.nearest import nearest
from urdf_ik.ik.redundancy import values
from urdf_ik.ik.redundancy.interval_search import intervals
from urdf_ik.ik.redundancy.sweep import sweep
from urdf_ik.ik.solutions import limits
from urdf_ik.kinematics import velocity
from urdf_ik.kinematics.chain import from_urdf, velocity_limits
from urdf_ik.paths.follow import follow
from urdf_ik.paths.tracker import Tracker
from urdf_ik.support import inputs

if TYPE_CHECKING:
    from collections.abc import Mapping

    import numpy as np
    from numpy.typing import ArrayLike, NDArray

    from urdf_ik.cell.swept_motions import Motions
    from urdf_ik.cell.tool import Shapes
    from urdf_ik.cell.world import World
    from urdf_ik.ik.redundancy import Intervals, Sweep
    from urdf_ik.ik.solutions import IKSolutions
    from urdf_ik.ik.solver import Solver
    from urdf_ik.kinematics.chain import Chain
    from urdf_ik.kinematics.chain.free_axis import FreeAxis
    from urdf_ik.kinematics.chain.redundancy import Redundancy
    from urdf_ik.kinematics.structure import Structure
    from urdf_ik.model.urdf import UrdfModel
    from urdf_ik.paths import Plan

    Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False, repr=False)
class Arm:
    """A serial arm, read from a URDF and ready to be solved; :func:`urdf_ik.load` makes it.

    Joint vectors are rad or m, base to tip. Poses (4, 4) are those of the tip link in the base link [m].

    Attributes:
        model: the URDF as it was read.
        chain: screw axes of the joints from base to tip.
        solver: the structure of the axes, the family and the compiled solver; see :class:`urdf_ik.ik.solver.Solver`.
        cell: self-collision, worlds and Pinocchio's reference; see :class:`urdf_ik.cell.cell.Cell`.

    Example:
        >>> import urdf_ik
        >>> arm = urdf_ik.load("zyyzyz_6r")
        >>> arm.dof, arm.task, arm.structure.family
        (6, 'pose', '6R spherical wrist, 2||3 and 1x2')
    """

    model: UrdfModel
    chain: Chain
    solver: Solver
    cell: Cell

    @classmethod
    def of(
        cls,
        model: UrdfModel,
        chain: Chain,
        task: str = "pose",
        free_axis: FreeAxis | None = None,
        given: Any = (),
        cell: Cell | None = None,
    ) -> Self:
        """The arm of a URDF and one of its chains; see :func:`urdf_ik.ik.preparation.prepare` for the settings.

        Raises:
            ArgumentError: ``model`` or ``chain`` is something else, or a setting does not fit.
            ChainError: one of ``given`` is not a joint of the chain.
            UnsupportedArm: no solver takes this arm with these settings.
        """
        inputs.kind(model, "joints", "model", "a URDF, as urdf_ik.load(...).model is,")
        inputs.kind(chain, "image_turns", "chain", "a chain, as urdf_ik.load(...).chain is,")
        cell = Cell(model, chain) if cell is None else cell
        speeds = velocity_limits(model, chain)
        return cls(model, chain, preparation.prepare(model.name, chain, speeds, cell, task, free_axis, given), cell)

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
    def limits(self) -> Array:
        """(n, 2) rad or m; a continuous joint has (-inf, inf)."""
        return self.chain.limits

    @property
    def structure(self) -> Structure:
        """Relations of the axes, family, method and branches; ``str()`` reads like a sentence."""
        return self.solver.structure

    @property
    def task(self) -> str:
        """What the arm can control: 'pose', 'position', 'position and axis', 'planar position' or 'planar pose'."""
        return self.solver.control.task

    @property
    def redundancy(self) -> Redundancy | None:
        """The redundancy parameter of an arm with seven joints or a free axis; None where a pose leaves nothing free.

        The first one of an arm with several; ``arm.solver.parameters`` holds all.
        """
        return self.solver.parameter

    def fk(self, q: ArrayLike) -> Array:
        """Pose of the tip in the base: (..., n) rad or m to (..., 4, 4); see :meth:`Chain.fk`.

        Example:
            >>> import urdf_ik
            >>> arm = urdf_ik.load("scara_rrpr")
            >>> (arm.fk([0.0, 0.0, 0.1, 0.0])[:3, 3].round(6) + 0.0).tolist()
            [0.6, 0.0, 0.23]
        """
        return self.chain.fk(q)

    def jacobian(self, q: ArrayLike) -> Array:
        """Geometric Jacobian at the tip in base axes: (..., n) to (..., 6, n); see :meth:`Chain.jacobian`.

        Example:
            >>> import urdf_ik
            >>> arm = urdf_ik.load("planar_2r")
            >>> (arm.jacobian([0.0, 0.0]).round(6) + 0.0)[[0, 1, 5]].tolist()
            [[0.0, 0.0], [0.196, 0.13], [1.0, 1.0]]
        """
        return self.chain.jacobian(q)

    def link_poses(self, q: ArrayLike) -> dict[str, Array]:
        """Pose of every link in the base: (..., n) to (..., 4, 4) each; see :meth:`Chain.link_poses`.

        Example:
            >>> import urdf_ik
            >>> poses = urdf_ik.load("scara_rrpr").link_poses([0.0, 0.0, 0.1, 0.0])
            >>> (poses["link_2"][:3, 3].round(6) + 0.0).tolist()
            [0.325, 0.0, 0.38]
        """
        return self.chain.link_poses(q)

    def manipulability(self, q: ArrayLike, part: str = "all") -> Array:
        """Yoshikawa's manipulability: (..., n) to (...); see :func:`urdf_ik.kinematics.velocity.manipulability`.

        Example:
            >>> import urdf_ik
            >>> arm = urdf_ik.load("planar_2r_unit")
            >>> arm.manipulability([[0.0, 0.5], [0.0, 1.5]], "translation").round(4).tolist()
            [0.4794, 0.9975]
        """
        return velocity.manipulability(self.chain, q, part)

    def limit_margin(self, q: ArrayLike) -> Array:
        """How far (..., n) rad or m are from the joint limits: (...), the least joint's share of half its range.

        1 in the middle of all ranges, 0 at a limit, negative outside; see :func:`urdf_ik.ik.solutions.limits.margin`.

        Example:
            >>> import urdf_ik
            >>> arm = urdf_ik.load("scara_rrpr")
            >>> middle = arm.limits.mean(axis=1)
            >>> (arm.limit_margin([middle, arm.limits[:, 1]]).round(6) + 0.0).tolist()
            [1.0, 0.0]
        """
        return limits.margin(self.chain.check(q), self.limits)

    def to_pinocchio(self, q: ArrayLike) -> Array:
        """Configurations (..., nq) of Pinocchio's model of the whole URDF: joints by name, continuous ones (cos, sin).

        Joints beside the chain stay at zero; those that mimic others follow them. ``arm.cell.reference.pin_model`` is
        the ``pinocchio.Model``.

        Raises:
            ArgumentError: the last dimension of ``q`` (..., n) is not n, or a value is not finite.
            UrdfError: Pinocchio refuses the URDF.

        Example:
            >>> import urdf_ik
            >>> arm = urdf_ik.load("zyyzyz_6r")
            >>> arm.to_pinocchio([0.1, 0.2, 0.3, 0.4, 0.5, 0.6]).tolist()
            [0.1, 0.2, 0.3, 0.4, 0.5, 0.6]
        """
        return self.cell.reference.configurations(self.chain.check(q))

    def from_pinocchio(self, q_pin: ArrayLike) -> Array:
        """Joint vectors (..., n) rad or m of configurations (..., nq), the inverse of :meth:`to_pinocchio`.

        Angles of continuous joints come back in (-pi, pi].

        Raises:
            ArgumentError: the last dimension is not nq, or a value is not finite.
            UrdfError: Pinocchio refuses the URDF.

        Example:
            >>> import urdf_ik
            >>> arm = urdf_ik.load("scara_rrpr")
            >>> arm.from_pinocchio(arm.to_pinocchio([0.3, 0.5, 0.1, 0.2])).round(6).tolist()
            [0.3, 0.5, 0.1, 0.2]
        """
        return self.cell.reference.joint_vectors(q_pin)

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
            T: (..., 4, 4) pose of the tip in the base [m], a ``pinocchio.SE3`` or a list of them. A rotation that is
                off by rounding (up to 1e-5) is replaced by the nearest one. The answer keeps a stack of poses by
                reference, for ``explain``; a single pose is copied.
            q_ref: (n,) rad, joint vector near which representatives of a continuum are chosen.
            redundancy: (...) rad or m, values of the redundancy parameter, which broadcast against the poses:
                ``ik(T[:, None], redundancy=values)`` solves every pose at every value. Default:
                ``self.redundancy.default``. (..., k) for an arm with k parameters.
            threads: number of threads that share a batch.
            task: what ``T`` is; default: a pose. An arm with few joints controls less, and takes that as target too,
                see :attr:`task`: 'position' (..., 3) m in the base; 'position and axis' (..., 6), position and a
                direction in the base for the tip's z axis (its x axis, else y, where the joints do not control z: see
                ``arm.solver.control.aimed``), or a pair of these; 'planar position' (..., 2) m and 'planar pose'
                (..., 3) m, m, rad in the arm's plane, see ``arm.solver.control.plane``.

        Returns:
            The solutions, (..., B, n), one column a branch. Those of seven joints are all that exist at the given
            value, and ``singular`` says where the Jacobian drops rank while it is kept.

        Raises:
            PoseError: a target is not finite, or is no pose.
            ArgumentError: ``q_ref``, ``redundancy``, ``threads`` or ``task`` does not fit.
            UnsupportedArm: no solver takes this arm.

        Example:
            >>> import urdf_ik
            >>> arm = urdf_ik.load("zyyzyz_6r")
            >>> for solution in arm.ik(arm.fk([0.3, -0.5, 0.8, 0.4, 0.7, -0.2])):
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
        solver = self.solver if task is None else solve.for_task(self.solver, preparation.check_task(task))
        return solve.solve(solver, T, q_ref, redundancy, threads)

    def ik_nearest(self, T: Any, q_ref: ArrayLike, *, task: str | None = None, **options: Any) -> IKSolutions:
        """The joint vector nearest to ``q_ref``: of all solutions, and over all values of a redundancy parameter.

        Args:
            T: as in ``ik``.
            q_ref: (n,), or one for each pose (..., n), rad or m.
            task: what ``T`` is; see ``ik``.
            **options: ``metric``, ``weights``, ``within``, ``within_limits`` (True), ``region`` and ``threads``: see
                :func:`urdf_ik.ik.nearest.nearest`.

        Returns:
            One column a pose; of a continuum what ``ik`` gives near ``q_ref``. With seven joints, ``redundancy`` holds
            the values of the parameter, of all in :meth:`intervals`, to 1e-8. With a region, ``poses`` holds the
            targets that were chosen in it.

        Raises:
            PoseError: a target is no pose.
            ArgumentError: ``q_ref``, ``task`` or an option does not fit.
            UnsupportedArm: no solver takes this arm.

        Example:
            >>> import urdf_ik
            >>> arm = urdf_ik.load("zyyzyz_6r")
            >>> q = [0.3, -0.5, 0.8, 0.4, 0.7, -0.2]
            >>> arm.ik_nearest(arm.fk(q), q).q.round(6).tolist()
            [[0.3, -0.5, 0.8, 0.4, 0.7, -0.2]]
        """
        solver = self.solver if task is None else solve.for_task(self.solver, preparation.check_task(task))
        return nearest(solver, T, q_ref, **options)

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
        return explain(self.solver, T, redundancy)

    def intervals(
        self, T: Any, within_limits: bool = True, world: World | None = None, *, threads: int = 1
    ) -> Intervals:
        """Where along the redundancy parameter each branch has solutions, and what ends them.

        The curves of solutions are followed from a grid of values; their ends are computed to 1e-9. For exact S-R-S
        arms, and for a free axis that is that of the last joint, they are roots in closed form.
        :mod:`urdf_ik.ik.redundancy.interval_search` says how, and what may be missed between two values of the grid.

        Args:
            T: (..., 4, 4) poses of the tip in the base [m], or a ``pinocchio.SE3``.
            within_limits: only solutions inside the joint limits count.
            world: only solutions count that touch neither it nor the arm itself.
            threads: number of threads that share the solving.

        Returns:
            Of a single pose a sequence of :class:`urdf_ik.Interval`, by branch and by value; of a batch,
            ``intervals[i]`` are those of one pose.

        Raises:
            PoseError: a target is no pose.
            UnsupportedArm: the arm has no redundancy parameter, or several.
            UrdfError: a world is given, and the URDF's collision shapes are missing or cannot be read.

        Example:
            >>> import urdf_ik
            >>> arm = urdf_ik.load("srs_7r")
            >>> first = arm.intervals(arm.fk([0.3, 0.5, -0.4, 0.9, 0.2, -0.6, 0.1]))[0]
            >>> round(first.low, 6), round(first.high, 6), str(first.ends[0])
            (-2.588603, -1.49593, "lower limit of joint 'joint_3'")
        """
        return intervals(self.solver, T, within_limits=within_limits, world=world, threads=threads)

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
        return sweep(self.solver, T, n, within_limits=within_limits, threads=threads)

    def redundancy_of(self, q: ArrayLike, T: Any = None) -> Array:
        """Values of the redundancy parameters at joint vectors: ``ik`` finds them again at these.

        Args:
            q: (..., n) rad or m.
            T: (..., 4, 4) m, the poses that they are to reach, which say what the rotation about a free axis is;
                default: the poses that the tip has, so that this rotation is zero. Other parameters follow from ``q``.

        Returns:
            (...) of one parameter, (..., k) of k of them.

        Raises:
            ArgumentError: ``q`` does not fit, or does not reach ``T``, whatever the rotation about the free axis.
            PoseError: ``T`` holds an invalid pose.
            UnsupportedArm: the arm has no such parameter.

        Example:
            >>> import urdf_ik
            >>> arm = urdf_ik.load("srs_7r")
            >>> q = [0.3, 0.5, -0.4, 0.9, 0.2, -0.6, 0.1]
            >>> value = arm.redundancy_of(q)
            >>> arm.ik(arm.fk(q), redundancy=value).nearest(q).to_array().round(6).tolist()
            [[0.3, 0.5, -0.4, 0.9, 0.2, -0.6, 0.1]]
        """
        return values.redundancy_of(self.solver, q, T)

    def clearance(self, q: ArrayLike, world: World | None = None) -> float | Array:
        """Least distance between links that must not touch, and between them and the obstacles of a world.

        Args:
            q: (..., n) rad or m.
            world: the obstacles; default: none, only the arm itself.

        Returns:
            A float for one joint vector, else (...) [m]: 0 in collision, infinite where nothing can collide.

        Raises:
            ArgumentError: ``q`` does not fit; an obstacle's mesh cannot be read, or it has the name of a link.
            UrdfError: the URDF has no collision shapes, or not all of them were found.

        Example:
            >>> import urdf_ik
            >>> arm, world = urdf_ik.load("zyyzyz_6r"), urdf_ik.World()
            >>> world.add("ceiling", urdf_ik.HalfSpace((0, 0, -1), -3.33))
            >>> round(float(arm.clearance([0.0] * 6, world)), 3)
            0.03
        """
        return self.cell.clearance(q, world)

    def motion_is_free(self, q0: ArrayLike, q1: ArrayLike, world: World | None = None, margin: float = 0.0) -> Motions:
        """Whether straight motions in joint space are free of contact from end to end: proven, not sampled.

        Each joint goes from its value in ``q0`` to its value in ``q1``, in proportion to the others, turns included.
        A motion that is not called free has a contact, or comes within 0.1 mm of one
        (``urdf_ik.cell.swept_motions.TOUCH``), where no finite number of distances can prove it free.

        Args:
            q0: (..., n) rad or m.
            q1: (..., n) rad or m; the leading dimensions broadcast against those of ``q0``.
            world: the obstacles; default: none, only the arm itself.
            margin: m that the bodies must stay apart.

        Returns:
            Its ``free`` (...) says which motions are; ``share`` (...) and ``pairs`` describe the first contact of
            the others. Of a single motion, the result itself is true or false.

        Raises:
            ArgumentError: the arrays do not fit the arm or each other, a joint goes farther than 10000 rad or m, or
                ``margin`` or an obstacle is invalid.
            UrdfError: the URDF has no collision shapes, or not all of them were found.

        Example:
            >>> import urdf_ik
            >>> arm, world = urdf_ik.load("scara_rrpr"), urdf_ik.World()
            >>> world.add("post", urdf_ik.Cylinder(0.05, 2.0), urdf_ik.pose([0.5, 0.0, 0.0]))
            >>> motion = arm.motion_is_free([-1.0, 0.0, 0.1, 0.0], [1.0, 0.0, 0.1, 0.0], world)
            >>> bool(motion), round(float(motion.share), 2), motion.pairs
            (False, 0.42, [('link_2', 'post')])
        """
        return self.cell.motion_is_free(q0, q1, world, margin)

    def follow(self, T: Any, **settings: Any) -> Plan:
        """The cheapest joint motion along a path, over all branches and turns, without a jump.

        From waypoint to waypoint the joints move linearly, and the tip is proven to keep within a tolerance of the
        straight segment; where it would not, waypoints are put in between, and ``Plan.motion`` holds them. Values of a
        redundancy parameter are searched on a grid first, and then on finer ones around the way found.

        Args:
            T: (m, 4, 4) m, waypoints; see :func:`urdf_ik.line`, :func:`urdf_ik.arc`, :func:`urdf_ik.polyline`.
            **settings: the fields of :class:`urdf_ik.paths.PathSettings`, such as ``world``, ``margin`` and ``cost``.

        Returns:
            See :class:`urdf_ik.Plan`; where ``found`` is false, ``explain()`` says how far each branch gets.

        Raises:
            ArgumentError: waypoints, ``start``, ``end`` or a setting do not fit.
            PoseError: a waypoint is no pose.
            UrdfError: a world is given, and the arm has no collision shapes.
            UnsupportedArm: no solver takes this arm.

        Example:
            >>> import urdf_ik
            >>> arm = urdf_ik.load("zyyzyz_6r")
            >>> T0 = arm.fk([0.3, -0.5, 0.8, 0.4, 0.7, -0.2])
            >>> T1 = T0.copy()
            >>> T1[1, 3] += 0.2
            >>> plan = arm.follow(urdf_ik.line(T0, T1, 50))
            >>> plan.found, len(plan.q), len(set(plan.branches))
            (True, 50, 1)
        """
        return follow(self.solver, self.cell, T, **settings)

    def tracker(self, q0: ArrayLike, dt: float, **options: Any) -> Tracker:
        """A tracker of targets, one each cycle of ``dt`` s, from ``q0`` on: see :class:`urdf_ik.paths.Tracker`.

        Example:
            >>> import urdf_ik
            >>> arm = urdf_ik.load("zyyzyz_6r")
            >>> tracker = arm.tracker([0.3, -0.5, 0.8, 0.4, 0.7, -0.2], dt=0.004)
            >>> tracker.step(arm.fk([0.301, -0.5, 0.8, 0.4, 0.7, -0.2])).status
            'ok'
        """
        return Tracker(self.solver, q0, dt, **options)

    def with_tool(self, pose: Any, shapes: Shapes = (), name: str = "tool") -> Self:
        """This arm with a tool at its tip: a new arm whose tip is the tool's centre point, and whose tool collides.

        The tool is a link of the new arm's URDF, fixed to the present tip, so that Pinocchio sees it too, and
        ``arm.model.write`` writes it. Tools may be stacked. Base, locked joints, task and changes of the
        allowed-collision table stay. A tool may touch the links that any link in its place may touch.

        Args:
            pose: (4, 4) of the tool's centre point in the present tip link [m], or a ``pinocchio.SE3``.
            shapes: what the tool is made of, each a shape or a pair (shape, pose in the present tip link [m]):
                ``Box``, ``Sphere``, ``Cylinder``, ``Capsule`` and ``Mesh``.
            name: of the tool's link.

        Raises:
            PoseError: an invalid pose.
            ArgumentError: the URDF has a link of this name, a shape is invalid, or the tip has a free axis.

        Example:
            >>> import urdf_ik
            >>> arm = urdf_ik.load("zyyzyz_6r")
            >>> body = (urdf_ik.Cylinder(0.03, 0.2), urdf_ik.pose([0.0, 0.0, 0.1]))
            >>> torch = arm.with_tool(urdf_ik.pose([0.0, 0.05, 0.25], rpy=[0.5, 0.0, 0.0]), [body], name="torch")
            >>> torch.tip, len(torch.ik(torch.fk([0.3, -0.5, 0.8, 0.4, 0.7, -0.2])))
            ('torch', 8)
        """
        model = tool.with_tool(self.model, preparation.fixed_tip(self.solver), pose, shapes, name)
        return self._again(model=model, chain=from_urdf(model, self.base, name).lock(dict(self.chain.locked)))

    def with_free_axis(self, axis: Any, at: ArrayLike | None = None) -> Self:
        """This arm, its tip free to turn about an axis: a new arm with one redundancy parameter more.

        For tools that are round: welding, spraying, drilling, gripping a cylinder. The parameter's value v [rad] says
        how far the tip is turned from the target: ``ik(T, redundancy=v)`` solves the target turned by v about the axis,
        ``T @ arm.solver.free_axis.rotation(v)``; ``ik(T)`` is v = 0. ``ik_nearest`` and ``follow`` choose the rotation.
        Mount a tool first: the axis belongs to the tip link. An arm with seven joints has two parameters then, this
        one first, and takes values ``redundancy=(..., 2)``.

        Args:
            axis: 'x', 'y' or 'z' of the tip, or a direction (3,) in the tip's frame.
            at: (3,) m, a point on the axis in the tip's frame; default: the tip's origin.

        Raises:
            ArgumentError: an invalid axis, the arm has a free axis already, a joint in its middle is given, or it
                has less than six joints or controls less than a pose.
            UnsupportedArm: no solver takes this arm.

        Example:
            >>> import urdf_ik
            >>> arm = urdf_ik.load("puma_560").with_free_axis("z")
            >>> T = arm.fk([0.3, -0.5, 0.8, 0.4, 0.7, -0.2])
            >>> s = arm.ik(T, redundancy=0.5)
            >>> arm.redundancy_of(s.to_array(), T).round(6).tolist()
            [0.5, 0.5, 0.5, 0.5, 0.5, 0.5, 0.5, 0.5]
        """
        return replace(self, solver=preparation.with_free_axis(self.solver, axis, at))

    def with_redundancy(self, *joints: str) -> Self:
        """This arm, the values of these joints being its redundancy parameters: a new arm.

        A rail, the joint of a positioner, or any other of seven joints or more. An end joint costs what the six others
        cost. One in the middle makes another arm of every value, prepared when the value is first asked for: a
        fraction of a millisecond for closed forms, up to a second for an elimination. ``arm.structure.reason`` says
        which parameter an arm has by itself, and why.

        Args:
            joints: names, as many as a pose leaves free, or fewer, to which others are added.
                ``arm.solver.parameters`` says in which order ``ik`` takes their values.

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
        return replace(self, solver=self.solver.again(given=joints))

    def with_locked(self, values: Mapping[str, float]) -> Self:
        """This arm, joints being held at these values [rad or m]: a new arm of the other joints.

        Joints of the chain become part of the fixed geometry; those beside it, such as the joints of a second arm,
        stand there as obstacles. Joints that are held already stay held, unless ``values`` names them anew.

        Raises:
            ChainError: the URDF has no such joint; the error lists those that it has.
            ArgumentError: a value is not a finite number.

        Example:
            >>> import urdf_ik
            >>> left = urdf_ik.load("dual_6r", tip="left_tool0")
            >>> q = [-1.2, 0.4, -2.6, 2.3, -0.9, -2.5]
            >>> crossed = left.with_locked({"right_joint_1": 1.6, "right_joint_2": 0.4, "right_joint_3": -2.6})
            >>> bool(left.clearance(q) > 0.02), float(crossed.clearance(q))
            (True, 0.0)
        """
        given = inputs.mapping(values, "values", "a value for each joint by name")
        chain = from_urdf(self.model, self.base, self.tip).lock({**dict(self.chain.locked), **given})
        return self._again(chain=chain)

    def with_cell(self, cell: Cell) -> Self:
        """This arm in another cell: a new arm with other allowed collisions.

        Example:
            >>> import urdf_ik
            >>> arm = urdf_ik.load("zyyzyz_6r")
            >>> arm.with_cell(arm.cell.allow("link_4", "link_6")).cell.nearest_pair([0.0] * 6).links
            ('link_3', 'link_5')
        """
        return replace(self, cell=cell, solver=self.solver.again(contacts=cell))

    def for_task(self, task: str) -> Self:
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
        return replace(self, solver=solve.for_task(self.solver, preparation.check_task(task)))

    def _again(self, model: UrdfModel | None = None, chain: Chain | None = None) -> Self:
        """This arm with another URDF or chain, and with the settings that it has."""
        model, chain = model or self.model, chain or self.chain
        of = self.solver
        return type(self).of(model, chain, of.task, of.free_axis, of.given, self.cell.moved_to(model, chain))

    def _repr_html_(self) -> str:
        return html(self.solver)

    def __repr__(self) -> str:
        return f"<Arm {self.name!r}: {self.base} to {self.tip}, {self.structure.family or f'{self.dof} joints'}>"


def arm_of(solver: Solver) -> Arm:
    """The arm whose solver made solutions, intervals or a plan.

    Example:
        >>> import urdf_ik
        >>> arm = urdf_ik.load("planar_2r")
        >>> arm_of(arm.ik(arm.fk([0.1, 0.2])).solver).model is arm.model
        True
    """
    cell = solver.contacts
    if not isinstance(cell, Cell):
        raise ArgumentError(f"{solver.name}: a solver that was prepared without a cell belongs to no arm")
    return Arm(cell.model, solver.chain, solver, cell)
