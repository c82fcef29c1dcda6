"""Measurements of arms whose URDF is not the one that a calibration starts from: Pinocchio's poses, with noise."""

from dataclasses import dataclass

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

import urdf_ik
from urdf_ik.cell.pinocchio_reference import Reference
from urdf_ik.kinematics.derivatives import written
from urdf_ik.model.urdf.edits import with_numbers

Array = NDArray[np.float64]
LENGTH, ANGLE = 0.002, np.deg2rad(0.5)  # how far the numbers of the true arm are off
NOISE = (5e-5, np.deg2rad(0.01))


@dataclass(frozen=True)
class TrueArm:
    """An arm as its URDF says it is, and Pinocchio's model of what it really is.

    ``base`` (4, 4) is where it stands in the measuring frame, ``marker`` (4, 4) where the marker is in its tip.
    """

    nominal: urdf_ik.Arm
    reference: Reference
    base: Array
    marker: Array

    def measured(self, seed: int, m: int, noise: tuple[float, float] = NOISE) -> tuple[Array, Array]:
        """Joint vectors (m, n) within the limits, and measured poses (m, 4, 4)."""
        rng = np.random.default_rng(seed)
        low, high = np.clip(self.nominal.limits, -3.0, 3.0).T
        q = rng.uniform(low, high, (m, self.nominal.dof))
        T = self.base @ self.reference.pose(q) @ self.marker
        T[:, :3, 3] += rng.normal(scale=noise[0], size=(m, 3))
        T[:, :3, :3] = np.array([pin.exp3(v) for v in rng.normal(scale=noise[1], size=(m, 3))]) @ T[:, :3, :3]
        return q, T


def true_arm(name: str, seed: int, *, away: bool = False) -> TrueArm:
    """An arm whose moving joints' origins are up to 2 mm and 0.5 degrees from its URDF; ``away``: seen by a tracker."""
    rng = np.random.default_rng(seed)
    arm = urdf_ik.load(name)
    geometry = written(arm.chain)
    changes = {}
    for joint, start in zip(geometry.joints, geometry.starts, strict=True):
        if joint.driver:
            numbers = geometry.values[start : start + 6]
            xyz, rpy = numbers[:3] + rng.uniform(-LENGTH, LENGTH, 3), numbers[3:] + rng.uniform(-ANGLE, ANGLE, 3)
            changes[joint.name] = {"origin": {"xyz": xyz, "rpy": rpy}}
    reference = Reference(with_numbers(arm.model.xml, changes).decode(), arm.base, arm.tip)
    still = np.eye(4)
    base = urdf_ik.pose([0.8, -0.3, 0.2], rpy=[0.3, -0.2, 2.1]) if away else still
    marker = urdf_ik.pose([0.02, -0.01, 0.06], rpy=[0.4, 0.1, -0.9]) if away else still
    return TrueArm(arm, reference, base, marker)


def floors(found: urdf_ik.Calibration, q: Array, T: Array) -> tuple[float, float]:
    """Errors of a calibrated arm at measured poses, in their noise: of a coordinate, and of an angle."""
    ours = found.base_pose @ found.arm.fk(q) @ found.marker_pose
    off = np.sqrt(np.mean((ours - T)[:, :3, 3] ** 2))
    turned = np.array([pin.log3(a.T @ b) for a, b in zip(ours[:, :3, :3], T[:, :3, :3], strict=True)])
    return float(off / NOISE[0]), float(np.sqrt(np.mean(turned**2)) / NOISE[1])
