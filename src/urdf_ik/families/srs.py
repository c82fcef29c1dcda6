"""Seven joints, S-R-S: three axes meet in the shoulder, three in the wrist, and the elbow is between them."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from urdf_ik._kernels import layout, swivel
from urdf_ik._kernels import srs as kernels
from urdf_ik.families.plan import RedundantPlan, snapped
from urdf_ik.redundancy import swivel_of
from urdf_ik.tolerances import DEFAULT

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from urdf_ik.chain import Chain
    from urdf_ik.structure import Structure

    Array = NDArray[np.float64]

NAMES = tuple(
    f"shoulder {shoulder}, elbow {up}, wrist {wrist}"
    for shoulder in ("noflip", "flip")
    for up in ("up", "down")
    for wrist in ("noflip", "flip")
)
# Axis 4 must be this far [of the arm's size] from shoulder and wrist.
_CLEAR = 1e-3


def prepare(structure: Structure, chain: Chain) -> RedundantPlan | None:
    """The plan of an arm that is of this family exactly; None where it is not."""
    shoulder, wrist = structure.triple(1, "meet"), structure.triple(5, "meet")
    if "prismatic" in structure.joint_types or shoulder is None or wrist is None:
        return None
    S, W = shoulder.point, wrist.point
    if S is None or W is None or _error(chain, S, W) > DEFAULT.exact_structure:
        return None
    h, to_axis, to_wrist = chain.H[3], chain.points[3] - S, W - chain.points[3]
    to_axis, fore = to_axis - (h @ to_axis) * h, to_wrist - (h @ to_wrist) * h
    a, b = float(np.linalg.norm(to_axis)), float(np.linalg.norm(fore))
    if min(a, b) < _CLEAR * chain.size:
        return None
    elbow = np.column_stack([to_axis / a, np.cross(h, to_axis / a), h])
    first, third, twists = _triple(chain.H[:3])
    fifth, seventh, wrist_twists = _triple(chain.H[4:])
    arm = np.zeros(swivel.LENGTH)
    arm[layout.BASE_ROTATION : layout.BASE_ROTATION + 9] = first.T.ravel()
    arm[layout.BASE_ORIGIN : layout.BASE_ORIGIN + 3] = S
    arm[layout.TOOL_ROTATION : layout.TOOL_ROTATION + 9] = (chain.R_tip.T @ seventh).ravel()
    arm[layout.TOOL_POINT : layout.TOOL_POINT + 3] = chain.R_tip.T @ (W - chain.P.sum(axis=0))
    arm[layout.SIZE] = chain.size
    arm[layout.REACH : layout.REACH + 9] = DEFAULT.for_kernels()
    arm[layout.CLAMP] = 100.0 * DEFAULT.fold
    arm[swivel.UPPER], arm[swivel.FORE], arm[swivel.ALONG] = a, b, h @ (W - S)
    arm[swivel.ZERO_4] = math.atan2(fore @ elbow[:, 1], fore @ elbow[:, 0])
    arm[swivel.SHOULDER : swivel.SHOULDER + 5] = twists
    arm[swivel.WRIST : swivel.WRIST + 5] = wrist_twists
    arm[swivel.TO_FRAME_3 : swivel.TO_FRAME_3 + 9] = snapped(elbow.T @ third).ravel()
    arm[swivel.FROM_FRAME_5 : swivel.FROM_FRAME_5 + 9] = snapped(fifth.T @ elbow).ravel()
    arm[swivel.H : swivel.H + 21] = chain.H.ravel()
    arm[swivel.P : swivel.P + 24] = chain.P.ravel()
    arm[swivel.R_TIP : swivel.R_TIP + 9] = chain.R_tip.ravel()

    def value_of(Q: Array) -> Array:
        values = np.empty(len(Q))
        swivel.swivels(arm, Q, values)
        return values

    return RedundantPlan(
        family="7R S-R-S",
        method="Closed form: the elbow by the law of cosines, its place by the swivel angle, then shoulder and wrist",
        branches=NAMES,
        imperfection=(0.0, max(shoulder.imperfection, wrist.imperfection)),
        error=0.0,
        arm=arm,
        parameter=swivel_of(chain.joint_names[3]),
        solve_at=kernels.solve,
        value_of=value_of,
        explain_at=lambda T, value: _explain(arm, T, value),
    )


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


def _explain(arm: Array, T: Array, value: float) -> str:
    R, p = T[:3, :3], T[:3, 3]
    far = float(np.linalg.norm(R @ arm[layout.TOOL_POINT : layout.TOOL_POINT + 3] + p - arm[layout.BASE_ORIGIN : 12]))
    a, b, c = arm[swivel.UPPER], arm[swivel.FORE], arm[swivel.ALONG]
    longest, shortest = math.hypot(a + b, c), math.hypot(a - b, c)
    if far > longest:
        return f"wrist centre {far:.6g} m from the shoulder, reach {longest:.6g} m"
    if far < shortest:
        return f"wrist centre {far:.6g} m from the shoulder, closer than the folded arm's {shortest:.6g} m"
    return f"at a swivel angle of {value:.6g} rad shoulder or wrist would have to bend more than their axes allow"
