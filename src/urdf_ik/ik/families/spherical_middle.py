"""Six revolute joints whose axes 2, 3 and 4 meet in a point; seen from the tip, those whose axes 3, 4 and 5 do."""

from typing import Any

import numpy as np

from urdf_ik.ik.families.parts.family import Family, FamilyMember
from urdf_ik.ik.families.parts.ideal import Variant, closed_form, eight, families
from urdf_ik.ik.families.parts.written import Numbers
from urdf_ik.kinematics.chain import Chain
from urdf_ik.kinematics.structure import Structure


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

    return closed_form(family, structure, chain, "spherical middle", (2, "meet"), meet, numbers)


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
