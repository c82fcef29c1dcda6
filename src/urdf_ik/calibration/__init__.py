"""Calibration: an arm's URDF fitted to measurements, and vendors' calibration files."""

from __future__ import annotations

from typing import TYPE_CHECKING

from urdf_ik.support.lazy import attributes

if TYPE_CHECKING:
    from urdf_ik.calibration.changes import Change, Errors
    from urdf_ik.calibration.fit import calibrate
    from urdf_ik.calibration.measurements import Measurements, measured, read_measurements
    from urdf_ik.calibration.poses import BestPoses, best_poses
    from urdf_ik.calibration.report import Calibration
    from urdf_ik.calibration.universal_robots import (
        UrKinematics,
        read_ur_kinematics,
        ur_kinematics,
        with_ur_kinematics,
    )

__all__ = [
    "BestPoses",
    "Calibration",
    "Change",
    "Errors",
    "Measurements",
    "UrKinematics",
    "best_poses",
    "calibrate",
    "measured",
    "read_measurements",
    "read_ur_kinematics",
    "ur_kinematics",
    "with_ur_kinematics",
]

_MODULE = {
    "BestPoses": "poses",
    "Calibration": "report",
    "Change": "changes",
    "Errors": "changes",
    "Measurements": "measurements",
    "UrKinematics": "universal_robots",
    "best_poses": "poses",
    "calibrate": "fit",
    "measured": "measurements",
    "read_measurements": "measurements",
    "read_ur_kinematics": "universal_robots",
    "ur_kinematics": "universal_robots",
    "with_ur_kinematics": "universal_robots",
}

__getattr__ = attributes(__name__, _MODULE)
