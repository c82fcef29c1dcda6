"""The reader of a URDF from a file, text or stream; a defect in a part that is not used becomes a warning."""

import hashlib
import os
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import IO

from lxml import etree

from urdf_ik.model import formats
from urdf_ik.model.urdf import links, tree
from urdf_ik.model.urdf.checks import write_joint
from urdf_ik.model.urdf.defects import Defects, together
from urdf_ik.model.urdf.urdf_model import UrdfModel
from urdf_ik.model.xml import open_source, parse


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
    links.write_materials(clean, original, opened.name)
    links.write_links(clean, names, opened.name, defects)
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
