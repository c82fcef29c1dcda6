"""Six revolute joints without a structure that a closed form could use: up to sixteen solutions, by elimination."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from urdf_ik._core import Solver
from urdf_ik.families.parts.elimination import elimination_values
from urdf_ik.families.parts.plan import Plan

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from urdf_ik.chain import Chain
    from urdf_ik.structure import Structure

    Array = NDArray[np.float64]

_NAMES = tuple(f"solution {k}" for k in range(1, 17))


def matches(structure: Structure) -> bool:
    """Whether the arm has six revolute joints."""
    return len(structure.joint_types) == 6 and "prismatic" not in structure.joint_types


def prepare(chain: Chain) -> Plan:
    """The elimination's constant matrices, for the ways of setting it up that find most."""
    return Plan(
        family="6R general",
        method="Elimination to one joint's angle (Raghavan and Roth), Newton's method on the URDF as written",
        branches=_NAMES,
        imperfection=(0.0, 0.0),
        error=0.0,
        solver=Solver("general 6R", elimination_values(chain)),
        explain=lambda T: _explain(chain, T[:3, 3]),
        by_elimination=True,
    )


def _explain(chain: Chain, point: Array) -> str:
    far = float(np.linalg.norm(point - chain.points[0]))
    if far > chain.size:
        return f"the tip is {far:.6g} m from axis 1, and all links together measure {chain.size:.6g} m"
    return "no joint angles bring the tip there: all real roots of the elimination were followed"
