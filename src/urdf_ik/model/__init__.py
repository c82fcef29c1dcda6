"""What a robot is, as its file says: URDF, xacro, MJCF and SRDF, meshes, the catalogue of names, and poses."""

from __future__ import annotations

from urdf_ik.support.lazy import attributes

__getattr__ = attributes(__name__)
