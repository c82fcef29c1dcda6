"""Arms outside Python: compiled arms that C++ and others solve from."""

from __future__ import annotations

from urdf_ik.support.lazy import attributes

__all__ = ["compile", "require_current"]

__getattr__ = attributes(__name__, {"compile": "compilation", "require_current": "compilation"})
