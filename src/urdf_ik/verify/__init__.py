"""Checks of an arm: against Pinocchio, against a second solver, against another URDF; many arms; your own tests."""

from __future__ import annotations

from urdf_ik.support.lazy import attributes

__getattr__ = attributes(__name__)
