"""Six revolute joints whose axes 2, 3 and 4 meet in a point; seen from the tip, those whose axes 3, 4 and 5 do."""

import math
from typing import Any

import numpy as np

from urdf_ik._core import Solver
from urdf_ik.ik.families.parts.explanations import beyond_links, outside
from urdf_ik.ik.families.parts.family import Family, FamilyMember
from urdf_ik.ik.families.parts.ideal import Variant, closed_form, eight, families
from urdf_ik.ik.families.parts.written import Numbers
from urdf_ik.kinematics.chain import Chain
from urdf_ik.kinematics.structure import Structure
from urdf_ik.typing import Array


def _matches(structure: Structure) -> bool:
    """Whether axes 2, 3 and 4 of a 6R arm meet, and neither axis 1 nor axis 5 in the same point."""
    return (
        structure.is_6r
        and structure.triple(2, "meet") is not None
        and structure.triple(1, "meet") is None
        and structure.triple(3, "meet") is None
        and all(pair.relation != "coincident" for pair in structure.pairs)
    )


def _prepare(family: Family, structure: Structure, chain: Chain) -> FamilyMember | None:
    """Parameters of the nearest arm with a spherical middle and this wrist."""
    meet = [5] if family.variant == "5x6" else []

    def numbers(ideal: Numbers) -> dict[str, Any]:
        a, d, ca, sa = ideal.a, ideal.d, ideal.cos_alpha, ideal.sin_alpha
        return {
            "centre": np.array([a[0], -sa[0] * d[0], ca[0] * d[0]]),
            "centre_5": np.array([-a[3], -sa[3] * d[2], -ca[3] * d[2] - d[3]]),
        }

    return closed_form(family, structure, chain, "spherical middle", (2, "meet"), meet, numbers, _explain)


_NAMES = eight("shoulder {}, wrist {}, {}")
_CENTRE, _MIDDLE = "where axes 2 to 4 meet is", "then joints 2 to 4 like a wrist"
FAMILIES = families(
    "6R 2x3x4",
    "axes {2, 3, 4} meet in a point",
    _matches,
    _prepare,
    [
        Variant(
            "5x6",
            " and 5x6",
            ", and axes {5, 6} meet",
            f"{_CENTRE} at a known distance from where 5 and 6 do: joint 1, joints 5 and 6, {_MIDDLE}",
            lambda structure, chain: structure.pairs[4].relation == "intersecting",
            _NAMES,
        ),
        Variant(
            "5||6",
            " and 5||6",
            ", and axes {5, 6} are parallel",
            f"{_CENTRE} in a known plane across axes 5 and 6: joint 1, a planar arm, {_MIDDLE}",
            lambda structure, chain: structure.pairs[4].relation == "parallel",
            _NAMES,
        ),
        Variant(
            "general",
            "",
            "",
            f"{_CENTRE} on a circle about axis 1 and on a torus about axes 5 and 6: a quartic in joint 1, {_MIDDLE}",
            lambda structure, chain: structure.pairs[4].relation == "skew",
            tuple(f"position {k}, {flip}" for k in (1, 2, 3, 4) for flip in ("noflip", "flip")),
            by_quadratics=False,
        ),
    ],
)


def _explain(arm: Numbers, solver: Solver, rotation: Array, point: Array) -> str:
    centre, centre_5, size = arm.centre, arm.centre_5, arm.ideal.size
    name = "the point where axes 2 to 4 meet"
    radius, up = math.hypot(centre[0], centre[1]), centre[2] - point[2]
    why = ""
    if arm.variant == "5x6":
        across = math.hypot(point[0], point[1])
        low, high = math.hypot(across - radius, up), math.hypot(across + radius, up)
        text = "is {at} m from where axes 5 and 6 meet, and joint 1 can bring it {low} to {high} m near"
        why = outside(f"{name} {text}", float(np.linalg.norm(centre_5)), low, high)
    elif arm.variant == "5||6":
        axis = rotation[:, 2]
        level, swing = float(axis @ [-point[0], -point[1], up]), radius * math.hypot(axis[0], axis[1])
        text = "is {at} m along axis 6 from the origin of its frame, and joint 1 can bring it to {low} to {high} m"
        why = outside(f"{name} {text}", arm.ideal.cos_alpha[4] * centre_5[2], level - swing, level + swing)
    far = float(np.linalg.norm(point))
    return why or (beyond_links("axis 6", far, size) if far > 2.0 * size else "")
