"""6R arms whose wrist mimics: seven axes, the fifth and the sixth of which follow one joint, as in painting robots.

In a hollow wrist (ABB IRB 5400) the axes 4 and 7 meet at every value of that joint, in a point that it may move along
both. The point is known from the target and the joint's value, and so are joints 1 to 3: one equation in one unknown.
"""

from dataclasses import replace

import numpy as np

from urdf_ik.ik.families import spherical_wrist
from urdf_ik.ik.families.parts.explanations import beyond_links
from urdf_ik.ik.families.parts.family import Family, FamilyMember, columns
from urdf_ik.ik.families.parts.written import Numbers, driven
from urdf_ik.kinematics.chain import Chain, CoupledChain
from urdf_ik.kinematics.structure import Structure, analyse
from urdf_ik.support.text import quoted
from urdf_ik.support.tolerances import DEFAULT
from urdf_ik.typing import Array

_COLUMNS = 32
# Samples of the wrist's joint a turn, and turns at most.
_SAMPLES, _MOST_TURNS = 128, 4
# Sine of the angle between axes 4 and 7 below which the point where they meet is lost to rounding.
_ALIGNED = 1e-3


def _prepare(family: Family, structure: Structure, chain: Chain) -> FamilyMember | None:
    """The plan of an arm for which ``why_not`` has no reason."""
    assert isinstance(chain, CoupledChain)
    axes, values = _signed(chain), _samples(chain)
    cosine, along_4, along_7, apart = _crossings(axes, chain.gain, values)
    position = spherical_wrist.TWO_PARALLEL.plan(*_with_centre(axes, along_4[0]))
    if position is None:
        return None
    tip = axes.points[6]
    home = axes.P.sum(axis=0)
    arm = Numbers(
        kind="hollow wrist",
        written=driven(chain, np.ones(6)),
        position=position.solver.arm,
        samples=len(values),
        value=values,
        cosine=cosine,
        along_4=along_4 - along_4[0],
        along_7=along_7,
        flange=axes.R_tip.T @ (tip - home),
        direction=axes.R_tip.T @ axes.H[6],
    )
    names = chain.joint_names
    return family.member(
        chain,
        arm,
        method=f"Where axes 4 and 7 meet is known at a value of {names[4]}, and with it joints 1 to 3; the angle "
        "between the two axes is one equation for that value, solved on every branch and refined by Newton's method on "
        "the URDF as written",
        imperfection=(0.0, float(apart)),
        why=lambda T: _out_of_reach(chain, T[:3, 3]),
    )


FAMILY = Family(
    name="6R hollow wrist, 2||3",
    reason="axes 4 and 7 meet at every value of the joint that turns axes 5 and 6, and axes 2 and 3 are parallel",
    steps="where axes 4 and 7 meet is known at a value of the joint that turns axes 5 and 6, and with it joints 1 to 3",
    branches=columns(_COLUMNS),
    matches=lambda structure, chain: isinstance(chain, CoupledChain) and chain.n == 6 and not why_not(chain),
    prepare=_prepare,
)


def why_not(chain: CoupledChain) -> str:
    """Why an arm of six independent joints is not solved as one with a hollow wrist; '' where it is."""
    axes, gain, names = chain.axes, chain.gain, chain.joint_names
    if axes.prismatic.any() or "prismatic" in chain.joint_types or axes.n != 7:
        return f"such a wrist has seven axes in all that turn, and six joints drive {axes.n} here"
    wanted = np.zeros((7, 6), dtype=np.bool_)
    wanted[range(7), [0, 1, 2, 3, 4, 4, 5]] = True
    alone = np.abs(gain[[0, 1, 2, 3, 6], [0, 1, 2, 3, 5]])
    wrong = np.flatnonzero(((gain != 0.0) != wanted).any(axis=1))
    if len(wrong) or (alone != 1.0).any():
        k = int(wrong[0]) if len(wrong) else (0, 1, 2, 3, 6)[int(np.argmax(alone != 1.0))]
        drivers = ", ".join(f"{factor:g} {name}" for name, factor in zip(names, gain[k], strict=True) if factor)
        found = f"axis {k + 1} ({axes.joint_names[k]}) follows {drivers}"
        return f"its axes 5 and 6 would follow one joint, the others a joint of their own, and here {found}"
    turns = chain.image_turns[4]
    if not 0.0 < turns <= _MOST_TURNS:
        factors = ", ".join(f"{factor:g}" for factor in gain[4:6, 4])
        return f"joint {quoted(names[4])}, with the multipliers {factors}, does not repeat within {_MOST_TURNS} turns"
    structure = analyse(_signed(chain))
    if not structure.is_parallel(2):
        return f"axes 2 and 3 ({names[1]}, {names[2]}) are {structure.pairs[1].relation}, and would have to be parallel"
    if structure.is_parallel(1) or structure.is_parallel(3):
        return "three of its first four axes are parallel"
    *_, apart = _crossings(_signed(chain), gain, _samples(chain))
    if apart > DEFAULT.near_distance * chain.size:
        return (
            f"axes 4 and 7 ({axes.joint_names[3]}, {axes.joint_names[6]}) would have to meet at every value of "
            f"{names[4]}, and pass each other at {apart:.3g} m"
        )
    return ""


def _signed(chain: CoupledChain) -> Chain:
    """The chain of the axes, those that turn against their joint turned round."""
    signs = np.array([-1.0 if chain.gain[k, j] < 0.0 else 1.0 for k, j in enumerate((0, 1, 2, 3, 4, 4, 5))])
    signs[4:6] = 1.0
    return replace(chain.axes, H=signs[:, None] * chain.axes.H)


def _samples(chain: CoupledChain) -> Array:
    """Values of the wrist's joint over its whole period, beside the ones at which axes tend to align."""
    turns = int(chain.image_turns[4])
    count = _SAMPLES * turns
    middles = (np.arange(count) + 0.5) * (2.0 * np.pi * turns / count) - np.pi * turns
    return np.asarray(middles, dtype=np.float64)


def _crossings(axes: Chain, gain: Array, values: Array) -> tuple[Array, Array, Array, float]:
    """Where axes 4 and 7 meet at values (m,) of the wrist's joint."""
    Q = np.zeros((len(values), 7))
    Q[:, 4:6] = values[:, None] * gain[4:6, 4]
    J, T = axes.jacobian(Q), axes.fk(Q)
    h, g = axes.H[3], J[:, 3:, 6]
    tip = T[:, :3, 3] - np.einsum("mij,j->mi", T[:, :3, :3], axes.R_tip.T @ (axes.P.sum(axis=0) - axes.points[6]))
    between = tip - axes.points[3]
    cosine = g @ h
    square = np.maximum(1.0 - cosine**2, 0.0)
    clear = square > _ALIGNED**2
    with np.errstate(invalid="ignore", divide="ignore"):
        along_4 = (between @ h - cosine * (between * g).sum(axis=1)) / square
        along_7 = (cosine * (between @ h) - (between * g).sum(axis=1)) / square
    normal = np.cross(h, g)
    apart = np.abs((between * normal).sum(axis=1))[clear] / np.sqrt(square[clear])
    for each in (along_4, along_7):
        each[~clear] = np.interp(values[~clear], values[clear], each[clear])
    return cosine, along_4, along_7, float(apart.max(initial=0.0))


def _with_centre(axes: Chain, along: float) -> tuple[Structure, Chain]:
    """Axes 1 to 4 and a wrist that turns about a point of axis 4: its structure and the chain."""
    centre = axes.points[3] + along * axes.H[3]
    across = np.cross(axes.H[3], np.eye(3)[int(np.argmin(np.abs(axes.H[3])))])
    across /= np.linalg.norm(across)
    points = np.vstack([np.zeros(3), axes.points[:3], centre, centre, centre, centre])
    chain = replace(
        axes,
        joint_names=axes.joint_names[:6],
        joint_types=axes.joint_types[:6],
        H=np.vstack([axes.H[:4], across, axes.H[3]]),
        P=np.diff(points, axis=0),
        R_tip=np.eye(3),
        limits=axes.limits[:6],
    )
    return analyse(chain), chain


def _out_of_reach(chain: CoupledChain, point: Array) -> str:
    """Why a target at ``point`` (3,) [m] has no solution."""
    far = float(np.linalg.norm(point - chain.points[0]))
    return beyond_links("the tip", far, chain.size) or (
        f"no angles of {', '.join(chain.joint_names[:3])} bring the wrist to where {', '.join(chain.joint_names[3:])} "
        "can give the tip its turn"
    )
