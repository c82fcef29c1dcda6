"""What a URDF's links look like: their visual shapes, else their collision shapes, as triangles."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
import trimesh
from lxml import etree

from urdf_ik.errors import UrdfIkError
from urdf_ik.poses import pose
from urdf_ik.urdf import resolve_mesh

if TYPE_CHECKING:
    from collections.abc import Callable

    from urdf_ik.urdf import UrdfModel

_GREY = (180, 180, 185)


@dataclass(frozen=True, eq=False)
class Shape:
    """One body of a link.

    Attributes:
        link: the link.
        mesh: its triangles [m] in the link's frame, with colours.
    """

    link: str
    mesh: trimesh.Trimesh


@dataclass(frozen=True, eq=False)
class Shapes:
    """Every body that could be read, and a sentence for each that could not.

    Attributes:
        bodies: in the order of the links.
        missing: why the others are not there.
    """

    bodies: tuple[Shape, ...]
    missing: tuple[str, ...]


def read(model: UrdfModel) -> Shapes:
    """The visual shapes of a URDF; where it has none that can be read, its collision shapes."""
    visual = _of_kind(model, "visual")
    if visual.bodies:
        return visual
    collision = _of_kind(model, "collision")
    return Shapes(collision.bodies, (*visual.missing, *collision.missing))


def _of_kind(model: UrdfModel, kind: str) -> Shapes:
    tree = etree.fromstring(model.xml)
    colours = {each.get("name"): each for each in tree.iterfind("material")}
    bodies, missing = [], []
    for body in tree.iterfind(f"link/{kind}"):
        link = body.getparent().get("name")
        geometry = body.find("geometry")[0]
        try:
            meshes = _MAKE[geometry.tag](geometry, model)
        except Exception as error:  # whatever a file of unknown origin makes its reader raise
            missing.append(str(error) if isinstance(error, UrdfIkError) else f"{link}: a mesh cannot be read: {error}")
            continue
        origin = body.find("origin")
        T = np.eye(4) if origin is None else pose(_numbers(origin, "xyz", 3), rpy=_numbers(origin, "rpy", 3))
        rgba = _colour(body.find("material"), colours)
        for mesh in meshes:
            mesh.apply_transform(T)
            if rgba is not None or geometry.tag != "mesh":
                mesh.visual = trimesh.visual.ColorVisuals(mesh, face_colors=_GREY if rgba is None else rgba)
            bodies.append(Shape(link, mesh))
    return Shapes(tuple(bodies), tuple(missing))


def _numbers(element: Any, name: str, count: int, otherwise: float = 0.0) -> list[float]:
    return [float(x) for x in (element.get(name) or "").split()] or [otherwise] * count


def _colour(material: Any, shared: dict[str, Any]) -> list[int] | None:
    """Red, green, blue, opacity, 0 to 255; None where the shape has no colour of its own."""
    if material is None:
        return None
    own = material.find("color")
    if own is None and material.get("name") in shared:
        own = shared[material.get("name")].find("color")
    return None if own is None else [round(255 * x) for x in _numbers(own, "rgba", 4)]


def _box(geometry: Any, _: UrdfModel) -> list[Any]:
    return [trimesh.creation.box(_numbers(geometry, "size", 3))]


def _cylinder(geometry: Any, _: UrdfModel) -> list[Any]:
    return [trimesh.creation.cylinder(float(geometry.get("radius")), float(geometry.get("length")))]


def _sphere(geometry: Any, _: UrdfModel) -> list[Any]:
    return [trimesh.creation.icosphere(subdivisions=3, radius=float(geometry.get("radius")))]


def _capsule(geometry: Any, _: UrdfModel) -> list[Any]:
    length = float(geometry.get("length"))
    return [trimesh.creation.capsule(length, float(geometry.get("radius"))).apply_translation([0, 0, -0.5 * length])]


def _mesh(geometry: Any, model: UrdfModel) -> list[Any]:
    scene = trimesh.load_scene(resolve_mesh(model, geometry.get("filename")))
    meshes = [each for each in scene.dump() if isinstance(each, trimesh.Trimesh) and len(each.faces)]
    scale = np.diag([*_numbers(geometry, "scale", 3, 1.0), 1.0])
    return [each.apply_transform(scale) for each in meshes]


_MAKE: dict[str, Callable[[Any, UrdfModel], list[Any]]] = {
    "box": _box,
    "cylinder": _cylinder,
    "sphere": _sphere,
    "capsule": _capsule,
    "mesh": _mesh,
}
