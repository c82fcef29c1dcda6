"""Calibration: an arm's URDF fitted to measurements, and vendors' calibration files."""

from urdf_ik.support.lazy import attributes

_MODULE = {
    "Calibration": "report",
    "Change": "report",
    "Errors": "report",
    "Measurements": "measurements",
    "best_poses": "fit",
    "calibrate": "fit",
    "measured": "measurements",
    "read_measurements": "measurements",
    "read_ur_kinematics": "universal_robots",
    "with_ur_kinematics": "universal_robots",
}

__all__ = [*_MODULE]  # noqa: PLE0604

__getattr__ = attributes(__name__, _MODULE)
