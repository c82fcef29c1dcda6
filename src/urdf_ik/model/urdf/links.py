"""Links in the clean XML: the shapes, inertia and colours that every URDF reader understands.

None of these affects kinematics, so a defect does not stop the reader. But after the first part that it cannot read,
Pinocchio drops the rest of the link, collision shapes included, and yourdfpy refuses the whole file. The clean XML
therefore omits a defective part, and the defect is recorded.
"""

from typing import Any

from lxml import etree

from urdf_ik.errors import UrdfError
from urdf_ik.model.urdf.checks import Place, label_of
from urdf_ik.model.urdf.defects import Defects
from urdf_ik.model.xml import child, children, tag, written_tag

_SHAPES: dict[str, dict[str, int]] = {
    "box": {"size": 3},
    "cylinder": {"radius": 1, "length": 1},
    "sphere": {"radius": 1},
}
_SHAPES["capsule"] = _SHAPES["cylinder"]
_INERTIA = ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")


def write_links(robot: Any, links: dict[str, Any], source: str, defects: Defects) -> None:
    """Append every link to the clean tree; omit its defective parts and record them."""
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
