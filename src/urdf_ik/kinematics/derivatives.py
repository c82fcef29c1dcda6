"""Derivatives of forward kinematics: by the numbers of the URDF as written, of second order by the joints.

The swivel angle of an S-R-S arm has them, too.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from urdf_ik.errors import ArgumentError
from urdf_ik.kinematics.chain import Chain
from urdf_ik.kinematics.chain.free_axis import turning
from urdf_ik.kinematics.chain.mimic import follows
from urdf_ik.kinematics.chain.serial import TreeJoint
from urdf_ik.model.poses import pose
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


class _Moved(NamedTuple):
    """A joint at joint vectors: its number in the chain, its frames, and the sign of what its numbers do to the tip."""

    joint: int
    parent: Array
    at: Array
    before: Array
    value: Array
    sign: float


class _Motions:
    """Motions of what follows a joint, by the number of the URDF that causes them."""

    def __init__(self, batch: tuple[int, ...]) -> None:
        self._still = np.zeros((*batch, 3))
        self._of: dict[int, tuple[Array, Array, Array]] = {}  # a point, its velocity, the angular velocity

    def add(self, number: int, moved: _Moved, linear: Array | None, angular: Array | None) -> None:
        v, w = (self._still if each is None else moved.sign * each for each in (linear, angular))
        self._of[number] = (moved.before[..., :3, 3], v, w)

    def twists(self, numbers: Sequence[int], point: Array) -> Array:
        """(..., 6, k) velocities at a point (..., 3), zero for numbers of joints that have not been added."""
        out = np.zeros((*self._still.shape[:-1], 6, len(numbers)))
        for place, number in enumerate(numbers):
            if number in self._of:
                start, v, w = self._of[number]
                out[..., :3, place] = v + np.cross(w, point - start)
                out[..., 3:, place] = w
        return out


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
        Q, numbers = self._checked(q, values)
        tip = np.broadcast_to(np.eye(4), (*Q.shape[:-1], 4, 4))
        for moved in self._walk(Q, numbers):
            tip = moved.at if moved.sign > 0.0 else moved.parent
        return np.array(tip)

    def screws(self, values: ArrayLike) -> tuple[Array, Array, Array]:
        """Directions H (m, 3), steps P (m + 1, 3) and rotation R_tip (3, 3) of the chain's m axes with other numbers.

        They are what :class:`urdf_ik.Chain` holds; where joints mimic others, it has more axes than joints.
        """
        _, numbers = self._checked(np.zeros(self.dof), values)
        axes, points, tip = [], [], np.eye(4)
        for moved in self._walk(np.zeros(self.dof), numbers):
            joint = self.joints[moved.joint]
            if joint.column is not None and follows(joint.multiplier):
                axes.append(self._direction(moved, numbers))
                points.append(moved.before[:3, 3])
            tip = moved.at if moved.sign > 0.0 else moved.parent
        steps = np.diff(np.array([np.zeros(3), *points, tip[:3, 3]]), axis=0)
        return np.array(axes), steps, np.ascontiguousarray(tip[:3, :3])

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
        asked, motions = self._asked(parameters), _Motions(Q.shape[:-1])
        tip = np.broadcast_to(np.eye(4), (*Q.shape[:-1], 4, 4))
        for moved in self._walk(Q, numbers):
            tip = moved.at if moved.sign > 0.0 else moved.parent
            self._collect(moved, numbers, asked, motions)
        return motions.twists(asked, tip[..., :3, 3])

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
        asked, motions = self._asked(parameters), _Motions(Q.shape[:-1])
        for moved in self._walk(Q, numbers):
            joint, start = self.joints[moved.joint], self.starts[moved.joint]
            own = joint.column == column
            # The axis is fixed to the parent, which stands on the base's side, or behind the joint.
            if not own or moved.sign > 0.0:
                self._collect(moved, numbers, [k for k in asked if not own or k < start + 6], motions)
            if not own:
                continue
            point, direction = moved.before[..., :3, 3], self._direction(moved, numbers)
            rates = motions.twists(asked, point)
            rates[..., 3:, :] = np.cross(rates[..., 3:, :], direction[..., None], axis=-2)
            R = moved.before if moved.sign > 0.0 else moved.at
            for place, k in enumerate(asked):
                if start + 6 <= k < start + 9:
                    du = self._turned_axis(k - start - 6, numbers[start + 6 : start + 9])
                    rates[..., 3:, place] = moved.sign * np.sign(joint.multiplier) * (R[..., :3, :3] @ du)
            return point, direction, rates
        raise ArgumentError(f"column {column} given; there are {self.dof} joints")

    def _asked(self, parameters: Sequence[Any] | None) -> list[int]:
        return list(range(len(self.parameters))) if parameters is None else self.columns(parameters)

    def _direction(self, moved: _Moved, numbers: Array) -> Array:
        """The unit direction (..., 3) of a joint's axis in the base, as the chain counts its joint's value."""
        joint, start = self.joints[moved.joint], self.starts[moved.joint]
        u = numbers[start + 6 : start + 9]
        # The value of a joint that mimics another is counted along its own axis.
        turn = moved.sign * (1.0 if self.coupled else np.sign(joint.multiplier))
        direction: Array = turn * (moved.before[..., :3, :3] @ (u / np.linalg.norm(u)))
        return direction

    def _collect(self, moved: _Moved, numbers: Array, asked: Sequence[int], motions: _Motions) -> None:
        """Add the motions that a joint's numbers give to all that follows it."""
        start = self.starts[moved.joint]
        for k in asked:
            if start <= k < start + (10 if self.joints[moved.joint].driver else 6):
                motions.add(k, moved, *self._motion(moved, k - start, numbers[start:]))

    @staticmethod
    def _turned_axis(k: int, axis: Array) -> Array:
        """How the unit direction changes with number ``k`` of an axis as written."""
        length = float(np.linalg.norm(axis))
        u = axis / length
        du: Array = (np.eye(3)[k] - u[k] * u) / length
        return du

    def _motion(self, moved: _Moved, k: int, numbers: Array) -> tuple[Array | None, Array | None]:
        """What number ``k`` of a joint does: the velocity of the joint's frame, and the angular one, in base axes."""
        if k < 3:
            return moved.parent[..., :3, k], None
        if k < 6:
            # R = Rz(yaw) Ry(pitch) Rx(roll): an angle turns about its axis as the angles to its left have turned it.
            first = np.where(np.arange(3) > k - 3, numbers[3:6], 0.0)
            return None, moved.parent[..., :3, :3] @ pose(np.zeros(3), rpy=first)[:3, k - 3]
        R, u = moved.before[..., :3, :3], numbers[6:9] / np.linalg.norm(numbers[6:9])
        slides = self.joints[moved.joint].prismatic
        if k == 9:
            axis = R @ u
            return (axis, None) if slides else (None, axis)
        du = self._turned_axis(k - 6, numbers[6:9])
        value = moved.value[..., None]
        if slides:
            return value * (R @ du), None
        # The rotation about a turned axis: n - R n for an axis that turns by n = u x du.
        return None, np.sin(value) * (R @ du) + (1.0 - np.cos(value)) * (R @ np.cross(u, du))

    def _walk(self, Q: Array, numbers: Array) -> Iterator[_Moved]:
        """Every joint in turn, with the frames of its parent, of its origin and of its child."""
        at = np.broadcast_to(np.eye(4), (*Q.shape[:-1], 4, 4))
        for k, (joint, up, start) in enumerate(zip(self.joints, self.upwards, self.starts, strict=True)):
            origin, value = pose(numbers[start : start + 3], rpy=numbers[start + 3 : start + 6]), np.zeros(Q.shape[:-1])
            motion = np.eye(4)
            if joint.driver:
                u = numbers[start + 6 : start + 9] / np.linalg.norm(numbers[start + 6 : start + 9])
                value = value + numbers[start + 9]
                if joint.column is not None:
                    value = value + joint.multiplier * Q[..., joint.column]
                motion = np.broadcast_to(motion, (*value.shape, 4, 4)).copy()
                if joint.prismatic:
                    motion[..., :3, 3] = value[..., None] * u
                else:
                    constant, cosine, sine = turning(u, np.zeros(3))
                    motion[..., :3, :] = (
                        constant + np.cos(value)[..., None, None] * cosine + np.sin(value)[..., None, None] * sine
                    )
            if up:
                parent = at @ np.linalg.inv(origin @ motion)
                yield _Moved(k, parent, at, parent @ origin, value, -1.0)
                at = parent
            else:
                parent, before = at, at @ origin
                at = before @ motion
                yield _Moved(k, parent, at, before, value, 1.0)

    def _checked(self, q: ArrayLike, values: ArrayLike | None) -> tuple[Array, Array]:
        Q = inputs.real(q, "a joint vector", f"an array of numbers (..., {self.dof})")
        if Q.ndim == 0 or Q.shape[-1] != self.dof:
            raise ArgumentError(f"joint vectors of shape {Q.shape} given; the last dimension must be {self.dof}")
        if values is None:
            return Q, self.values
        numbers = inputs.real(values, "values", f"the {len(self.values)} numbers of the URDF")
        if numbers.shape != self.values.shape or not np.isfinite(numbers).all():
            raise ArgumentError(f"values of shape {numbers.shape} given; {len(self.values)} finite numbers are needed")
        return Q, numbers


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
_STEP = 1e-30  # of a complex step, whose error is its square


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
    """Rates (3, k) of the point with the least sum of squared distances from lines.

    The point x solves sum P (x - p) = 0 with P = 1 - h h^T; its rate follows from that equation's.
    """
    points, directions = (np.array([each[k] for each in axes]) for k in (0, 1))
    across = np.eye(3) - directions[:, :, None] * directions[:, None, :]
    total = across.sum(axis=0)
    off = np.linalg.solve(total, np.einsum("aij,aj->i", across, points - points[0])) - (points - points[0])
    right = np.zeros_like(axes[0][2][:3])
    for (_, h, rates), P, x in zip(axes, across, off, strict=True):
        turned = rates[3:]
        right += P @ rates[:3] + np.outer(h, x @ turned) + (h @ x) * turned
    return np.asarray(np.linalg.solve(total, right))
