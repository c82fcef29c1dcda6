"""Every family, in the order of cost, and which one an arm is solved as.

A new family is a row here: see CONTRIBUTING.md.
"""

from collections.abc import Sequence
from dataclasses import replace

from urdf_ik.ik.families import (
    axis_added,
    coupled,
    few_joints,
    general,
    hollow_wrist,
    joint_given,
    parallel_shoulder,
    planar,
    slides,
    spherical_middle,
    spherical_wrist,
    srs,
    three_parallel,
)
from urdf_ik.ik.families.parts.family import Family, FamilyMember, mirrored
from urdf_ik.ik.families.parts.ideal import geometric
from urdf_ik.kinematics.chain import Chain, typical_stretch
from urdf_ik.kinematics.structure import Structure, analyse

FEW_JOINTS: list[Family] = [planar.FAMILY, few_joints.FAMILY]
"""Families of one to five joints."""

_CLOSED_FORMS = (spherical_wrist, three_parallel, parallel_shoulder, spherical_middle)
# Quartics last.
SIX_TURNING: list[Family] = sorted(
    (family for module in _CLOSED_FORMS for family in module.FAMILIES), key=lambda family: not family.by_quadratics
)
"""Closed forms of six turning joints, which are tried from either end."""

SIX_WITH_SLIDES: list[Family] = [slides.THREE_SLIDES, slides.SPHERICAL_WRIST]
"""Closed forms of six joints with slides, which are tried from either end."""

SINGULAR_EVERYWHERE: list[Family] = [general.SINGULAR]
"""Six joints with a continuum of solutions for every pose that they reach."""

BY_ELIMINATION: list[Family] = [general.TURNING, general.WITH_SLIDES]
"""Six joints that are in no other family."""

SEVEN_JOINTS: list[Family] = [srs.FAMILY]
"""Families of seven joints."""

MOST_JOINTS = 9
"""Arms with more joints have more redundancy parameters than a compiled solver takes."""

MIMICKING: list[Family] = [coupled.FAMILY, hollow_wrist.FAMILY]
"""Arms in which joints mimic others."""


# If an arm's distance from the nearest member of a family [rad, share of size] is larger than this share of its
# Jacobian's smallest singular value, the member may be singular everywhere and is not used.
_SHARE = 0.3


def every() -> list[Family]:
    """Every family, in the order of cost among those that an arm may belong to."""
    return [
        *FEW_JOINTS,
        *SIX_TURNING,
        *SIX_WITH_SLIDES,
        *SINGULAR_EVERYWHERE,
        *BY_ELIMINATION,
        *SEVEN_JOINTS,
        *MIMICKING,
    ]


def choose(structure: Structure, chain: Chain, given: tuple[str, ...] = ()) -> FamilyMember | None:
    """How an arm is solved; None where no solver takes it.

    Of fewer joints than six, and of those that mimic others, the first family that takes the arm. Five turning joints
    of no family get an added axis; of seven joints one is given where they are of no family, of more as many as leave
    six or seven.

    Args:
        structure: how the axes lie.
        chain: the joints.
        given: names of joints whose values are to be the redundancy parameters.
    """
    if (plain := coupled.uncoupled(chain)) is not None:
        plan = choose(analyse(plain), plain)
        links = ", ".join(map(str, chain.followers))
        return plan and replace(plan, reason=f"parallelograms turn as one axis ({links}): {plan.reason}")
    if chain.axes is not chain:
        return _first(MIMICKING, structure, chain)
    if chain.n < 6:
        return _first(FEW_JOINTS, structure, chain) or axis_added.prepare_completed(structure, chain, of_six)
    if chain.n == 6:
        return of_six(structure, chain)
    if chain.n > MOST_JOINTS:
        return None
    own = None if given or chain.n > 7 else _of_seven(structure, chain)
    return own or joint_given.prepare(chain, _of_seven, (_closed_form, _with_slides, _elimination), given)


def _of_seven(structure: Structure, chain: Chain) -> FamilyMember | None:
    plan = _first(SEVEN_JOINTS, structure, chain)
    return plan if plan is not None and _is_guide(plan, chain) else None


def of_six(structure: Structure, chain: Chain) -> FamilyMember | None:
    """How six joints are solved: in closed form from either end, else by elimination."""
    if singular := _first(SINGULAR_EVERYWHERE, structure, chain):
        return singular
    closed_form = _with_slides if structure.slides else _closed_form
    return closed_form(structure, chain) or _elimination(structure, chain)


def _closed_form(structure: Structure, chain: Chain) -> FamilyMember | None:
    """The first family that takes six turning joints exactly, from either end, quartics last; else the nearest one."""
    back = chain.reversed()
    quartic: FamilyMember | None = None
    near: list[tuple[FamilyMember, Chain]] = []
    for seen, relations in ((chain, structure), (back, analyse(back))):
        for family in SIX_TURNING:
            plan = family.plan(relations, seen)
            if plan is None:
                continue
            if not plan.is_exact:
                near.append((plan, seen))
                continue
            plan = mirrored(plan) if seen is back else _named(plan, chain)
            if family.by_quadratics:
                return plan
            quartic = quartic or plan
    if quartic or not near:
        return quartic
    plan, seen = min(near, key=lambda entry: (not entry[0].family.by_quadratics, entry[0].error))
    if not _is_guide(plan, seen):
        return None
    plan = general.beside(plan, seen)
    return mirrored(plan) if seen is back else _named(plan, chain)


def _named(plan: FamilyMember, chain: Chain) -> FamilyMember:
    """The plan with the names of its branches by geometry, where axes 2 and 3 are parallel."""
    wrist = {"6R spherical wrist, 2||3": (3, 4), "6R 2||3||4 and 5x6": (4, 5)}.get(plan.family.name)
    return plan if wrist is None else replace(plan, branches=geometric(plan.branches, plan.solver, chain, wrist))


def _is_guide(plan: FamilyMember, chain: Chain) -> bool:
    """Whether the plan's ideal arm is near enough to give starting points: it cannot be singular everywhere."""
    return plan.is_exact or plan.error < _SHARE * typical_stretch(chain)


def _with_slides(structure: Structure, chain: Chain) -> FamilyMember | None:
    """The closed form of six joints with slides that fits best, from either end."""
    back = chain.reversed()
    plans: list[FamilyMember] = []
    for seen, relations in ((chain, structure), (back, analyse(back))):
        plan = _first(SIX_WITH_SLIDES, relations, seen)
        if plan is not None:
            plan = plan if plan.is_exact else general.behind(plan, seen)
            plans.append(mirrored(plan) if seen is back else plan)
    return min(plans, key=lambda plan: plan.error, default=None)


def _elimination(structure: Structure, chain: Chain) -> FamilyMember | None:
    return _first(BY_ELIMINATION, structure, chain)


def _first(families: Sequence[Family], structure: Structure, chain: Chain) -> FamilyMember | None:
    """The plan of the first family that has one."""
    plans = (family.plan(structure, chain) for family in families)
    return next((plan for plan in plans if plan is not None), None)
