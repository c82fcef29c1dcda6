"""The arms that the benchmarks solve, as URDF text from published link lengths."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np
import pinocchio as pin

Vector = tuple[float, float, float]
ZERO: Vector = (0.0, 0.0, 0.0)
X: Vector = (1.0, 0.0, 0.0)
Y: Vector = (0.0, 1.0, 0.0)
Z: Vector = (0.0, 0.0, 1.0)


@dataclass(frozen=True)
class Robot:
    """A benchmarked arm.

    Attributes:
        name: what the table calls it.
        urdf: the URDF text; base link ``base``, tip link ``tool``.
        structure: ``"wrist"`` (spherical wrist, 2 || 3), ``"three parallel"`` (2 || 3 || 4, 5 x 6) or ``"general"``.
    """

    name: str
    urdf: str
    structure: str

    @cached_property
    def reference(self) -> "ReferenceModel":
        """Pinocchio's model of the same text."""
        return ReferenceModel(self.urdf)


class ReferenceModel:
    """Pinocchio's view of a benchmarked arm: poses, errors, axes. It shares no code with any solver."""

    def __init__(self, urdf: str, base: str = "base", tip: str = "tool") -> None:
        """Build it from URDF text; the joints are those that move the tip, each with one degree of freedom."""
        self.model = pin.buildModelFromXML(urdf)
        self.data = self.model.createData()
        self.base = self.model.getFrameId(base, pin.FrameType.BODY)
        self.tip = self.model.getFrameId(tip, pin.FrameType.BODY)
        if self.model.frames[self.base].parentJoint != 0:
            raise ValueError(f"link {base!r} moves: benchmarks take arms whose base stands still")
        supports = self.model.supports[self.model.frames[self.tip].parentJoint]
        self._joints = [self.model.joints[i] for i in supports if i > 0]
        self._to_base = np.linalg.inv(self.model.frames[self.base].placement.homogeneous)

    def poses(self, Q: np.ndarray) -> np.ndarray:
        """The tip's poses (m, 4, 4) in the base at joint vectors Q (m, 6) [rad], base to tip; all by Pinocchio."""
        out = np.empty((len(Q), 4, 4))
        model, data, tip = self.model, self.data, self.tip
        place = data.oMf[tip]
        for i, q in enumerate(self._configurations(Q)):
            pin.forwardKinematics(model, data, q)
            pin.updateFramePlacement(model, data, tip)
            out[i] = place.homogeneous
        return self._to_base @ out

    def sigma_min(self, q: np.ndarray) -> float:
        """Smallest singular value of the Jacobian at q (6,)."""
        J = pin.computeFrameJacobian(self.model, self.data, self._configurations(q[None])[0], self.tip, pin.LOCAL)
        columns = [joint.idx_v for joint in self._joints]
        return float(np.linalg.svd(J[:, columns], compute_uv=False)[-1])

    def _configurations(self, Q: np.ndarray) -> np.ndarray:
        """Pinocchio's configurations (m, nq); a continuous joint's is a cosine and a sine, others stay at zero."""
        full = np.tile(pin.neutral(self.model), (len(Q), 1))
        for joint, column in zip(self._joints, Q.T, strict=True):
            if joint.nq == 2:
                full[:, joint.idx_q], full[:, joint.idx_q + 1] = np.cos(column), np.sin(column)
            else:
                full[:, joint.idx_q] = column
        return full

    def pose(self, q: np.ndarray) -> np.ndarray:
        """The tool's pose (4, 4) in the base at the joint vector q (6,) [rad]."""
        pin.framesForwardKinematics(self.model, self.data, q)
        return self.data.oMf[self.base].actInv(self.data.oMf[self.tip]).homogeneous

    def jacobian(self, q: np.ndarray) -> np.ndarray:
        """The Jacobian (6, 6) at q, in the tool's frame."""
        pin.computeJointJacobians(self.model, self.data, q)
        pin.updateFramePlacements(self.model, self.data)
        return pin.getFrameJacobian(self.model, self.data, self.tip, pin.LOCAL)

    def error(self, q: np.ndarray, target: np.ndarray) -> float:
        """The larger of position [m] and angle [rad] between the pose at q and the target (4, 4)."""
        pose = self.pose(q)
        turn = pose[:3, :3].T @ target[:3, :3]
        sine = 0.5 * math.hypot(turn[2, 1] - turn[1, 2], turn[0, 2] - turn[2, 0], turn[1, 0] - turn[0, 1])
        return max(math.dist(pose[:3, 3], target[:3, 3]), math.atan2(sine, 0.5 * (np.trace(turn) - 1.0)))


def serial(name: str, origins: Sequence[tuple[Vector, Vector]], axes: Sequence[Vector]) -> str:
    """URDF text of revolute joints and a fixed tool; ``origins`` holds one (xyz [m], rpy [rad]) more than ``axes``."""
    links = ["base", *(f"link_{i}" for i in range(1, len(origins))), "tool"]
    lines = [f'<robot name="{name}">', *(f'  <link name="{link}"/>' for link in links)]
    for i, (xyz, rpy) in enumerate(origins):
        kind = "revolute" if i < len(axes) else "fixed"
        lines += [
            f'  <joint name="joint_{i + 1}" type="{kind}">',
            f'    <origin xyz="{" ".join(map(repr, xyz))}" rpy="{" ".join(map(repr, rpy))}"/>',
            f'    <parent link="{links[i]}"/>',
            f'    <child link="{links[i + 1]}"/>',
        ]
        if i < len(axes):
            lines += [
                f'    <axis xyz="{" ".join(map(repr, axes[i]))}"/>',
                '    <limit lower="-3.1415926535897931" upper="3.1415926535897931" effort="100" velocity="3"/>',
            ]
        lines.append("  </joint>")
    return "\n".join([*lines, "</robot>", ""])


# The numbers of Universal Robots' description, its rounded right angles (1.57079632679) included.
_RIGHT = 1.57079632679
UR5 = Robot(
    "UR5",
    serial(
        "ur5",
        [
            ((0.0, 0.0, 0.089159), ZERO),
            ((0.0, 0.13585, 0.0), (0.0, _RIGHT, 0.0)),
            ((0.0, -0.1197, 0.425), ZERO),
            ((0.0, 0.0, 0.39225), (0.0, _RIGHT, 0.0)),
            ((0.0, 0.093, 0.0), ZERO),
            ((0.0, 0.0, 0.09465), ZERO),
            ((0.0, 0.0823, 0.0), (0.0, 0.0, _RIGHT)),
        ],
        [Z, Y, Y, Y, Z, Y],
    ),
    "three parallel",
)

# ABB IRB 2400: shoulder 0.1 m in front of the turning axis, elbow offset 0.135 m, forearm along x at q = 0. The tool is
# turned so that its z axis leaves the flange.
IRB2400 = Robot(
    "IRB 2400",
    serial(
        "irb2400",
        [
            (ZERO, ZERO),
            ((0.1, 0.0, 0.615), ZERO),
            ((0.0, 0.0, 0.705), ZERO),
            ((0.258, 0.0, 0.135), ZERO),
            ((0.497, 0.0, 0.0), ZERO),
            ((0.085, 0.0, 0.0), ZERO),
            (ZERO, (0.0, math.pi / 2, 0.0)),
        ],
        [Z, Y, Y, X, Y, X],
    ),
    "wrist",
)

# The article's arm: axes z y y z y z, link lengths 1, 1, 1, 0.1, 0.1, 0.1 m, all frames aligned with the base at
# q = 0.
ZYYZYZ = Robot(
    "z y y z y z",
    serial(
        "zyyzyz",
        [
            (ZERO, ZERO),
            ((0.0, 0.0, 1.0), ZERO),
            ((0.0, 0.0, 1.0), ZERO),
            ((0.0, 0.0, 1.0), ZERO),
            ((0.0, 0.0, 0.1), ZERO),
            ((0.0, 0.0, 0.1), ZERO),
            ((0.0, 0.0, 0.1), ZERO),
        ],
        [Z, Y, Y, Z, Y, Z],
    ),
    "wrist",
)

# Universal Robots' UR10e: link lengths a, offsets d [m] and twists alpha [rad] of its published standard DH table.
_UR10E_A = (0.0, -0.6127, -0.57155, 0.0, 0.0, 0.0)
_UR10E_D = (0.1807, 0.0, 0.0, 0.17415, 0.11985, 0.11655)
_UR10E_ALPHA = (math.pi / 2, 0.0, 0.0, math.pi / 2, -math.pi / 2, 0.0)
# Deviations of the kind and size that a factory calibration writes: a [m], d [m], alpha [rad], theta [rad]. These are
# made up; no robot has them.
_DELTA_A = (3.1e-5, 4.7e-4, -6.2e-4, 2.4e-5, -5.1e-5, 0.0)
_DELTA_D = (-2.3e-4, 1.1e-3, -7.4e-4, -3.9e-4, 1.8e-4, -2.7e-4)
_DELTA_ALPHA = (-4.4e-4, 1.3e-3, -1.7e-3, 6.5e-4, -9.2e-4, 0.0)
_DELTA_THETA = (1.2e-6, -8.3e-4, 1.4e-3, -5.6e-4, 2.1e-6, -3.3e-6)


def _from_dh(name: str, a: Sequence[float], d: Sequence[float], alpha: Sequence[float], theta: Sequence[float]) -> str:
    """URDF text of a standard DH table: joints about z, each followed by Rz(theta) Tz(d) Tx(a) Rx(alpha)."""
    origins: list[tuple[Vector, Vector]] = [(ZERO, ZERO)]
    for length, offset, twist, turn in zip(a, d, alpha, theta, strict=True):
        origins.append(((length * math.cos(turn), length * math.sin(turn), offset), (twist, 0.0, turn)))
    return serial(name, origins, [Z] * 6)


def _sum(values: Sequence[float], deltas: Sequence[float]) -> list[float]:
    return [value + delta for value, delta in zip(values, deltas, strict=True)]


UR10E = Robot("UR10e", _from_dh("ur10e", _UR10E_A, _UR10E_D, _UR10E_ALPHA, (0.0,) * 6), "three parallel")
# UR5e, from its published table likewise.
_UR5E_A = (0.0, -0.425, -0.3922, 0.0, 0.0, 0.0)
_UR5E_D = (0.1625, 0.0, 0.0, 0.1333, 0.0997, 0.0996)
UR5E = Robot("UR5e", _from_dh("ur5e", _UR5E_A, _UR5E_D, _UR10E_ALPHA, (0.0,) * 6), "three parallel")


def _calibrated(name: str, a: Sequence[float], d: Sequence[float]) -> Robot:
    """One of these arms with the deviations."""
    alpha = _sum(_UR10E_ALPHA, _DELTA_ALPHA)
    urdf = _from_dh(f"{name.lower()}_calibrated", _sum(a, _DELTA_A), _sum(d, _DELTA_D), alpha, _DELTA_THETA)
    return Robot(f"calibrated {name}", urdf, "general")


CALIBRATED_UR10E = _calibrated("UR10e", _UR10E_A, _UR10E_D)
CALIBRATED_UR5E = _calibrated("UR5e", _UR5E_A, _UR5E_D)


def _random_6r(seed: int) -> str:
    """URDF text of six axes in random directions, 0.1 to 0.4 m apart in random directions, and a tool."""
    rng = np.random.default_rng(seed)

    def direction() -> np.ndarray:
        v = rng.normal(size=3)
        return v / np.linalg.norm(v)

    def vector(v: np.ndarray) -> Vector:
        x, y, z = map(float, v)
        return x, y, z

    origins = [(vector(rng.uniform(0.1, 0.4) * direction()), vector(rng.uniform(-1.0, 1.0, 3))) for _ in range(7)]
    return serial(f"random_6r_{seed}", origins, [vector(direction()) for _ in range(6)])


def _from_file(name: str, stem: str) -> Robot:
    """An arm whose kinematics lie in benchmarks/urdf."""
    return Robot(name, (Path(__file__).parent / "urdf" / f"{stem}.urdf").read_text(), "general")


RANDOM_6R = Robot("random 6R", _random_6r(1), "general")
KINOVA = _from_file("Kinova j2n6s300", "kinova_j2n6s300")
CRX = _from_file("FANUC CRX-10iA/L", "fanuc_crx10ial")
HC10 = _from_file("Yaskawa HC10", "yaskawa_hc10")

ROBOTS = (UR5, IRB2400, ZYYZYZ)
GENERAL = (KINOVA, CRX, RANDOM_6R)
