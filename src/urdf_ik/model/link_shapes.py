"""Triangle meshes of a URDF's links: their visual shapes, else their collision shapes."""

from typing import Any

import numpy as np
import trimesh
from lxml import etree

from urdf_ik.errors import UrdfIkError
from urdf_ik.model.meshes import read_scene
from urdf_ik.model.urdf.urdf_model import UrdfModel, resolve_mesh
from urdf_ik.model.xml import floats, origin_of

_GREY = (180, 180, 185)
COARSE = 400
"""Faces that a mesh has at most where it is read coarsely."""
_FINEST, _COARSER = 64, 1.3  # cells along the longest edge at first, and how much larger the next ones are


Body = tuple[str, trimesh.Trimesh]
"""A link, and the triangles [m] of one of its shapes in the link's frame, with colours."""


def read(model: UrdfModel, *, coarse: bool = False) -> tuple[list[Body], tuple[str, ...]]:
    """The visual shapes of a URDF; where it has none that can be read, its collision shapes.

    Args:
        model: the URDF.
        coarse: with at most ``COARSE`` faces a mesh, for pictures that are drawn face by face.

    Returns:
        The bodies in the order of the links, and a sentence for each shape that cannot be read.
    """
    bodies, missing = _of_kind(model, "visual", coarse)
    if bodies:
        return bodies, tuple(missing)
    bodies, more = _of_kind(model, "collision", coarse)
    return bodies, (*missing, *more)


def joined(meshes: list[trimesh.Trimesh]) -> trimesh.Trimesh:
    """One mesh without colours."""
    starts = np.cumsum([0, *(len(mesh.vertices) for mesh in meshes[:-1])])
    return trimesh.Trimesh(
        np.concatenate([mesh.vertices for mesh in meshes]),
        np.concatenate([mesh.faces + start for mesh, start in zip(meshes, starts, strict=True)]),
        process=False,
    )


def capsule(radius: float, length: float, count: list[int]) -> Any:
    """A ``Trimesh``, its middle at the origin, along z; trimesh puts it there, or one of its ends, by its version."""
    mesh = trimesh.creation.capsule(length, radius, count=count)
    return mesh.apply_translation(-mesh.bounds.mean(axis=0))


def simplified(mesh: trimesh.Trimesh, most: int) -> trimesh.Trimesh:
    """``mesh`` without colours and with at most ``most`` faces: vertices in one cell of a grid become one.

    Rossignac and Borrel, "Multi-resolution 3D approximations for rendering complex scenes", 1993: unlike others, it
    takes any triangles, such as the loose ones of a drawing program. The cells grow until the faces are few enough.
    """
    cell = float(np.ptp(mesh.vertices, axis=0).max()) / _FINEST or 1.0
    small = mesh
    while len(small.faces) > most:
        small = trimesh.Trimesh(mesh.vertices / cell, mesh.faces, process=False)
        small.merge_vertices(merge_tex=True, merge_norm=True, digits_vertex=0)
        small.update_faces(small.nondegenerate_faces() & small.unique_faces())
        small.vertices *= cell
        cell *= _COARSER
    return small


def _of_kind(model: UrdfModel, kind: str, coarse: bool) -> tuple[list[Body], list[str]]:
    tree = etree.fromstring(model.xml)
    colours = {each.get("name"): each for each in tree.iterfind("material")}
    bodies: list[Body] = []
    missing: list[str] = []
    for body in tree.iterfind(f"link/{kind}"):
        link = body.getparent().get("name")
        geometry = body.find("geometry")[0]
        try:
            meshes = _meshes(geometry, model, coarse)
        except Exception as error:  # whatever a file of unknown origin makes its reader raise
            missing.append(str(error) if isinstance(error, UrdfIkError) else f"{link}: a mesh cannot be read: {error}")
            continue
        T = origin_of(body)
        rgba = _colour(body.find("material"), colours)
        for mesh in meshes:
            mesh.apply_transform(T)
            if rgba is not None or geometry.tag != "mesh":
                mesh.visual = trimesh.visual.ColorVisuals(mesh, face_colors=_GREY if rgba is None else rgba)
            bodies.append((link, mesh))
    return bodies, missing


def _colour(material: Any, shared: dict[str, Any]) -> list[int] | None:
    """Red, green, blue, opacity, 0 to 255; None for a shape without a colour."""
    if material is None:
        return None
    own = material.find("color")
    if own is None and material.get("name") in shared:
        own = shared[material.get("name")].find("color")
    return None if own is None else [round(255 * x) for x in floats(own, "rgba", (0.0,) * 4)]


def _meshes(geometry: Any, model: UrdfModel, coarse: bool) -> list[Any]:
    """The triangles of one shape, without its origin."""
    if geometry.tag == "mesh":
        return _read_mesh(geometry, model, coarse)
    if geometry.tag == "box":
        return [trimesh.creation.box(floats(geometry, "size"))]
    radius = float(geometry.get("radius"))
    if geometry.tag == "sphere":
        return [trimesh.creation.icosphere(subdivisions=2 if coarse else 3, radius=radius)]
    length = float(geometry.get("length"))
    if geometry.tag == "cylinder":
        return [trimesh.creation.cylinder(radius, length, sections=16 if coarse else 32)]
    return [capsule(radius, length, [8, 16] if coarse else [32, 32])]


def _read_mesh(geometry: Any, model: UrdfModel, coarse: bool) -> list[Any]:
    path = resolve_mesh(model, geometry.get("filename"))
    scene = read_scene(path, model.source)
    meshes = [each for each in scene.dump() if isinstance(each, trimesh.Trimesh) and len(each.faces)]
    scale = np.diag([*floats(geometry, "scale", (1.0, 1.0, 1.0)), 1.0])
    meshes = [each.apply_transform(scale) for each in meshes]
    return [simplified(joined(meshes), COARSE)] if coarse and meshes else meshes
