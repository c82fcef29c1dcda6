"""Calibration: an arm's URDF fitted to measurements."""

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
}

__all__ = [*_MODULE]  # noqa: PLE0604

__getattr__ = attributes(__name__, _MODULE)
