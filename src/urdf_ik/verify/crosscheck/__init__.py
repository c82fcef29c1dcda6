"""Cross-checks of an arm with Pinocchio, over random poses and every branch."""

from __future__ import annotations

from urdf_ik.verify.crosscheck.check import COLLISION_POSES, PROPERTIES, check, replay
from urdf_ik.verify.crosscheck.report import Report, Row

__all__ = [
    "COLLISION_POSES",
    "PROPERTIES",
    "Report",
    "Row",
    "check",
    "replay",
]
