"""Arms outside Python: compiled arms, one-file C++ and C, a page that needs no server."""

from urdf_ik.support.lazy import attributes

__all__ = ["c", "compile", "cpp", "html", "require_current"]

__getattr__ = attributes(
    __name__,
    {"c": "one_file", "compile": "compilation", "cpp": "one_file", "html": "page", "require_current": "compilation"},
)
