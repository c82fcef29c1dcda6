"""Accessors that every check uses: an arm's Pinocchio model and its solutions."""

from __future__ import annotations

from urdf_ik.arm import Arm
from urdf_ik.cell.pinocchio_reference import Reference
from urdf_ik.ik.solutions import IKSolutions
from urdf_ik.typing import Array


def reference_of(arm: Arm) -> Reference:
    """Pinocchio's model of the arm, built from the URDF itself."""
    return Reference(arm.model, arm.base, arm.tip, locked=dict(arm.chain.locked))


def parameters_of(arm: Arm) -> tuple[str, ...]:
    """The arm's redundancy parameters in words, such as 'swivel of joint_3'."""
    return tuple(f"{each.kind} of {each.joint}" for each in arm.solver.parameters)


def redundancy_at(arm: Arm, q: Array) -> Array | None:
    """Redundancy parameters (..., k) or (...) at joint vectors (..., n); None for an arm that has none."""
    return arm.redundancy_of(q) if arm.redundancy is not None else None


def solutions_of(arm: Arm, T: Array, redundancy: Array | None = None) -> IKSolutions:
    """Every solution of poses (m, 4, 4); an arm with few joints solves for the part of a pose that it controls."""
    if arm.task != "pose":
        return arm.for_task(arm.task).ik(arm.solver.control.target_of(T))
    return arm.ik(T) if redundancy is None else arm.ik(T, redundancy=redundancy)
