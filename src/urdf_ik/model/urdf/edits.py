"""A URDF with other origins and axes of joints, comments and all; and two URDFs joined into one."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from lxml import etree
from numpy.typing import NDArray

from urdf_ik.errors import ArgumentError, UrdfError
from urdf_ik.model.urdf.reader import read
from urdf_ik.model.urdf.urdf_model import UrdfModel
from urdf_ik.model.xml import child, children, numbers_text, open_source, origin_attributes, parse


def with_numbers(source: object, changes: Mapping[str, Mapping[str, Mapping[str, Sequence[float]]]]) -> bytes:
    """The text of a URDF in UTF-8, in which attributes of joints have new numbers.

    Args:
        source: a path, XML text, or an open file.
        changes: joint name -> 'origin', 'axis' or 'mimic' -> attribute -> numbers. An element or attribute that is
            missing is added.

    Example:
        >>> text = '<robot name="r"><!-- mine --><joint name="j"><origin xyz="0 0 1"/></joint></robot>'
        >>> print(with_numbers(text, {"j": {"origin": {"xyz": [0.0, 0.0, 1.5]}}}).decode(), end="")
        <robot name="r"><!-- mine --><joint name="j"><origin xyz="0.0 0.0 1.5"/></joint></robot>
    """
    opened = open_source(source)
    robot = parse(opened)
    joints = _joints(robot)
    for name, elements in changes.items():
        if name not in joints:
            hint = "give a URDF, not a program that makes one (xacro)"
            raise UrdfError(f"there is no joint {name!r} in the text", source=opened.name, hint=hint)
        for element, attributes in elements.items():
            changed = child(joints[name], element)
            if changed is None:
                changed = etree.Element(element)
                joints[name].insert(0, changed)
            changed.attrib.update({key: numbers_text(numbers) for key, numbers in attributes.items()})
    whole = [*reversed(list(robot.itersiblings(preceding=True))), robot, *robot.itersiblings()]
    return b"".join(etree.tostring(each, encoding="utf-8", with_tail=False) + b"\n" for each in whole)


def text_of(model: UrdfModel) -> Any:
    """What a URDF was read from, where its joints stand there as such; else its clean XML."""
    if model.path is None or not model.path.is_file():
        return model.xml
    try:
        there = _joints(parse(open_source(model.path)))
    except UrdfError:
        return model.xml
    return model.path if all(joint.name in there for joint in model.joints) else model.xml


def _joints(robot: Any) -> dict[str, Any]:
    """The elements of the robot's joints by name."""
    return {joint.get("name", ""): joint for joint in children(robot, "joint")}


_NAMING = ("link", "joint", "material")


def joined(model: UrdfModel, other: UrdfModel, link: str, pose: NDArray[np.float64], prefix: str) -> UrdfModel:
    """Fix the root of ``other`` to ``link`` of ``model`` at ``pose`` (4, 4) m; its names get ``prefix``."""
    robot, added = etree.fromstring(model.xml), etree.fromstring(other.xml)
    taken = {(each.tag, each.get("name")) for each in robot if each.tag in _NAMING}
    for element in added.iter():
        if element.tag in _NAMING and element.get("name") is not None:
            element.set("name", prefix + element.get("name"))
        for attribute in ("link", "joint"):
            if element.tag in ("parent", "child", "mimic") and element.get(attribute) is not None:
                element.set(attribute, prefix + element.get(attribute))
    for element in added:
        if (element.tag, element.get("name")) in taken:
            raise ArgumentError(f"{element.tag} {element.get('name')!r} is there twice; give another name=...")
        robot.append(element)
    joint = etree.SubElement(robot, "joint", name=f"{prefix}mount", type="fixed")
    etree.SubElement(joint, "origin", origin_attributes(pose))
    etree.SubElement(joint, "parent", link=link)
    etree.SubElement(joint, "child", link=prefix + other.root)
    folders = [each.path.parent for each in (model, other) if each.path is not None]
    roots = tuple(dict.fromkeys((*model.mesh_roots, *other.mesh_roots, *folders)))
    whole = read(etree.tostring(robot, encoding="utf-8"), mesh_roots=roots)
    there = (each.within(prefix) for each in other.warnings)
    return replace(whole, source=model.source, warnings=(*model.warnings, *there, *whole.warnings))
