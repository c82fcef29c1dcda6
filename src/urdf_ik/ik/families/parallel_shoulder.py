"""Six revolute joints whose axes 1, 2 and 3 are parallel; seen from the tip, those whose axes 4, 5 and 6 are."""

from urdf_ik.ik.families.parts.family import Family, FamilyMember
from urdf_ik.ik.families.parts.ideal import POSITIONS, Variant, closed_form, eight, families
from urdf_ik.kinematics.chain import Chain
from urdf_ik.kinematics.structure import Structure

# Distance of axes 4 and 5 [of the arm's size] that can be divided by.
_CLEAR = 1e-4


def _matches(structure: Structure) -> bool:
    """Whether axes 1, 2 and 3 of a 6R arm are parallel, and neither the wrist nor a pair of axes is degenerate."""
    return (
        structure.is_6r
        and structure.triple(1, "parallel") is not None
        and not structure.is_parallel(3)
        and structure.triple(4, "parallel") is None
        and structure.triple(4, "meet") is None
        and all(pair.relation != "coincident" for pair in structure.pairs)
    )


def _has_offset(structure: Structure, chain: Chain) -> bool:
    """Whether axes 4 and 5 are as far apart as the quartic needs."""
    return not structure.is_parallel(4) and structure.pairs[3].distance > _CLEAR * chain.size


def _prepare(family: Family, structure: Structure, chain: Chain) -> FamilyMember | None:
    """Parameters of the nearest arm with a parallel shoulder and this wrist."""
    meet = {"4x5": [4], "5x6": [5]}.get(family.variant, [])

    kind = "parallel shoulder"
    return closed_form(family, structure, chain, kind, (1, "parallel"), meet, lambda ideal: {})


_PLANAR = "the rest is a planar arm"
_NAMES = eight("wrist {}, elbow {}, {}")
FAMILIES = families(
    "6R 1||2||3",
    "axes {1, 2, 3} are parallel",
    _matches,
    _prepare,
    [
        Variant(
            "5x6",
            " and 5x6",
            ", and axes {5, 6} meet",
            f"joint 4 by the height along axes 1 to 3, joint 6 by the tilt of axis 5 to them, {_PLANAR}",
            lambda structure, chain: structure.is_intersecting(5),
            _NAMES,
        ),
        Variant(
            "5||6",
            " and 5||6",
            ", and axes {5, 6} are parallel",
            f"joint 4 by the tilt of axes 5 and 6 to axes 1 to 3, joint 6 by the height along these, {_PLANAR}",
            lambda structure, chain: structure.is_parallel(5),
            _NAMES,
        ),
        Variant(
            "4x5",
            " and 4x5",
            ", and axes {4, 5} meet",
            f"joint 6 by the height along axes 1 to 3, joint 4 by the tilt of axis 5 to them, {_PLANAR}",
            lambda structure, chain: structure.is_intersecting(4),
            _NAMES,
        ),
        Variant(
            "4||5",
            " and 4||5",
            ", and axes {4, 5} are parallel",
            f"joint 6 by the tilt of axes 4 and 5 to axes 1 to 3, joint 4 by the height along these, {_PLANAR}",
            lambda structure, chain: structure.is_parallel(4),
            _NAMES,
        ),
        Variant(
            "general",
            "",
            "",
            f"a quartic in joint 6 from height and tilt along axes 1 to 3, {_PLANAR}",
            _has_offset,
            POSITIONS,
            by_quadratics=False,
        ),
    ],
)
