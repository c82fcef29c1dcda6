"""One file a family; the tables below are the order in which they are tried, cheapest solver first."""

from __future__ import annotations

from typing import TYPE_CHECKING

from urdf_ik.families import (
    completed,
    coupled,
    few_joints,
    general_6r,
    general_slides,
    parallel_shoulder,
    planar,
    sampled,
    slides,
    spherical_middle,
    spherical_wrist,
    srs,
    three_parallel,
)
from urdf_ik.families.wrappers import imperfect, joint_given
from urdf_ik.families.wrappers.mirrored import mirrored
from urdf_ik.structure import analyse

if TYPE_CHECKING:
    from urdf_ik.chain import Chain
    from urdf_ik.families.parts.plan import Plan, RedundantPlan
    from urdf_ik.structure import Structure

FAMILIES = (spherical_wrist, three_parallel, parallel_shoulder, spherical_middle)


def choose(structure: Structure, chain: Chain) -> Plan | RedundantPlan | None:
    """The first family that takes the arm exactly, from either end; else the nearest, with elimination behind it.

    A quartic comes after all closed forms without one. Elimination alone where no family is near; None where no
    solver takes the arm. Of seven joints one is given.
    """
    if chain.axes is not chain:
        return coupled.prepare(chain)
    if chain.n < 6:
        few = planar.prepare(structure, chain) or few_joints.prepare(structure, chain)
        return few or completed.prepare(structure, chain, of_six)
    if chain.n == 7:
        return srs.prepare(structure, chain) or joint_given.prepare(chain, (_of_a_family, _general))
    return of_six(structure, chain)


def of_six(structure: Structure, chain: Chain) -> Plan | None:
    """What ``choose`` says of six joints."""
    if chain.prismatic.any():
        return _with_slides(structure, chain)
    if sampled.matches(chain):
        return sampled.prepare(chain)
    return _of_a_family(structure, chain) or _general(structure, chain)


def _with_slides(structure: Structure, chain: Chain) -> Plan | None:
    back = chain.reversed()
    plans: list[Plan] = []
    for seen, relations in ((chain, structure), (back, analyse(back))):
        plan = slides.prepare(relations, seen) if slides.matches(relations) else None
        if plan is not None:
            plan = plan if plan.is_exact else general_slides.behind(plan, seen)
            plans.append(mirrored(plan) if seen is back else plan)
    if plans:
        return min(plans, key=lambda plan: plan.error)
    return general_slides.prepare(chain) if general_slides.matches(structure) else None


def _of_a_family(structure: Structure, chain: Chain) -> Plan | None:
    back = chain.reversed()
    quartic: Plan | None = None
    near: list[tuple[Plan, Chain]] = []
    for seen, relations in ((chain, structure), (back, analyse(back))):
        for family in FAMILIES:
            if family.matches(relations):
                plan = family.prepare(relations, seen)
                if not plan.is_exact:
                    near.append((plan, seen))
                    continue
                plan = mirrored(plan) if seen is back else plan
                if not plan.by_quartic:
                    return plan
                quartic = quartic or plan
    if quartic or not near:
        return quartic
    plan, seen = min(near, key=lambda entry: entry[0].error)
    plan = imperfect.prepare(plan, seen)
    return mirrored(plan) if seen is back else plan


def _general(structure: Structure, chain: Chain) -> Plan | None:
    return general_6r.prepare(chain) if general_6r.matches(structure) else None
