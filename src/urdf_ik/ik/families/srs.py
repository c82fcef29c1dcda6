"""Seven joints, S-R-S: three axes meet in the shoulder, three in the wrist, and the elbow is between them."""

import math
from dataclasses import replace

import numpy as np

from urdf_ik.ik.families.parts.explanations import beyond_reach
from urdf_ik.ik.families.parts.family import Family, FamilyMember, self_motion
from urdf_ik.ik.families.parts.ideal import eight, snapped
from urdf_ik.ik.families.parts.written import Numbers, ends, written
from urdf_ik.kinematics.chain import Chain
from urdf_ik.kinematics.chain.redundancy import SWIVEL, Redundancy
from urdf_ik.kinematics.structure import Structure
from urdf_ik.support.angles import amount
from urdf_ik.support.tolerances import DEFAULT
from urdf_ik.typing import Array

NAMES = eight("shoulder {}, elbow {}, wrist {}", ("noflip", "flip"))
# Axis 4 must be this far [of the arm's size] from shoulder and wrist.
_CLEAR = 1e-3
# How far below zero a squared sine may fall for an arm that is off by 1 [share of size]: its solutions may still exist.
_CLAMP = 50.0
# Sine of the angle below which the wrist counts as lying on axis 1, as in src/core/families/seven_joints/swivel.hpp.
_ON_AXIS = 1e-7


def _matches(structure: Structure) -> bool:
    """Whether seven joints turn, and the first three axes meet in a point, the last three in another."""
    meeting = structure.triple(1, "meet") is not None and structure.triple(5, "meet") is not None
    return meeting and structure.joint_types.count("prismatic") == 0 and len(structure.joint_types) == 7


def _prepare(family: Family, structure: Structure, chain: Chain) -> FamilyMember | None:
    """The plan of such an arm; None where the elbow is too near to shoulder or wrist."""
    shoulder, wrist = structure.triple(1, "meet"), structure.triple(5, "meet")
    if shoulder is None or wrist is None or shoulder.point is None or wrist.point is None:
        return None
    S, W = shoulder.point, wrist.point
    h, to_axis, to_wrist = chain.H[3], chain.points[3] - S, W - chain.points[3]
    to_axis, fore = to_axis - (h @ to_axis) * h, to_wrist - (h @ to_wrist) * h
    a, b = float(np.linalg.norm(to_axis)), float(np.linalg.norm(fore))
    if min(a, b) < _CLEAR * chain.size:
        return None
    error = _error(chain, S, W)
    exact = error <= DEFAULT.exact_structure
    elbow = np.column_stack([to_axis / a, np.cross(h, to_axis / a), h])
    first, third, twists = _triple(chain.H[:3])
    fifth, seventh, wrist_twists = _triple(chain.H[4:])
    frames = ends(first.T, S, chain.R_tip.T @ seventh, chain.R_tip.T @ (W - chain.P.sum(axis=0)))
    arm = Numbers(
        kind="S-R-S",
        ideal=frames,
        written=written(chain),
        shoulder=_meeting(twists),
        wrist=_meeting(wrist_twists),
        to_frame_3=snapped(elbow.T @ third),
        from_frame_5=snapped(fifth.T @ elbow),
        upper=a,
        fore=b,
        along=float(h @ (W - S)),
        zero_4=math.atan2(fore @ elbow[:, 1], fore @ elbow[:, 0]),
        clamp=100.0 * DEFAULT.fold + (0.0 if exact else _CLAMP * error),
        imperfection=0.0 if exact else error,
        off=_off(chain, S, W),
        value=0.0,
    )
    return family.member(
        chain,
        arm,
        error,
        branches=family.branches if exact else family.branches + tuple(f"further {k}" for k in range(1, 9)),
        imperfection=(0.0, max(shoulder.imperfection, wrist.imperfection)),
        parameters=(Redundancy(SWIVEL, chain.joint_names[3], (-np.pi, np.pi), 0.0, "rad"),),
        self_motion=self_motion(chain, -1, frames),
        value_of=lambda Q, T: _swivels(chain, frames, Q)[:, None],
        why=lambda T, values: _explain(arm, T, float(values[0])),
        swivel=frames,
    )


FAMILY = Family(
    name="7R S-R-S",
    reason="axes {1, 2, 3} meet in the shoulder, and axes {5, 6, 7} in the wrist",
    steps="the elbow by the law of cosines, its place by the swivel angle, then shoulder and wrist",
    branches=NAMES,
    by_quadratics=True,
    matches=lambda structure, chain: _matches(structure),
    prepare=_prepare,
)


def _meeting(twists: Array) -> Numbers:
    """``MeetingAxes`` of the core, by the numbers of ``_triple``."""
    names = ("cos_alpha", "sin_alpha", "cos_beta", "sin_beta", "shift")
    square = twists[0] == 0.0 and twists[2] == 0.0  # both twists are right angles
    return Numbers(**dict(zip(names, twists.tolist(), strict=True)), square=bool(square))


def _swivels(chain: Chain, frames: Numbers, Q: Array) -> Array:
    """Swivel angles (m,) of joint vectors (m, 7), as the solver measures them (swivel.hpp of the core)."""
    T = chain.fk(Q)
    W = (T[:, :3, :3] @ frames.tool_point + T[:, :3, 3] - frames.base_origin) @ frames.base_rotation.T
    axis = chain.jacobian(Q)[:, 3:, 3] @ frames.base_rotation.T
    length, aside = np.linalg.norm(W, axis=1), np.hypot(W[:, 0], W[:, 1])
    on_axis = aside <= _ON_AXIS * length
    with np.errstate(invalid="ignore", divide="ignore"):
        along = np.where(length[:, None] > 0.0, W / length[:, None], [0.0, 0.0, 1.0])
        normal = np.column_stack([-W[:, 1] / aside, W[:, 0] / aside, np.zeros(len(W))])
        # On the axis frame 1's x, made perpendicular to the line; it has no such part where the line is x itself.
        x = np.array([1.0, 0.0, 0.0]) - along[:, :1] * along
        normal = np.where(on_axis[:, None], x / np.linalg.norm(x, axis=1, keepdims=True), normal)
    across = np.cross(along, normal)
    return np.asarray(np.arctan2((across * axis).sum(axis=1), (normal * axis).sum(axis=1)))


def _off(chain: Chain, S: Array, W: Array) -> Array:
    """From each axis to a parallel one through S, S, S, itself, W, W, W (7, 3) m, in the joint's frame at zero."""
    along = np.array([S, S, S, chain.points[3], W, W, W]) - chain.points[:7]
    off = along - (along * chain.H).sum(axis=1)[:, None] * chain.H
    R, out = np.eye(3), np.empty((7, 3))
    for k, step in enumerate(written(chain).steps[:7]):
        R = R @ step[:, :3]
        out[k] = R.T @ off[k]
    return out


def _error(chain: Chain, S: Array, W: Array) -> float:
    """How far the poses are from those of the arm whose axes meet in S and W [rad, share of size]."""
    points = np.vstack([np.zeros(3), S, S, S, chain.points[3], W, W, W, chain.P.sum(axis=0)])
    ideal = replace(chain, P=np.diff(points, axis=0))
    Q = np.random.default_rng(0).uniform(-np.pi, np.pi, (12, 7))
    apart = ideal.fk(Q) - chain.fk(Q)
    apart[:, :3, 3] /= chain.size
    return float(np.abs(apart).max())


def _triple(H: Array) -> tuple[Array, Array, Array]:
    """Frames of the first and the last of three axes (3, 3), and what lies between.

    R(h1, q1) R(h2, q2) R(h3, q3) = F1 Rz(q1) Rx(alpha) Rz(q2 + shift) Rx(beta) Rz(q3) F3^T.

    Returns:
        F1 and F3 (3, 3), and (cos alpha, sin alpha, cos beta, sin beta, shift).
    """
    x, x_next = np.cross(H[0], H[1]), np.cross(H[1], H[2])
    sa, sb = float(np.linalg.norm(x)), float(np.linalg.norm(x_next))
    x, x_next = x / sa, x_next / sb
    shift = math.atan2(np.cross(x, x_next) @ H[1], x @ x_next)
    frames = [np.column_stack([side, np.cross(h, side), h]) for side, h in ((x, H[0]), (x_next, H[2]))]
    return frames[0], frames[1], np.array([*snapped(np.array([H[0] @ H[1], sa, H[1] @ H[2], sb])), shift])


def _explain(arm: Numbers, T: Array, value: float) -> str:
    far = float(np.linalg.norm(T[:3, :3] @ arm.ideal.tool_point + T[:3, 3] - arm.ideal.base_origin))
    a, b, c = arm.upper, arm.fore, arm.along
    what = "wrist centre {at} m from the shoulder"
    why = beyond_reach(what, np.array([far]), math.hypot(a - b, c), math.hypot(a + b, c))
    at = amount(value, form=".6g")
    return why or f"at a swivel angle of {at} shoulder or wrist would have to bend more than their axes allow"
