"""The three arms that the benchmark solves, as URDF text from published link lengths."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import pinocchio as pin

Vector = tuple[float, float, float]
ZERO: Vector = (0.0, 0.0, 0.0)
X: Vector = (1.0, 0.0, 0.0)
Y: Vector = (0.0, 1.0, 0.0)
Z: Vector = (0.0, 0.0, 1.0)


@dataclass(frozen=True)
class OrthoParallel:
    """The parameters by which an ortho-parallel arm with spherical wrist is described [m, rad].

    They are those of Brandstoetter, Angerer and Hofbaur (2014): shoulder, elbow and lateral offset ``a1``, ``a2``,
    ``b``; link lengths ``c1`` to ``c4``; the joint angles' offsets.
    """

    a1: float
    a2: float
    b: float
    c1: float
    c2: float
    c3: float
    c4: float
    offsets: tuple[float, float, float, float, float, float] = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0)


@dataclass(frozen=True)
class Robot:
    """A benchmarked arm.

    Attributes:
        name: what the table calls it.
        urdf: the URDF text; base link ``base``, tip link ``tool``.
        structure: ``"wrist"`` (spherical wrist, 2 || 3) or ``"three parallel"`` (2 || 3 || 4, 5 x 6).
        ortho_parallel: its ortho-parallel parameters, where it has them.
    """

    name: str
    urdf: str
    structure: str
    ortho_parallel: OrthoParallel | None = None

    @cached_property
    def judge(self) -> Judge:
        """Pinocchio's model of the same text."""
        return Judge(self.urdf)


class Judge:
    """Pinocchio's view of a benchmarked arm: poses, errors, axes. It shares no code with any solver."""

    def __init__(self, urdf: str) -> None:
        """Build it from URDF text."""
        self.model = pin.buildModelFromXML(urdf)
        self.data = self.model.createData()
        self.base = self.model.getFrameId("base", pin.FrameType.BODY)
        self.tip = self.model.getFrameId("tool", pin.FrameType.BODY)

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

    def screws(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Axes H (6, 3), offsets P (7, 3) from joint to joint and home rotation (3, 3), all in the base at q = 0."""
        q = np.zeros(6)
        pin.framesForwardKinematics(self.model, self.data, q)
        pin.computeJointJacobians(self.model, self.data, q)
        to_base = self.data.oMf[self.base].inverse()
        axes, points = [], [np.zeros(3)]
        for i in range(1, 7):
            world = self.data.oMi[i]
            column = pin.getJointJacobian(self.model, self.data, i, pin.LOCAL)[3:, i - 1]
            axes.append(to_base.rotation @ world.rotation @ column)
            points.append(to_base.act(world.translation))
        tip = to_base * self.data.oMf[self.tip]
        return np.array(axes), np.diff([*points, tip.translation], axis=0), tip.rotation


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
    OrthoParallel(
        a1=0.1,
        a2=-0.135,
        b=0.0,
        c1=0.615,
        c2=0.705,
        c3=0.755,
        c4=0.085,
        offsets=(0.0, 0.0, -math.pi / 2, 0.0, 0.0, 0.0),
    ),
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
    OrthoParallel(a1=0.0, a2=0.0, b=0.0, c1=1.0, c2=1.0, c3=1.1, c4=0.2),
)

ROBOTS = (UR5, IRB2400, ZYYZYZ)
