"""Six revolute joints whose axes 2, 3 and 4 are parallel, as Universal Robots builds them."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from urdf_ik._core import Solver
from urdf_ik._kernels import layout
from urdf_ik._kernels import three_parallel as kernels
from urdf_ik.families.plan import (
    NAMES,
    SIGNS,
    Plan,
    distances_of,
    ideal_frames,
    ideal_values,
    imperfection,
    mean_direction,
    method_in_words,
    pack,
    written_values,
)

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from urdf_ik.chain import Chain
    from urdf_ik.structure import Structure

    Array = NDArray[np.float64]

_ROOTS = tuple(
    f"position {root}, elbow {up}" for first in (1, 3) for up in ("up", "down") for root in (first, first + 1)
)


def matches(structure: Structure) -> bool:
    """Whether axes 2, 3 and 4 of a 6R arm are parallel, and neither axis 1 nor axis 5 is parallel to them."""
    return (
        len(structure.joint_types) == 6
        and "prismatic" not in structure.joint_types
        and structure.triple(2, "parallel") is not None
        and structure.triple(1, "parallel") is None
        and structure.triple(3, "parallel") is None
        and not structure.is_parallel(5)
        and structure.pairs[1].relation != "coincident"
        and structure.pairs[2].relation != "coincident"
    )


def prepare(structure: Structure, chain: Chain) -> Plan:
    """Parameters of the nearest arm with three parallel axes, whose axes 5 and 6 meet or do not."""
    crossing = structure.is_intersecting(5)
    parallel = structure.triple(2, "parallel")
    directions, points = chain.H.copy(), chain.points.copy()
    directions[1:4] = mean_direction(directions[1:4])
    meet = [False, False, False, False, crossing]
    frames, error = ideal_frames(chain, directions, points, [False, True, True, False, False], meet)
    arm = pack(chain, frames, error, SIGNS)
    ca, sa = arm[layout.COS_ALPHA : layout.COS_ALPHA + 5], arm[layout.SIN_ALPHA : layout.SIN_ALPHA + 5]
    d = arm[layout.D : layout.D + 4]
    turn_3, turn_4 = ca[1], ca[1] * ca[2]
    arm[layout.ALONG] = d[0] + turn_3 * d[1] + turn_4 * (d[2] + ca[3] * d[3])
    arm[layout.TURN_3], arm[layout.TURN_4] = turn_3, turn_4
    arm[layout.COS_FIRST], arm[layout.SIN_FIRST] = turn_4 * ca[3], turn_4 * sa[3]
    _, distance = imperfection(structure, [], [5] if crossing else [])
    steps = (
        "height along the parallel axes gives joint 1, the last axis joint 5 and joint 6, the rest is a planar arm"
        if crossing
        else "a quartic in joint 1 from height and direction along the parallel axes, the rest is a planar arm"
    )
    values = {
        "ideal": ideal_values(frames, error, SIGNS, chain.size),
        "written": written_values(chain),
        "along": float(arm[layout.ALONG]),
        "turn_3": float(turn_3),
        "turn_4": float(turn_4),
        "cos_first": float(arm[layout.COS_FIRST]),
        "sin_first": float(arm[layout.SIN_FIRST]),
        "square_wrist": bool(crossing and arm[layout.COS_FIRST] == 0.0 and ca[4] == 0.0),
    }
    solver = Solver(f"three parallel axes, {'5x6' if crossing else 'general hand'}", values)
    return Plan(
        family="6R 2||3||4 and 5x6" if crossing else "6R 2||3||4",
        method=method_in_words(steps, error),
        branches=NAMES if crossing else _ROOTS,
        imperfection=(parallel.imperfection if parallel else 0.0, distance),
        error=error,
        arm=arm,
        solve=kernels.solve_intersecting_56 if crossing else kernels.solve_general_wrist,
        explain=lambda rotation, point: _explain(arm, solver, crossing, rotation, point),
        by_quartic=not crossing,
        solver=solver,
    )


def _explain(arm: Array, solver: Solver, crossing: bool, rotation: Array, point: Array) -> str:
    if crossing:
        side = (arm[layout.COS_ALPHA] * point[2] - arm[layout.ALONG]) / arm[layout.SIN_ALPHA]
        radius = math.hypot(point[0], point[1])
        if radius < abs(side):
            return (
                f"the point where axes 5 and 6 meet is {radius:.6g} m from axis 1, and the arm's sideways offset "
                f"keeps it {abs(side):.6g} m away"
            )
    distances = distances_of(solver, rotation, point)
    longest = arm[layout.A + 1] + arm[layout.A + 2]
    shortest = abs(arm[layout.A + 1] - arm[layout.A + 2])
    if len(distances) and distances.min() > longest:
        return f"axis 4 would have to be {distances.min():.6g} m or more from axis 2, reach {longest:.6g} m"
    if len(distances) and distances.max() < shortest:
        return f"axis 4 would be {distances.max():.6g} m or less from axis 2, the folded links' {shortest:.6g} m away"
    return "no turn of joint 1 gives the last axis both its direction and its height along axes 2 to 4"
