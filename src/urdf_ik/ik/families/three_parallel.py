"""Six revolute joints whose axes 2, 3 and 4 are parallel, as Universal Robots builds them."""

import cmath
import math
from collections.abc import Iterator
from typing import Any

import numpy as np

from urdf_ik._core import Solver
from urdf_ik.ik.families.parts.explanations import links_beyond_reach, outside
from urdf_ik.ik.families.parts.family import Family, FamilyMember
from urdf_ik.ik.families.parts.ideal import POSITIONS, Variant, closed_form, families
from urdf_ik.ik.families.parts.written import Numbers
from urdf_ik.kinematics.chain import Chain
from urdf_ik.kinematics.structure import Structure
from urdf_ik.typing import Array


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


def _prepare(family: Family, structure: Structure, chain: Chain) -> FamilyMember | None:
    """Parameters of the nearest arm with three parallel axes, whose axes 5 and 6 meet or do not."""
    crossing = family.variant == "5x6"

    def numbers(ideal: Numbers) -> dict[str, Any]:
        ca, sa, d = ideal.cos_alpha, ideal.sin_alpha, ideal.d
        turn_3, turn_4 = float(ca[1]), float(ca[1] * ca[2])
        return {
            "along": float(d[0] + turn_3 * d[1] + turn_4 * (d[2] + ca[3] * d[3])),
            "turn_3": turn_3,
            "turn_4": turn_4,
            "cos_first": float(turn_4 * ca[3]),
            "sin_first": float(turn_4 * sa[3]),
            "square_wrist": bool(crossing and ca[3] == 0.0 and ca[4] == 0.0),
        }

    meet = [5] if crossing else []
    return closed_form(family, structure, chain, "three parallel axes", (2, "parallel"), meet, numbers, _explain)


FAMILIES = CROSSING, GENERAL = families(
    "6R 2||3||4",
    "axes {2, 3, 4} are parallel",
    _matches,
    _prepare,
    [
        Variant(
            "5x6",
            " and 5x6",
            ", and axes {5, 6} meet",
            "height along the parallel axes gives joint 1, the last axis joint 5 and joint 6, the rest is a planar arm",
            lambda structure, chain: structure.is_intersecting(5),
        ),
        Variant(
            "general",
            "",
            "",
            "a quartic in joint 1 from height and direction along the parallel axes, the rest is a planar arm",
            lambda structure, chain: not structure.is_intersecting(5),
            POSITIONS,
            by_quadratics=False,
        ),
    ],
)


def _explain(arm: Numbers, solver: Solver, rotation: Array, point: Array) -> str:
    if arm.variant != "5x6":
        return ""
    ideal, (upper, lower) = arm.ideal, arm.ideal.a[1:3]
    side = (ideal.cos_alpha[0] * point[2] - arm.along) / ideal.sin_alpha[0]
    near = "the point where axes 5 and 6 meet is {at} m from axis 1, and the arm's sideways offset keeps it {low} m"
    if why := outside(f"{near} away", math.hypot(point[0], point[1]), abs(side)):
        return why
    distances = np.array(list(_distances(arm, rotation, point, side)))
    return links_beyond_reach("axis 4", "axis 2", distances, abs(upper - lower), upper + lower)


def _distances(arm: Numbers, rotation: Array, point: Array, side: float) -> Iterator[float]:
    """The distances of axes 2 and 4 [m] that a pose, seen from frame 1, requires: one for each shoulder and wrist."""
    ca, sa, cb, sb = arm.cos_first, arm.sin_first, arm.ideal.cos_alpha[4], arm.ideal.sin_alpha[4]
    c1, s1 = arm.ideal.cos_alpha[0], arm.ideal.sin_alpha[0]
    ahead = math.sqrt(max(point[0] ** 2 + point[1] ** 2 - side**2, 0.0))
    for front in (ahead, -ahead):
        # From frame 1 to after joint 1, with z along the parallel axes.
        t1 = math.atan2(point[1], point[0]) - math.atan2(side, front)
        c, s = math.cos(t1), math.sin(t1)
        turned = np.array([[c, s, 0.0], [-c1 * s, c1 * c, s1], [s1 * s, -s1 * c, c1]])
        axis, (x, y, _) = turned @ rotation[:, 2], turned @ point - [arm.ideal.a[0], 0.0, 0.0]
        bend = (ca * cb - axis[2]) / (sa * sb)
        for sine in (math.sqrt(max(1.0 - bend**2, 0.0)), -math.sqrt(max(1.0 - bend**2, 0.0))):
            phi = math.atan2(axis[1], axis[0]) - math.atan2(-(ca * sb * bend + sa * cb), sb * sine)
            # From axis 4 to the point where axes 5 and 6 meet, before the turn phi.
            yield abs(complex(x, y) - complex(arm.ideal.a[3], -sa * arm.ideal.d[3]) * cmath.exp(1j * phi))
