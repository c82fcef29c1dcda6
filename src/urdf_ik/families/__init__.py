"""One file a family; the tables below are the order in which they are tried, cheapest solver first."""

from __future__ import annotations

from typing import TYPE_CHECKING

from urdf_ik.families import completed, few_joints, general_6r, imperfect, planar, spherical_wrist, three_parallel
from urdf_ik.families.mirrored import mirrored
from urdf_ik.structure import analyse

if TYPE_CHECKING:
    from urdf_ik.chain import Chain
    from urdf_ik.families.plan import Plan
    from urdf_ik.structure import Structure

FAMILIES = (spherical_wrist, three_parallel)


def choose(structure: Structure, chain: Chain) -> Plan | None:
    """The first family that takes the arm exactly, from either end; else the nearest, with elimination behind it.

    Elimination alone where no family is near; None where no solver takes the arm.
    """
    if chain.n < 6:
        few = planar.prepare(structure, chain) or few_joints.prepare(structure, chain)
        return few or completed.prepare(structure, chain, choose)
    back = chain.reversed()
    near: list[tuple[Plan, Chain]] = []
    for seen, relations in ((chain, structure), (back, analyse(back))):
        for family in FAMILIES:
            if family.matches(relations):
                plan = family.prepare(relations, seen)
                if plan.is_exact:
                    return mirrored(plan) if seen is back else plan
                near.append((plan, seen))
    if near:
        plan, seen = min(near, key=lambda entry: entry[0].error)
        plan = imperfect.prepare(plan, seen)
        return mirrored(plan) if seen is back else plan
    return general_6r.prepare(chain) if general_6r.matches(structure) else None
