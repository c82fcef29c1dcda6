"""What is known of an arm's structure, in plain English: why it is solved so, how far it is off, whether cuspidal."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from urdf_ik.structure.axes import Structure

_KINDS = {"revolute": "R", "continuous": "R", "prismatic": "P"}
# What a family rests on, by how its name begins and whether it is seen from the tip.
_GROUNDS = {
    ("6R spherical wrist", False): "axes 4, 5 and 6 meet in a point",
    ("6R spherical wrist", True): "axes 1, 2 and 3 meet in a point",
    ("6R 2||3||4", False): "axes 2, 3 and 4 are parallel",
    ("6R 2||3||4", True): "axes 3, 4 and 5 are parallel",
}


def in_sentences(structure: Structure) -> str:
    """Everything, one sentence after the other."""
    kinds = "".join(_KINDS[kind] for kind in structure.joint_types)
    name = f"{len(structure.joint_types)} joints ({kinds})"
    sentences = [f"{name}: {structure.family}" if structure.family else f"{name}, of no family that is solved here"]
    sentences.append("; ".join([*map(str, structure.triples), *map(str, structure.pairs)]))
    if structure.family:
        # The relations just told say why, unless there are none that help.
        sentences += [why(structure) if structure.is_general else "", structure.method, solutions(structure)]
        sentences.append(f"imperfection: {imperfection(structure)}")
    if structure.cuspidal is not None:
        sentences.append(f"cuspidal: {cuspidal(structure)}")
    return " ".join(f"{text[0].upper()}{text[1:]}." for text in sentences if text)


def why(structure: Structure) -> str:
    """The relations that decided for the solver; '' where its family says it all."""
    if structure.is_general:
        if not structure.triples:
            return "no three neighbouring axes meet in a point or are parallel, so no closed form applies"
        return f"{' and '.join(map(str, structure.triples))}, but no closed form applies to these six axes"
    back = structure.family.endswith(", reversed")
    for (start, mirrored), ground in _GROUNDS.items():
        if structure.family.startswith(start) and mirrored == back:
            return ground if structure.is_exact else f"{ground}, exactly or nearly"
    return ""


def solutions(structure: Structure) -> str:
    """How many there can be, and how the columns are counted."""
    further = sum(name.startswith("further ") for name in structure.branches)
    most = f"up to {structure.max_solutions} solutions"
    if not further:
        return most
    ideal = structure.max_solutions - further
    return f"{most}: {ideal} next to those of the ideal arm, and {further} that only the arm as written can have"


def imperfection(structure: Structure) -> str:
    """How far the URDF as written is off its family, and what is done about it."""
    if structure.is_general:
        return "none, since no relation between the axes is made use of; solutions are verified on the URDF as written"
    if structure.is_exact:
        return "none: the URDF as written is of this family, exact to rounding"
    angle, distance = structure.imperfection
    off = f"the URDF as written is {angle:.2g} rad and {distance:.2g} m off this family"
    if max(angle, distance) == 0.0:
        off = f"the URDF as written is off this family by {structure.error:.1g} of its size"
    return f"{off}; the ideal arm gives starting points only, and solutions are verified on the URDF as written"


def cuspidal(structure: Structure) -> str:
    """Whether it changes solution without crossing a singularity, after "cuspidal"."""
    if structure.cuspidal is None:
        return "not known: no change of solution around the singularities was found, which does not rule one out"
    if structure.cuspidal:
        return "yes: limits aside, it can change from one solution of a pose to another without crossing a singularity"
    return "no: every change from one solution of a pose to another crosses a singularity"
