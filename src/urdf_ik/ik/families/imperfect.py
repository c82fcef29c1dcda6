"""Arms that have a family's structure only nearly: up to rounded decimals, or up to a calibration."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, ClassVar

import numpy as np

from urdf_ik._core import Solver
from urdf_ik.ik.families.parts.elimination import EliminationArm, elimination_arm
from urdf_ik.ik.families.parts.family import FamilyMember
from urdf_ik.ik.families.parts.ideal import ClosedFormArm
from urdf_ik.kinematics.chain import Chain
from urdf_ik.kinematics.dh.frames import rotation_z
from urdf_ik.typing import Array

# Most boxes that are looked at; of arms that are at least so far off [rad, share of size], whose boxes hardly shrink.
_BOXES, _COARSE_BOXES, _COARSE = 8000, 64, 5e-4

# Below this imperfection, the complex solutions that the ideal arm lacks are too far from real to be followed. Above it
# they can be followed, and they exchange places with the others from pose to pose. Chosen by tests: between 1e-3 and
# 4e-3 such exchanges were too rare to rely on.
_NEAR = 4e-3


def prepare(plan: FamilyMember, chain: Chain) -> FamilyMember:
    """The plan of the ideal arm, made to hold for the arm as written."""
    family = plan.solver.arm
    assert isinstance(family, ClosedFormArm)
    further = tuple(f"further {k}" for k in range(1, 17 - len(plan.branches)))
    return replace(
        plan,
        method=f"{plan.method}; near singularities by elimination too",
        branches=(*plan.branches, *further),
        solver=Solver(_arm(family, chain)),
    )


@dataclass(frozen=True, kw_only=True, eq=False)
class _ImperfectArm:
    """An arm that has a family's structure only nearly: ``ImperfectArm`` of the core.

    Attributes:
        family: the ideal arm.
        elimination: the same arm as written, by elimination.
        inner_steps: (7, 3, 4) motions of the arm as written from the ideal arm's frame 1 to its frame 6 [m].
        ideal_steps: (7, 3, 4) the same motions of the ideal arm; both take the ideal arm's angles.
        boxes: most boxes of joint vectors that are looked at to prove that no solution is missing. They decide how long
            a pose may take, and how often it stays open.
    """

    kind: ClassVar = "imperfect"
    family: ClosedFormArm
    elimination: EliminationArm
    inner_steps: Array
    ideal_steps: Array
    boxes: int


def without_boxes(arm: Any) -> Any:
    """The arm of a solver; of an arm near a family, one that proves a pose at once or leaves it open.

    For arms that are asked at many values of a redundancy parameter.

    Args:
        arm: the dataclass of a solver.
    """
    return replace(arm, boxes=0) if isinstance(arm, _ImperfectArm) else arm


def _arm(family: ClosedFormArm, chain: Chain) -> _ImperfectArm:
    ideal = family.ideal
    base, tool = np.eye(4), np.eye(4)
    base[:3, :3], base[:3, 3] = ideal.base_rotation.T, ideal.base_origin
    tool[:3, :3], tool[:3, 3] = ideal.tool_rotation.T, -ideal.tool_rotation.T @ ideal.tool_point
    inner = np.array([np.vstack([step, [0.0, 0.0, 0.0, 1.0]]) for step in np.array(chain.motion.steps)])
    inner[0], inner[-1] = np.linalg.inv(base) @ inner[0], inner[-1] @ np.linalg.inv(tool)
    back = np.array([rotation_z(-offset)[:3, :3] for offset in (*ideal.offset, 0.0)])
    inner, steps = np.ascontiguousarray(inner[:, :3]), ideal.steps.copy()
    inner[:, :, :3], steps[:, :, :3] = inner[:, :, :3] @ back, steps[:, :, :3] @ back
    return _ImperfectArm(
        family=family,
        elimination=elimination_arm(chain, near=bool(ideal.imperfection < _NEAR)),
        inner_steps=inner,
        ideal_steps=steps,
        boxes=_BOXES if ideal.imperfection < _COARSE else _COARSE_BOXES,
    )
