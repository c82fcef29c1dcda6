"""Two arms, or two URDFs of one arm: what is different, and what it does to the solutions and to the tool.

For swaps: another arm, another tool, a calibrated copy of a nominal arm. Each arm is asked for what it controls of a
pose (see ``Arm.task``); where a tip really is, Pinocchio says.
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
