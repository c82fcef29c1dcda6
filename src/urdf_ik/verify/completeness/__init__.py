"""Completeness checks: the solutions of two independent methods, compared pose by pose.

The first method is the arm's own solver. The second shares only forward kinematics with it: the elimination of Raghavan
and Roth, set up at three places of the loop, and Newton's method from many random starts.

Each pose comes from a planted joint vector. If neither method finds this vector, the report counts it as missed.
"""

from __future__ import annotations

from urdf_ik.verify.completeness.check import compare, planted, replay
from urdf_ik.verify.completeness.report import Completeness, Difference, Group

__all__ = [
    "Completeness",
    "Difference",
    "Group",
    "compare",
    "planted",
    "replay",
]
