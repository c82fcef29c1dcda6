"""A chain by the numbers of its URDF: forward kinematics for changed numbers, and the tip's twist for each number."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from urdf_ik.errors import ArgumentError
from urdf_ik.kinematics.chain.free_axis import turning
from urdf_ik.model.poses import pose
from urdf_ik.support import inputs
from urdf_ik.support.read_only import Frozen
from urdf_ik.support.text import quoted

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

    from urdf_ik.kinematics.chain import Chain
    from urdf_ik.kinematics.chain.serial import TreeJoint

    Array = NDArray[np.float64]

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


@dataclass(frozen=True, eq=False)
class WrittenChain(Frozen):
    """The joints from base to tip with their origins and axes as the URDF has them; :func:`written` makes it.

    Attributes:
        joints: the joints, fixed ones too, in the order from base to tip.
        upwards: which of them lead from child to parent, since the base need not be the root.
        dof: length n of the joint vector.
        values: (p,) the numbers of the URDF, in the order of ``parameters``.

    Example:
        >>> import urdf_ik
        >>> geometry = written(urdf_ik.load("planar_2r").chain)
        >>> len(geometry.parameters), str(geometry.parameters[10])
        (26, 'joint_2 xyz x')
    """

    joints: tuple[TreeJoint, ...]
    upwards: tuple[bool, ...]
    dof: int
    values: Array

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

        Example:
            >>> import urdf_ik
            >>> written(urdf_ik.load("planar_2r").chain).columns([("joint_2", "xyz", 0)])
            [10]
        """
        place = {parameter: k for k, parameter in enumerate(self.parameters)}
        found = []
        for each in inputs.items(parameters, "parameters", "tuples (joint, field, part)"):
            key: Any = tuple(each) if isinstance(each, tuple | list) else each
            if not isinstance(key, tuple) or key not in place:
                names = list(dict.fromkeys(joint.name for joint in self.joints))
                own = [tuple(p) for p in self.parameters if isinstance(key, tuple) and key and p.joint == key[0]]
                valid = f"those of this joint: {own}" if own else f"the joints of the chain: {', '.join(names)}"
                raise ArgumentError(f"there is no parameter {quoted(each)}, (joint, field, part); {valid}")
            found.append(place[key])
        return found

    def fk(self, q: ArrayLike, values: ArrayLike | None = None) -> Array:
        """Poses (..., 4, 4) of the tip at joint vectors (..., n), with the numbers ``values`` (p,) of the URDF.

        Example:
            >>> import urdf_ik
            >>> arm = urdf_ik.load("planar_2r")
            >>> geometry = written(arm.chain)
            >>> longer = geometry.values.copy()
            >>> longer[geometry.columns([("joint_2", "xyz", 0)])] += 0.1
            >>> float((geometry.fk([0.0, 0.0], longer) - arm.fk([0.0, 0.0]))[0, 3].round(6))
            0.1
        """
        Q, numbers = self._checked(q, values)
        tip = np.broadcast_to(np.eye(4), (*Q.shape[:-1], 4, 4))
        for moved in self._walk(Q, numbers):
            tip = moved.at if moved.sign > 0.0 else moved.parent
        return np.array(tip)

    def screws(self, values: ArrayLike) -> tuple[Array, Array, Array]:
        """Directions H (n, 3), steps P (n + 1, 3) and rotation R_tip (3, 3) of the chain with other numbers.

        They are what :class:`urdf_ik.Chain` holds, for a chain whose joints each drive one axis.

        Example:
            >>> import urdf_ik
            >>> chain = urdf_ik.load("planar_2r").chain
            >>> geometry = written(chain)
            >>> bool(abs(geometry.screws(geometry.values)[1] - chain.P).max() < 1e-15)
            True
        """
        _, numbers = self._checked(np.zeros(self.dof), values)
        H, points, tip = np.zeros((self.dof, 3)), np.zeros((self.dof + 1, 3)), np.eye(4)
        for moved in self._walk(np.zeros(self.dof), numbers):
            joint, start = self.joints[moved.joint], self.starts[moved.joint]
            if joint.column is not None:
                u = numbers[start + 6 : start + 9]
                direction = moved.sign * joint.multiplier * (moved.before[:3, :3] @ u)
                H[joint.column] = direction / np.linalg.norm(direction)
                points[joint.column] = moved.before[:3, 3]
            tip = moved.at if moved.sign > 0.0 else moved.parent
        points[-1] = tip[:3, 3]
        return H, np.diff(points, axis=0, prepend=np.zeros((1, 3))), np.ascontiguousarray(tip[:3, :3])

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

        Example:
            >>> import urdf_ik
            >>> geometry = written(urdf_ik.load("planar_2r").chain)
            >>> (geometry.twists([0.0, 0.0], parameters=[("joint_2", "offset", 0)])[:, 0].round(6) + 0.0).tolist()
            [0.0, 0.13, 0.0, 0.0, 0.0, 1.0]
        """
        Q, numbers = self._checked(q, values)
        batch = Q.shape[:-1]
        asked = list(range(len(self.parameters))) if parameters is None else self.columns(parameters)
        wanted = set(asked)
        columns: dict[int, tuple[Array, Array, Array]] = {}  # point, velocity of the point, angular velocity
        still, tip = np.zeros((*batch, 3)), np.broadcast_to(np.eye(4), (*batch, 4, 4))
        for moved in self._walk(Q, numbers):
            tip = moved.at if moved.sign > 0.0 else moved.parent
            start = self.starts[moved.joint]
            for k in range(start, start + (10 if self.joints[moved.joint].driver else 6)):
                if k in wanted:
                    linear, angular = self._motion(moved, k - start, numbers[start:])
                    columns[k] = (
                        moved.before[..., :3, 3],
                        still if linear is None else moved.sign * linear,
                        still if angular is None else moved.sign * angular,
                    )
        out = np.zeros((*batch, 6, len(asked)))
        for place, k in enumerate(asked):
            point, linear, angular = columns[k]
            out[..., :3, place] = linear + np.cross(angular, tip[..., :3, 3] - point)
            out[..., 3:, place] = angular
        return out

    def _motion(self, moved: _Moved, k: int, numbers: Array) -> tuple[Array | None, Array | None]:
        """What number ``k`` of a joint does: the velocity of the joint's frame, and the angular one, in base axes."""
        if k < 3:
            return moved.parent[..., :3, k], None
        if k < 6:
            # R = Rz(yaw) Ry(pitch) Rx(roll): an angle turns about its axis as the angles to its left have turned it.
            first = np.where(np.arange(3) > k - 3, numbers[3:6], 0.0)
            return None, moved.parent[..., :3, :3] @ pose(np.zeros(3), rpy=first)[:3, k - 3]
        R, length = moved.before[..., :3, :3], float(np.linalg.norm(numbers[6:9]))
        u, slides = numbers[6:9] / length, self.joints[moved.joint].prismatic
        if k == 9:
            axis = R @ u
            return (axis, None) if slides else (None, axis)
        du = (np.eye(3)[k - 6] - u[k - 6] * u) / length
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
    inputs.kind(chain, "tree", "chain", "a chain, as arm.chain is,")
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
    return WrittenChain(tuple(joints), tuple(upwards), chain.n, numbers)
