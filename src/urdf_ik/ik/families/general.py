"""Six joints without a structure that a closed form could use, turning or with slides: up to sixteen solutions."""

from __future__ import annotations

from dataclasses import replace
from functools import partial

from urdf_ik._core import Solver
from urdf_ik.ik.families.parts.elimination import elimination_arm
from urdf_ik.ik.families.parts.explanations import off_by
from urdf_ik.ik.families.parts.family import Family, FamilyMember, columns
from urdf_ik.kinematics.chain import Chain, is_redundant, kinds_of
from urdf_ik.kinematics.structure import Structure


def _prepare(family: Family, structure: Structure, chain: Chain) -> FamilyMember:
    """The elimination's constant matrices, and poses of which all solutions are known."""
    triples, reason = " and ".join(map(str, structure.triples)), family.reason
    if structure.is_6r:
        reason = "no three neighbouring axes meet in a point or are parallel, so no closed form applies"
        reason = f"{triples}, but no closed form applies to these six axes" if triples else reason
    return FamilyMember(
        family=family,
        name=f"{kinds_of(chain)} general",
        reason=reason,
        method=family.steps,
        branches=family.branches,
        solver=Solver(elimination_arm(chain)),
        explain=partial(off_by, chain),
    )


TURNING = Family(
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


def _matches(structure: Structure) -> bool:
    """Whether six joints have one slide, or two that are not opposite in the loop: joints 1 and 4, 2 and 5, 3 and 6.

    However a loop is cut, opposite slides stand on both sides, and the elimination then has a solution with both at
    infinity for every value of the hidden joint.
    """
    slides = [i for i, kind in enumerate(structure.joint_types) if kind == "prismatic"]
    return len(structure.joint_types) == 6 and len(slides) in (1, 2) and slides[-1] - slides[0] != 3


WITH_SLIDES = Family(
    name="six joints with slides, general",
    reason="one or two of six joints slide, and no three axes at an end meet in a point, so no closed form applies",
    steps="Elimination to one joint's value (Raghavan and Roth), a slide as tan(t / 2), Newton's method on the URDF as "
    "written",
    branches=columns(16),
    by_quadratics=False,
    by_elimination=True,
    matches=lambda structure, chain: _matches(structure) and not is_redundant(chain),
    prepare=_prepare,
)


def behind(plan: FamilyMember, chain: Chain) -> FamilyMember:
    """The plan of an arm whose wrist meets only nearly, with elimination behind it."""
    return replace(
        plan,
        method="Elimination to one joint's value (Raghavan and Roth), Newton's method on the URDF as written",
        branches=columns(16),
        solver=Solver(elimination_arm(chain)),
    )
