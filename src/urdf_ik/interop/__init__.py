"""Arms and solutions in other programs: ROS messages, pink, viser and rerun; derivatives in torch and jax."""

from __future__ import annotations

from typing import TYPE_CHECKING

from urdf_ik.support.lazy import attributes

if TYPE_CHECKING:
    from urdf_ik.interop.other_programs import (
        RerunArm,
        ViserArm,
        add_to_rerun,
        add_to_viser,
        from_joint_state,
        pink_configuration,
        to_joint_state,
    )

__all__ = [
    "RerunArm",
    "ViserArm",
    "add_to_rerun",
    "add_to_viser",
    "from_joint_state",
    "pink_configuration",
    "to_joint_state",
]

__getattr__ = attributes(__name__, dict.fromkeys(__all__, "other_programs"))


def __dir__() -> list[str]:
    return __all__
