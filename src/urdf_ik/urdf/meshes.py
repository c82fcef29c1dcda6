"""Mesh filenames, confined to the folders that they may come from."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from urdf_ik.errors import UrdfError
from urdf_ik.text import quoted
from urdf_ik.urdf import packages
from urdf_ik.urdf.xml import XACRO_HINT, has_xacro

if TYPE_CHECKING:
    from collections.abc import Sequence

_HINT = (
    "add the folder that holds it, or its package, to mesh_roots, or name the package's folder in AMENT_PREFIX_PATH or "
    "ROS_PACKAGE_PATH"
)


def resolve(filename: str, roots: Sequence[Path], source: str) -> Path:
    """Find a mesh inside ``roots`` or in a ROS package: see :func:`urdf_ik.urdf.resolve_mesh`."""
    element = f"<mesh filename={quoted(filename)}>"
    searched = ", ".join(map(str, roots)) or "none"

    def error(problem: str, hint: str) -> UrdfError:
        return UrdfError(problem, source=source, element=element, hint=hint)

    if has_xacro(filename):
        raise error("the filename holds an unresolved xacro expression", XACRO_HINT)
    package = _package(filename, roots)
    if package is not None:
        roots = (*roots, package)
        searched = ", ".join(map(str, roots))
    if not roots:
        raise error("there is no folder to look in", "give mesh_roots=[...]: this URDF did not come from a path")
    candidates = _candidates(filename, roots)
    if candidates is None:
        raise error("unknown kind of address", "use package://, file:// or a path relative to the URDF")
    inside = outside = False
    for candidate in candidates:
        try:
            found = candidate.resolve()  # follows symbolic links, so that none of them leads out
            if not any(found.is_relative_to(root.resolve()) for root in roots):
                outside = True
                continue
            inside = True
            if found.is_file():
                return found
        except (OSError, ValueError, RuntimeError) as problem:  # a null byte, a loop of links, no right to look
            raise error(f"cannot look for it: {problem}", "check the filename") from None
    if outside:
        missed = "not found inside the mesh roots, and it" if inside else "it"
        raise error(f"{missed} leads outside the mesh roots ({searched})", "add its folder to mesh_roots")
    raise error(f"not found; searched {searched}", _HINT)


def _package(filename: str, roots: Sequence[Path]) -> Path | None:
    """Folder of the ROS package that the address names, None for another kind of address or an unknown package."""
    scheme, _, rest = filename.partition("://")
    return packages.find(rest.partition("/")[0], roots) if scheme == "package" else None


def _candidates(filename: str, roots: Sequence[Path]) -> list[Path] | None:
    """Places the name may mean, in the order of the roots; None for an address of another kind."""
    scheme, separator, rest = filename.partition("://")
    if not separator:
        return [root / filename for root in roots]
    if scheme == "file":
        return [root / rest for root in roots]
    if scheme not in ("package", "model"):
        return None
    package, _, within = rest.partition("/")
    out = []
    for root in roots:
        out.append(root / rest.lstrip("/"))
        if packages.is_package(root, package):
            out.append(root / within.lstrip("/"))
    return out
