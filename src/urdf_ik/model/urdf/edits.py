"""A URDF's text with other origins and axes of joints, comments and all; and two URDFs joined into one."""

import re
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any, NamedTuple
from xml.parsers import expat

import numpy as np
from lxml import etree
from numpy.typing import NDArray

from urdf_ik.errors import ArgumentError, UrdfError
from urdf_ik.model.urdf.reader import read
from urdf_ik.model.urdf.urdf_model import UrdfModel
from urdf_ik.model.xml import numbers_text, open_source, origin_attributes

_ATTRIBUTE = r"""(\s{name}\s*=\s*)("[^"]*"|'[^']*')"""
_TAG_END = re.compile(r"""(?:[^"'>]|"[^"]*"|'[^']*')*>""")
_ENCODING = re.compile(r"""(<\?xml[^>]*?\sencoding\s*=\s*)("[^"]*"|'[^']*')""")


class _Tag(NamedTuple):
    """A start tag: its name, and where it begins and ends in the text's bytes."""

    name: str
    start: int
    end: int


def with_numbers(source: object, changes: Mapping[str, Mapping[str, Mapping[str, Sequence[float]]]]) -> bytes:
    """The text of a URDF in UTF-8, in which attributes of joints have new numbers.

    Args:
        source: a path, XML text, or an open file.
        changes: joint name -> 'origin', 'axis' or 'mimic' -> attribute -> numbers. An element or attribute that is
            missing is added.

    Example:
        >>> text = '<robot name="r"><!-- mine --><joint name="j"><origin xyz="0 0 1"/></joint></robot>'
        >>> print(with_numbers(text, {"j": {"origin": {"xyz": [0.0, 0.0, 1.5]}}}).decode())
        <robot name="r"><!-- mine --><joint name="j"><origin xyz="0.0 0.0 1.5"/></joint></robot>
    """
    opened = open_source(source)
    data = _ENCODING.sub(r'\1"utf-8"', opened.text, count=1).encode()
    joints = _joints(data, opened.name)
    edits: list[tuple[int, int, bytes]] = []
    for name, elements in changes.items():
        if name not in joints:
            raise UrdfError(
                f"there is no joint {name!r} in the text",
                source=opened.name,
                hint="give a URDF, not a program that makes one (xacro)",
            )
        joint, children = joints[name]
        for element, attributes in elements.items():
            if (tag := children.get(element)) is not None:
                edits.append((tag.start, tag.end, _changed(data[tag.start : tag.end].decode(), attributes).encode()))
                continue
            added = _changed(f"<{element}/>", attributes).encode()
            opening = data[joint.start : joint.end]
            if opening.endswith(b"/>"):
                opening = opening[:-2] + b">"
                edits.append((joint.start, joint.end, opening + added + f"</{joint.name}>".encode()))
            else:
                edits.append((joint.end, joint.end, added))
    for start, end, text in sorted(edits, reverse=True):
        data = data[:start] + text + data[end:]
    return data


def text_of(model: UrdfModel) -> Any:
    """What a URDF was read from, where its joints stand there as such; else its clean XML."""
    if model.path is None or not model.path.is_file():
        return model.xml
    opened = open_source(model.path)
    try:
        there = _joints(opened.text.encode(), opened.name)
    except UrdfError:
        return model.xml
    return model.path if all(joint.name in there for joint in model.joints) else model.xml


def _changed(tag: str, attributes: Mapping[str, Sequence[float]]) -> str:
    """A start tag with attributes set."""
    for name, numbers in attributes.items():
        value = numbers_text(numbers)
        tag, found = re.subn(_ATTRIBUTE.format(name=name), rf'\g<1>"{value}"', tag, count=1)
        if not found:
            close = len(tag) - (2 if tag.endswith("/>") else 1)
            tag = f'{tag[:close].rstrip()} {name}="{value}"{tag[close:]}'
    return tag


def _joints(data: bytes, source: str) -> dict[str, tuple[_Tag, dict[str, _Tag]]]:
    """The robot's joints by name, each with its first child of each name."""
    found: dict[str, tuple[_Tag, dict[str, _Tag]]] = {}
    above: list[str] = []
    parser = expat.ParserCreate("utf-8")

    def start(name: str, attributes: dict[str, str]) -> None:
        begin = parser.CurrentByteIndex
        own = len(above) == 1 and name == "joint"
        if own or above[1:] == ["joint"]:
            match = _TAG_END.match(data[begin : begin + 2**16].decode(errors="surrogateescape"))
            end = begin + len(match[0].encode(errors="surrogateescape")) if match else begin
            tag = _Tag(name, begin, end)
            if own:
                found[attributes.get("name", "")] = (tag, {})
            else:
                list(found.values())[-1][1].setdefault(name, tag)
        above.append(name)

    parser.StartElementHandler = start
    parser.EndElementHandler = lambda name: above.pop()
    try:
        parser.Parse(data, True)
    except expat.ExpatError as error:
        raise UrdfError(
            f"malformed XML: {expat.ErrorString(error.code)}",
            source=source,
            line=error.lineno,
            hint="correct the XML at this line; it is needed to write the file again as it was",
        ) from None
    return found


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
