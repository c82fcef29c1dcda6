"""Six joints with slides, in closed form: a spherical wrist behind any three joints, or three slides in any order.

The Stanford arm (RRPRRR), gantries with a wrist (PPPRRR), and so on. See src/core/families/slides.hpp.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from urdf_ik._core import Solver
from urdf_ik.families.few_joints import Aim, Joint, columns, is_redundant, kinds_of, step_values
from urdf_ik.families.parts.nearest import off_by
from urdf_ik.families.parts.plan import Plan
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
    exact = error <= DEFAULT.exact_structure
    values = _values(chain, np.arange(3, 6), most, 0.0 if exact else error)
    if values is None:
        return None
    joints = [
        Joint(h, p, bool(s), i)
        for i, (h, p, s) in enumerate(zip(chain.H[:3], chain.points[:3] / chain.size, chain.prismatic[:3], strict=True))
    ]
    values["step"] = step_values(joints, centre / chain.size)
    values["in_tip"] = chain.R_tip.T @ (centre - chain.P.sum(axis=0)) / chain.size
    return Plan(
        family=f"{kinds_of(chain)} spherical wrist",
        method=f"{'Closed form' if exact else 'Closed form of the arm whose wrist meets in a point'}: the first three "
        "joints place the wrist's centre, two flips of the wrist; verified and polished on the URDF as written",
        branches=columns(most),
        imperfection=(0.0, off),
        error=0.0 if exact else error,
        explain=lambda T: off_by(chain, Aim(), T[:3, :3], T[:3, 3]),
        solver=Solver("slides", values),
    )


def _three_slides(chain: Chain) -> Plan | None:
    values = _values(chain, np.flatnonzero(~chain.prismatic), 2, 0.0)
    if values is None:
        return None
    return Plan(
        family=f"{kinds_of(chain)} three slides",
        method="Closed form: the turning joints make the orientation, two ways, the slides follow from a linear "
        "system; verified and polished on the URDF as written",
        branches=columns(2),
        imperfection=(0.0, 0.0),
        error=0.0,
        explain=lambda T: off_by(chain, Aim(), T[:3, :3], T[:3, 3]),
        solver=Solver("slides", values),
    )


def _values(chain: Chain, turns: NDArray[np.intp], most: int, error: float) -> dict[str, Any] | None:
    """The arm and the three turns (3,) that make the orientation, as the compiled solver takes them.

    ``most``: columns of a pose; ``error``: how far the arm is off its structure. None where two turns are parallel.
    """
    first, middle, last = chain.H[turns]
    side, side_too = np.cross(first, middle), np.cross(middle, last)
    sa, sb = float(np.linalg.norm(side)), float(np.linalg.norm(side_too))
    if min(sa, sb) < 1e-6:
        return None
    side, side_too = side / sa, side_too / sb
    return {
        "written": Aim().written(chain),
        "columns": most,
        "turns": turns.astype(np.float64),
        "first": np.column_stack([side, np.cross(first, side), first]),
        "last": np.column_stack([side_too, np.cross(last, side_too), last]),
        "home": np.ascontiguousarray(chain.R_tip),
        "clamp": 50.0 * error,
        "imperfection": error,
        "ca": float(first @ middle),
        "sa": sa,
        "cb": float(middle @ last),
        "sb": sb,
        "bend": float(np.arctan2(np.cross(side, side_too) @ middle, side @ side_too)),
    }
