"""The reader of a URDF from a file, text or stream; a defect in a part that is not used becomes a warning."""

import hashlib
import os
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import IO, Any

from lxml import etree

from urdf_ik.errors import UrdfError
from urdf_ik.model import formats
from urdf_ik.model.urdf import tree
from urdf_ik.model.urdf.checks import Defects, Place, label_of, together, write_joint
from urdf_ik.model.urdf.urdf_model import UrdfModel
from urdf_ik.model.xml import child, children, open_source, parse, tag, written_tag


def read(
    source: str | os.PathLike[str] | bytes | IO[str] | IO[bytes],
    *,
    mesh_roots: Sequence[str | os.PathLike[str]] = (),
    xacro_args: Mapping[str, object] | None = None,
    strict: bool = False,
) -> UrdfModel:
    """Read a URDF; a defect becomes a warning if the chain may do without the defective part.

    Args:
        source: a path, XML text, or an open text or binary file: a URDF, a MuJoCo model (MJCF), or
            a xacro, which is a program: a file whose name ends in ``.xacro``, or anything with ``xacro_args``.
        mesh_roots: folders that meshes may come from besides the URDF's own and its ROS package; meshes need not
            exist. The search for ROS packages starts here; AMENT_PREFIX_PATH and ROS_PACKAGE_PATH follow.
        xacro_args: values of a xacro's arguments by name.
        strict: whether every defect is an error.

    Returns:
        The model, with every joint's origin and axis, digit for digit as yourdfpy reads them.

    Example:
        >>> from urdf_ik.model import catalogue
        >>> model = read(catalogue.resolve("planar_2r").path)
        >>> model.name, model.root, len(model.links)
        ('planar_2r', 'base_link', 4)
    """
    folders = _folders(mesh_roots)
    opened, lost = formats.as_urdf(open_source(source), folders, xacro_args)
    original, defects = parse(opened), Defects()
    for error in lost:
        defects.add("collision", error, collides="<collision>" in (error.element or ""))
    name = tree.check_robot(original, opened.name, defects)
    every = tree.check_links(original, opened.name, defects)
    joints, written = tree.check_joints(original, every, opened.name, defects)
    root, joints, names = tree.check_tree(joints, written, every, opened.name, defects)
    joints = tree.check_mimics(joints, written, defects)

    # URDF 1.1 is the first in which urdfdom reads capsules, and the last in which both readers know rpy only.
    clean = etree.Element("robot", name=name, version="1.1")
    write_materials(clean, original, opened.name)
    write_links(clean, names, opened.name, defects)
    if strict and defects.found:
        raise together([each.error for each in defects.found])
    for joint in joints:
        write_joint(clean, joint, written[joint.name])
    xml = etree.tostring(clean, encoding="utf-8", xml_declaration=True, pretty_print=True)
    return UrdfModel(
        name=name,
        source=opened.name,
        path=opened.path,
        xml=xml,
        links=tuple(names),
        joints=tuple(joints),
        root=root,
        mesh_roots=folders,
        warnings=tuple(defects.found),
        sha256=hashlib.sha256(opened.text.encode()).hexdigest(),
    )


def _folders(roots: Iterable[str | os.PathLike[str]] | str | os.PathLike[str]) -> tuple[Path, ...]:
    return tuple(Path(root).absolute() for root in ([roots] if isinstance(roots, str | os.PathLike) else roots))


_SHAPES = {"box": {"size": 3}, "cylinder": {"radius": 1, "length": 1}, "sphere": {"radius": 1}}
_SHAPES["capsule"] = _SHAPES["cylinder"]
_INERTIA = ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")


def write_links(robot: Any, links: dict[str, Any], source: str, defects: Defects) -> None:
    """Append every link to the clean tree; omit its defective parts and record them.

    Shapes, inertia and colours do not affect kinematics, so a defect does not stop the reader. But after the first part
    that it cannot read, Pinocchio drops the rest of the link, collision shapes included, and yourdfpy refuses the whole
    file. The clean XML therefore omits a defective part, and the defect is recorded.
    """
    for name, element in links.items():
        link = etree.SubElement(robot, "link", name=name)
        parts = [("inertial", _inertial)] if child(element, "inertial") is not None else []
        for kind, write in (*parts, ("visual", _visual), ("collision", _shape)):
            found = list(children(element, kind))
            for part in found[:1] if kind == "inertial" else found:
                place = Place(source, part, f"<{kind}> of {label_of(element)}")
                out = etree.Element(tag(part))
                try:
                    write(place, out)
                except UrdfError as error:
                    defects.add(kind, error)
                else:
                    link.append(out)


def write_materials(robot: Any, original: Any, source: str) -> None:
    """Append the colours that links refer to by name, without the defective ones."""
    written: set[str] = set()
    for element in children(original, "material"):
        name = element.get("name")
        if name not in written and child(element, "color") is not None:
            written.update([name] if _material(Place(source, element, "<material>"), element, robot) else [])


def _inertial(place: Place, out: Any) -> None:
    _write_origin(place, out)
    for name, attributes in (("mass", ("value",)), ("inertia", _INERTIA)):
        element = child(place.element, name)
        if element is None:
            place.fail(f"<{name}> is missing", hint=f"write <{name} .../> or leave out the <inertial>")
        etree.SubElement(out, name, {each: place.numbers(element, each, 1)[0] for each in attributes})


def _visual(place: Place, out: Any) -> None:
    _shape(place, out)
    material = child(place.element, "material")
    if material is not None:
        _material(place, material, out)


def _shape(place: Place, out: Any) -> None:
    name = place.element.get("name")
    if name is not None:
        out.set("name", name)
    _write_origin(place, out)
    geometry = child(place.element, "geometry")
    shape: Any = None if geometry is None else next((each for each in geometry if isinstance(each.tag, str)), None)
    if shape is None:
        place.fail("it has no shape", hint=f"write <geometry> with one of {', '.join(_SHAPES)}, mesh")
    if tag(shape) == "mesh":
        attributes = _mesh(place, shape)
    elif tag(shape) in _SHAPES:
        attributes = {name: _lengths(place, shape, name, count) for name, count in _SHAPES[tag(shape)].items()}
    else:
        place.fail(f"unknown shape <{written_tag(shape)}>", hint=f"one of {', '.join(_SHAPES)}, mesh")
    etree.SubElement(etree.SubElement(out, "geometry"), tag(shape), attributes)


def _mesh(place: Place, shape: Any) -> dict[str, str]:
    if not shape.get("filename"):
        place.fail("a mesh without a filename", hint='write <mesh filename="..."/>', at=shape)
    if shape.get("scale") is None:
        return {"filename": shape.get("filename")}
    scale = place.in_range(shape, "scale", place.numbers(shape, "scale", 3))
    return {"filename": shape.get("filename"), "scale": " ".join(scale)}


def _lengths(place: Place, shape: Any, attribute: str, count: int) -> str:
    values = place.in_range(shape, attribute, place.numbers(shape, attribute, count))
    if any(float(value) < 0 for value in values):
        place.fail(f"{attribute}={shape.get(attribute)!r} is negative", hint="write lengths in metres", at=shape)
    return " ".join(values)


def _write_origin(place: Place, out: Any) -> None:
    origin = place.origin(place.element)
    if origin:
        etree.SubElement(out, "origin", origin)


def _material(place: Place, element: Any, out: Any) -> bool:
    """Write a material if every reader takes it; return whether it was written."""
    name, color = element.get("name"), child(element, "color")
    if not name:
        return False
    try:
        rgba = [] if color is None else place.numbers(color, "rgba", 4)
    except UrdfError:
        return False
    if not all(0 <= float(value) <= 1 for value in rgba):
        return False
    written = etree.SubElement(out, "material", name=name)
    if rgba:
        etree.SubElement(written, "color", rgba=" ".join(rgba))
    return True
