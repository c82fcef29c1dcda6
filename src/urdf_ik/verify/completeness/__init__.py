"""Two independent ways to every solution, compared pose by pose: a report of every difference.

Compared are the arm's own solver and a second way that shares nothing with it but forward kinematics: the elimination
of Raghavan and Roth, set up at three places of the loop, and Newton's method from many random starts.

The planted joint vector of each pose is a third witness: it is missed where neither has it.
"""

from __future__ import annotations

from urdf_ik.verify.completeness.check import compare, replay
from urdf_ik.verify.completeness.report import Completeness, Difference, Group

__all__ = [
    "Completeness",
    "Difference",
    "Group",
    "compare",
    "replay",
]
