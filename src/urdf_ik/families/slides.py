"""Six joints with slides, in closed form: a spherical wrist behind any three joints, or three slides in any order.

The Stanford arm (RRPRRR), gantries with a wrist (PPPRRR), and so on. See _kernels/slides.py.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from urdf_ik._core import Solver
from urdf_ik._kernels import layout
from urdf_ik._kernels import slide_position as step
from urdf_ik._kernels import slides as kernels
from urdf_ik.families.few_joints import (
    POSE,
    Aim,
    Joint,
    columns,
    feet,
    is_redundant,
    kinds_of,
    pack_chain,
    step_values,
)
from urdf_ik.families.nearest import off_by
from urdf_ik.families.plan import Plan
from urdf_ik.tolerances import DEFAULT

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from urdf_ik.chain import Chain
    from urdf_ik.structure import Structure

    Array = NDArray[np.float64]


def matches(structure: Structure) -> bool:
    """Whether six joints have slides and end in three axes that meet, or have three slides."""
    slides = structure.joint_types.count("prismatic")
    if len(structure.joint_types) != 6 or slides == 0:
        return False
    return slides == 3 or structure.triple(4, "meet") is not None


def prepare(structure: Structure, chain: Chain) -> Plan | None:
    """The plan of such an arm; None where it is redundant."""
    if is_redundant(chain):
        return None
    wrist = structure.triple(4, "meet")
    if wrist is None or wrist.point is None or chain.prismatic.sum() == 3:
        return _three_slides(chain)
    return _wrist(chain, wrist.imperfection, wrist.point)


def _wrist(chain: Chain, off: float, centre: Array) -> Plan | None:
    most = 8 if chain.prismatic.sum() == 1 else 4
    error = off / chain.size
    arm = _pack(chain, np.arange(3, 6))
    if arm is None:
        return None
    exact = error <= DEFAULT.exact_structure
    arm[layout.IMPERFECTION] = 0.0 if exact else error
    arm[layout.CLAMP] = 0.0 if exact else 50.0 * error
    arm[kernels.BY_WRIST] = 1.0
    row = arm[kernels.STEP : kernels.STEP + step.LENGTH]
    points = chain.points[:3] / chain.size
    if not chain.prismatic[:2].any():
        points[:2] = feet(chain.H[0], points[0], chain.H[1], points[1])
    row[step.SLIDES : step.SLIDES + 3] = chain.prismatic[:3]
    row[step.DIRECTIONS : step.DIRECTIONS + 9] = chain.H[:3].ravel()
    row[step.POINTS : step.POINTS + 9] = points.ravel()
    row[step.POINT : step.POINT + 3] = centre / chain.size
    tip = chain.P.sum(axis=0)
    arm[kernels.IN_TIP : kernels.IN_TIP + 3] = chain.R_tip.T @ (centre - tip) / chain.size
    return Plan(
        family=f"{kinds_of(chain)} spherical wrist",
        method=f"{'Closed form' if exact else 'Closed form of the arm whose wrist meets in a point'}: the first three "
        "joints place the wrist's centre, two flips of the wrist; verified and polished on the URDF as written",
        branches=columns(most),
        imperfection=(0.0, off),
        error=0.0 if exact else error,
        arm=arm,
        solve=kernels.solve,
        explain=lambda rotation, point: off_by(chain, Aim(), rotation, point),
        solver=Solver("slides", wrist_values(chain, arm, centre, most)),
    )


def wrist_values(chain: Chain, arm: Array, centre: Array, most: int) -> dict[str, Any]:
    """The arm with a spherical wrist at ``centre`` (3,) m as the compiled solvers take it, ``most`` columns."""
    joints = [
        Joint(h, p, bool(s), i)
        for i, (h, p, s) in enumerate(zip(chain.H[:3], chain.points[:3] / chain.size, chain.prismatic[:3], strict=True))
    ]
    return _values(chain, arm, most) | {
        "step": step_values(joints, centre / chain.size),
        "in_tip": arm[kernels.IN_TIP : kernels.IN_TIP + 3].copy(),
    }


def _values(chain: Chain, arm: Array, most: int) -> dict[str, Any]:
    ca, sa, cb, sb, bend = arm[kernels.ANGLES : kernels.ANGLES + 5].tolist()
    return {
        "written": Aim().written(chain),
        "columns": most,
        "turns": arm[kernels.TURNS : kernels.TURNS + 3].copy(),
        "first": arm[kernels.FIRST_FRAME : kernels.FIRST_FRAME + 9].copy(),
        "last": arm[kernels.LAST_FRAME : kernels.LAST_FRAME + 9].copy(),
        "home": np.ascontiguousarray(chain.R_tip),
        "clamp": float(arm[layout.CLAMP]),
        "imperfection": float(arm[layout.IMPERFECTION]),
    } | {"ca": ca, "sa": sa, "cb": cb, "sb": sb, "bend": bend}


def _three_slides(chain: Chain) -> Plan | None:
    arm = _pack(chain, np.flatnonzero(~chain.prismatic))
    if arm is None:
        return None
    return Plan(
        family=f"{kinds_of(chain)} three slides",
        method="Closed form: the turning joints make the orientation, two ways, the slides follow from a linear "
        "system; verified and polished on the URDF as written",
        branches=columns(2),
        imperfection=(0.0, 0.0),
        error=0.0,
        arm=arm,
        solve=kernels.solve,
        explain=lambda rotation, point: off_by(chain, Aim(), rotation, point),
        solver=Solver("slides", _values(chain, arm, 2)),
    )


def _pack(chain: Chain, turns: NDArray[np.intp]) -> Array | None:
    """The numbers of the arm and of the three turns (3,) that make the orientation; None where two are parallel."""
    first, middle, last = chain.H[turns]
    side, side_too = np.cross(first, middle), np.cross(middle, last)
    sa, sb = float(np.linalg.norm(side)), float(np.linalg.norm(side_too))
    if min(sa, sb) < 1e-6:
        return None
    side, side_too = side / sa, side_too / sb
    arm = np.concatenate([pack_chain(chain, POSE), np.zeros(kernels.LENGTH - kernels.STEP)])
    arm[kernels.TURNS : kernels.TURNS + 3] = turns
    frames = (side, np.cross(first, side), first), (side_too, np.cross(last, side_too), last)
    arm[kernels.FIRST_FRAME : kernels.FIRST_FRAME + 9] = np.stack(frames[0], axis=1).ravel()
    arm[kernels.LAST_FRAME : kernels.LAST_FRAME + 9] = np.stack(frames[1], axis=1).ravel()
    bend = np.arctan2(np.cross(side, side_too) @ middle, side @ side_too)
    arm[kernels.ANGLES : kernels.ANGLES + 5] = first @ middle, sa, middle @ last, sb, bend
    return arm
