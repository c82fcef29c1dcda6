"""Tools: an additional link at the tip, written into the URDF, so that every reader sees it."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from lxml import etree

from urdf_ik.cell.shapes import Box, Capsule, Cylinder, Mesh, Shape, Sphere
from urdf_ik.errors import ArgumentError, PoseError
from urdf_ik.model import poses, urdf
from urdf_ik.model.urdf import UrdfModel
from urdf_ik.model.xml import numbers_text, origin_attributes, require_name
from urdf_ik.support.text import quoted
from urdf_ik.typing import Array

Shapes = Sequence[Shape | tuple[Shape, Any]] | Shape
"""What a tool is made of: shapes, each alone or with its pose in the link that the tool is mounted on."""


def with_tool(model: UrdfModel, mount: str, pose: Any, shapes: Shapes, name: str) -> UrdfModel:
    """A URDF with a tool at the link ``mount``; see :meth:`urdf_ik.Arm.with_tool`."""
    centre = _one_pose(pose, "the tool's centre point")
    bodies = [_placed(shape) for shape in ([shapes] if isinstance(shapes, Shape) else shapes)]
    require_name(name, "the tool's link")
    if name in model.links:
        raise ArgumentError(f"the URDF has a link {quoted(name)} already; give the tool another name=...")
    joints = {joint.name for joint in model.joints}
    fixed = f"{name}_joint"
    while fixed in joints:
        fixed += "_"
    robot = etree.fromstring(model.xml)
    link = etree.SubElement(robot, "link", name=name)
    joint = etree.SubElement(robot, "joint", name=fixed, type="fixed")
    etree.SubElement(joint, "parent", link=mount)
    etree.SubElement(joint, "child", link=name)
    etree.SubElement(joint, "origin", origin_attributes(centre))
    to_centre = np.linalg.inv(centre)
    folders: list[Path] = []
    for kind in ("visual", "collision"):
        for shape, placed in bodies:
            part = etree.SubElement(link, kind)
            etree.SubElement(part, "origin", origin_attributes(to_centre @ placed))
            tag, attributes = _geometry(shape, folders)
            etree.SubElement(etree.SubElement(part, "geometry"), tag, attributes)
    roots = tuple(dict.fromkeys((*model.mesh_roots, *folders)))
    read = urdf.read(etree.tostring(robot, encoding="utf-8"), mesh_roots=roots)
    warnings = (*model.warnings, *read.warnings)
    return replace(read, source=model.source, path=model.path, warnings=warnings, sha256=model.sha256)


def _geometry(shape: Shape, folders: list[Path]) -> tuple[str, dict[str, str]]:
    """A shape's URDF element; the folder of a mesh is added to ``folders``."""
    if isinstance(shape, Box):
        return "box", {"size": numbers_text(shape.size)}
    if isinstance(shape, Sphere):
        return "sphere", {"radius": repr(shape.radius)}
    if isinstance(shape, Cylinder | Capsule):
        tag = "cylinder" if isinstance(shape, Cylinder) else "capsule"
        return tag, {"radius": repr(shape.radius), "length": repr(shape.length)}
    if isinstance(shape, Mesh):
        file = shape.file()
        folders.append(file.parent)
        return "mesh", {"filename": str(file), "scale": numbers_text(shape.scale)}
    raise ArgumentError(
        f"a tool cannot have a {type(shape).__name__} for a shape, which a URDF cannot hold; give Box, Sphere, "
        "Cylinder, Capsule or Mesh"
    )


def _placed(entry: Any) -> tuple[Shape, Array]:
    """A shape and its pose in the frame that it is mounted in."""
    shape, pose = entry if isinstance(entry, tuple | list) and len(entry) == 2 else (entry, np.eye(4))
    if not isinstance(shape, Shape):
        raise ArgumentError(
            f"{quoted(shape)} given as a tool's shape; give a shape such as urdf_ik.Box, or (shape, pose)"
        )
    return shape, _one_pose(pose, f"the tool's {type(shape).__name__}")


def _one_pose(pose: Any, what: str) -> Array:
    T = poses.check_poses(pose)
    if T.ndim != 2:
        raise PoseError(f"an array of shape {T.shape} given for {what}; one pose (4, 4) is needed")
    return T
