"""Reading a URDF: hardened XML in, a checked kinematic tree out, with line and element in every refusal."""

from __future__ import annotations

from urdf_ik.urdf.checks import MOVABLE
from urdf_ik.urdf.model import Joint, UrdfModel, read, resolve_mesh

__all__ = [
    "MOVABLE",
    "Joint",
    "UrdfModel",
    "read",
    "resolve_mesh",
]
