"""Six revolute joints whose axes 2, 3 and 4 meet in a point; seen from the tip, those whose axes 3, 4 and 5 do."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from urdf_ik.ik.families.parts.explanations import beyond_links, closed_form, compared, too_far
from urdf_ik.ik.families.parts.family import Family, FamilyMember
from urdf_ik.ik.families.parts.ideal import (
    ClosedFormArm,
    ideal_arm,
    ideal_frames,
    imperfection,
    straightened,
)
from urdf_ik.ik.families.parts.written import written
from urdf_ik.kinematics.chain import Chain
from urdf_ik.kinematics.structure import Structure
from urdf_ik.typing import Array

_NAMES = tuple(
    f"shoulder {front}, wrist {up}, {flip}"
    for front in ("front", "back")
    for up in ("up", "down")
    for flip in ("noflip", "flip")
)
_MIDDLE = "then joints 2 to 4 like a wrist"
_CENTRE = "where axes 2 to 4 meet is"


@dataclass(frozen=True, kw_only=True, eq=False)
class _SphericalMiddleArm(ClosedFormArm):
    """An arm whose axes 2, 3 and 4 meet in a point: ``SphericalMiddleArm`` of the core.

    Attributes:
        variant: how axes 5 and 6 lie: '5x6', '5||6' or 'general'.
        centre: (3,) m, where axes 2, 3 and 4 meet, in frame 1.
        centre_5: (3,) m, the same in frame 5 before joint 5 turns.
    """

    kind: ClassVar = "spherical middle"
    centre: Array
    centre_5: Array


def _matches(structure: Structure) -> bool:
    """Whether axes 2, 3 and 4 of a 6R arm meet, and neither axis 1 nor axis 5 in the same point.

    A fourth axis there and two axes in one line make the arm singular everywhere.
    """
    return (
        structure.is_6r
        and structure.triple(2, "meet") is not None
        and structure.triple(1, "meet") is None
        and structure.triple(3, "meet") is None
        and all(pair.relation != "coincident" for pair in structure.pairs)
    )


def _prepare(family: Family, structure: Structure, chain: Chain) -> FamilyMember:
    """Parameters of the nearest arm with a spherical middle and this wrist."""
    wrist = family.variant
    middle = structure.triple(2, "meet")
    directions, parallel = straightened(structure, chain.H)
    points = chain.points.copy()
    if middle is not None and middle.point is not None:
        points[1:4] = middle.point
    frames, error = ideal_frames(chain, directions, points, parallel, [False, True, True, False, wrist == "5x6"])
    ideal = ideal_arm(frames, error, chain)
    a, d, ca, sa = ideal.a, ideal.d, ideal.cos_alpha, ideal.sin_alpha
    arm = _SphericalMiddleArm(
        variant=wrist,
        ideal=ideal,
        written=written(chain),
        centre=np.array([a[0], -sa[0] * d[0], ca[0] * d[0]]),
        centre_5=np.array([-a[3], -sa[3] * d[2], -ca[3] * d[2] - d[3]]),
    )
    pairs = [i for i, holds in enumerate(parallel, start=1) if holds]
    angle, distance = imperfection(structure, pairs, [5] if wrist == "5x6" else [])
    off = angle, max(distance, middle.imperfection if middle else 0.0)
    return closed_form(family, chain, arm, error, off, lambda _, rotation, point: _explain(arm, rotation, point))


CROSSING = Family(
    name="6R 2x3x4 and 5x6",
    reason="axes {2, 3, 4} meet in a point, and axes {5, 6} meet",
    steps=f"{_CENTRE} at a known distance from where 5 and 6 do: joint 1, joints 5 and 6, {_MIDDLE}",
    branches=_NAMES,
    by_quadratics=True,
    matches=lambda structure, chain: _matches(structure) and structure.pairs[4].relation == "intersecting",
    prepare=_prepare,
    variant="5x6",
)
PARALLEL = Family(
    name="6R 2x3x4 and 5||6",
    reason="axes {2, 3, 4} meet in a point, and axes {5, 6} are parallel",
    steps=f"{_CENTRE} in a known plane across axes 5 and 6: joint 1, a planar arm, {_MIDDLE}",
    branches=_NAMES,
    by_quadratics=True,
    matches=lambda structure, chain: _matches(structure) and structure.pairs[4].relation == "parallel",
    prepare=_prepare,
    variant="5||6",
)
GENERAL = Family(
    name="6R 2x3x4",
    reason="axes {2, 3, 4} meet in a point",
    steps=f"{_CENTRE} on a circle about axis 1 and on a torus about axes 5 and 6: a quartic in joint 1, {_MIDDLE}",
    branches=tuple(f"position {k}, {flip}" for k in (1, 2, 3, 4) for flip in ("noflip", "flip")),
    by_quadratics=False,
    matches=lambda structure, chain: _matches(structure) and structure.pairs[4].relation == "skew",
    prepare=_prepare,
    variant="general",
)


def _explain(arm: _SphericalMiddleArm, rotation: Array, point: Array) -> str:
    centre, centre_5, size = arm.centre, arm.centre_5, arm.ideal.size
    name = "the point where axes 2 to 4 meet"
    radius, up = math.hypot(centre[0], centre[1]), centre[2] - point[2]
    if arm.variant == "5x6":
        wanted = float(np.linalg.norm(centre_5))
        across = math.hypot(point[0], point[1])
        low, high = math.hypot(across - radius, up), math.hypot(across + radius, up)
        if not low <= wanted <= high:
            at, least, most = compared(wanted, low, high)
            off = too_far(wanted, low, high)
            return (
                f"{name} is {at} m from where axes 5 and 6 meet, and joint 1 can bring it {least} to {most} m near{off}"
            )
    if arm.variant == "5||6":
        axis = rotation[:, 2]
        level, swing = float(axis @ [-point[0], -point[1], up]), radius * math.hypot(axis[0], axis[1])
        low, high = level - swing, level + swing
        wanted = arm.ideal.cos_alpha[4] * centre_5[2]
        if not low <= wanted <= high:
            at, least, most = compared(wanted, low, high)
            return (
                f"{name} is {at} m along axis 6 from the origin of its frame, and joint 1 can bring it to {least} to "
                f"{most} m"
            )
    far = float(np.linalg.norm(point))
    if far > 2.0 * size:
        return beyond_links("axis 6", far, size)
    return ""
