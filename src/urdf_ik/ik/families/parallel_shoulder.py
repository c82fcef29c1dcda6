"""Six revolute joints whose axes 1, 2 and 3 are parallel; seen from the tip, those whose axes 4, 5 and 6 are."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import ClassVar

import numpy as np

from urdf_ik._core import Solver
from urdf_ik.ik.families.parts.explanations import closed_form, compared, distances_of, links_beyond_reach, too_far
from urdf_ik.ik.families.parts.family import Family, FamilyMember
from urdf_ik.ik.families.parts.ideal import (
    ClosedFormArm,
    IdealFrames,
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
    f"wrist {front}, elbow {up}, {flip}"
    for front in ("front", "back")
    for up in ("up", "down")
    for flip in ("noflip", "flip")
)
# Distance of axes 4 and 5 [of the arm's size] that can be divided by.
_CLEAR = 1e-4
_PLANAR = "the rest is a planar arm"


@dataclass(frozen=True, kw_only=True, eq=False)
class _ParallelShoulderArm(ClosedFormArm):
    """An arm whose axes 1, 2 and 3 are parallel: ``ParallelShoulderArm`` of the core.

    Attributes:
        variant: how the wrist's axes lie: '5x6', '5||6', '4x5', '4||5' or 'general'.
    """

    kind: ClassVar = "parallel shoulder"


def _matches(structure: Structure) -> bool:
    """Whether axes 1, 2 and 3 of a 6R arm are parallel, and neither the wrist nor a pair of axes is degenerate.

    A fourth parallel axis, three wrist axes that are parallel or meet, and two axes in one line make the arm
    singular everywhere.
    """
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


def _prepare(family: Family, structure: Structure, chain: Chain) -> FamilyMember:
    """Parameters of the nearest arm with a parallel shoulder and this wrist."""
    wrist = family.variant
    directions, parallel = straightened(structure, chain.H)
    meet = [False, False, False, wrist == "4x5", wrist == "5x6"]
    frames, error = ideal_frames(chain, directions, chain.points, parallel, meet)
    ideal = ideal_arm(frames, error, chain)
    arm = _ParallelShoulderArm(variant=wrist, ideal=ideal, written=written(chain))
    pairs = [i for i, holds in enumerate(parallel, start=1) if holds]
    off = imperfection(structure, pairs, [i for i, holds in enumerate(meet, start=1) if holds])
    return closed_form(family, chain, arm, error, off, partial(_explain, ideal))


def _with_wrist(wrist: str, relation: str, steps: str, holds: Callable[[Structure], bool]) -> Family:
    """The family of these arms whose wrist has a relation that makes every step a quadratic."""
    return Family(
        name=f"6R 1||2||3 and {wrist}",
        reason=f"axes {{1, 2, 3}} are parallel, and {relation}",
        steps=f"{steps}, {_PLANAR}",
        branches=_NAMES,
        by_quadratics=True,
        matches=lambda structure, chain: _matches(structure) and holds(structure),
        prepare=_prepare,
        variant=wrist,
    )


WITH_WRIST = (
    _with_wrist(
        "5x6",
        "axes {5, 6} meet",
        "joint 4 by the height along axes 1 to 3, joint 6 by the tilt of axis 5 to them",
        lambda structure: structure.is_intersecting(5),
    ),
    _with_wrist(
        "5||6",
        "axes {5, 6} are parallel",
        "joint 4 by the tilt of axes 5 and 6 to axes 1 to 3, joint 6 by the height along these",
        lambda structure: structure.is_parallel(5),
    ),
    _with_wrist(
        "4x5",
        "axes {4, 5} meet",
        "joint 6 by the height along axes 1 to 3, joint 4 by the tilt of axis 5 to them",
        lambda structure: structure.is_intersecting(4),
    ),
    _with_wrist(
        "4||5",
        "axes {4, 5} are parallel",
        "joint 6 by the tilt of axes 4 and 5 to axes 1 to 3, joint 4 by the height along these",
        lambda structure: structure.is_parallel(4),
    ),
)
GENERAL = Family(
    name="6R 1||2||3",
    reason="axes {1, 2, 3} are parallel",
    steps=f"a quartic in joint 6 from height and tilt along axes 1 to 3, {_PLANAR}",
    branches=tuple(
        f"position {root}, elbow {up}" for first in (1, 3) for up in ("up", "down") for root in (first, first + 1)
    ),
    by_quadratics=False,
    matches=lambda structure, chain: _matches(structure) and _has_offset(structure, chain),
    prepare=_prepare,
    variant="general",
)


def _explain(ideal: IdealFrames, solver: Solver, rotation: Array, point: Array) -> str:
    a, d, ca, sa = ideal.a, ideal.d, ideal.cos_alpha, ideal.sin_alpha
    shortest, longest = abs(a[0] - a[1]), a[0] + a[1]
    # Height of the last axis above axis 4's foot, along axis 3.
    level = ca[0] * ca[1] * point[2] - d[1] - ca[2] * d[2]
    across = float(np.hypot(rotation[2, 0], rotation[2, 1]))
    links = abs(a[3] * sa[2]) + abs(d[3]) + a[4] * across
    if abs(level) > links:
        far, reach = compared(abs(level), links)
        return (
            f"along axes 1 to 3, axis 6 would have to be {far} m from axis 4, and the links between them reach no "
            f"further than {reach} m in the wanted direction{too_far(abs(level), 0.0, links)}"
        )
    distances = distances_of(solver, rotation, point)
    if why := links_beyond_reach(("axis 3", "axis 1"), distances, shortest, longest):
        return why
    if len(distances):
        return (
            f"axis 3 would be {distances.min():.6g} to {distances.max():.6g} m from axis 1, "
            f"reach {shortest:.6g} to {longest:.6g} m"
        )
    return ""
