"""Reference: Pinocchio's model of a URDF, the check of this package's kinematics. It shares no code with ``chain``."""

import os
import threading
from collections.abc import Callable, Mapping
from functools import partial
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from urdf_ik.cell import missing_pinocchio
from urdf_ik.errors import ArgumentError, UnsupportedArm, UrdfError
from urdf_ik.model import urdf
from urdf_ik.model.poses import as_pose_array
from urdf_ik.support import inputs
from urdf_ik.support.text import quoted
from urdf_ik.support.tolerances import STILL
from urdf_ik.typing import Array

try:
    import pinocchio as pin
except ModuleNotFoundError:
    raise missing_pinocchio.needed("comparisons with the reference") from None

HALF_TURN = np.pi
HALF_SLIDE = 1.0
"""Joint vectors are drawn from +-these [rad, m] where a joint has no limit."""

FAR = 100.0
"""A limit beyond this [rad, m] means no limit: some URDFs write 1e9 or 1e16."""


class _Drive(NamedTuple):
    """How one joint of Pinocchio's model follows the joint vector: value = multiplier * q[column] + offset."""

    idx_q: int
    idx_v: int
    circular: bool
    column: int | None
    multiplier: float
    offset: float


class _Work(threading.local):
    """Pinocchio's scratch memory, one a thread: a ``pin.Data`` must not be shared."""

    def __init__(self, model: Any) -> None:
        self.data = model.createData()
        self.q = pin.neutral(model)


class Reference:
    """Forward kinematics, Jacobian and errors of a chain as Pinocchio computes them from the URDF itself.

    Joints outside the chain stay at zero; a joint that mimics another follows it. Each thread has its own scratch
    memory, so any number of threads may use one object.

    Attributes:
        base: base link; every pose is expressed in it.
        tip: tip link.
        joint_names: independent movable joints, base to tip; if a joint of the chain mimics one outside it, the name of
            the joint outside.
        prismatic: (n,) true for prismatic joints.
        ranges: (n, 2) rad or m, the joint limits, with a turn [-pi, pi] or [-1, 1] m in place of missing ones.
        limits: (n, 2) rad or m, infinite where there is no limit; those of mimicking joints of the chain count, unless
            they leave nothing.
        size: length that rounding errors are relative to [m]: the sum of all steps between the model's joints.
        pin_model: the ``pinocchio.Model``.
        base_frame: index of the base link's frame in ``pin_model.frames``.
        warnings: defects beside the chain, which the URDF that Pinocchio was given is without.
    """

    def __init__(
        self,
        source: urdf.UrdfModel | str | os.PathLike[str] | bytes,
        base: str | None = None,
        tip: str | None = None,
        *,
        locked: Mapping[str, float] | None = None,
    ) -> None:
        """Build Pinocchio's model.

        Args:
            source: a model that was read, a path, or XML text.
            base: base link; default: the root.
            tip: tip link, anywhere in the tree; default: the end of the only movable chain.
            locked: fixed values of joints outside the joint vector [rad or m].

        Raises:
            UrdfError: the chain uses a defective part of the URDF, or Pinocchio refuses it.
            ChainError: base or tip is unknown, or the tip is ambiguous.
            UnsupportedArm: the chain has a floating or planar joint.
        """
        model = source if isinstance(source, urdf.UrdfModel) else urdf.read(source)
        self._made_from = partial(Reference, locked=dict(locked or {})), (model, base, tip)
        self.base, self.tip = model.resolve_chain(base, tip)
        model.require_sound(self.base, self.tip)
        self.warnings = model.warnings
        self.pin_model = _build(model)
        self.base_frame, self._tip = self._frame(self.base), self._frame(self.tip)
        self._bodies = [(f.name, i) for i, f in enumerate(self.pin_model.frames) if f.type == pin.FrameType.BODY]

        followed = {joint.name: model.driver(joint) for joint in model.joints}
        path, locked_values = self._path(), dict(locked or {})
        drivers = dict.fromkeys(followed[name][0].name for name in path if abs(followed[name][1]) > STILL)
        self.joint_names = tuple(name for name in drivers if name not in locked_values)
        for name in self.joint_names:
            joint = self._joint(name)
            if joint.nv != 1:
                problem = f"joint {quoted(name)} of the chain has {joint.nv} degrees of freedom"
                raise UnsupportedArm(f"{model.source}: {problem}; only joints with one can be in a joint vector")
        column = {name: i for i, name in enumerate(self.joint_names)}
        self._drives = []
        for name in self.pin_model.names[1:]:
            joint = self._joint(name)
            driver, multiplier, offset = followed[name]
            offset += multiplier * locked_values.get(driver.name, 0.0)
            # A joint that Pinocchio treats as a mimic has no own entry in the configuration.
            if joint.nq and joint.nv == 1 and (driver.name in column or offset):
                place = column.get(driver.name)
                self._drives.append(_Drive(joint.idx_q, joint.idx_v, joint.nq == 2, place, multiplier, offset))
        # Pinocchio's velocities from the joint vector's.
        self._spread = np.zeros((self.pin_model.nv, self.dof))
        for drive in self._drives:
            if drive.column is not None:
                self._spread[drive.idx_v, drive.column] = drive.multiplier
        kinds = [self._joint(name).shortname() for name in self.joint_names]
        self.prismatic = np.array([kind.startswith("JointModelP") for kind in kinds], dtype=np.bool_)
        self.limits = self._limits()
        for row, name in zip(self.limits, self.joint_names, strict=True):
            others = [joint for joint in model.joints if joint.name in path and joint.name != name]
            followers = [joint for joint in others if followed[joint.name][0].name == name]
            _tighten(row, [(joint, *followed[joint.name][1:]) for joint in followers])
        self.ranges = self._ranges()
        self.size = self._size()
        for array in (self._spread, self.prismatic, self.limits, self.ranges):
            array.setflags(write=False)
        self._work = _Work(self.pin_model)

    def __reduce__(self) -> tuple[Any, ...]:
        return self._made_from

    @property
    def dof(self) -> int:
        """Number of joints in a joint vector."""
        return len(self.joint_names)

    def configuration(self, q: Array) -> Array:
        """Pinocchio's configuration (nq,) of one joint vector (n,): matched by name, continuous joints as (cos, sin).

        The array belongs to the calling thread and is overwritten by its next call.
        """
        full: Array = self._work.q
        for drive in self._drives:
            value = drive.offset if drive.column is None else drive.multiplier * q[drive.column] + drive.offset
            if drive.circular:
                full[drive.idx_q] = np.cos(value)
                full[drive.idx_q + 1] = np.sin(value)
            else:
                full[drive.idx_q] = value
        return full

    def configurations(self, q: ArrayLike) -> Array:
        """Pinocchio's configurations (..., nq) of joint vectors (..., n), in an array of their own.

        Raises:
            ArgumentError: the last dimension is not n.
        """
        Q = self.vectors(q)
        out = np.empty((*Q.shape[:-1], self.pin_model.nq))
        for index in np.ndindex(Q.shape[:-1]):
            out[index] = self.configuration(Q[index])
        return out

    def joint_vectors(self, q_pin: ArrayLike) -> Array:
        """Joint vectors (..., n) of Pinocchio's configurations (..., nq); continuous joints in (-pi, pi].

        Raises:
            ArgumentError: the last dimension is not nq, or a value is not finite.
        """
        full = inputs.array(q_pin, "configurations", (..., self.pin_model.nq))
        out = np.empty((*full.shape[:-1], self.dof))
        for column, name in enumerate(self.joint_names):
            joint = self._joint(name)
            value = full[..., joint.idx_q]
            out[..., column] = np.arctan2(full[..., joint.idx_q + 1], value) if joint.nq == 2 else value
        return out

    def pose(self, q: ArrayLike) -> Array:
        """Pose of the tip in the base.

        Args:
            q: (..., n) rad or m; rows that are not finite give NaN.

        Returns:
            (..., 4, 4).

        Raises:
            ArgumentError: the last dimension is not n.
        """
        return self._each(q, (4, 4), self._pose)

    def jacobian(self, q: ArrayLike) -> Array:
        """Velocity of the tip against the base: at the tip, in base axes, linear rows above angular ones.

        Args:
            q: (..., n) rad or m; rows that are not finite give NaN.

        Returns:
            (..., 6, n).

        Raises:
            ArgumentError: the last dimension is not n.
        """
        return self._each(q, (6, self.dof), self._jacobian)

    def link_poses(self, q: ArrayLike) -> dict[str, Array]:
        """Pose of every link of the URDF in the base link's frame.

        Args:
            q: (..., n) rad or m; rows that are not finite give NaN.

        Returns:
            Link name to (..., 4, 4).

        Raises:
            ArgumentError: the last dimension is not n.
        """
        poses = self._each(q, (len(self._bodies), 4, 4), self._links)
        return {name: poses[..., k, :, :] for k, (name, _) in enumerate(self._bodies)}

    def error(self, q: ArrayLike, T: ArrayLike) -> tuple[float, float]:
        """How far the tip is from a pose.

        Args:
            q: (n,) rad or m.
            T: (4, 4) pose of the tip in the base.

        Returns:
            Position error [m] and rotation error [rad]; NaN where q is not finite.

        Raises:
            ArgumentError: q is no (n,).
        """
        position, rotation = self.errors(q, T)
        if position.ndim:
            raise ArgumentError(f"one joint vector ({self.dof},) and one pose are needed; errors() takes arrays")
        return float(position), float(rotation)

    def errors(self, q: ArrayLike, T: ArrayLike) -> tuple[Array, Array]:
        """How far the tip is from poses.

        Args:
            q: (..., n) rad or m; rows that are not finite give NaN.
            T: (..., 4, 4) poses of the tip in the base; the leading dimensions broadcast against those of q.

        Returns:
            Position errors (...) [m] and rotation errors (...) [rad].

        Raises:
            ArgumentError: the last dimension of q is not n.
        """
        return pose_errors(self.pose(q), as_pose_array(T))

    def vectors(self, q: ArrayLike) -> Array:
        """``q`` as a float64 array (..., n).

        Raises:
            ArgumentError: the last dimension is not n.
        """
        Q = inputs.real(q, "a joint vector", f"an array of numbers (..., {self.dof})")
        if Q.ndim == 0 or Q.shape[-1] != self.dof:
            raise ArgumentError(
                f"joint vectors of shape {Q.shape} given; the last dimension must be {self.dof} "
                f"({', '.join(self.joint_names)})"
            )
        return Q

    def _each(self, q: ArrayLike, shape: tuple[int, ...], compute: Callable[[Array], Any]) -> Array:
        """What is computed of each of the joint vectors (..., n): (..., *shape), NaN where one is not finite."""
        Q = self.vectors(q)
        out = np.full((*Q.shape[:-1], *shape), np.nan)
        for index in np.argwhere(np.isfinite(Q).all(axis=-1)):
            out[tuple(index)] = compute(Q[tuple(index)])
        return out

    def _pose(self, q: Array) -> Any:
        data = self._work.data
        pin.forwardKinematics(self.pin_model, data, self.configuration(q))
        base, tip = (pin.updateFramePlacement(self.pin_model, data, frame) for frame in (self.base_frame, self._tip))
        return base.actInv(tip).homogeneous

    def _links(self, q: Array) -> list[Any]:
        data = self._work.data
        pin.framesForwardKinematics(self.pin_model, data, self.configuration(q))
        return [data.oMf[self.base_frame].actInv(data.oMf[frame]).homogeneous for _, frame in self._bodies]

    def _jacobian(self, q: Array) -> Array:
        model, data = self.pin_model, self._work.data
        pin.computeJointJacobians(model, data, self.configuration(q))
        pin.updateFramePlacements(model, data)
        base, tip = data.oMf[self.base_frame], data.oMf[self._tip]
        # Pinocchio gives the Jacobian of a single joint as a vector.
        J = pin.getFrameJacobian(model, data, self._tip, pin.LOCAL_WORLD_ALIGNED).reshape(6, -1) @ self._spread
        J_base = (
            pin.getFrameJacobian(model, data, self.base_frame, pin.LOCAL_WORLD_ALIGNED).reshape(6, -1) @ self._spread
        )
        # The base may move, too: it need not be the root. Subtract what the tip would do if it were fixed to it.
        J[:3] -= J_base[:3] + np.cross(J_base[3:], tip.translation - base.translation, axis=0)
        J[3:] -= J_base[3:]
        return np.concatenate([base.rotation.T @ J[:3], base.rotation.T @ J[3:]])

    def _frame(self, link: str) -> int:
        index = self.pin_model.getFrameId(link, pin.FrameType.BODY)
        if index >= self.pin_model.nframes:  # its way of saying no
            raise UrdfError(f"Pinocchio's model has no link {quoted(link)}", source="Pinocchio")
        return int(index)

    def _joint(self, name: str) -> Any:
        return self.pin_model.joints[self.pin_model.getJointId(name)]

    def _path(self) -> list[str]:
        """Movable joints from base to tip as Pinocchio's tree has them, mimicking ones included."""

        def to_root(frame: int) -> list[int]:
            joint, out = self.pin_model.frames[frame].parentJoint, []
            while joint:
                out.append(int(joint))
                joint = self.pin_model.parents[joint]
            return out

        up, down = to_root(self.base_frame), to_root(self._tip)
        while up and down and up[-1] == down[-1]:
            up.pop()
            down.pop()
        return [self.pin_model.names[joint] for joint in (*up, *reversed(down))]

    def _limits(self) -> Array:
        out = np.empty((self.dof, 2))
        for row, name in zip(out, self.joint_names, strict=True):
            joint = self._joint(name)
            row[:] = -np.inf, np.inf
            if joint.nq == 1:
                row[:] = self.pin_model.lowerPositionLimit[joint.idx_q], self.pin_model.upperPositionLimit[joint.idx_q]
        return out

    def _ranges(self) -> Array:
        out = self.limits.copy()
        for row, slides in zip(out, self.prismatic, strict=True):
            half = HALF_SLIDE if slides else HALF_TURN
            lower, upper = row
            if lower < -FAR:
                lower = -half if upper > FAR else upper - 2.0 * half
            row[:] = lower, (lower + 2.0 * half if upper > FAR else upper)
        return out

    def _size(self) -> float:
        steps = [np.linalg.norm(placement.translation) for placement in self.pin_model.jointPlacements]
        ends = [np.linalg.norm(self.pin_model.frames[i].placement.translation) for i in (self.base_frame, self._tip)]
        return float(sum(steps) + sum(ends))


def pose_errors(A: Array, B: Array) -> tuple[Array, Array]:
    """Distance (...) [m] and angle (...) [rad] between poses A (..., 4, 4) and B (..., 4, 4), which broadcast."""
    position = np.linalg.norm(A[..., :3, 3] - B[..., :3, 3], axis=-1)
    turn = np.swapaxes(A[..., :3, :3], -1, -2) @ B[..., :3, :3]
    # From sine and cosine together: the cosine alone knows no angle below 1e-8.
    across = turn[..., [2, 0, 1], [1, 2, 0]] - turn[..., [1, 2, 0], [2, 0, 1]]
    cosine = np.trace(turn, axis1=-2, axis2=-1) - 1.0
    return position, np.arctan2(np.linalg.norm(across, axis=-1), cosine)


def _build(model: urdf.UrdfModel) -> Any:
    """Pinocchio's model, in which mimicking joints follow by themselves where it can."""
    text = model.xml.decode()
    try:
        return pin.buildModelFromXML(text, mimic=True)
    except ValueError:
        pass
    try:
        return pin.buildModelFromXML(text)
    except ValueError as error:
        raise UrdfError(f"Pinocchio refuses it: {error}", source=model.source) from None


def _tighten(limits: Array, followers: list[tuple[urdf.Joint, float, float]]) -> None:
    """Narrow a driver's limits (2,) to what the limits of joints that follow it, times and plus these, leave."""
    lowest, highest = limits
    for joint, multiplier, offset in followers:
        if abs(multiplier) > STILL and joint.type != "continuous" and joint.lower < joint.upper:
            one, other = (joint.lower - offset) / multiplier, (joint.upper - offset) / multiplier
            lowest, highest = max(lowest, min(one, other)), min(highest, max(one, other))
    if lowest <= highest:
        limits[:] = lowest, highest
