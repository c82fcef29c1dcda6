"""Six revolute joints whose last three axes meet in a point (Pieper 1968)."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np

from urdf_ik.ik.families.parts.explanations import beyond_links, beyond_reach, closed_form, compared, too_far
from urdf_ik.ik.families.parts.family import Family, FamilyMember
from urdf_ik.ik.families.parts.ideal import (
    LITTLE,
    NAMES,
    ClosedFormArm,
    IdealFrames,
    ideal_arm,
    ideal_frames,
    imperfection,
    mean_direction,
)
from urdf_ik.ik.families.parts.written import written
from urdf_ik.kinematics.chain import Chain
from urdf_ik.kinematics.dh.frames import DHFrames
from urdf_ik.kinematics.structure import Structure
from urdf_ik.support.tolerances import DEFAULT
from urdf_ik.typing import Array

# An offset [of the arm's size] or an angle [rad] that can be divided by.
_CLEAR = 3e-3
_FLIPS = "then the wrist"


@dataclass(frozen=True, kw_only=True, eq=False)
class SphericalWristArm(ClosedFormArm):
    """An arm with a spherical wrist: ``SphericalWristArm`` of the core.

    Attributes:
        variant: how axes 1 to 3 lie: '2||3', '1x2', '1||2' or 'general'.
        centre: (3,) m, of the wrist in frame 3.
        rho: m, distance of the wrist's centre from axis 3.
        cos_phi: of the direction from axis 3 to the wrist's centre.
        sin_phi: of the same.
        height: m, of the wrist's centre along axis 2; '2||3' only.
        bend_offset: rad, the elbow's bend less joint 3's value; '2||3' only.
        swing: (2,) factor and constant of the equation for joint 3; '1x2' and '1||2' only.
        square_wrist: whether both twists of the wrist are right angles.
    """

    kind: ClassVar = "spherical wrist"
    centre: Array
    rho: float
    cos_phi: float
    sin_phi: float
    height: float
    bend_offset: float
    swing: Array
    square_wrist: bool


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
    shoulder = family.variant
    wrist = structure.triple(4, "meet")
    directions, points = chain.H.copy(), chain.points.copy()
    if wrist is not None and wrist.point is not None:
        points[3:] = wrist.point
    parallel, meet = [False] * 5, [False, False, False, True, True]
    pairs = []
    if shoulder in ("2||3", "1||2"):
        first = int(shoulder[0])
        pairs.append(first)
        directions[first - 1 : first + 1] = mean_direction(directions[first - 1 : first + 1])
        parallel[first - 1] = True
    # With 2 || 3 an offset between axes 1 and 2 costs nothing, so what nearly meets need not be made to.
    crossing = structure.is_intersecting(1) and structure.pairs[0].off_distance < 1e-12 * chain.size
    meet[0] = crossing or shoulder == "1x2"
    frames, error = ideal_frames(chain, directions, points, parallel, meet)
    angle, distance = imperfection(structure, pairs, [1] if shoulder == "1x2" else [])
    ideal = ideal_arm(frames, error, chain)
    arm = _arm(chain, ideal, shoulder, _front(chain, frames, points[3]))
    if arm is None:
        return None
    off = angle, max(distance, wrist.imperfection if wrist else 0.0)
    plan = closed_form(family, chain, arm, error, off, lambda _, rotation, point: _explain(arm, rotation, point))
    return replace(plan, name=f"{plan.name} and 1x2") if shoulder == "2||3" and crossing else plan


TWO_PARALLEL = Family(
    name="6R spherical wrist, 2||3",
    reason="axes {4, 5, 6} meet in a point, and axes {2, 3} are parallel",
    steps=f"wrist centre first: joint 1 by the plane it lies in, elbow by the law of cosines; {_FLIPS}",
    branches=NAMES,
    by_quadratics=True,
    matches=lambda structure, chain: _matches(structure) and structure.is_parallel(2),
    prepare=_prepare,
    variant="2||3",
)
FIRST_PARALLEL = Family(
    name="6R spherical wrist, 1||2",
    reason="axes {4, 5, 6} meet in a point, and axes {1, 2} are parallel",
    steps=f"wrist centre first: joint 3 by its height, joints 1 and 2 in the plane; {_FLIPS}",
    branches=NAMES,
    by_quadratics=True,
    matches=lambda structure, chain: _matches(structure) and structure.is_parallel(1),
    prepare=_prepare,
    variant="1||2",
)
CROSSING = Family(
    name="6R spherical wrist, 1x2",
    reason="axes {4, 5, 6} meet in a point, and axes {1, 2} meet",
    steps=f"wrist centre first: joint 3 by its distance, joints 2 and 1 by its height; {_FLIPS}",
    branches=NAMES,
    by_quadratics=True,
    matches=lambda structure, chain: _matches(structure) and structure.is_intersecting(1) and _oblique(structure),
    prepare=_prepare,
    variant="1x2",
)
GENERAL = Family(
    name="6R spherical wrist, general shoulder",
    reason="axes {4, 5, 6} meet in a point",
    steps=f"wrist centre first, by a quartic in joint 3; {_FLIPS}",
    branches=tuple(f"position {k}, wrist {flip}" for k in (1, 2, 3, 4) for flip in ("noflip", "flip")),
    by_quadratics=False,
    matches=lambda structure, chain: _matches(structure) and _oblique(structure) and _has_no_other(structure, chain),
    prepare=_prepare,
    variant="general",
)


def _front(chain: Chain, frames: DHFrames, centre: Array) -> float:
    """1 where frame 1's x points to the arm's front, else -1.

    The front is where the shoulder's offset puts axis 2; without one, where the wrist is at q = 0; if that is on
    axis 1, where a positive turn of joint 2 leans the arm. What a calibration may have put there is no offset.
    """
    if frames.a[0] > LITTLE * chain.size:
        return 1.0
    x = frames.base[:3, 0]
    ahead = float((centre - frames.base[:3, 3]) @ x)
    if abs(ahead) < LITTLE * chain.size:
        ahead = float(np.cross(chain.H[1], chain.H[0]) @ x)
    return 1.0 if ahead > 0.0 else -1.0


def _arm(chain: Chain, ideal: IdealFrames, shoulder: str, ahead: float) -> SphericalWristArm | None:
    """The arm for the compiled solver; ``ahead``: side of x that is the front.

    None where the equation for joint 3 does not depend on joint 3: the wrist lies on axis 3, or axis 2 meets both its
    neighbours where axis 1 does.
    """
    a, d, ca, sa = ideal.a, ideal.d, ideal.cos_alpha, ideal.sin_alpha
    centre = np.array([a[2], -sa[2] * d[2], ca[2] * d[2]])
    rho, phi = math.hypot(centre[0], centre[1]), math.atan2(centre[1], centre[0])
    cos_phi, sin_phi = math.cos(phi), math.sin(phi)
    level, height, bend_offset, swing = centre[2] + d[1], 0.0, 0.0, np.zeros(2)
    signs = ideal.signs.copy()
    if shoulder == "2||3":
        height = d[0] + ca[1] * level
        bend_offset = math.remainder(phi + ideal.offset[2], 2.0 * math.pi)
        signs[0] *= ahead
        # The elbow is up where it lies above the line from shoulder to wrist, seen along axis 1.
        signs[1] *= -ca[1] * np.sign(sa[0]) * signs[0]
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
    return SphericalWristArm(
        variant=shoulder,
        ideal=replace(ideal, signs=signs),
        written=written(chain),
        centre=centre,
        rho=rho,
        cos_phi=cos_phi,
        sin_phi=sin_phi,
        height=float(height),
        bend_offset=bend_offset,
        swing=swing,
        square_wrist=bool((ca[3:5] == 0.0).all()),
    )


def _explain(arm: SphericalWristArm, rotation: Array, point: Array) -> str:
    ideal, rho, shoulder, (swing, shift) = arm.ideal, arm.rho, arm.variant, arm.swing
    a, ca, sa, size = ideal.a, ideal.cos_alpha[0], ideal.sin_alpha[0], ideal.size
    if shoulder == "2||3":
        height = arm.height
        up = (point[2] - ca * height) / sa
        side = ca * up - sa * height
        radius = math.hypot(point[0], point[1])
        if radius < abs(side):
            near, off = compared(radius, abs(side))
            return (
                f"the wrist centre is {near} m from axis 1, and joints 2 and 3 cannot bring it closer than {off} m"
                f"{too_far(radius, abs(side), math.inf)}"
            )
        ahead = math.sqrt(radius**2 - side**2)
        reach = [math.hypot(sign * ahead - a[0], up) for sign in (1.0, -1.0)]
        what = "wrist centre {} m from the shoulder (axis 2)"
        if why := beyond_reach(what, np.array(reach), abs(a[1] - rho), a[1] + rho):
            return why
    elif shoulder in ("1x2", "1||2"):
        square = float(point @ point) if shoulder == "1x2" else ca * point[2]
        if abs(square * swing + shift) > 1.0:
            low, high = sorted(((-1.0 - shift) / swing, (1.0 - shift) / swing))
            if shoulder == "1x2":
                low, high = math.sqrt(max(low, 0.0)), math.sqrt(max(high, 0.0))
                at, least, most = compared(math.sqrt(square), low, high)
                off = too_far(math.sqrt(square), low, high)
                return (
                    f"wrist centre {at} m from the shoulder (where axes 1 and 2 meet), reach {least} to {most} m{off}"
                )
            at, least, most = compared(square, low, high)
            return f"wrist centre at {at} m along axis 1, which joint 3 moves from {least} to {most} m"
    distance = float(np.linalg.norm(point))
    if distance > 2.0 * size:
        return beyond_links("the wrist centre", distance, size)
    return ""
