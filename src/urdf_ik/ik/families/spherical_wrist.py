"""Six revolute joints whose last three axes meet in a point (Pieper 1968)."""

import math
from dataclasses import replace
from typing import Any

import numpy as np

from urdf_ik._core import Solver
from urdf_ik.ik.families.parts.explanations import beyond_reach, outside
from urdf_ik.ik.families.parts.family import Family, FamilyMember
from urdf_ik.ik.families.parts.ideal import LITTLE, Variant, closed_form, families
from urdf_ik.ik.families.parts.written import Numbers
from urdf_ik.kinematics.chain import Chain
from urdf_ik.kinematics.structure import Structure
from urdf_ik.support.tolerances import DEFAULT
from urdf_ik.typing import Array

# An offset [of the arm's size] or an angle [rad] that can be divided by.
_CLEAR = 3e-3


def _matches(structure: Structure) -> bool:
    """Whether axes 4, 5 and 6 of a 6R arm meet, and its position problem is not degenerate."""
    return (
        structure.is_6r
        and structure.triple(4, "meet") is not None
        and structure.triple(1, "meet") is None
        and structure.triple(1, "parallel") is None
        and not structure.is_parallel(3)
    )


def _oblique(structure: Structure) -> bool:
    """Whether the angle between axes 2 and 3 can be divided by."""
    return bool(np.sin(structure.pairs[1].angle) >= _CLEAR)


def _has_no_other(structure: Structure, chain: Chain) -> bool:
    """Whether the quartic is needed, or has a real offset and angle to divide by."""
    first = structure.pairs[0]
    kinds = structure.is_parallel(2) or structure.is_parallel(1) or structure.is_intersecting(1)
    return not kinds or (first.distance > _CLEAR * chain.size and bool(np.sin(first.angle) > _CLEAR))


def _prepare(family: Family, structure: Structure, chain: Chain) -> FamilyMember | None:
    """Parameters of the nearest arm with a spherical wrist and this shoulder; None where its wrist lies on axis 3."""
    shoulder, wrist = family.variant, structure.triple(4, "meet")
    # With 2 || 3 an offset between axes 1 and 2 costs nothing, so what nearly meets need not be made to.
    crossing = structure.is_intersecting(1) and structure.pairs[0].off_distance < 1e-12 * chain.size
    centre = chain.points[3] if wrist is None or wrist.point is None else wrist.point
    meet = [1] if crossing or shoulder == "1x2" else []

    def numbers(ideal: Numbers) -> dict[str, Any] | None:
        return _numbers(ideal, shoulder, _front(chain, ideal, centre))

    plan = closed_form(family, structure, chain, "spherical wrist", (4, "meet"), meet, numbers, _explain)
    if plan is not None and shoulder == "2||3" and crossing:
        return replace(plan, name=f"{plan.name} and 1x2")
    return plan


FAMILIES = TWO_PARALLEL, FIRST_PARALLEL, CROSSING, GENERAL = families(
    "6R spherical wrist",
    "axes {4, 5, 6} meet in a point",
    _matches,
    _prepare,
    [
        Variant(
            "2||3",
            ", 2||3",
            ", and axes {2, 3} are parallel",
            "wrist centre first: joint 1 by the plane it lies in, elbow by the law of cosines; then the wrist",
            lambda structure, chain: structure.is_parallel(2),
        ),
        Variant(
            "1||2",
            ", 1||2",
            ", and axes {1, 2} are parallel",
            "wrist centre first: joint 3 by its height, joints 1 and 2 in the plane; then the wrist",
            lambda structure, chain: structure.is_parallel(1),
        ),
        Variant(
            "1x2",
            ", 1x2",
            ", and axes {1, 2} meet",
            "wrist centre first: joint 3 by its distance, joints 2 and 1 by its height; then the wrist",
            lambda structure, chain: structure.is_intersecting(1) and _oblique(structure),
        ),
        Variant(
            "general",
            ", general shoulder",
            "",
            "wrist centre first, by a quartic in joint 3; then the wrist",
            lambda structure, chain: _oblique(structure) and _has_no_other(structure, chain),
            tuple(f"position {k}, wrist {flip}" for k in (1, 2, 3, 4) for flip in ("noflip", "flip")),
            by_quadratics=False,
        ),
    ],
)


def _front(chain: Chain, ideal: Numbers, centre: Array) -> float:
    """1 where frame 1's x points to the arm's front, else -1.

    The front is where the shoulder's offset puts axis 2; without one, where the wrist is at q = 0; if that is on
    axis 1, where a positive turn of joint 2 leans the arm. What a calibration may have put there is no offset.
    """
    if ideal.a[0] > LITTLE * chain.size:
        return 1.0
    x = ideal.base_rotation[0]
    ahead = float((centre - ideal.base_origin) @ x)
    if abs(ahead) < LITTLE * chain.size:
        ahead = float(np.cross(chain.H[1], chain.H[0]) @ x)
    return 1.0 if ahead > 0.0 else -1.0


def _numbers(ideal: Numbers, shoulder: str, ahead: float) -> dict[str, Any] | None:
    """What the solver takes beside the ideal arm; ``ahead``: side of x that is the front."""
    a, d, ca, sa = ideal.a, ideal.d, ideal.cos_alpha, ideal.sin_alpha
    centre = np.array([a[2], -sa[2] * d[2], ca[2] * d[2]])
    rho, phi = math.hypot(centre[0], centre[1]), math.atan2(centre[1], centre[0])
    cos_phi, sin_phi = math.cos(phi), math.sin(phi)
    level, height, bend_offset, swing = centre[2] + d[1], 0.0, 0.0, np.zeros(2)
    if shoulder == "2||3":
        height = d[0] + ca[1] * level
        bend_offset = math.remainder(phi + ideal.offset[2], 2.0 * math.pi)
        ideal.signs = ideal.signs.copy()
        ideal.signs[0] *= ahead
        # The elbow is up where it lies above the line from shoulder to wrist, seen along axis 1.
        ideal.signs[1] *= -ca[1] * np.sign(sa[0]) * ideal.signs[0]
    elif shoulder == "1x2":
        # |p|^2 = constant + 2 rho |(a2, d2 sin alpha2)| cos(t3 + phi - delta)
        x, y = a[1], d[0] * sa[1]
        size, delta = 2.0 * rho * math.hypot(x, y), math.atan2(y, x)
        if size <= DEFAULT.exact_structure * ideal.size**2:
            return None
        constant = a[1] ** 2 + d[0] ** 2 + rho**2 + level**2 + 2.0 * d[0] * ca[1] * level
        swing = np.array([1.0 / size, -constant / size])
        cos_phi, sin_phi = math.cos(delta - phi), math.sin(delta - phi)
    elif shoulder == "1||2":
        # cos(alpha1) p_z = d2 + sin(alpha2) rho sin(t3 + phi) + cos(alpha2) level
        size = sa[1] * rho
        if abs(size) <= DEFAULT.exact_structure * ideal.size:
            return None
        swing = np.array([1.0 / size, -(d[0] + ca[1] * level) / size])
    return {
        "centre": centre,
        "rho": rho,
        "cos_phi": cos_phi,
        "sin_phi": sin_phi,
        "height": float(height),
        "bend_offset": bend_offset,
        "swing": swing,
        "square_wrist": bool((ca[3:5] == 0.0).all()),
    }


def _explain(arm: Numbers, solver: Solver, rotation: Array, point: Array) -> str:
    """Which length does not fit where axes 2 and 3 are parallel; of other arms the nearest pose explains."""
    if arm.variant != "2||3":
        return ""
    ideal, rho = arm.ideal, arm.rho
    a, ca, sa = ideal.a, ideal.cos_alpha[0], ideal.sin_alpha[0]
    up = (point[2] - ca * arm.height) / sa
    side = ca * up - sa * arm.height
    radius = math.hypot(point[0], point[1])
    near = "the wrist centre is {at} m from axis 1, and joints 2 and 3 cannot bring it closer than {low} m"
    if why := outside(near, radius, abs(side)):
        return why
    ahead = math.sqrt(radius**2 - side**2)
    reach = np.array([math.hypot(sign * ahead - a[0], up) for sign in (1.0, -1.0)])
    return beyond_reach("wrist centre {at} m from the shoulder (axis 2)", reach, abs(a[1] - rho), a[1] + rho)
