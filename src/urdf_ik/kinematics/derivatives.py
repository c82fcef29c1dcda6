"""Derivatives of forward kinematics by the numbers of the URDF as written."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from urdf_ik.errors import ArgumentError
from urdf_ik.kinematics.chain import Chain
from urdf_ik.kinematics.chain.mimic import follows
from urdf_ik.kinematics.chain.serial import TreeJoint
from urdf_ik.model.poses import from_rpy
from urdf_ik.support import inputs
from urdf_ik.support.read_only import Frozen
from urdf_ik.typing import Array

FIELDS = ("xyz", "rpy", "axis", "offset")


class Parameter(NamedTuple):
    """One number of a URDF.

    Attributes:
        joint: the joint's name.
        field: 'xyz' [m] or 'rpy' [rad] of its origin, 'axis' as written, or 'offset', what is added to the joint's
            value [rad or m]: the offset of a joint that mimics another, zero for others.
        part: 0, 1 or 2, which of the three numbers; 0 for an offset.
    """

    joint: str
    field: str
    part: int

    def __str__(self) -> str:
        names = {"xyz": "xyz", "rpy": ("roll", "pitch", "yaw"), "axis": "xyz"}.get(self.field)
        return f"{self.joint} {self.field}" if names is None else f"{self.joint} {self.field} {names[self.part]}"


_STEP = 1e-30  # of a complex step, whose error is its square


def _unit(v: Any) -> Any:
    return v / np.sqrt((v * v).sum(axis=-1, keepdims=True))


def _rotation(u: Any, angle: Any) -> Any:
    """Rodrigues' formula (..., 3, 3), also of complex numbers."""
    K = np.cross(np.eye(3), u[..., None, :])
    return np.eye(3) + np.sin(angle)[..., None, None] * K + (1.0 - np.cos(angle))[..., None, None] * (K @ K)


def _transform(R: Any, p: Any) -> Any:
    shape = np.broadcast_shapes(R.shape[:-2], p.shape[:-1])
    T = np.zeros((*shape, 4, 4), dtype=np.result_type(R, p))
    T[..., :3, :3], T[..., :3, 3], T[..., 3, 3] = R, p, 1.0
    return T


def _origin(numbers: Any) -> Any:
    """The origin (..., 4, 4) written as x, y, z, roll, pitch, yaw."""
    return _transform(from_rpy(numbers[..., 3:6]), numbers[..., :3])


def _inverse(T: Any) -> Any:
    back = np.swapaxes(T[..., :3, :3], -1, -2)
    return _transform(back, -(back @ T[..., :3, 3, None])[..., 0])


@dataclass(frozen=True, eq=False)
class WrittenChain(Frozen):
    """The joints from base to tip with their origins and axes as the URDF has them; :func:`written` makes it.

    Attributes:
        joints: the joints, fixed ones too, in the order from base to tip.
        upwards: which of them lead from child to parent, since the base need not be the root.
        dof: length n of the joint vector.
        values: (p,) the numbers of the URDF, in the order of ``parameters``.
        coupled: whether some joints mimic others.
    """

    joints: tuple[TreeJoint, ...]
    upwards: tuple[bool, ...]
    dof: int
    values: Array
    coupled: bool = False

    @cached_property
    def parameters(self) -> tuple[Parameter, ...]:
        """(p,) all numbers: origins of all joints, axes and offsets of those that move."""
        return tuple(
            Parameter(joint.name, field, part)
            for joint in self.joints
            for field in (FIELDS if joint.driver else FIELDS[:2])
            for part in range(1 if field == "offset" else 3)
        )

    @cached_property
    def starts(self) -> tuple[int, ...]:
        """Where the numbers of each joint begin in ``values``."""
        counts = [10 if joint.driver else 6 for joint in self.joints]
        return tuple(int(each) for each in np.cumsum([0, *counts[:-1]]))

    def columns(self, parameters: Sequence[Any]) -> list[int]:
        """The places of parameters in ``parameters``.

        Raises:
            ArgumentError: there is no such parameter; the error lists those of the joint, or the joints.
        """
        place = {parameter: k for k, parameter in enumerate(self.parameters)}
        found = []
        for parameter in parameters:
            key: Any = tuple(parameter)
            if key not in place:
                names = list(dict.fromkeys(joint.name for joint in self.joints))
                own = [tuple(p) for p in self.parameters if p.joint == key[0]]
                valid = f"those of this joint: {own}" if own else f"the joints of the chain: {', '.join(names)}"
                raise ArgumentError(f"there is no parameter {parameter!r}, (joint, field, part); {valid}")
            found.append(place[key])
        return found

    def fk(self, q: ArrayLike, values: ArrayLike | None = None) -> Array:
        """Poses (..., 4, 4) of the tip at joint vectors (..., n), with the numbers ``values`` (p,) of the URDF."""
        return self._frames(*self._checked(q, values))[-1]

    def screws(self, values: ArrayLike) -> tuple[Array, Array, Array]:
        """Directions H (m, 3), steps P (m + 1, 3) and rotation R_tip (3, 3) of the chain's m axes with other numbers.

        They are what :class:`urdf_ik.Chain` holds; where joints mimic others, it has more axes than joints.
        """
        Q, numbers = self._checked(np.zeros(self.dof), values)
        frames = self._frames(Q, numbers)
        moving = [k for k, each in enumerate(self.joints) if each.column is not None and follows(each.multiplier)]
        lines = [np.stack(self._line(k, self._own(k, numbers))) @ frames[k][:3, :3].T for k in moving]
        points = [frames[k][:3, 3] + line[0] for k, line in zip(moving, lines, strict=True)]
        steps = np.diff(np.array([np.zeros(3), *points, frames[-1][:3, 3]]), axis=0)
        return np.array([line[1] for line in lines]), steps, np.ascontiguousarray(frames[-1][:3, :3])

    def twists(self, q: ArrayLike, values: ArrayLike | None = None, parameters: Sequence[Any] | None = None) -> Array:
        """The tip's twist for each of the URDF's numbers, the joints held still.

        Args:
            q: (..., n) rad or m.
            values: (p,) the numbers; default: as written.
            parameters: those that are asked for; default: all.

        Returns:
            (..., 6, k) at the tip in base axes, linear rows above angular ones, as the Jacobian's: m and rad per m or
            rad, or per number of an axis.

        Raises:
            ArgumentError: an argument does not fit, or there is no such parameter.
        """
        Q, numbers = self._checked(q, values)
        frames = self._frames(Q, numbers)
        rates = self._rates(Q, numbers, frames, frames[-1][..., :3, 3])
        return rates if parameters is None else rates[..., self.columns(parameters)]

    def _own(self, k: int, numbers: Array) -> Array:
        start = self.starts[k]
        return numbers[start : start + (10 if self.joints[k].driver else 6)]

    def _stepped(self, k: int, numbers: Array, dimensions: int) -> Any:
        """(c, 1, ..., 1, c) a joint's numbers, each with a complex step in turn, for a batch of so many dimensions."""
        own = self._own(k, numbers)
        return (own + 1j * _STEP * np.eye(len(own))).reshape(len(own), *[1] * dimensions, len(own))

    def _local(self, k: int, Q: Array, own: Any) -> Any:
        """The motion (..., 4, 4) from the base's side of joint ``k`` to the tip's, by its own numbers (..., c)."""
        joint, motion = self.joints[k], _origin(own)
        if joint.driver:
            value = own[..., 9] if joint.column is None else own[..., 9] + joint.multiplier * Q[..., joint.column]
            u = _unit(own[..., 6:9])
            turned, slid = (0.0 * value, value) if joint.prismatic else (value, 0.0 * value)
            motion = motion @ _transform(_rotation(u, turned), slid[..., None] * u)
        return _inverse(motion) if self.upwards[k] else motion

    def _line(self, k: int, own: Any) -> tuple[Any, Any]:
        """A point (..., 3) on the axis of joint ``k`` and its direction, in the frame on the base's side."""
        # The value of a joint that mimics another is counted along its own axis.
        turn, u = 1.0 if self.coupled else np.sign(self.joints[k].multiplier), _unit(own[..., 6:9])
        if self.upwards[k]:
            return 0.0 * u, -turn * u
        origin = _origin(own)
        return origin[..., :3, 3], turn * (origin[..., :3, :3] @ u[..., None])[..., 0]

    def _frames(self, Q: Array, numbers: Array) -> list[Array]:
        """The frames (..., 4, 4) before each joint, and the tip's."""
        frames = [np.broadcast_to(np.eye(4), (*Q.shape[:-1], 4, 4))]
        for k in range(len(self.joints)):
            frames.append(frames[-1] @ self._local(k, Q, self._own(k, numbers)))
        return frames

    def _rates(self, Q: Array, numbers: Array, frames: Sequence[Array], point: Array) -> Array:
        """(..., 6, p) velocities at a point (..., 3) fixed to the last of the frames, for each number before it."""
        out = np.zeros((*Q.shape[:-1], 6, len(numbers)))
        for k, (before, after) in enumerate(zip(frames, frames[1:], strict=False)):
            moved = self._local(k, Q, self._stepped(k, numbers, Q.ndim - 1)).imag / _STEP
            spin = before @ moved @ _inverse(after)  # (c, ..., 4, 4): the rate of the pose, times the pose's inverse
            part = slice(self.starts[k], self.starts[k] + len(spin))
            linear = spin[..., :3, 3] + (spin[..., :3, :3] @ point[..., None])[..., 0]
            out[..., part] = np.moveaxis(np.concatenate([linear, spin[..., [2, 0, 1], [1, 2, 0]]], axis=-1), 0, -1)
        return out

    def _checked(self, q: ArrayLike, values: ArrayLike | None) -> tuple[Array, Array]:
        Q = inputs.array(q, "a joint vector", (..., self.dof))
        return Q, self.values if values is None else inputs.array(values, "values", self.values.shape)


def written(chain: Chain) -> WrittenChain:
    """The chain by the numbers of its URDF, with joints that are held as they are.

    Example:
        >>> import urdf_ik
        >>> arm = urdf_ik.load("puma_560")
        >>> q = [0.3, -0.5, 0.8, 0.4, 0.7, -0.2]
        >>> bool(abs(written(arm.chain).fk(q) - arm.fk(q)).max() < 1e-12)
        True
    """
    links = chain.links
    between = {(joint.parent, joint.child): joint for joint in chain.tree}
    joints, upwards, values = [], [], []
    for one, other in zip(links, links[1:], strict=False):
        up = (one, other) not in between
        joint = between[(other, one) if up else (one, other)]
        joints.append(joint)
        upwards.append(up)
        values += [*joint.origin[:3, 3].tolist(), *joint.rpy]
        if joint.driver:
            values += [*(joint.axis_length * joint.axis).tolist(), joint.offset]
    numbers = np.array(values, dtype=np.float64)
    numbers.setflags(write=False)
    return WrittenChain(tuple(joints), tuple(upwards), chain.n, numbers, chain.axes is not chain)
