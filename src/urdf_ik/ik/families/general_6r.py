"""Six revolute joints without a structure that a closed form could use: up to sixteen solutions.

By elimination to one joint, and by continuation of all complex solutions where that leaves doubts.
"""

from __future__ import annotations

from urdf_ik._core import Solver
from urdf_ik.ik.families.parts.elimination import elimination_arm
from urdf_ik.ik.families.parts.family import Family, FamilyMember, columns
from urdf_ik.ik.families.parts.nearest_pose import off_by
from urdf_ik.ik.families.parts.written import Aim
from urdf_ik.kinematics.chain import Chain
from urdf_ik.kinematics.structure import Structure


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
        explain=lambda T: off_by(chain, Aim(), T[:3, :3], T[:3, 3]),
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
