"""``load``, ``load_compiled``, and the record ``Arm`` that they return."""

from urdf_ik.arm.arm import Arm, assemble
from urdf_ik.arm.compiled import is_compiled, load_compiled
from urdf_ik.arm.loading import Robot, load, loaded, with_positioner

__all__ = ["Arm", "Robot", "assemble", "is_compiled", "load", "load_compiled", "loaded", "with_positioner"]
