"""``Task``: the part of a pose that is asked for."""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from urdf_ik.errors import ArgumentError, PoseError
from urdf_ik.ik.descent import angle_missed
from urdf_ik.kinematics.chain import Chain
from urdf_ik.kinematics.chain.free_axis import FreeAxis
from urdf_ik.model.poses import as_pose_array, check_poses
from urdf_ik.support import inputs
from urdf_ik.support.text import quoted
from urdf_ik.typing import Array

NUMBERS = {"pose": 6, "position": 3, "position and axis": 5, "orientation": 3, "axis": 2, "look at": 2}
"""How many numbers each kind of target fixes."""
LEVEL = "level"
_AHEAD = 1e-9
"""m: a point nearer to the tip is in no direction from it."""


@dataclass(frozen=True)
class Task:
    """What is asked of the tip; the other parts of its pose are free.

    Attributes:
        components: 'pose'; 'position'; 'position and axis': all but the rotation about an axis; 'orientation'; 'axis':
            the direction of an axis alone; 'look at': an axis of the tip points at a position.
        axis: the axis; None where there is none.
        frame: 'tip': the direction of an axis of the tip is asked for. 'base': the rotation about an axis of the base
            is free; about z, roll and pitch are asked for and the yaw is free.

    Example:
        >>> import urdf_ik
        >>> urdf_ik.Task.read("position", axis="x")
        Task(components='position and axis', axis=(1.0, 0.0, 0.0), frame='tip')
    """

    components: str
    axis: tuple[float, float, float] | None = None
    frame: str = "tip"

    @classmethod
    def read(cls, task: Any, axis: Any = None) -> "Task":
        """From a task or its components, and 'x', 'y', 'z' or a direction (3,); default: z.

        'level' is the position, roll and pitch: any yaw.

        Raises:
            ArgumentError: there is no such task, or it has no axis.
        """
        if isinstance(task, Task):
            return task
        if task == LEVEL:
            return cls("position and axis", (0.0, 0.0, 1.0), "base")
        if not isinstance(task, str) or task not in NUMBERS:
            names = ", ".join(map(repr, (*NUMBERS, LEVEL)))
            raise ArgumentError(f"no task is called {quoted(task)}; tasks: {names}, or an urdf_ik.Task")
        if axis is None and task in ("pose", "position", "orientation"):
            return cls(task)
        if task in ("pose", "orientation"):
            raise ArgumentError(f"axis={axis!r} given; the task {task!r} asks for the directions of all axes")
        return cls(
            "position and axis" if task == "position" else task, FreeAxis.read("z" if axis is None else axis).direction
        )

    @classmethod
    def chosen(cls, task: Any, axis: Any, aimed: Array | None) -> "str | Task":
        """The task, or the name of one in a plane; ``aimed``: the axis of 'position and axis', where none is named."""
        if isinstance(task, Task):
            return "pose" if task == POSE else task
        by_name = axis is None and (task == "pose" or task not in (*NUMBERS, LEVEL))
        axis = aimed if axis is None and task == "position and axis" else axis
        return task if by_name and isinstance(task, str) else cls.read(task, axis)

    def __str__(self) -> str:
        if self.axis is None:
            return self.components
        name = FreeAxis(self.axis).name
        if self.frame == "base":
            return "position, roll and pitch" if name == "z" else f"position, free to turn about {name} of the base"
        return {"position and axis": f"position and direction of {name}", "axis": f"direction of {name}"}.get(
            self.components, f"{name} looks at a point"
        )

    @property
    def has_place(self) -> bool:
        """Whether a position is asked for."""
        return self.components in ("pose", "position", "position and axis", "look at")

    @property
    def has_turn(self) -> bool:
        """Whether a direction or a rotation is asked for."""
        return self.components not in ("position", "look at")

    def read_targets(self, T: Any) -> Array:
        """Targets as poses (..., 4, 4), of which only what is asked for counts.

        Args:
            T: (..., 4, 4) poses; positions (..., 3) [m] of 'position' and 'look at'; directions (..., 3) of an 'axis';
                both (..., 6) of 'position and axis'.

        Raises:
            PoseError: a target of another shape, or not finite.
        """
        if are_poses(T):
            return check_poses(as_pose_array(T))
        width = {"position": 3, "look at": 3, "axis": 3, "position and axis": 6}.get(self.components)
        target = inputs.real(T, f"a target of the task {self}", "an array of numbers", PoseError)
        if width is None or self.frame == "base" or target.shape[-1:] != (width,):
            numbers = "" if width is None or self.frame == "base" else f", or of shape (..., {width})"
            raise PoseError(f"a target of shape {target.shape} given; the task {self} takes poses (..., 4, 4){numbers}")
        if (bad := inputs.first_bad(target)) is not None:
            raise PoseError(
                f"a target of the task {self}: {target[bad]} given; {inputs.why_bad(target[bad])}", bad[:-1] or None
            )
        out = np.tile(np.eye(4), (*target.shape[:-1], 1, 1))
        if self.components != "axis":
            out[..., :3, 3] = target[..., :3]
        if self.components in ("axis", "position and axis"):
            directions = target[..., -3:].reshape(-1, 3)
            largest = np.abs(directions).max(axis=1, keepdims=True)  # lest squares overflow
            if not largest.all():
                at = np.argwhere(largest.reshape(target.shape[:-1]) == 0.0)[0]
                raise PoseError("a direction of the target has no length", tuple(at.tolist()) or None)
            directions = directions / largest
            length = np.linalg.norm(directions, axis=1, keepdims=True)
            out[..., :3, :3] = turn_to(np.array(self.axis), directions / length).reshape(*target.shape[:-1], 3, 3)
        return out

    def matrix(self, T: Array) -> tuple[Array, float]:
        """``descent.Wanted.matrix`` (m, 3, 3) and its constant, of targets (m, 4, 4)."""
        R = T[:, :3, :3]
        if self.axis is None or not self.has_turn:
            return R, 3.0
        a = np.array(self.axis)
        if self.frame == "base":
            return 2.0 * a[:, None] * (a @ R)[:, None, :], 2.0
        return 2.0 * (R @ a)[:, :, None] * a, 2.0

    def chain(self, chain: Chain) -> Chain:
        """The chain whose tip goes to the target's position: for 'look at' with a slide along the axis, from 0 on."""
        if self.components != "look at":
            return chain
        h = chain.R_tip @ np.array(self.axis)
        return replace(
            chain,
            joint_names=(*chain.joint_names, ""),
            joint_types=(*chain.joint_types, "prismatic"),
            H=np.vstack([chain.H, h]),
            P=np.vstack([chain.P, np.zeros(3)]),
            limits=np.vstack([chain.limits, [0.0, np.inf]]),
        )

    def errors(self, T: Array, reached: Array) -> tuple[Array, Array]:
        """What poses ``reached`` (..., 4, 4) miss of targets (..., 4, 4): m and rad, 0 where nothing is asked for."""
        T, reached = np.broadcast_arrays(T, reached)
        off = reached[..., :3, 3] - T[..., :3, 3]
        zero = np.zeros(off.shape[:-1])
        if self.components == "look at":
            along = reached[..., :3, :3] @ np.array(self.axis)
            far = np.einsum("...i,...i", -off, along)
            return np.linalg.norm(np.cross(off, along), axis=-1), np.where(far > _AHEAD, 0.0, np.pi)
        angle = zero
        if self.has_turn:
            wanted = self.matrix(T.reshape(-1, 4, 4))
            angle = angle_missed(reached.reshape(-1, 4, 4)[:, :3, :3], *wanted).reshape(zero.shape)
        return (np.linalg.norm(off, axis=-1) if self.has_place else zero), angle


POSE = Task("pose")


def are_poses(T: Any) -> bool:
    """Whether targets are whole poses: (..., 4, 4), or an object that is one."""
    try:
        return not isinstance(T, np.ndarray | list | tuple) or np.shape(T)[-2:] == (4, 4)
    except ValueError:  # of several lengths
        return False


_HALF = 0.5


def turn_to(axis: Array, directions: Array) -> Array:
    """Rotations (m, 3, 3), one each, that turn unit ``axis`` (3,) to unit ``directions`` (m, 3).

    Half turns about the middle of the two; where they are nearly opposite, after half a turn about what lies across
    the axis.
    """
    opposite = np.linalg.norm(directions + axis, axis=1) < _HALF
    middle = directions + np.where(opposite[:, None], -axis, axis)
    middle /= np.linalg.norm(middle, axis=1, keepdims=True)
    turn = 2.0 * middle[:, :, None] * middle[:, None, :] - np.eye(3)
    across = np.cross(axis, np.eye(3)[int(np.argmin(np.abs(axis)))])
    across /= np.linalg.norm(across)
    # (2 m m' - 1)(2 a a' - 1), number by number, so that a batch has the digits of its members.
    shared = (middle * across).sum(axis=1)[:, None, None]
    flipped = 4.0 * shared * middle[:, :, None] * across - turn - 2.0 * np.outer(across, across)
    return np.where(opposite[:, None, None], flipped, turn)
