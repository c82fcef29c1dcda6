"""Mesh files: the folders that they may come from, and the checks before a reader opens them.

Mesh readers open every further file that a mesh names (the buffers of a glTF, the materials of an OBJ), in any folder,
and build every placed copy of a part. The checks here therefore run first.
"""

from __future__ import annotations

import json
import re
import stat
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any
from urllib.parse import unquote

import numpy as np
from lxml import etree

from urdf_ik.errors import UrdfError, printable
from urdf_ik.model import ros_packages
from urdf_ik.model.xml import XACRO_HINT, has_xacro
from urdf_ik.support.text import quoted
from urdf_ik.support.tolerances import LARGEST

KINDS = (".stl", ".dae", ".obj", ".ply", ".off", ".glb", ".gltf")
MAX_BYTES = 64 * 2**20
"""Greatest size of a mesh's file, and of all its parts counted as often as it places them [bytes]."""
MAX_TOGETHER = 4 * MAX_BYTES
"""Greatest size of all the collision meshes of a URDF [bytes]."""

_MATERIALS = re.compile(rb"^[ \t]*mtllib[ \t]+(.+?)[ \t\r]*$", re.MULTILINE)
_NO_NUMBER = re.compile(rb"^[ \t]*v(?:ertex)?[ \t][^\n]*?(?:nan|inf)[^\n]*$", re.MULTILINE | re.IGNORECASE)
_STL_HEAD = 84
_STL_FACE = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
_GLB, _JSON = b"glTF", 0x4E4F534A
_PART = 64
"""Size counted for each part of a mesh besides its own data [bytes]."""
_HINT = (
    "add the folder that holds it, or its package, to mesh_roots (--mesh-root), or name the package's folder in "
    "AMENT_PREFIX_PATH or ROS_PACKAGE_PATH"
)


def resolve(filename: str, roots: Sequence[Path], source: str) -> Path:
    """Find a mesh inside ``roots`` or in a ROS package: see :func:`urdf_ik.model.urdf.resolve_mesh`."""
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
    return ros_packages.find(rest.partition("/")[0], roots) if scheme == "package" else None


def _candidates(filename: str, roots: Sequence[Path]) -> list[Path] | None:
    """Paths that the filename may mean, in the order of the roots; None for an unknown kind of address."""
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
        if ros_packages.is_package(root, package):
            out.append(root / within.lstrip("/"))
    return out


def check(path: Path, roots: Sequence[Path], source: str) -> None:
    """Refuse a mesh that would open other files than those of its folders, or grow beyond ``MAX_BYTES``.

    Args:
        path: the mesh's file.
        roots: folders that it may open further files from.
        source: what the error calls the place that names the mesh.

    Raises:
        UrdfError: of an unknown kind, too large, broken, or it leads out of the folders.
    """
    file = _File(path, roots, source)
    data = file.read(path)
    match path.suffix.lower():
        case ".obj":
            _check_lines(file, data)
            for line in _MATERIALS.findall(data.replace(b"\\\n", b" ").replace(b"\\\r\n", b" ")):
                file.require_inside(line.decode(errors="replace"))
        case ".gltf" | ".glb":
            _check_gltf(file, data)
        case ".dae":
            _check_collada(file, data)
        case ".stl":
            if len(data) == _STL_HEAD + _STL_FACE.itemsize * int.from_bytes(data[80:_STL_HEAD], "little"):
                faces = np.frombuffer(data, _STL_FACE, offset=_STL_HEAD)
                check_vertices(faces["corners"].reshape(-1, 3), path, source)
            else:
                _check_lines(file, data)
        case ".ply" | ".off":
            pass
        case other:
            raise file.error(f"meshes of the kind {quoted(other)} are not read", f"one of {', '.join(KINDS)}")


def check_all(paths: Sequence[Path], roots: Sequence[Path], source: str) -> None:
    """:func:`check` each of the meshes of a URDF, and that they are not too large together.

    Raises:
        UrdfError: one of them is refused, or they come to more than ``MAX_TOGETHER``.
    """
    for path in paths:
        check(path, roots, source)
    if sum(path.stat().st_size for path in paths) > MAX_TOGETHER:
        raise UrdfError(
            f"its meshes come to more than {MAX_TOGETHER >> 20} MiB", source=source, hint="simplify the meshes"
        )


def check_vertices(vertices: Any, path: Path, source: str) -> None:
    """Refuse vertices (k, 3) m that are not finite: what has them touches everything, or nothing.

    Raises:
        UrdfError: one of them is not finite, or beyond ``LARGEST``.
    """
    bad = np.flatnonzero(~(np.abs(np.asarray(vertices)) <= LARGEST).all(axis=-1))
    if len(bad):
        where = _File(path, (), source)
        raise where.error(f"vertex {bad[0]} is {np.asarray(vertices)[bad[0]].tolist()}", "correct the mesh")


class _File:
    """A mesh's file, with the folders that it may open further files from."""

    def __init__(self, path: Path, roots: Sequence[Path], source: str) -> None:
        # A mesh of a ROS package lies in none of the folders; what lies beside it is its own.
        self.path, self._roots, self._source = path, (*roots, path.parent), source

    def error(self, problem: str, hint: str) -> UrdfError:
        return UrdfError(problem, source=self._source, element=f"mesh {printable(self.path, 200)}", hint=hint)

    def read(self, path: Path) -> bytes:
        """The whole file, if it is one of bounded size."""
        try:
            status = path.stat()
            if not stat.S_ISREG(status.st_mode):
                raise self.error(f"{printable(path, 200)} is no regular file", "give a file")
            if status.st_size > MAX_BYTES:
                raise self.error(f"{printable(path.name)} is larger than {MAX_BYTES >> 20} MiB", "simplify the mesh")
            return path.read_bytes()
        except OSError as failure:
            raise self.error(f"cannot read: {failure.strerror or failure}", "check its path and rights") from None

    def require_inside(self, name: str) -> None:
        """Refuse a further file that is there and lies outside the folders; one that is missing is not opened."""
        try:
            found = (self.path.parent / name).resolve()
            inside = any(found.is_relative_to(root.resolve()) for root in self._roots)
            if inside and found.exists():
                self.read(found)
        except (OSError, ValueError, RuntimeError) as failure:
            raise self.error(f"it names the file {quoted(name)}: {failure}", "correct the name") from None
        if not inside:
            folders = ", ".join(printable(root, 200) for root in self._roots)
            raise self.error(
                f"it names the file {quoted(name)}, which leads outside the mesh roots ({folders})",
                "add its folder to mesh_roots",
            )


def _check_lines(file: _File, data: bytes) -> None:
    """Refuse lines that give a vertex by words instead of numbers, as 'nan'."""
    found = _NO_NUMBER.search(data)
    if found is not None:
        line = " ".join(found[0].decode(errors="replace").split())
        raise file.error(f"the vertex {quoted(line)} is not finite", "correct the mesh")


def _check_gltf(file: _File, data: bytes) -> None:
    try:
        scene = json.loads(_json_of_glb(data) if data[:4] == _GLB else data)
        addresses = [part.get("uri") for kind in ("buffers", "images") for part in scene.get(kind, ())]
        counts = [
            sum(int(scene["accessors"][each.get("indices", each["attributes"]["POSITION"])]["count"])
                for each in mesh["primitives"]) for mesh in scene.get("meshes", ())
        ]  # fmt: skip
        nodes = scene.get("nodes", [])
        sizes = [16 * counts[node["mesh"]] if "mesh" in node else 0 for node in nodes]
        parts = [[int(k) for k in node.get("children", ())] for node in nodes]
        # Each node is the child of one other at most; where it is of more, readers place it that often.
        total = _grown(file, sizes, parts)
    except UrdfError:
        raise
    except (AttributeError, IndexError, KeyError, RecursionError, TypeError, ValueError) as failure:
        raise file.error(f"no valid glTF: {type(failure).__name__} {printable(failure)}", "export it again") from None
    for address in addresses:
        if isinstance(address, str) and not address.startswith("data:"):
            file.require_inside(unquote(address))
    _require_small(file, total)


def _json_of_glb(data: bytes) -> bytes:
    length, kind = (int.from_bytes(data[k : k + 4], "little") for k in (12, 16))
    if kind != _JSON:
        raise ValueError("the first chunk is not JSON")
    return data[20 : 20 + length]


def _check_collada(file: _File, data: bytes) -> None:
    # Its size is bounded and its entities stay as they are, so that the tree is no larger than the file makes it.
    parser = etree.XMLParser(
        resolve_entities=False, no_network=True, huge_tree=True, recover=True, remove_comments=True
    )
    root = etree.fromstring(data, parser) if data.strip() else None
    if root is None:
        raise file.error("no valid COLLADA", "export it again")
    if root.getroottree().docinfo.internalDTD is not None:
        raise file.error("a DOCTYPE is refused", "delete the DOCTYPE and its entities")
    sizes: list[int] = []
    parts: list[list[int]] = []
    names: dict[str, int] = {}
    placing = list(root.iter("{*}node", "{*}geometry", "{*}controller", "{*}visual_scene"))
    places = {each: k for k, each in enumerate(placing)}
    for k, each in enumerate(placing):
        if each.get("id") is not None:
            names.setdefault(each.get("id"), k)
    for each in placing:
        is_geometry = etree.QName(each).localname == "geometry"
        sizes.append(sum(len(part.text or "") for part in each.iter()) if is_geometry else 0)
        addresses = [part.get("url") or part.get("source") or "" for part in each]
        held = [names.get(address.removeprefix("#"), -1) for address in addresses]
        parts.append([k for k in (*held, *(places.get(part, -1) for part in each)) if k >= 0])
    _require_small(file, _grown(file, sizes, parts))


def _grown(file: _File, sizes: list[int], parts: list[list[int]]) -> int:
    """Size [bytes] of the largest part together with all parts that it places."""
    grown: dict[int, int] = {}
    for first in range(len(sizes)):
        waiting: list[tuple[int, bool]] = [(first, False)]
        open_: set[int] = set()
        while waiting:
            k, done = waiting.pop()
            if done:
                open_.discard(k)
                grown[k] = min(sizes[k] + _PART + sum(grown[part] for part in parts[k]), MAX_BYTES + 1)
            elif k not in grown:
                if k in open_:
                    raise file.error("its nodes hold themselves", "export it again")
                open_.add(k)
                waiting.append((k, True))
                waiting += [(part, False) for part in parts[k] if part not in grown]
    return max(grown.values(), default=0)


def _require_small(file: _File, total: int) -> None:
    if total > MAX_BYTES:
        raise file.error(
            f"its parts, placed as often as it says, come to more than {MAX_BYTES >> 20} MiB", "simplify the mesh"
        )


def opened(path: Path, roots: Sequence[Path], source: str) -> Any:
    """Read a mesh file with trimesh, as a ``trimesh.Scene``, after :func:`check`.

    Raises:
        UrdfError: as :func:`check`; it cannot be read; a vertex is not finite.
    """
    import trimesh
    from trimesh.resolvers import Resolver

    check(path, roots, source)
    file = _File(path, roots, source)

    class Confined(Resolver):
        """Gives trimesh further files only from inside the folders."""

        def __init__(self) -> None:
            pass

        def get(self, name: str) -> bytes:
            file.require_inside(name)
            return file.read((path.parent / name).resolve())

        def keys(self) -> Iterator[str]:
            return iter(())

        def namespaced(self, namespace: str) -> Any:
            return self

        def write(self, name: str, data: Any) -> None:
            raise NotImplementedError

    try:
        with path.open("rb") as data:
            scene = trimesh.load_scene(data, file_type=path.suffix.lower()[1:], resolver=Confined(), process=False)
    except UrdfError:
        raise
    except Exception as failure:  # whatever a file of unknown origin makes its reader raise
        raise file.error(f"cannot read: {printable(failure, 200)}", "export it again") from None
    for mesh in scene.geometry.values():
        if isinstance(mesh, trimesh.Trimesh):
            check_vertices(mesh.vertices, path, source)  # first: trimesh would drop them in silence
            mesh.merge_vertices()
    return scene
