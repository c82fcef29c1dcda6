"""One file a family; the table below is the order in which they are tried, cheapest solver first."""

from __future__ import annotations

from typing import TYPE_CHECKING

from urdf_ik.families import general_6r, imperfect, spherical_wrist, three_parallel

if TYPE_CHECKING:
    from urdf_ik.chain import Chain
    from urdf_ik.families.plan import Plan
    from urdf_ik.structure import Structure

FAMILIES = (spherical_wrist, three_parallel)


def choose(structure: Structure, chain: Chain) -> Plan | None:
    """The first family that takes the arm exactly; else the nearest one, with the general solver behind it; else that.

    None where no solver takes the arm.
    """
    near = []
    for family in FAMILIES:
        if family.matches(structure):
            plan = family.prepare(structure, chain)
            if plan.is_exact:
                return plan
            near.append(plan)
    if near:
        return imperfect.prepare(min(near, key=lambda plan: plan.error), chain)
    return general_6r.prepare(structure, chain) if general_6r.matches(structure) else None
