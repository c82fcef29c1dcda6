"""Comparisons of two arms or of two URDFs of one arm: the differences, and their effect on solutions and tool.

They answer the questions before a swap: another arm, another tool, a calibrated copy of a nominal arm. Each arm solves
for the part of a pose that it controls (see ``Arm.task``); Pinocchio computes where its tip really is.
"""

from __future__ import annotations

from urdf_ik.verify.comparison.many import ManyArms, Row, compare_many
from urdf_ik.verify.comparison.report import (
    AxisChange,
    BranchChange,
    Comparison,
    Fact,
    LimitChange,
    Reach,
    Side,
    ToolError,
)
from urdf_ik.verify.comparison.two_arms import compare

__all__ = [
    "AxisChange",
    "BranchChange",
    "Comparison",
    "Fact",
    "LimitChange",
    "ManyArms",
    "Reach",
    "Row",
    "Side",
    "ToolError",
    "compare",
    "compare_many",
]
