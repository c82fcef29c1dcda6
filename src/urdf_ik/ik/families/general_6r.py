"""Six revolute joints without a structure that a closed form could use: up to sixteen solutions.

By elimination to one joint, and by continuation of all complex solutions where that leaves doubts.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from urdf_ik._core import Solver
from urdf_ik.ik.families.parts.elimination import elimination_arm
from urdf_ik.ik.families.parts.family import Family, FamilyMember, columns

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from urdf_ik.kinematics.chain import Chain
    from urdf_ik.kinematics.structure import Structure

    Array = NDArray[np.float64]


def _prepare(family: Family, structure: Structure, chain: Chain) -> FamilyMember:
    """The elimination's constant matrices, and poses of which all solutions are known."""
    triples = " and ".join(map(str, structure.triples))
    none = "no three neighbouring axes meet in a point or are parallel, so no closed form applies"
    return FamilyMember(
        family=family,
        name=family.name,
        reason=f"{triples}, but no closed form applies to these six axes" if triples else none,
        method=family.steps,
        branches=family.branches,
        solver=Solver(elimination_arm(chain)),
        explain=lambda T: _explain(chain, T[:3, 3]),
    )


FAMILY = Family(
    name="6R general",
    reason="six turning joints, whatever their axes",
    steps="Elimination to one joint's angle (Raghavan and Roth), continuation of all complex solutions where that "
    "leaves doubts, Newton's method on the URDF as written",
    branches=columns(16),
    by_quadratics=False,
    by_elimination=True,
    matches=lambda structure, chain: structure.is_6r,
    prepare=_prepare,
)


def _explain(chain: Chain, point: Array) -> str:
    far = float(np.linalg.norm(point - chain.points[0]))
    if far > chain.size:
        return f"the tip is {far:.6g} m from axis 1, and all links together measure {chain.size:.6g} m"
    return "no joint angles bring the tip there: all complex solutions were followed, and none of them is real"
