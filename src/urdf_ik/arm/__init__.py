"""Arm: what :func:`load` returns. It joins reading, chain, structure, family and solutions."""

from __future__ import annotations

from urdf_ik.arm.arm import Arm
from urdf_ik.arm.loading import load

__all__ = ["Arm", "load"]
