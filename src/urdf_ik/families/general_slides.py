"""Six joints of which one or two slide, without a structure that a closed form could use: elimination."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from urdf_ik._core import Solver
from urdf_ik._kernels import general_slides as kernels
from urdf_ik._kernels import layout
from urdf_ik._kernels import slides as wrist
from urdf_ik.families.elimination import elimination_values
from urdf_ik.families.few_joints import POSE, Aim, columns, is_redundant, kinds_of, pack_chain
from urdf_ik.families.general_6r import with_elimination
from urdf_ik.families.nearest import off_by
from urdf_ik.families.plan import Plan

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from urdf_ik.chain import Chain
    from urdf_ik.structure import Structure

    Array = NDArray[np.float64]

_ROWS_OF_A_WRIST = slice(wrist.STEP, wrist.LENGTH)


def matches(structure: Structure) -> bool:
    """Whether six joints have one slide, or two that are not opposite in the loop: joints 1 and 4, 2 and 5, 3 and 6.

    However a loop is cut, opposite slides stand on both sides, and the elimination then has a solution with both at
    infinity for every value of the hidden joint.
    """
    slides = [i for i, kind in enumerate(structure.joint_types) if kind == "prismatic"]
    return len(structure.joint_types) == 6 and len(slides) in (1, 2) and slides[-1] - slides[0] != 3


def prepare(chain: Chain) -> Plan | None:
    """The plan by elimination alone; None where the arm is redundant."""
    if is_redundant(chain):
        return None
    solver = Solver("general slides", elimination_values(chain))

    def solve(T: Array, arm: Array, q_ref: Array, Q: Array, flags: NDArray[np.uint8]) -> int:
        return solver.solve(T, None, Q, flags)

    return Plan(
        family=f"{kinds_of(chain)} general",
        method="Elimination to one joint's value (Raghavan and Roth), a slide as tan(t / 2), Newton's method on the "
        "URDF as written",
        branches=columns(16),
        imperfection=(0.0, 0.0),
        error=0.0,
        arm=_room(chain),
        solve=solve,
        explain=lambda rotation, point: off_by(chain, Aim(), rotation, point),
        solver=solver,
    )


def behind(plan: Plan, chain: Chain) -> Plan:
    """The plan of an arm whose wrist meets only nearly, with elimination behind it."""
    arm = _room(chain)
    arm[_ROWS_OF_A_WRIST] = plan.arm[_ROWS_OF_A_WRIST]
    arm[layout.CLAMP], arm[layout.IMPERFECTION] = plan.arm[layout.CLAMP], plan.arm[layout.IMPERFECTION]
    return replace(
        plan,
        method=f"{plan.method}; what only the arm as written has by elimination",
        branches=columns(16),
        arm=with_elimination(arm, chain, kernels.trial),
        solve=kernels.solve,
        solver=None,
    )


def _room(chain: Chain) -> Array:
    """The numbers of an arm of few joints, with room up to those of the elimination."""
    numbers = pack_chain(chain, POSE)
    return np.concatenate([numbers, np.zeros(layout.LENGTH - len(numbers))])
