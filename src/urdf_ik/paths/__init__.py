"""Paths: waypoints, plans through them, their timing, and a tracker for targets that arrive one by one."""

from __future__ import annotations

from typing import TYPE_CHECKING

from urdf_ik.support.lazy import attributes

if TYPE_CHECKING:
    from urdf_ik._core import Step
    from urdf_ik.paths.path_settings import PathSettings
    from urdf_ik.paths.planned_motion import Change, Margins, Plan, Stop
    from urdf_ik.paths.target_tracker import Tracker
    from urdf_ik.paths.waypoint_files import read_waypoints
    from urdf_ik.paths.waypoints import arc, line, polyline

__all__ = [
    "Change",
    "Margins",
    "PathSettings",
    "Plan",
    "Step",
    "Stop",
    "Tracker",
    "arc",
    "line",
    "polyline",
    "read_waypoints",
]

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
    "read_waypoints": "waypoint_files",
}

__getattr__ = attributes(__name__, _MODULE)
