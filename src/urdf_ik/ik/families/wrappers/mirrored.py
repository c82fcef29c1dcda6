"""Arms that belong to a family when they are looked at from the tip: the same code on the reversed chain."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, ClassVar

import numpy as np

from urdf_ik._core import Solver
from urdf_ik.ik.families.parts.family import FamilyMember
from urdf_ik.typing import Array

_OTHER_END = {"shoulder": "wrist", "wrist": "shoulder"}


@dataclass(frozen=True, kw_only=True, eq=False)
class Reversed:
    """An arm that is solved on the chain from tip to base.

    Attributes:
        solver: the reversed chain's arm: the dataclass of its solver.
    """

    kind: ClassVar = "reversed"
    solver: Any


def mirrored(plan: FamilyMember) -> FamilyMember:
    """The plan for an arm whose reversed chain ``plan`` was made for."""

    def explain(T: Array) -> str:
        return f"seen from the tip, {plan.explain(np.asarray(np.linalg.inv(T), dtype=np.float64))}"

    why = plan.family.why(from_tip=True)
    return replace(
        plan,
        name=f"{plan.name}, reversed",
        reason=why if plan.is_exact else f"{why}, exactly or nearly",
        method=f"{plan.method}; on the chain from tip to base",
        branches=tuple(_renamed(name) for name in plan.branches),
        explain=explain,
        solver=Solver(Reversed(solver=plan.solver.arm)),
    )


def _renamed(name: str) -> str:
    return " ".join(_OTHER_END.get(word, word) for word in name.split(" "))
