"""Derivatives of forward kinematics: by the numbers of the URDF as written, of second order by the joints.

The swivel angle of an S-R-S arm has them, too.
"""

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
from urdf_ik.kinematics.structure import meeting_point
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
        return self._asked(self._rates(Q, numbers, frames, frames[-1][..., :3, 3]), parameters)

    def axis(self, column: int, q: ArrayLike, parameters: Sequence[Any] | None = None) -> tuple[Array, Array, Array]:
        """The line of a joint's axis, and how it moves with each of the URDF's numbers, the joints held still.

        Args:
            column: index of the joint, which mimics no other.
            q: (..., n) rad or m.
            parameters: those that are asked for; default: all.

        Returns:
            A point on the axis (..., 3) m and its unit direction (..., 3), in base axes; and their rates (..., 6, k),
            the point's above the direction's.
        """
        Q, numbers = self._checked(q, None)
        k = next((k for k, joint in enumerate(self.joints) if joint.column == column), None)
        if k is None:
            raise ArgumentError(f"column {column} given; there are {self.dof} joints")
        frames = self._frames(Q, numbers)[: k + 1]
        R = frames[-1][..., :3, :3]
        point, direction = (R @ each for each in self._line(k, self._own(k, numbers)))
        point = frames[-1][..., :3, 3] + point
        rates = self._rates(Q, numbers, frames, point)
        rates[..., 3:, :] = np.cross(rates[..., 3:, :], direction[..., None], axis=-2)
        own = np.concatenate(self._line(k, self._stepped(k, numbers, 0)), axis=-1).imag.T / _STEP
        part = slice(self.starts[k], self.starts[k] + own.shape[1])
        rates[..., part] = np.concatenate([R @ own[:3], R @ own[3:]], axis=-2)
        return point, direction, self._asked(rates, parameters)

    def _asked(self, rates: Array, parameters: Sequence[Any] | None) -> Array:
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


def curvature(chain: Chain, q: Array, along: Array, moving: Array) -> Array:
    """The rate of the twist ``J(q) along`` when the joints move with the velocities ``moving``: (dJ/dq moving) along.

    With joint i before joint k on the way to the tip, column k of the Jacobian is (v_k, z_k), and
    dv_k/dq_i = z_i x v_k, dv_i/dq_k = z_i x v_k, dz_k/dq_i = z_i x z_k, dz_i/dq_k = 0 (Hourtash, "The kinematic Hessian
    and higher derivatives", IEEE CIRA 2005). With ``along`` = ``moving`` it is the term that joint velocities add to
    the tip's acceleration.

    Args:
        chain: the arm.
        q: (..., n) rad or m, finite.
        along: (..., n) rad/s or m/s.
        moving: (..., n) rad/s or m/s; the leading dimensions broadcast.

    Returns:
        (..., 6) m/s^2 and rad/s^2 at the tip, in base axes.
    """
    axes = chain.axes
    if axes is not chain:
        gain: Array = chain.gain  # type: ignore[attr-defined]  # where axes differ from joints, the chain is coupled
        q, along, moving = (each @ gain.T for each in (q, along, moving))
    J = axes.jacobian(q)
    v, z = J[..., :3, :], np.where(axes.prismatic, 0.0, J[..., 3:, :])
    a, b = along[..., None, :], moving[..., None, :]
    # Sums over the joints before each one.
    before_a, before_b = (np.cumsum(z * each, axis=-1) - z * each for each in (a, b))
    linear = np.cross(before_a, v * b, axis=-2) + np.cross(before_b, v * a, axis=-2) + np.cross(z * a, v * b, axis=-2)
    angular = np.cross(before_b, z * a, axis=-2)
    return np.concatenate([linear.sum(axis=-1), angular.sum(axis=-1)], axis=-1)


SHOULDER, ELBOW, WRIST = slice(0, 3), 3, slice(4, 7)


class Points(NamedTuple):
    """What a swivel angle is measured from.

    Attributes:
        wrist: (3,) m in the tip, where axes 5, 6 and 7 meet.
        shoulder: (3,) m in the base, where axes 1, 2 and 3 meet.
        up: (3,) direction of axis 1 in the base.
    """

    wrist: Array
    shoulder: Array
    up: Array


class Seen(NamedTuple):
    """The vectors that a swivel angle is a function of, or their rates.

    Attributes:
        line: (..., 3) m from shoulder to wrist.
        axis: (..., 3) direction of axis 4.
        up: (..., 3) direction of axis 1.
    """

    line: Any
    axis: Any
    up: Any


def rate(at: Seen, by: Seen) -> Any:
    """The rate of the swivel angle (...) when its vectors have rates; of complex numbers too.

    It is the angle about the line, from the normal of the plane of line and axis 1 to axis 4; see swivel.hpp.
    """
    length = np.sqrt((at.line * at.line).sum(-1))[..., None]
    w = at.line / length
    w_rate = (by.line - w * (w * by.line).sum(-1)[..., None]) / length
    normal = np.cross(at.up, w)
    normal_rate = np.cross(by.up, w) + np.cross(at.up, w_rate)
    across = np.cross(w, normal)
    across_rate = np.cross(w_rate, normal) + np.cross(w, normal_rate)
    c, s = (at.axis * normal).sum(-1), (at.axis * across).sum(-1)
    c_rate = (by.axis * normal + at.axis * normal_rate).sum(-1)
    s_rate = (by.axis * across + at.axis * across_rate).sum(-1)
    return (c * s_rate - s * c_rate) / (c * c + s * s)


def slopes(chain: Chain, points: Points, q: Array) -> Array:
    """The derivatives (..., 7) of the swivel angle by the joints (..., 7)."""
    T, J = chain.fk(q), chain.jacobian(q)
    arm = (T[..., :3, :3] @ points.wrist[:, None])[..., 0]
    z = np.swapaxes(J[..., 3:, :], -1, -2)
    axis = z[..., ELBOW, :]
    lines = np.swapaxes(J[..., :3, :], -1, -2) + np.cross(z, arm[..., None, :])
    # Axis 4 is turned by the joints before it.
    axes = np.where(np.arange(chain.n)[:, None] < ELBOW, np.cross(z, axis[..., None, :]), 0.0)
    at = Seen((T[..., :3, 3] + arm - points.shoulder)[..., None, :], axis[..., None, :], points.up)
    return np.asarray(rate(at, Seen(lines, axes, np.zeros(3))))


def second_rate(chain: Chain, points: Points, q: Array, along: Array, moving: Array) -> Array:
    """The rate of the swivel angle's rate along joint velocities, when the joints move with others.

    Args:
        chain: the arm of seven joints.
        points: what the angle is measured from.
        q: (..., 7) rad, finite.
        along: (..., 7) rad/s.
        moving: (..., 7) rad/s.

    Returns:
        (...) rad/s^2, symmetric in the two velocities.
    """
    T, J, bent = chain.fk(q), chain.jacobian(q), curvature(chain, q, along, moving)
    arm = (T[..., :3, :3] @ points.wrist[:, None])[..., 0]
    z = J[..., 3:, :]
    twists = [(J @ each[..., None])[..., 0] for each in (along, moving)]
    lines = [each[..., :3] + np.cross(each[..., 3:], arm) for each in twists]
    bent_line = (
        bent[..., :3] + np.cross(bent[..., 3:], arm) + np.cross(twists[0][..., 3:], np.cross(twists[1][..., 3:], arm))
    )
    turns = [(z[..., :ELBOW] @ each[..., :ELBOW, None])[..., 0] for each in (along, moving)]
    axis, still = z[..., ELBOW], np.zeros((*q.shape[:-1], 3))
    axes = [np.cross(each, axis) for each in turns]
    passed = np.cumsum(z[..., :ELBOW] * moving[..., None, :ELBOW], axis=-1) - z[..., :ELBOW] * moving[..., None, :ELBOW]
    bent_turn = np.cross(passed, z[..., :ELBOW] * along[..., None, :ELBOW], axis=-2).sum(axis=-1)
    bent_axis = np.cross(bent_turn, axis) + np.cross(turns[0], axes[1])
    at = Seen(T[..., :3, 3] + arm - points.shoulder, axis, np.broadcast_to(points.up, still.shape))
    moved = Seen(at.line + 1j * _STEP * lines[1], at.axis + 1j * _STEP * axes[1], at.up)
    by = Seen(lines[0] + 1j * _STEP * bent_line, axes[0] + 1j * _STEP * bent_axis, still)
    return np.asarray(rate(moved, by).imag / _STEP)


def rates_by_geometry(chain: Chain, points: Points, q: Array, parameters: Sequence[Any] | None = None) -> Array:
    """Rates (..., k) of the swivel angle by numbers of the URDF, the joints held still.

    Shoulder and wrist are the points with the least squared distances from their three axes where all joints are zero,
    as the solver takes them: they follow every change of the numbers, also one after which the axes meet no more.
    """
    geometry, zero = written(chain), np.zeros(chain.n)
    T0, twists0 = chain.fk(zero), geometry.twists(zero, parameters=parameters)
    shoulder_rate = _meeting_rates(*(geometry.axis(k, zero, parameters) for k in range(chain.n)[SHOULDER]))
    wrist_rate = _meeting_rates(*(geometry.axis(k, zero, parameters) for k in range(chain.n)[WRIST]))
    up_rate = geometry.axis(0, zero, parameters)[2][3:]
    arm0 = (T0[:3, :3] @ points.wrist)[:, None]
    own = wrist_rate - twists0[:3] - np.cross(twists0[3:], arm0, axis=0)  # of the wrist against the tip, in the base

    T, twists = chain.fk(q), geometry.twists(q, parameters=parameters)
    R = T[..., :3, :3]
    arm = R @ points.wrist[:, None]
    _, axis, axis_rates = geometry.axis(ELBOW, q, parameters)
    line_rates = (
        twists[..., :3, :] + np.cross(twists[..., 3:, :], arm, axis=-2) + R @ (T0[:3, :3].T @ own) - shoulder_rate
    )
    line = T[..., :3, 3] + arm[..., 0] - points.shoulder
    at = Seen(line[..., None, :], axis[..., None, :], points.up)
    by = Seen(*(np.swapaxes(each, -1, -2) for each in (line_rates, axis_rates[..., 3:, :], up_rate)))
    return np.asarray(rate(at, by))


def _meeting_rates(*axes: tuple[Array, Array, Array]) -> Array:
    """Rates (3, k) of the point with the least sum of squared distances from lines, by a complex step."""
    lines, rates = (np.stack(each) for each in zip(*((np.stack(axis[:2]), axis[2]) for axis in axes), strict=True))
    stepped = lines[..., None] + 1j * _STEP * rates.reshape(len(axes), 2, 3, -1)
    return np.stack([meeting_point(*np.swapaxes(each, 0, 1)).imag / _STEP for each in np.moveaxis(stepped, -1, 0)], 1)
