"""``load``, and the record ``Arm`` that it returns."""

from __future__ import annotations

from urdf_ik.arm.arm import Arm, arm_of, assemble
from urdf_ik.arm.loading import load
from urdf_ik.arm.positioner import with_positioner

__all__ = ["Arm", "arm_of", "assemble", "load", "with_positioner"]
