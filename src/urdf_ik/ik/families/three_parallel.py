"""Six revolute joints whose axes 2, 3 and 4 are parallel, as Universal Robots builds them."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import partial
from typing import ClassVar

from urdf_ik._core import Solver
from urdf_ik.ik.families.parts.explanations import closed_form, compared, distances_of, links_beyond_reach, too_far
from urdf_ik.ik.families.parts.family import Family, FamilyMember
from urdf_ik.ik.families.parts.ideal import (
    NAMES,
    ClosedFormArm,
    ideal_arm,
    ideal_frames,
    imperfection,
    mean_direction,
)
from urdf_ik.ik.families.parts.written import written
from urdf_ik.kinematics.chain import Chain
from urdf_ik.kinematics.structure import Structure
from urdf_ik.typing import Array

_PLANAR = "the rest is a planar arm"


@dataclass(frozen=True, kw_only=True, eq=False)
class _ThreeParallelArm(ClosedFormArm):
    """An arm whose axes 2, 3 and 4 are parallel: ``ThreeParallelArm`` of the core.

    Attributes:
        variant: '5x6' where axes 5 and 6 meet, else 'general'.
        along: m, sum of the offsets along the parallel axes, from axis 1 to the point that is solved for.
        turn_3: 1 where axis 3 points as axis 2 does, else -1.
        turn_4: 1 where axis 4 points as axis 2 does, else -1.
        cos_first: of the angle between axes 2 and 5.
        sin_first: of the same.
        square_wrist: whether both twists of the wrist are right angles.
    """

    kind: ClassVar = "three parallel axes"
    along: float
    turn_3: float
    turn_4: float
    cos_first: float
    sin_first: float
    square_wrist: bool


def _matches(structure: Structure) -> bool:
    """Whether axes 2, 3 and 4 of a 6R arm are parallel, and neither axis 1 nor axis 5 is parallel to them."""
    return (
        structure.is_6r
        and structure.triple(2, "parallel") is not None
        and structure.triple(1, "parallel") is None
        and structure.triple(3, "parallel") is None
        and not structure.is_parallel(5)
        and structure.pairs[1].relation != "coincident"
        and structure.pairs[2].relation != "coincident"
    )


def _prepare(family: Family, structure: Structure, chain: Chain) -> FamilyMember:
    """Parameters of the nearest arm with three parallel axes, whose axes 5 and 6 meet or do not."""
    crossing = family.variant == "5x6"
    parallel = structure.triple(2, "parallel")
    directions, points = chain.H.copy(), chain.points.copy()
    directions[1:4] = mean_direction(directions[1:4])
    meet = [False, False, False, False, crossing]
    frames, error = ideal_frames(chain, directions, points, [False, True, True, False, False], meet)
    ideal = ideal_arm(frames, error, chain)
    ca, sa, d = ideal.cos_alpha, ideal.sin_alpha, ideal.d
    turn_3, turn_4 = float(ca[1]), float(ca[1] * ca[2])
    arm = _ThreeParallelArm(
        variant=family.variant,
        ideal=ideal,
        written=written(chain),
        along=float(d[0] + turn_3 * d[1] + turn_4 * (d[2] + ca[3] * d[3])),
        turn_3=turn_3,
        turn_4=turn_4,
        cos_first=float(turn_4 * ca[3]),
        sin_first=float(turn_4 * sa[3]),
        square_wrist=bool(crossing and ca[3] == 0.0 and ca[4] == 0.0),
    )
    _, distance = imperfection(structure, [], [5] if crossing else [])
    off = parallel.imperfection if parallel else 0.0, distance
    return closed_form(family, chain, arm, error, off, partial(_explain, arm, crossing))


CROSSING = Family(
    name="6R 2||3||4 and 5x6",
    reason="axes {2, 3, 4} are parallel, and axes {5, 6} meet",
    steps=f"height along the parallel axes gives joint 1, the last axis joint 5 and joint 6, {_PLANAR}",
    branches=NAMES,
    by_quadratics=True,
    matches=lambda structure, chain: _matches(structure) and structure.is_intersecting(5),
    prepare=_prepare,
    variant="5x6",
)
GENERAL = Family(
    name="6R 2||3||4",
    reason="axes {2, 3, 4} are parallel",
    steps=f"a quartic in joint 1 from height and direction along the parallel axes, {_PLANAR}",
    branches=tuple(
        f"position {root}, elbow {up}" for first in (1, 3) for up in ("up", "down") for root in (first, first + 1)
    ),
    by_quadratics=False,
    matches=lambda structure, chain: _matches(structure) and not structure.is_intersecting(5),
    prepare=_prepare,
    variant="general",
)


def _explain(arm: _ThreeParallelArm, crossing: bool, solver: Solver, rotation: Array, point: Array) -> str:
    ideal, (upper, lower) = arm.ideal, arm.ideal.a[1:3]
    if crossing:
        side = (ideal.cos_alpha[0] * point[2] - arm.along) / ideal.sin_alpha[0]
        radius = math.hypot(point[0], point[1])
        if radius < abs(side):
            near, off = compared(radius, abs(side))
            return (
                f"the point where axes 5 and 6 meet is {near} m from axis 1, and the arm's sideways offset keeps it "
                f"{off} m away{too_far(radius, abs(side), math.inf)}"
            )
    distances = distances_of(solver, rotation, point)
    return links_beyond_reach(("axis 4", "axis 2"), distances, abs(upper - lower), upper + lower)
