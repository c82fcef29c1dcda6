"""IKSolutions: what ``arm.ik`` returns, and how solutions are filtered, multiplied and chosen."""

from __future__ import annotations

from urdf_ik.ik.solutions.ik_solutions import IKSolutions
from urdf_ik.ik.solutions.solution import Singular, Solution, Step

__all__ = ["IKSolutions", "Singular", "Solution", "Step"]
