"""Arms outside Python: compiled arms that C++ and others solve from."""

from __future__ import annotations

from urdf_ik.support.lazy import attributes

__all__ = ["c", "compile", "cpp", "require_current"]

__getattr__ = attributes(
    __name__, {"c": "one_file", "compile": "compilation", "cpp": "one_file", "require_current": "compilation"}
)
