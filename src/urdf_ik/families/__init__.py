"""One file a family; the table below is the order in which they are tried, cheapest solver first."""

from __future__ import annotations

from typing import TYPE_CHECKING

from urdf_ik.families import spherical_wrist, three_parallel

if TYPE_CHECKING:
    from urdf_ik.chain import Chain
    from urdf_ik.families.plan import Plan
    from urdf_ik.structure import Structure

FAMILIES = (spherical_wrist, three_parallel)


def choose(structure: Structure, chain: Chain) -> Plan | None:
    """The first family that takes the arm exactly, else the one that it is nearest to, else None."""
    plans = [family.prepare(structure, chain) for family in FAMILIES if family.matches(structure)]
    return min(plans, key=lambda plan: plan.rank, default=None)
