"""Paths: waypoints, plans through them, their timing, and a tracker for targets that arrive one by one."""

from __future__ import annotations

from urdf_ik.paths.plan import Change, Margins, Plan, Stop
from urdf_ik.paths.tracker import Step, Tracker
from urdf_ik.paths.waypoint_files import read_waypoints
from urdf_ik.paths.waypoints import arc, line, polyline

__all__ = ["Change", "Margins", "Plan", "Step", "Stop", "Tracker", "arc", "line", "polyline", "read_waypoints"]
