"""Paths: waypoints, plans through them, their timing, and a tracker for targets that arrive one by one."""

from urdf_ik.support.lazy import attributes

_MODULE = {
    "Change": "planned_motion",
    "Margins": "planned_motion",
    "PathSettings": "path_settings",
    "Plan": "planned_motion",
    "Step": "target_tracker",
    "Stop": "planned_motion",
    "Tracker": "target_tracker",
    "arc": "waypoints",
    "line": "waypoints",
    "polyline": "waypoints",
    "read_waypoints": "waypoints",
}

__all__ = [*_MODULE]  # noqa: PLE0604

__getattr__ = attributes(__name__, _MODULE)
