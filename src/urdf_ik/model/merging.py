"""The merge of two URDFs: a fixed joint attaches the second to a link of the first."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from lxml import etree
from numpy.typing import NDArray

from urdf_ik.errors import ArgumentError
from urdf_ik.model.poses import to_rpy
from urdf_ik.model.urdf import UrdfModel, read

_NAMING = ("link", "joint", "material")


def joined(model: UrdfModel, other: UrdfModel, link: str, pose: NDArray[np.float64], prefix: str) -> UrdfModel:
    """Fix the root of ``other`` to ``link`` of ``model`` at ``pose`` (4, 4) m; its names get ``prefix``.

    Raises:
        ArgumentError: ``model`` already has one of the prefixed names.
    """
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
    etree.SubElement(joint, "origin", xyz=_numbers(pose[:3, 3]), rpy=_numbers(to_rpy(pose)))
    etree.SubElement(joint, "parent", link=link)
    etree.SubElement(joint, "child", link=prefix + other.root)
    folders = [each.path.parent for each in (model, other) if each.path is not None]
    roots = tuple(dict.fromkeys((*model.mesh_roots, *other.mesh_roots, *folders)))
    whole = read(etree.tostring(robot, encoding="utf-8"), mesh_roots=roots)
    there = (each.within(prefix) for each in other.warnings)
    return replace(whole, source=model.source, warnings=(*model.warnings, *there, *whole.warnings))


def _numbers(values: NDArray[np.float64]) -> str:
    return " ".join(repr(float(value) + 0.0) for value in values)
