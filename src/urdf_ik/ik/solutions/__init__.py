"""``IKSolutions``, the result of ``arm.ik``: filters, turns, and the choice of a solution."""

from urdf_ik.ik.solutions.ik_solutions import IKSolutions
from urdf_ik.ik.solutions.proof import Proof
from urdf_ik.ik.solutions.solution import Singular, Solution, Step

__all__ = ["IKSolutions", "Proof", "Singular", "Solution", "Step"]
