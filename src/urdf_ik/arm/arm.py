"""Arm: a URDF, its chain, its solver and its cell, as one record."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from html import escape
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from urdf_ik.cell import tool
from urdf_ik.cell.cell import Cell
from urdf_ik.cell.tool import Shapes
from urdf_ik.errors import ArgumentError
from urdf_ik.ik import solver as solvers
from urdf_ik.ik.explanation import explain
from urdf_ik.ik.nearest import nearest
from urdf_ik.ik.pose_solving import solve
from urdf_ik.ik.redundancy import Intervals, values
from urdf_ik.ik.redundancy.interval_search import intervals
from urdf_ik.ik.solutions import IKSolutions, limits
from urdf_ik.ik.solutions.tables import stick_picture
from urdf_ik.ik.solver import Solver, prepare
from urdf_ik.ik.task import Task
from urdf_ik.kinematics import velocity
from urdf_ik.kinematics.chain import Chain, from_urdf, velocity_limits
from urdf_ik.kinematics.chain.free_axis import FreeAxis
from urdf_ik.kinematics.chain.redundancy import Redundancy
from urdf_ik.kinematics.structure import Structure
from urdf_ik.model.urdf import UrdfModel
from urdf_ik.paths.path_settings import takes_settings
from urdf_ik.paths.target_tracker import Tracker
from urdf_ik.support.palette import colours
from urdf_ik.support.report import table
from urdf_ik.typing import Array, Threads

if TYPE_CHECKING:
    from urdf_ik.cell.swept_motions import Motions
    from urdf_ik.cell.world import World
    from urdf_ik.paths.planned_motion import Plan


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

    def __post_init__(self) -> None:
        object.__setattr__(self.solver, "arm", self)

    def __reduce__(self) -> tuple[Any, ...]:
        return _remade, (self.model, self.chain, self.cell, self.solver.settings)

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
        """The redundancy parameter of an arm with seven joints or a free axis; None for other arms.

        The first one of an arm with several; ``arm.solver.parameters`` holds all.
        """
        return self.solver.parameter

    def fk(self, q: ArrayLike) -> Array:
        """Pose of the tip in the base: (..., n) rad or m to (..., 4, 4); see :meth:`Chain.fk`."""
        return self.chain.fk(q)

    def jacobian(self, q: ArrayLike) -> Array:
        """Geometric Jacobian at the tip in base axes: (..., n) to (..., 6, n); see :meth:`Chain.jacobian`."""
        return self.chain.jacobian(q)

    def link_poses(self, q: ArrayLike) -> dict[str, Array]:
        """Pose of every link in the base: (..., n) to (..., 4, 4) each; see :meth:`Chain.link_poses`."""
        return self.chain.link_poses(q)

    def manipulability(self, q: ArrayLike, part: str = "all") -> Array:
        """Yoshikawa's manipulability: (..., n) to (...); see :func:`urdf_ik.kinematics.velocity.manipulability`."""
        return velocity.manipulability(self.chain, q, part)

    def limit_margin(self, q: ArrayLike) -> Array:
        """Distance (...) of joint vectors (..., n) from the joint limits: the least over joints, in half ranges.

        1 in the middle of all ranges, 0 at a limit, negative outside; see :func:`urdf_ik.ik.solutions.limits.margin`.
        """
        return limits.margin(self.chain.check(q, padded=True), self.limits)

    def to_pinocchio(self, q: ArrayLike) -> Array:
        """Configurations (..., nq) of Pinocchio's model of the whole URDF: joints by name, continuous ones (cos, sin).

        Joints outside the chain stay at zero. Joints that mimic others follow them. ``arm.cell.reference.pin_model`` is
        the ``pinocchio.Model``. See :meth:`urdf_ik.cell.pinocchio_reference.Reference.configurations`.
        """
        return self.cell.reference.configurations(self.chain.check(q, padded=True))

    def from_pinocchio(self, q_pin: ArrayLike) -> Array:
        """Joint vectors (..., n) rad or m of configurations (..., nq), the inverse of :meth:`to_pinocchio`.

        Angles of continuous joints come back in (-pi, pi]; see
        :meth:`urdf_ik.cell.pinocchio_reference.Reference.joint_vectors`.
        """
        return self.cell.reference.joint_vectors(q_pin)

    def ik(
        self,
        T: Any,
        q_ref: ArrayLike | None = None,
        *,
        redundancy: ArrayLike | None = None,
        threads: Threads = 1,
        task: str | Task | None = None,
        axis: ArrayLike | str | None = None,
        tolerance: ArrayLike | None = None,
        out: IKSolutions | None = None,
    ) -> IKSolutions:
        """Every joint vector that brings the tip to ``T``.

        Each solution was verified against the URDF as written: position and rotation errors are below 1e-9 m and rad.
        :meth:`IKSolutions.explain` explains an empty answer. At a singularity that leaves a joint free, the answer
        holds one representative, marked in ``singular``: the free joint stands at zero, or near ``q_ref``.

        Args:
            T: (..., 4, 4) pose of the tip in the base [m], a ``pinocchio.SE3`` or a list of them. A rotation that is
                off by rounding (up to 1e-5) is replaced by the nearest one. The answer keeps a stack by reference.
            q_ref: (n,) rad, joint vector near which representatives of a continuum are chosen.
            redundancy: (...) rad or m, values of the redundancy parameter, which broadcast against the poses:
                ``ik(T[:, None], redundancy=values)`` solves every pose at every value. Default:
                ``self.redundancy.default``. (..., k) for an arm with k parameters.
            threads: number of threads that share a batch; 'auto': one for each processor that this process may use.
            task: the kind of target; default: a pose. 'position' (..., 3) m; 'position and axis' (..., 6), position and
                direction of the tip's ``axis`` in the base; 'level', poses of which the yaw is
                free; 'orientation', poses; 'axis' (..., 3), a direction alone; 'look at' (..., 3) m, a point to which
                the axis points. All take poses, too. See :class:`urdf_ik.Task`. Planar arms: 'planar position'
                (..., 2) m and 'planar pose' (..., 3) m, m, rad, see ``arm.solver.control.plane``.
            axis: of the tip: 'x', 'y', 'z' or a direction (3,). Default: z; with 'position and axis' of five joints the
                one they control, ``arm.solver.control.aimed``. 'position' with an axis is 'position and axis'.
            tolerance: (m, rad) by which a solution may miss the pose, for poses that were rounded and arms with fewer
                joints than six: (5e-7, 1e-6) for six decimals; default: 1e-9, as rounding leaves. ``error`` of the
                solutions says what each misses; see :func:`urdf_ik.ik.tolerance.solve_within`.
            out: what an earlier call returned for a batch of the same shape. It is overwritten and returned, and so are
                arrays taken from it. Fresh memory costs a large batch up to twice the time of solving.

        Returns:
            The solutions, (..., B, n), one column a branch. With seven joints these are all solutions at the given
            value, and ``singular`` marks those at which the Jacobian loses rank while the value is held.

        Raises:
            PoseError: a target is not finite or not a rigid pose.
            ArgumentError: ``q_ref``, ``redundancy``, ``threads``, ``task`` or ``out`` does not fit.
            UnsupportedArm: no solver takes this arm.

        Example:
            >>> import urdf_ik
            >>> arm = urdf_ik.load("zyyzyz_6r")
            >>> s = arm.ik(arm.fk([0.3, -0.5, 0.8, 0.4, 0.7, -0.2]))
            >>> s.q.shape, s[0].branch
            ((8, 6), 'shoulder front, elbow up, wrist flip')
        """
        solver = self.solver if task is None else self.for_task(task, axis).solver
        if tolerance is not None:
            from urdf_ik.ik.tolerance import solve_within

            return solve_within(solver, T, tolerance, q_ref=q_ref, redundancy=redundancy, threads=threads)
        return solve(solver, T, q_ref, redundancy, threads, out)

    def ik_closest(
        self, T: Any, weights: ArrayLike | None = None, first: str | None = None, **options: Any
    ) -> IKSolutions:
        """The joint vectors that miss least of ``T``: every local minimum found, the best first, with what it misses.

        Arguments, errors and an example: :func:`urdf_ik.ik.closest.closest`.
        """
        from urdf_ik.ik.closest import closest

        return closest(self.solver, T, weights, first, **options)

    def values_inside(self, T: Any, threads: Threads = 1) -> Array:
        """Values of the redundancy parameters, as ``ik`` takes them, at which ``T`` has solutions inside the limits.

        Arguments and errors: :func:`urdf_ik.ik.redundancy.elsewhere.values_inside`.
        """
        from urdf_ik.ik.redundancy.elsewhere import values_inside

        return values_inside(self.solver, T, threads)

    def ik_nearest(self, T: Any, q_ref: ArrayLike, *, task: str | Task | None = None, **options: Any) -> IKSolutions:
        """The solution nearest to ``q_ref``, over all branches and all values of the redundancy parameters.

        Args:
            T: as in ``ik``.
            q_ref: (n,), or one for each pose (..., n), rad or m.
            task: the kind of target; see ``ik``.
            **options: ``metric``, ``weights``, ``within``, ``within_limits`` (True), ``region`` and ``threads``: see
                :func:`urdf_ik.ik.nearest.nearest`.

        Returns:
            One column a pose. At a continuum it is the representative near ``q_ref``. With seven joints, ``redundancy``
            holds the values of the parameter to 1e-8, found over all of :meth:`intervals`. With a region, ``poses``
            holds the poses chosen in it.

        Raises:
            PoseError: a target is not a rigid pose.
            ArgumentError: ``q_ref``, ``task`` or an option does not fit.
            UnsupportedArm: no solver takes this arm.

        Example:
            >>> import urdf_ik
            >>> arm = urdf_ik.load("zyyzyz_6r")
            >>> q = [0.3, -0.5, 0.8, 0.4, 0.7, -0.2]
            >>> arm.ik_nearest(arm.fk(q), q).q.round(6).tolist()
            [[0.3, -0.5, 0.8, 0.4, 0.7, -0.2]]
        """
        solver = self.solver if task is None else self.for_task(task).solver
        return nearest(solver, T, q_ref, **options)

    def explain(self, T: Any, redundancy: ArrayLike | None = None) -> str:
        """The reason why one pose ``T`` (4, 4) has no solution inside the joint limits, and by how much it fails.

        Arguments, errors and an example: :func:`urdf_ik.ik.explanation.explain`.
        """
        return explain(self.solver, T, redundancy)

    def intervals(self, T: Any, within_limits: bool = True, *, threads: Threads = 1) -> Intervals:
        """The intervals of the redundancy parameter in which each branch has solutions, and the cause of each end.

        Arguments, errors and an example: :func:`urdf_ik.ik.redundancy.interval_search.intervals`.
        """
        return intervals(self.solver, T, within_limits=within_limits, threads=threads)

    def redundancy_of(self, q: ArrayLike, T: Any = None) -> Array:
        """Values of the redundancy parameters at joint vectors; ``ik`` at these values returns the joint vectors.

        Arguments, errors and an example: :func:`urdf_ik.ik.redundancy.values.redundancy_of`.
        """
        return values.redundancy_of(self.solver, q, T)

    def clearance(self, q: ArrayLike, world: World | None = None) -> float | Array:
        """Least distance between links that must not touch, and between them and the obstacles of a world.

        Arguments, errors and an example: :meth:`urdf_ik.cell.cell.Cell.clearance`.
        """
        return self.cell.clearance(q, world)

    def motion_is_free(self, q0: ArrayLike, q1: ArrayLike, world: World | None = None, margin: float = 0.0) -> Motions:
        """Whether straight motions in joint space are free of contact from end to end; proven, not sampled.

        Arguments, errors and an example: :meth:`urdf_ik.cell.cell.Cell.motion_is_free`.
        """
        return self.cell.motion_is_free(q0, q1, world, margin)

    @takes_settings
    def follow(self, T: Any, **settings: Any) -> Plan:
        """The cheapest joint motion along a path, over all branches and turns, without a jump.

        From waypoint to waypoint the joints move linearly, and the tip provably stays within a tolerance of the
        straight segment. Where it would leave it, ``follow`` adds waypoints; ``Plan.motion`` holds them. Redundancy
        parameters are searched on a coarse grid, then on finer grids around the path found.

        Args:
            T: (m, 4, 4) m, waypoints; see :func:`urdf_ik.line`, :func:`urdf_ik.arc`, :func:`urdf_ik.polyline`.
            **settings: see PathSettings.

        Returns:
            See :class:`urdf_ik.Plan`; where ``found`` is false, ``explain()`` says how far each branch gets.

        Raises:
            ArgumentError: waypoints, ``start``, ``end`` or a setting do not fit.
            PoseError: a waypoint is not a rigid pose.
            UrdfError: a world is given, or ``collisions="require"``, and not all collision shapes can be read.
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
        from urdf_ik.paths.planning import follow  # brings coal

        return follow(self.solver, self.cell, T, **settings)

    def tracker(self, q0: ArrayLike, dt: float, **options: Any) -> Tracker:
        """A tracker that starts at ``q0`` and takes one target every ``dt`` s: see :class:`urdf_ik.paths.Tracker`.

        Example:
            >>> import urdf_ik
            >>> arm = urdf_ik.load("zyyzyz_6r")
            >>> tracker = arm.tracker([0.3, -0.5, 0.8, 0.4, 0.7, -0.2], dt=0.004)
            >>> tracker.step(arm.fk([0.301, -0.5, 0.8, 0.4, 0.7, -0.2])).status
            'ok'
        """
        return Tracker(self.solver, q0, dt, **options)

    def with_tool(self, pose: Any, shapes: Shapes = (), name: str = "tool") -> Arm:
        """A new arm with a tool at the tip: its tip is the tool's centre point, and the tool's shapes collide.

        The tool is a link of the new arm's URDF, fixed to the present tip. So Pinocchio sees it too, and
        ``arm.model.write`` writes it. Tools may be stacked. Base, locked joints, task and changes of the
        allowed-collision table stay. A tool may touch the links that any link in its place may touch.

        Args:
            pose: (4, 4) of the tool's centre point in the present tip link [m], or a ``pinocchio.SE3``.
            shapes: the tool's shapes, each a shape or a pair (shape, pose in the present tip link [m]):
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
        model = tool.with_tool(self.model, solvers.fixed_tip(self.solver), pose, shapes, name)
        return self._again(model, from_urdf(model, self.base, name).lock(dict(self.chain.locked)))

    def with_free_axis(self, axis: Any, at: ArrayLike | None = None) -> Arm:
        """A new arm whose tip may turn about an axis: it has one more redundancy parameter.

        For round tools: welding, spraying, drilling, gripping a cylinder. The parameter's value v [rad] is the angle
        by which the tip is turned from the target: ``ik(T, redundancy=v)`` solves the target turned by v about the
        axis, ``T @ arm.solver.free_axis.rotation(v)``; ``ik(T)`` is v = 0. ``ik_nearest`` and ``follow`` choose the
        rotation. Mount a tool first: the axis belongs to the tip link. An arm with seven joints then has two
        parameters, this one first, and takes values ``redundancy=(..., 2)``.

        Args:
            axis: 'x', 'y' or 'z' of the tip, or a direction (3,) in the tip's frame.
            at: (3,) m, a point on the axis in the tip's frame; default: the tip's origin.

        Raises:
            ArgumentError: an invalid axis, the arm has a free axis already, a joint in its middle is given, or it
                has fewer than six joints or controls less than a pose.
            UnsupportedArm: no solver takes this arm.

        Example:
            >>> import urdf_ik
            >>> arm = urdf_ik.load("puma_560").with_free_axis("z")
            >>> T = arm.fk([0.3, -0.5, 0.8, 0.4, 0.7, -0.2])
            >>> s = arm.ik(T, redundancy=0.5)
            >>> arm.redundancy_of(s.to_array(), T).round(6).tolist()
            [0.5, 0.5, 0.5, 0.5, 0.5, 0.5, 0.5, 0.5]
        """
        return replace(self, solver=solvers.with_free_axis(self.solver, axis, at))

    def with_redundancy(self, *joints: str) -> Arm:
        """A new arm whose redundancy parameters are the values of these joints.

        Any joint of an arm with seven or more may be chosen, such as a rail or the joint of a positioner. With an end
        joint, a value costs as much as solving the other six. With a joint in the middle, each value is another arm,
        prepared when the value is first used: a fraction of a millisecond for closed forms, up to a second for an
        elimination. ``arm.structure.reason`` names the default parameter and the reason for it.

        Args:
            joints: names, at most one for each redundancy parameter of the arm; missing ones are added.
                ``arm.solver.parameters`` has the order in which ``ik`` takes their values.

        Raises:
            ChainError: the chain has no such joint; the error lists those it has.
            ArgumentError: more joints than the arm has redundancy parameters.
            UnsupportedArm: no solver takes the other joints, or joints mimic others.

        Example:
            >>> import urdf_ik
            >>> arm = urdf_ik.load("srs_7r").with_redundancy("joint_1")
            >>> arm.redundancy.joint, arm.redundancy.kind
            ('joint_1', 'locked joint')
        """
        return replace(self, solver=self.solver.again(chosen=joints))

    def with_locked(self, values: Mapping[str, float]) -> Arm:
        """A new arm with joints locked at these values [rad or m]; the other joints move.

        Locked joints of the chain become fixed geometry. Joints outside it, such as those of a second arm, put their
        links there as obstacles. Joints that are locked already stay so, unless ``values`` gives them a new value.

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
        held = {**dict(self.chain.locked), **values}
        return self._again(self.model, from_urdf(self.model, self.base, self.tip).lock(held))

    def with_cell(self, cell: Cell) -> Arm:
        """A new arm in another cell, such as one with other allowed collisions."""
        return replace(self, cell=cell, solver=replace(self.solver))

    def for_task(self, task: str | Task, axis: ArrayLike | str | None = None) -> Arm:
        """A new arm whose ``ik`` and ``explain`` take targets of a task; see :meth:`urdf_ik.Arm.ik`.

        A task that leaves more free than the arm's joints need has redundancy parameters: values of joints, or the
        rotation about the axis. One that no closed form solves is searched, and ``status`` is 'incomplete'.

        Raises:
            ArgumentError: the task is unknown, or the arm cannot control it.
            UnsupportedArm: no solver takes this arm.

        Example:
            >>> import urdf_ik
            >>> arm = urdf_ik.load("planar_2r").for_task("planar position")
            >>> len(arm.ik([0.1, 0.1]))
            2
        """
        asked = Task.chosen(task, axis, self.solver.control.aimed)
        if asked not in self._tasks:
            same = asked == self.solver.settings["task"]
            if not same and self.solver.free_axis is not None:
                raise ArgumentError(
                    f"{self.name}: with {self.solver.free_axis} free, targets are poses, and the rotation about it "
                    f"does not matter; {task!r} is a task of the arm without a free axis"
                )
            self._tasks[asked] = self if same else replace(self, solver=self.solver.again(task=asked))
        return self._tasks[asked]

    @cached_property
    def _tasks(self) -> dict[str | Task, Arm]:
        """The arms of :meth:`for_task`."""
        return {}

    def _again(self, model: UrdfModel, chain: Chain) -> Arm:
        """The arm of another URDF or chain, with the settings that it has."""
        own = self.solver
        return assemble(model, chain, own.settings["task"], own.free_axis, own.chosen, self.cell.moved_to(model, chain))

    def _repr_html_(self) -> str:
        return html(self.solver)

    def __repr__(self) -> str:
        return f"<Arm {self.name!r}: {self.base} to {self.tip}, {self.structure.family or f'{self.dof} joints'}>"


def assemble(
    model: UrdfModel,
    chain: Chain,
    task: str | Task = "pose",
    free_axis: FreeAxis | None = None,
    chosen: Sequence[str] = (),
    cell: Cell | None = None,
) -> Arm:
    """The arm of a URDF and one of its chains.

    Args:
        model: the URDF.
        chain: the joints from base to tip.
        task: the kind of targets; see :meth:`urdf_ik.Arm.ik`.
        free_axis: a line in the tip about which it may be turned; see :meth:`urdf_ik.Arm.with_free_axis`.
        chosen: names of joints whose values are redundancy parameters; see :meth:`urdf_ik.Arm.with_redundancy`.
        cell: self-collision and worlds; default: those of the URDF.

    Raises:
        ArgumentError: ``model`` or ``chain`` is something else, or a setting does not fit.
        ChainError: one of ``chosen`` is not a joint of the chain.
        UnsupportedArm: no solver takes this arm with these settings.
    """
    cell = Cell(model, chain) if cell is None else cell
    speeds = velocity_limits(model, chain)
    return Arm(model, chain, prepare(model.name, chain, speeds, task, free_axis, chosen), cell)


def _remade(model: UrdfModel, chain: Chain, cell: Cell, settings: dict[str, Any]) -> Arm:
    """An arm as it was before it was pickled or copied: its solver is prepared again."""
    return Arm(model, chain, prepare(**settings), cell)


def html(solver: Solver) -> str:
    """Joints and limits, how it is solved, and a small picture of it nearest to zero within its limits."""
    kinds = solver.chain.joint_types
    rows = [
        [str(k + 1), name, kind, _bound(lower), _bound(upper), "m" if kind == "prismatic" else "rad"]
        for k, (name, kind, (lower, upper)) in enumerate(zip(solver.joint_names, kinds, solver.limits, strict=True))
    ]
    structure = solver.structure
    solved = f"{structure.family}: {structure.solutions_in_words()}" if structure.family else "no solver takes it"
    title = f"{solver.name}: {solver.chain.base} to {solver.chain.tip}"
    q = np.clip(np.zeros(solver.dof), *solver.limits.T)
    picture = stick_picture(solver.chain, q[None], colours(1))
    joints = table(["#", "joint", "type", "lower", "upper", "unit"], rows)
    return f"<div><p><b>{escape(title)}</b><br/>{escape(solved)}</p>{picture}{joints}</div>"


def _bound(value: float) -> str:
    return "none" if np.isinf(value) else f"{value:.4f}"
