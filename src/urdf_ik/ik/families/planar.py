"""Two or three parallel turning joints, exactly so, and at most one slide along them: 2R, 3R and SCARA."""

import math
from dataclasses import replace
from typing import Any

import numpy as np

from urdf_ik._core import Solver
from urdf_ik.ik.families import few_joints
from urdf_ik.ik.families.parts.explanations import beyond_reach, seen_in_frame_1
from urdf_ik.ik.families.parts.family import Family, FamilyMember
from urdf_ik.ik.families.parts.written import Numbers, ends
from urdf_ik.kinematics.chain import Chain, kinds_of
from urdf_ik.kinematics.chain.plane import axes_across
from urdf_ik.kinematics.structure import Structure
from urdf_ik.support.angles import amount
from urdf_ik.support.tolerances import DEFAULT
from urdf_ik.typing import Array

_ELBOW = ("elbow left", "elbow right")
# Links shorter than this [share of size] are left to the general way.
_SHORT = 1e-3


def _prepare(family: Family, structure: Structure, chain: Chain) -> FamilyMember | None:
    """The plan for poses; None where a link is too short."""
    plan = few_joints.FAMILY.plan(structure, chain)
    plane = _plane(chain)
    if plan is None or plane is None:
        return None
    arm = Numbers(kind="planar", **_ways(plan), **plane, number=chain.n)
    slide = "height by the slide, " if chain.prismatic.any() else ""
    last = ", the last joint turns the tip" if np.count_nonzero(~chain.prismatic) == 3 else ""
    return replace(
        plan,
        family=family,
        name=f"{kinds_of(chain)} {'SCARA' if slide else 'planar'}",
        reason=family.reason,
        method=f"Closed form: {slide}elbow by the law of cosines{last}",
        branches=_ELBOW,
        solver=Solver(arm),
        why=seen_in_frame_1(chain, arm.ideal, lambda rotation, point: _explain(chain, arm, rotation, point)),
    )


FAMILY = Family(
    name="planar",
    reason="two or three joints turn about parallel axes, and no other joint but a slide along them moves the tip",
    steps="elbow by the law of cosines",
    branches=_ELBOW,
    by_quadratics=True,
    matches=lambda structure, chain: _matches(chain),
    prepare=_prepare,
)


def for_points(chain: Chain, plan: FamilyMember) -> FamilyMember:
    """The plan of two joints for points in the plane, faster where the arm is exactly planar."""
    plane = _plane(chain) if _matches(chain) and chain.n == 2 else None
    if plane is None:
        return plan
    arm = Numbers(kind="planar points", **_ways(plan), **plane)
    return replace(
        plan,
        method="Closed form: elbow by the law of cosines",
        branches=_ELBOW,
        solver=Solver(arm),
        why=lambda T: _explain(chain, arm, None, arm.ideal.base_rotation @ (T[:3, 3] - arm.ideal.base_origin)),
    )


def _matches(chain: Chain) -> bool:
    """Whether two or three joints turn about exactly parallel axes, and at most one slides along them."""
    turning = ~chain.prismatic
    if chain.axes is not chain or np.count_nonzero(turning) not in (2, 3) or np.count_nonzero(chain.prismatic) > 1:
        return False
    normal = np.cross(*axes_across(chain.H[np.argmax(turning)]))
    return bool(np.linalg.norm(np.cross(chain.H, normal), axis=1).max() < DEFAULT.exact_structure)


def _ways(plan: FamilyMember) -> dict[str, Any]:
    """The fields that the arm shares with an arm of few joints."""
    return {name: getattr(plan.solver.arm, name) for name in ("written", "way", "spare")}


def _plane(chain: Chain) -> dict[str, Any] | None:
    """The fields that describe the plane and the links; None where a link is too short."""
    turning = np.flatnonzero(~chain.prismatic)
    axes = axes_across(chain.H[turning[0]])
    B = np.array([*axes, np.cross(*axes)])
    tip = chain.P.sum(axis=0)
    joints = chain.points[turning]
    end = joints[2] if len(turning) == 3 else tip
    links = np.array([B @ (joints[1] - joints[0]), B @ (end - joints[1])])
    lengths = np.hypot(links[:, 0], links[:, 1])
    if lengths.min() < _SHORT * chain.size:
        return None
    angles = np.arctan2(links[:, 1], links[:, 0])
    signs, column = np.zeros(4), np.full(4, -1.0)
    slides = np.flatnonzero(chain.prismatic)
    for k, joint in [*enumerate(turning), *((3, joint) for joint in slides)]:
        signs[k], column[k] = np.sign(chain.H[joint] @ B[2]), joint
    # Heights are measured from where the end of the links is at q = 0.
    origin = joints[0] + ((end - joints[0]) @ B[2]) * B[2]
    return {
        "ideal": ends(B, origin, chain.R_tip.T @ B.T, chain.R_tip.T @ (end - tip)),
        "links": lengths,
        "angles": angles,
        "bend": math.remainder(angles[1] - angles[0], 2.0 * math.pi),
        "signs": signs,
        "joints": column,
    }


def _explain(chain: Chain, arm: Numbers, rotation: Array | None, point: Array) -> str:
    """What does not fit of a target in the plane's frame: tilt, height, distance, turn."""
    tilt = 0.0 if rotation is None else math.atan2(math.hypot(rotation[0, 2], rotation[1, 2]), rotation[2, 2])
    if tilt > DEFAULT.reach:
        return f"the tip is tilted by {amount(tilt, form='.3g')}, and its joints turn it only about axis 1"
    if rotation is not None and arm.joints[3] < 0.0 and abs(point[2]) > DEFAULT.reach * chain.size:
        return f"the tip is {abs(point[2]):.6g} m {'above' if point[2] > 0.0 else 'below'} the plane that it moves in"
    a, b = arm.links
    far = math.hypot(point[0], point[1])
    end = "axis 3" if arm.joints[2] >= 0.0 else "the tip"
    if why := beyond_reach(f"{end} is {{at}} m from axis 1", np.array([far]), abs(a - b), a + b):
        return why
    # Two joints: whichever way the elbow bends, the tip is turned as they have it.
    turn = 0.0 if rotation is None else math.atan2(rotation[1, 0], rotation[0, 0])
    ahead = math.atan2(point[1], point[0])
    bend = math.acos(max(-1.0, min(1.0, (far**2 - a**2 - b**2) / (2.0 * a * b))))
    inner = math.atan2(b * math.sin(bend), a + b * math.cos(bend))
    at_zero = float(arm.angles[1])
    # The second link's direction is the line's to the point, and what is left of the bend on either side of it.
    off = [turn + at_zero - (ahead + sign * (bend - inner)) for sign in (1.0, -1.0)]
    least = min(abs(math.remainder(each, 2.0 * math.pi)) for each in off)
    off_by = amount(least, form=".3g")
    return f"with the tip there its turn about axis 1 is {off_by} off, and no joint is left to change that"
