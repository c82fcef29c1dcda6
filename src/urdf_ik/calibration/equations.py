"""The equations of a calibration: residuals of measurements and their derivatives by the fitted numbers.

The chain of the URDF is lengthened at both ends: by the pose of the base in the frame that was measured in, and by the
pose of the measured marker in the tip. Each is a fixed joint with a first estimate, and one with what is fitted.
"""

from dataclasses import dataclass

import numpy as np

from urdf_ik.calibration.measurements import Measurements
from urdf_ik.kinematics.chain import Chain
from urdf_ik.kinematics.chain.serial import TreeJoint
from urdf_ik.kinematics.derivatives import Parameter, WrittenChain, written
from urdf_ik.model.poses import nearest_rotation, to_rotvec, to_rpy
from urdf_ik.typing import Array

BASE, MARKER = "the base", "the marker"
"""Names of the fitted parameters that are not in the URDF."""


@dataclass(frozen=True, eq=False)
class Equations:
    """Residuals of measurements as functions of fitted numbers.

    Attributes:
        chain: the chain with the base's place before it and the marker's behind it.
        columns: places of the fitted numbers in ``chain.values``.
        kind: what was measured.
        start: first estimates of the fitted numbers.
    """

    chain: WrittenChain
    columns: tuple[int, ...]
    kind: str
    start: Array

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        """The fitted numbers, in order."""
        return tuple(self.chain.parameters[k] for k in self.columns)

    def residuals(self, x: Array, given: Measurements) -> Array:
        """(m, r) m, and rad for rotations: model less measurement."""
        T = self.chain.fk(given.q, self.values(x))
        if self.kind == "position":
            return np.asarray(T[:, :3, 3] - given.values)
        turn = T[:, :3, :3] @ np.swapaxes(given.values[:, :3, :3], 1, 2)
        return np.hstack([T[:, :3, 3] - given.values[:, :3, 3], to_rotvec(_posed(turn))])

    def derivatives(self, x: Array, given: Measurements) -> Array:
        """(m, r, k) of the residuals by the fitted numbers."""
        parameters = [self.chain.parameters[k] for k in self.columns]
        twists = self.chain.twists(given.q, self.values(x), parameters)
        if self.kind == "position":
            return twists[:, :3]
        phi = self.residuals(x, given)[:, 3:]
        return np.concatenate([twists[:, :3], _left_inverse(phi) @ twists[:, 3:]], axis=1)

    def moved(self, x: Array) -> dict[Parameter, float]:
        """The fitted numbers by name."""
        return dict(zip(self.parameters, x.tolist(), strict=True))

    def place(self, name: str, x: Array) -> Array:
        """Pose (4, 4) of the base in the measuring frame, or of the marker in the tip."""
        joints = [k for k, joint in enumerate(self.chain.joints) if joint.name in (name, _first(name))]
        part = WrittenChain(
            tuple(self.chain.joints[k] for k in joints), tuple(self.chain.upwards[k] for k in joints), 0,
            np.concatenate([self.values(x)[s : s + 6] for s in (self.chain.starts[k] for k in joints)]),
        )  # fmt: skip
        return part.fk(np.zeros(0))

    def values(self, x: Array) -> Array:
        """The chain's numbers with the fitted ones in their places."""
        values = self.chain.values.copy()
        values[list(self.columns)] = x
        return values


def equations(chain: Chain, given: Measurements, chosen: list[Parameter], *, base: bool, marker: bool) -> Equations:
    """The equations of measurements, with first estimates of what is fitted beside the URDF.

    Args:
        chain: the arm's.
        given: what was measured.
        chosen: numbers of the URDF that are fitted.
        base: whether the base's pose in the measuring frame is fitted too.
        marker: whether the marker's pose in the tip is.
    """
    own = written(chain)
    Z, X = _places(chain.fk(given.q), given, base=base, marker=marker)
    joints = (_fixed(_first(BASE), Z), _fixed(BASE, np.eye(4)), *own.joints)
    joints += (_fixed(_first(MARKER), X), _fixed(MARKER, np.eye(4)))
    ends = [np.concatenate([T[:3, 3], to_rpy(T)]) for T in (Z, X)]
    still = np.zeros(6)
    whole = WrittenChain(
        joints, (False, False, *own.upwards, False, False), own.dof,
        np.concatenate([ends[0], still, own.values, ends[1], still]),
    )  # fmt: skip
    fields = ("xyz", "rpy") if given.kind == "pose" else ("xyz",)
    beside = [Parameter(BASE, field, part) for field in ("xyz", "rpy") for part in range(3) if base]
    beside += [Parameter(MARKER, field, part) for field in fields for part in range(3) if marker]
    columns = tuple(whole.columns([*beside, *chosen]))
    return Equations(whole, columns, given.kind, whole.values[list(columns)])


def _places(T: Array, given: Measurements, *, base: bool, marker: bool) -> tuple[Array, Array]:
    """First estimates of the base in the measuring frame Z and of the marker in the tip X: measured = Z T X."""
    Z, X = np.eye(4), np.eye(4)
    R, p = T[:, :3, :3], T[:, :3, 3]
    if given.kind == "pose":
        S, s = given.values[:, :3, :3], given.values[:, :3, 3]
        if base and marker:
            # S Y = Z R with Y = X^T is linear in both rotations (Shah, "Solving the robot-world/hand-eye calibration
            # problem using the Kronecker product", ASME Journal of Mechanisms and Robotics 5(3), 2013).
            eye = np.eye(3)
            left = np.einsum("mij,kl->mikjl", S, eye).reshape(-1, 9)
            right = np.einsum("mjk,ia->mikaj", R, eye).reshape(-1, 9)
            v = np.linalg.svd(np.hstack([left, -right]), full_matrices=False)[2][-1]
            Y, Q = v[:9].reshape(3, 3), v[9:].reshape(3, 3)
            sign = np.sign(np.linalg.det(Q)) or 1.0
            X[:3, :3], Z[:3, :3] = nearest_rotation(sign * Y).T, nearest_rotation(sign * Q)
        elif base:
            Z[:3, :3] = nearest_rotation((S @ np.swapaxes(R, 1, 2)).sum(axis=0))
        elif marker:
            X[:3, :3] = nearest_rotation((np.swapaxes(R, 1, 2) @ S).sum(axis=0))
    else:
        s = given.values
        for _ in range(20 if base and marker else 1):
            if base:
                at = p + R @ X[:3, 3]
                Z[:3, :3] = nearest_rotation((s - s.mean(axis=0)).T @ (at - at.mean(axis=0)))
                Z[:3, 3] = s.mean(axis=0) - Z[:3, :3] @ at.mean(axis=0)
            if marker:
                X[:3, 3] = (np.swapaxes(R, 1, 2) @ ((s - Z[:3, 3]) @ Z[:3, :3] - p)[..., None]).mean(axis=0)[:, 0]
        return Z, X
    # s = R_Z (R x + p) + z: linear in the marker's shift x and the base's z.
    blocks = [np.broadcast_to(np.eye(3), R.shape)] * base + [Z[:3, :3] @ R] * marker
    if blocks:
        A = np.concatenate(blocks, axis=2).reshape(-1, 3 * len(blocks))
        shifts = np.linalg.lstsq(A, (s - p @ Z[:3, :3].T).ravel(), rcond=None)[0].reshape(-1, 3)
        if base:
            Z[:3, 3] = shifts[0]
        if marker:
            X[:3, 3] = shifts[-1]
    return Z, X


def _fixed(name: str, T: Array) -> TreeJoint:
    return TreeJoint("", "", T, np.array([1.0, 0.0, 0.0]), False, None, 1.0, 0.0, "", name)


def _first(name: str) -> str:
    return f"{name}, first estimate"


def _posed(R: Array) -> Array:
    T = np.zeros((*R.shape[:-2], 4, 4))
    T[..., :3, :3], T[..., 3, 3] = R, 1.0
    return T


def _left_inverse(phi: Array) -> Array:
    """(m, 3, 3) inverse left Jacobian of rotation vectors: a small rotation on the left of R to the change of log(R).

    1 - [phi] / 2 + (1 / a^2 - (1 + cos a) / (2 a sin a)) [phi]^2 with a = |phi| (Barfoot, State Estimation for
    Robotics, equation 7.77).
    """
    a = np.linalg.norm(phi, axis=1)
    small = a < 1e-4
    b = np.where(small, 1.0, a)
    factor = np.where(small, 1.0 / 12.0, 1.0 / b**2 - (1.0 + np.cos(b)) / (2.0 * b * np.sin(b)))
    cross = np.cross(np.eye(3), phi[:, None, :])
    return np.asarray(np.eye(3) - 0.5 * cross + factor[:, None, None] * (cross @ cross))
