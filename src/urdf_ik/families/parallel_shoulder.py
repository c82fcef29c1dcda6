"""Six revolute joints whose axes 1, 2 and 3 are parallel; seen from the tip, those whose axes 4, 5 and 6 are."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from urdf_ik._core import Solver
from urdf_ik.families.parts.plan import (
    SIGNS,
    Plan,
    cheapest,
    compared,
    distances_of,
    ideal_frames,
    ideal_values,
    imperfection,
    method_in_words,
    seen_in_frame_1,
    straightened,
    written_values,
)

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from urdf_ik.chain import Chain
    from urdf_ik.structure import Structure

    Array = NDArray[np.float64]

_NAMES = tuple(
    f"wrist {front}, elbow {up}, {flip}"
    for front in ("front", "back")
    for up in ("up", "down")
    for flip in ("noflip", "flip")
)
_ROOTS = tuple(
    f"position {root}, elbow {up}" for first in (1, 3) for up in ("up", "down") for root in (first, first + 1)
)
# Distance of axes 4 and 5 [of the arm's size] that can be divided by.
_CLEAR = 1e-4
_PLANAR = "the rest is a planar arm"
_STEPS = {
    "5x6": f"joint 4 by the height along axes 1 to 3, joint 6 by the tilt of axis 5 to them, {_PLANAR}",
    "5||6": f"joint 4 by the tilt of axes 5 and 6 to axes 1 to 3, joint 6 by the height along these, {_PLANAR}",
    "4x5": f"joint 6 by the height along axes 1 to 3, joint 4 by the tilt of axis 5 to them, {_PLANAR}",
    "4||5": f"joint 6 by the tilt of axes 4 and 5 to axes 1 to 3, joint 4 by the height along these, {_PLANAR}",
    "": f"a quartic in joint 6 from height and tilt along axes 1 to 3, {_PLANAR}",
}


def matches(structure: Structure) -> bool:
    """Whether axes 1, 2 and 3 of a 6R arm are parallel, and neither the wrist nor a pair of axes is degenerate.

    A fourth parallel axis, three wrist axes that are parallel or meet, and two axes in one line make the arm
    singular everywhere.
    """
    return (
        len(structure.joint_types) == 6
        and "prismatic" not in structure.joint_types
        and structure.triple(1, "parallel") is not None
        and not structure.is_parallel(3)
        and structure.triple(4, "parallel") is None
        and structure.triple(4, "meet") is None
        and all(pair.relation != "coincident" for pair in structure.pairs)
    )


def prepare(structure: Structure, chain: Chain) -> Plan:
    """Parameters of the nearest arm of this family, for the cheapest wrist that it has exactly, or has nearly."""
    relations = {
        "5x6": structure.is_intersecting(5),
        "5||6": structure.is_parallel(5),
        "4x5": structure.is_intersecting(4),
        "4||5": structure.is_parallel(4),
        # An offset to divide by.
        "": not structure.is_parallel(4) and structure.pairs[3].distance > _CLEAR * chain.size,
    }
    return cheapest(_with_wrist(structure, chain, wrist) for wrist, holds in relations.items() if holds)


def _with_wrist(structure: Structure, chain: Chain, wrist: str) -> Plan:
    directions, parallel = straightened(structure, chain.H)
    meet = [False, False, False, wrist == "4x5", wrist == "5x6"]
    frames, error = ideal_frames(chain, directions, chain.points, parallel, meet)
    ideal = ideal_values(frames, error, SIGNS, chain.size)
    values = {"ideal": ideal, "written": written_values(chain)}
    solver = Solver(f"parallel shoulder, {wrist or 'general wrist'}", values)
    pairs = [i for i, holds in enumerate(parallel, start=1) if holds]
    return Plan(
        family=f"6R 1||2||3 and {wrist}" if wrist else "6R 1||2||3",
        method=method_in_words(_STEPS[wrist], error),
        branches=_NAMES if wrist else _ROOTS,
        imperfection=imperfection(structure, pairs, [i for i, holds in enumerate(meet, start=1) if holds]),
        error=error,
        solver=solver,
        explain=seen_in_frame_1(ideal, lambda rotation, point: _explain(ideal, solver, rotation, point)),
        by_quartic=not wrist,
    )


def _explain(ideal: dict[str, Any], solver: Solver, rotation: Array, point: Array) -> str:
    a, d, ca, sa = (ideal[name] for name in ("a", "d", "cos_alpha", "sin_alpha"))
    shortest, longest = abs(a[0] - a[1]), a[0] + a[1]
    # Height of the last axis above axis 4's foot, along axis 3.
    level = ca[0] * ca[1] * point[2] - d[1] - ca[2] * d[2]
    across = float(np.hypot(rotation[2, 0], rotation[2, 1]))
    links = abs(a[3] * sa[2]) + abs(d[3]) + a[4] * across
    if abs(level) > links:
        far, reach = compared(abs(level), links)
        return (
            f"along axes 1 to 3, axis 6 would have to be {far} m from axis 4, and the links between them reach no "
            f"further than {reach} m in the wanted direction"
        )
    distances = distances_of(solver, rotation, point)
    if len(distances) and distances.min() > longest:
        far, reach = compared(distances.min(), longest)
        return f"axis 3 would have to be {far} m or more from axis 1, reach {reach} m"
    if len(distances) and distances.max() < shortest:
        near, folded = compared(distances.max(), shortest)
        return f"axis 3 would be {near} m or less from axis 1, the folded links' {folded} m away"
    if len(distances):
        return (
            f"axis 3 would be {distances.min():.6g} to {distances.max():.6g} m from axis 1, "
            f"reach {shortest:.6g} to {longest:.6g} m"
        )
    return "no turns of joints 4 and 6 give the last axis both its direction and its height along axes 1 to 3"
