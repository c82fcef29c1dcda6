"""Six joints with slides, in closed form: a spherical wrist behind any three joints, or three slides in any order.

The Stanford arm (RRPRRR), gantries with a wrist (PPPRRR), and so on. See src/core/families/few_joints/slides.hpp.
"""

import numpy as np
from numpy.typing import NDArray

from urdf_ik.ik.families.few_joints import joints_of, position_step
from urdf_ik.ik.families.parts.family import Family, FamilyMember, columns
from urdf_ik.ik.families.parts.written import Numbers, written
from urdf_ik.kinematics.chain import Chain, is_redundant, kinds_of
from urdf_ik.kinematics.structure import Structure
from urdf_ik.support.tolerances import DEFAULT
from urdf_ik.typing import Array


def _prepare_wrist(family: Family, structure: Structure, chain: Chain) -> FamilyMember | None:
    """The plan of an arm whose wrist meets, exactly or nearly."""
    wrist = structure.triple(4, "meet")
    if wrist is None or wrist.point is None:
        return None
    most = 8 if chain.prismatic.sum() == 1 else 4
    error = wrist.imperfection / chain.size
    exact = error <= DEFAULT.exact_structure
    step = position_step(joints_of(chain, chain.size)[:3], wrist.point / chain.size)
    in_tip = chain.R_tip.T @ (wrist.point - chain.P.sum(axis=0)) / chain.size
    arm = _arm(chain, np.arange(3, 6), most, 0.0 if exact else error, step, in_tip)
    if arm is None:
        return None
    return family.member(
        chain,
        arm,
        0.0 if exact else error,
        name=f"{kinds_of(chain)} spherical wrist",
        method=f"{'Closed form' if exact else 'Closed form of the arm whose wrist meets in a point'}: {family.steps}",
        branches=columns(most),
        imperfection=(0.0, wrist.imperfection),
    )


def _prepare_three(family: Family, structure: Structure, chain: Chain) -> FamilyMember | None:
    """The plan of an arm with three slides; None where two of the turns are parallel."""
    arm = _arm(chain, np.flatnonzero(~chain.prismatic), 2, 0.0)
    return None if arm is None else family.member(chain, arm, name=f"{kinds_of(chain)} three slides")


SPHERICAL_WRIST = Family(
    name="six joints with slides, spherical wrist",
    reason="axes {4, 5, 6} meet in a point, and one or two of the other joints slide",
    steps="the first three joints place the wrist's centre, two flips of the wrist; verified and polished on the URDF "
    "as written",
    branches=columns(8),
    matches=lambda structure, chain: (
        structure.slides in (1, 2)
        and len(structure.joint_types) == 6
        and structure.triple(4, "meet") is not None
        and not is_redundant(chain)
    ),
    prepare=_prepare_wrist,
)
THREE_SLIDES = Family(
    name="six joints, three slides",
    reason="three of the six joints slide, so that the other three make the orientation on their own",
    steps="the turning joints make the orientation, two ways, the slides follow from a linear system; verified and "
    "polished on the URDF as written",
    branches=columns(2),
    by_quadratics=True,
    matches=lambda structure, chain: structure.slides == 3 and chain.n == 6 and not is_redundant(chain),
    prepare=_prepare_three,
)


def _arm(
    chain: Chain,
    turns: NDArray[np.intp],
    most: int,
    error: float,
    step: Numbers | None = None,
    in_tip: Array | None = None,
) -> Numbers | None:
    """The arm for the compiled solver; None where two of its turns are parallel."""
    first, middle, last = chain.H[turns]
    side, side_too = np.cross(first, middle), np.cross(middle, last)
    sa, sb = float(np.linalg.norm(side)), float(np.linalg.norm(side_too))
    if min(sa, sb) < 1e-6:
        return None
    side, side_too = side / sa, side_too / sb
    return Numbers(
        kind="slides",
        written=written(chain),
        columns=most,
        step=step,
        in_tip=in_tip,
        turns=turns.astype(np.float64),
        first=np.column_stack([side, np.cross(first, side), first]),
        last=np.column_stack([side_too, np.cross(last, side_too), last]),
        home=np.ascontiguousarray(chain.R_tip),
        clamp=50.0 * error,
        imperfection=error,
        ca=float(first @ middle),
        sa=sa,
        cb=float(middle @ last),
        sb=sb,
        bend=float(np.arctan2(np.cross(side, side_too) @ middle, side @ side_too)),
    )
