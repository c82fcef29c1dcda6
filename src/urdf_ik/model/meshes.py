"""Mesh files and ROS packages: the folders in which they are looked up, and the reader of meshes."""

import os
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from lxml import etree

from urdf_ik.errors import UrdfError
from urdf_ik.model.xml import XACRO_HINT, has_xacro
from urdf_ik.support.tolerances import LARGEST

_HINT = (
    "add the folder that holds it, or its package, to mesh_roots (--mesh-root), or name the package's folder in "
    "AMENT_PREFIX_PATH or ROS_PACKAGE_PATH"
)


def resolve(filename: str, roots: Sequence[Path], source: str) -> Path:
    """Find a mesh inside ``roots`` or in a ROS package: see :func:`urdf_ik.model.urdf.resolve_mesh`."""
    element = f"<mesh filename={filename!r}>"

    def error(problem: str, hint: str) -> UrdfError:
        return UrdfError(problem, source=source, element=element, hint=hint)

    if has_xacro(filename):
        raise error("the filename holds an unresolved xacro expression", XACRO_HINT)
    scheme, _, rest = filename.partition("://")
    if scheme == "package" and (package := find_package(rest.partition("/")[0], roots)) is not None:
        roots = (*roots, package)
    searched = ", ".join(map(str, roots))
    if not roots:
        raise error("there is no folder to look in", "give mesh_roots=[...]: this URDF did not come from a path")
    candidates = _candidates(filename, roots)
    if candidates is None:
        raise error("unknown kind of address", "use package://, file:// or a path relative to the URDF")
    inside = outside = False
    for candidate in candidates:
        found = candidate.resolve()  # follows symbolic links, so that none of them leads out
        if not any(found.is_relative_to(root.resolve()) for root in roots):
            outside = True
            continue
        inside = True
        if found.is_file():
            return found
    if outside:
        missed = "not found inside the mesh roots, and it" if inside else "it"
        raise error(f"{missed} leads outside the mesh roots ({searched})", "add its folder to mesh_roots")
    raise error(f"not found; searched {searched}", _HINT)


def _candidates(filename: str, roots: Sequence[Path]) -> list[Path] | None:
    """Paths that the filename may mean, in the order of the roots; None for an unknown kind of address."""
    scheme, separator, rest = filename.partition("://")
    if not separator or scheme == "file":
        return [root / (rest or filename) for root in roots]
    if scheme not in ("package", "model"):
        return None
    package, _, within = rest.partition("/")
    out = []
    for root in roots:
        out.append(root / rest.lstrip("/"))
        if is_package(root, package):
            out.append(root / within.lstrip("/"))
    return out


def check_vertices(vertices: Any, path: Path, source: str) -> None:
    """Refuse vertices (k, 3) m that are not finite: what has them touches everything, or nothing."""
    bad = np.flatnonzero(~(np.abs(np.asarray(vertices)) <= LARGEST).all(axis=-1))
    if len(bad):
        raise _error(f"vertex {bad[0]} is {np.asarray(vertices)[bad[0]].tolist()}", path, source, "correct the mesh")


def read_scene(path: Path, source: str) -> Any:
    """Read a mesh file with trimesh, as a ``trimesh.Scene``."""
    import trimesh

    try:
        scene = trimesh.load_scene(path, process=False)
    except Exception as failure:  # trimesh's readers have no common class of errors
        raise _error(f"cannot read: {failure}", path, source, "export it again") from None
    for mesh in scene.geometry.values():
        if isinstance(mesh, trimesh.Trimesh):
            check_vertices(mesh.vertices, path, source)  # first: trimesh would drop them in silence
            mesh.merge_vertices()
    return scene


def _error(problem: str, path: Path, source: str, hint: str) -> UrdfError:
    return UrdfError(problem, source=source, element=f"mesh {path}", hint=hint)


MANIFEST = "package.xml"
DEEPEST = 5
"""Greatest depth of the search below the folders of ROS_PACKAGE_PATH."""


def find_package(name: str, roots: Sequence[Path]) -> Path | None:
    """The folder of a ROS package.

    Args:
        name: the package's name.
        roots: folders that are searched first: each is a package itself, or holds packages.

    Returns:
        The folder; None if neither ``roots`` nor AMENT_PREFIX_PATH nor ROS_PACKAGE_PATH has it.
    """
    if not name or name != Path(name).name or name == "..":
        return None
    for root in roots:
        if is_package(root, name):
            return root
        if (root / name).is_dir():
            return root / name
    return next(_in_environment(name), None)


def own_package(file: Path) -> Path | None:
    """The folder of a file's ROS package: the nearest parent folder with a package.xml."""
    return next((folder for folder in file.parents if (folder / MANIFEST).is_file()), None)


def is_package(folder: Path, name: str) -> bool:
    """Whether a folder is the package of that name, by its manifest or by its own name."""
    manifest = folder / MANIFEST
    if folder.name == name or not manifest.is_file():
        return folder.name == name
    try:
        parser = etree.XMLParser(resolve_entities=False, no_network=True)
        return bool(etree.parse(str(manifest), parser).getroot().findtext("name", "").strip() == name)
    except (OSError, etree.XMLSyntaxError):
        return False


def _in_environment(name: str) -> Iterator[Path]:
    """The package's folders by AMENT_PREFIX_PATH (ROS 2), then by ROS_PACKAGE_PATH (ROS 1)."""
    for prefix in _folders("AMENT_PREFIX_PATH"):
        if (prefix / "share" / name).is_dir():
            yield prefix / "share" / name
    for root in _folders("ROS_PACKAGE_PATH"):
        waiting = [(root, 0)]
        for folder, depth in waiting:
            if (folder / MANIFEST).is_file():
                if is_package(folder, name):
                    yield folder
            elif depth < DEEPEST:
                waiting += [(each, depth + 1) for each in _below(folder)]


def _below(folder: Path) -> list[Path]:
    try:
        return sorted(each for each in folder.iterdir() if each.is_dir() and not each.name.startswith("."))
    except OSError:
        return []


def _folders(variable: str) -> list[Path]:
    return [Path(each) for each in os.environ.get(variable, "").split(os.pathsep) if each]
