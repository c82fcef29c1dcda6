"""Arms that belong to a family when they are looked at from the tip: the same code on the reversed chain."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from urdf_ik._core import Solver
from urdf_ik._kernels import mirror

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from urdf_ik.families.plan import Plan

    Array = NDArray[np.float64]

_OTHER_END = {"shoulder": "wrist", "wrist": "shoulder"}


def mirrored(plan: Plan) -> Plan:
    """The plan for an arm whose reversed chain ``plan`` was made for."""

    def solve(T: Array, arm: Array, q_ref: Array, Q: Array, flags: NDArray[np.uint8]) -> int:
        inverse = np.empty_like(T)
        mirror.invert_poses(T, inverse)
        reference = q_ref.copy()
        reference[:-1] = q_ref[-2::-1]
        bad = plan.solve(inverse, arm, reference, Q, flags)
        mirror.turn_round(Q, flags)
        return bad

    def explain(rotation: Array, point: Array) -> str:
        return f"seen from the tip, {plan.explain(rotation, point)}"

    return replace(
        plan,
        family=f"{plan.family}, reversed",
        method=f"{plan.method}; on the chain from tip to base",
        branches=tuple(_renamed(name) for name in plan.branches),
        solve=solve,
        explain=explain,
        mirrored=True,
        solver=None if plan.solver is None else Solver("reversed", {"solver": plan.solver}),
    )


def _renamed(name: str) -> str:
    return " ".join(_OTHER_END.get(word, word) for word in name.split(" "))
