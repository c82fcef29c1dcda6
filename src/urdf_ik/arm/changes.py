"""Arms with one setting changed: a tool, a free axis, redundancy parameters, locked joints, a task."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any, NamedTuple

from numpy.typing import ArrayLike

from urdf_ik.cell import tool
from urdf_ik.cell.cell import Cell
from urdf_ik.cell.tool import Shapes
from urdf_ik.errors import ArgumentError
from urdf_ik.ik import solver as solvers
from urdf_ik.ik.solver import Solver
from urdf_ik.ik.task import Task
from urdf_ik.kinematics.chain import Chain, from_urdf, velocity_limits
from urdf_ik.kinematics.chain.free_axis import FreeAxis
from urdf_ik.model.urdf import UrdfModel
from urdf_ik.support import inputs


class Parts(NamedTuple):
    """The fields of an arm; see :class:`urdf_ik.Arm`."""

    model: UrdfModel
    chain: Chain
    solver: Solver
    cell: Cell


def assembled(
    model: UrdfModel,
    chain: Chain,
    task: str = "pose",
    free_axis: FreeAxis | None = None,
    chosen: Sequence[str] = (),
    cell: Cell | None = None,
) -> Parts:
    """The parts of the arm of a URDF and one of its chains.

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
    return Parts(model, chain, solvers.prepare(model.name, chain, speeds, task, free_axis, chosen), cell)


def with_tool(arm: Parts, pose: Any, shapes: Shapes = (), name: str = "tool") -> Parts:
    """A new arm with a tool at the tip: its tip is the tool's centre point, and the tool's shapes collide.

    The tool is a link of the new arm's URDF, fixed to the present tip. So Pinocchio sees it too, and
    ``arm.model.write`` writes it. Tools may be stacked. Base, locked joints, task and changes of the
    allowed-collision table stay. A tool may touch the links that any link in its place may touch.

    Args:
        arm: its parts.
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
    model = tool.with_tool(arm.model, solvers.fixed_tip(arm.solver), pose, shapes, name)
    return _again(arm, model=model, chain=from_urdf(model, arm.chain.base, name).lock(dict(arm.chain.locked)))


def with_free_axis(arm: Parts, axis: Any, at: ArrayLike | None = None) -> Parts:
    """A new arm whose tip may turn about an axis: it has one more redundancy parameter.

    For round tools: welding, spraying, drilling, gripping a cylinder. The parameter's value v [rad] is the angle
    by which the tip is turned from the target: ``ik(T, redundancy=v)`` solves the target turned by v about the axis,
    ``T @ arm.solver.free_axis.rotation(v)``; ``ik(T)`` is v = 0. ``ik_nearest`` and ``follow`` choose the rotation.
    Mount a tool first: the axis belongs to the tip link. An arm with seven joints then has two parameters, this
    one first, and takes values ``redundancy=(..., 2)``.

    Args:
        arm: its parts.
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
    return arm._replace(solver=solvers.with_free_axis(arm.solver, axis, at))


def with_redundancy(arm: Parts, *joints: str) -> Parts:
    """A new arm whose redundancy parameters are the values of these joints.

    Any joint of an arm with seven or more may be chosen, such as a rail or the joint of a positioner. With an end
    joint, a value costs as much as solving the other six. With a joint in the middle, each value is another arm,
    prepared when the value is first used: a fraction of a millisecond for closed forms, up to a second for an
    elimination. ``arm.structure.reason`` names the default parameter and the reason for it.

    Args:
        arm: its parts.
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
    return arm._replace(solver=arm.solver.again(chosen=joints))


def with_locked(arm: Parts, values: Mapping[str, float]) -> Parts:
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
    given = inputs.mapping(values, "values", "a value for each joint by name")
    chain = from_urdf(arm.model, arm.chain.base, arm.chain.tip).lock({**dict(arm.chain.locked), **given})
    return _again(arm, chain=chain)


def with_cell(arm: Parts, cell: Cell) -> Parts:
    """A new arm in another cell, such as one with other allowed collisions."""
    return arm._replace(cell=cell, solver=replace(arm.solver))


def for_task(arm: Parts, task: str | Task) -> Parts:
    """A new arm whose ``ik`` and ``explain`` take targets of a task; see :meth:`urdf_ik.Arm.ik`.

    A task that leaves more free than the arm's joints need has redundancy parameters: values of joints, or the rotation
    about the axis. One that no closed form solves is searched, and ``status`` is 'incomplete'.

    Raises:
        ArgumentError: the task is unknown, or the arm cannot control it.
        UnsupportedArm: no solver takes this arm.

    Example:
        >>> import urdf_ik
        >>> arm = urdf_ik.load("planar_2r").for_task("planar position")
        >>> len(arm.ik([0.1, 0.1]))
        2
    """
    if arm.solver.free_axis is not None:
        raise ArgumentError(
            f"{arm.model.name}: with {arm.solver.free_axis} free, targets are poses, and the rotation about it does "
            f"not matter; {task!r} is a task of the arm without a free axis"
        )
    return arm._replace(solver=arm.solver.again(task=task))


def _again(arm: Parts, model: UrdfModel | None = None, chain: Chain | None = None) -> Parts:
    """An arm with another URDF or chain, and with the settings that it has."""
    model, chain = model or arm.model, chain or arm.chain
    before = arm.solver
    return assembled(model, chain, before.task, before.free_axis, before.chosen, arm.cell.moved_to(model, chain))
