"""Small changes of a URDF, each with the joint or link that it is about, and rewritings that change nothing."""

import math
import random
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from lxml import etree

from urdf_ik.arm import Arm


@dataclass(frozen=True)
class Mutant:
    """A changed URDF.

    Attributes:
        what: the change.
        xml: the URDF.
        names: joints or links, one of which must be named.
    """

    what: str
    xml: bytes
    names: tuple[str, ...]


def _tree(arm: Arm) -> etree._Element:
    return etree.fromstring(arm.model.xml)


def _joint(tree: etree._Element, name: str) -> etree._Element:
    return next(each for each in tree.iterfind("joint") if each.get("name") == name)


def _numbers(element: etree._Element | None, name: str) -> list[float]:
    text = None if element is None else element.get(name)
    return [float(x) for x in text.split()] if text else [0.0, 0.0, 0.0]


def _set(joint: etree._Element, tag: str, name: str, values: list[float]) -> None:
    element = joint.find(tag)
    if element is None:
        element = etree.SubElement(joint, tag)
    element.set(name, " ".join(map(repr, map(float, values))))


def _turned(joint: etree._Element, degrees: float, axis: int) -> None:
    """Turn a joint's origin about an axis of the parent."""
    roll, pitch, yaw = _numbers(joint.find("origin"), "rpy")
    _set(joint, "origin", "rpy", rpy_of(_rotation(axis, math.radians(degrees)) @ rotation_of(roll, pitch, yaw)))


def _rotation(axis: int, angle: float) -> np.ndarray:
    c, s = math.cos(angle), math.sin(angle)
    R = np.eye(3)
    i, k = [(1, 2), (2, 0), (0, 1)][axis]
    R[i, i], R[i, k], R[k, i], R[k, k] = c, -s, s, c
    return R


def rotation_of(roll: float, pitch: float, yaw: float) -> np.ndarray:
    """(3, 3) of fixed angles."""
    return _rotation(2, yaw) @ _rotation(1, pitch) @ _rotation(0, roll)


def rpy_of(R: np.ndarray) -> list[float]:
    """Fixed angles of a rotation (3, 3)."""
    pitch = math.atan2(-R[2, 0], math.hypot(R[0, 0], R[1, 0]))
    if math.hypot(R[0, 0], R[1, 0]) < 1e-9:
        return [math.atan2(-R[1, 2], R[1, 1]), pitch, 0.0]
    return [math.atan2(R[2, 1], R[2, 2]), pitch, math.atan2(R[1, 0], R[0, 0])]


def mutants(arm: Arm) -> Iterator[Mutant]:
    """Every change that must be found."""
    names = arm.joint_names
    middle, late = names[len(names) // 2], names[-1]
    path = arm.model.path_between(arm.base, arm.tip)

    def mutant(what: str, *about: str) -> Mutant:
        return Mutant(what, etree.tostring(tree), about)

    tree = _tree(arm)
    joint = _joint(tree, middle)
    axis = _numbers(joint.find("axis"), "xyz") if joint.find("axis") is not None else [1.0, 0.0, 0.0]
    _set(joint, "axis", "xyz", [-x for x in axis])
    yield mutant("an axis negated", middle)

    tree = _tree(arm)
    first, second = _joint(tree, names[0]), _joint(tree, names[1])
    first.set("name", names[1])
    second.set("name", names[0])
    yield mutant("two joints swapped in order", names[0], names[1])

    for k, name in enumerate((names[0], middle, late)):
        tree = _tree(arm)
        joint = _joint(tree, name)
        xyz = _numbers(joint.find("origin"), "xyz")
        xyz[k] += 1e-4
        _set(joint, "origin", "xyz", xyz)
        yield mutant(f"origin of {name} moved by 0.1 mm", name)
        tree = _tree(arm)
        _turned(_joint(tree, name), 0.01, k)
        yield mutant(f"origin of {name} turned by 0.01 degrees", name)

    limited = [joint for joint in path if joint.type == "revolute" and joint.name in names]
    if limited:
        tree = _tree(arm)
        limit = _joint(tree, limited[0].name).find("limit")
        limit.set("upper", repr(float(limit.get("upper")) - math.radians(1.0)))
        yield mutant("a limit cut by 1 degree", limited[0].name)

    tree = _tree(arm)
    _turned(_joint(tree, path[-1].name), 0.5, 0)
    yield mutant("the tip frame turned", path[-1].name, arm.tip)

    tree = _tree(arm)
    _joint(tree, middle).set("name", "renamed_joint")
    for mimic in tree.iterfind("joint/mimic"):
        if mimic.get("joint") == middle:
            mimic.set("joint", "renamed_joint")
    yield mutant("a joint renamed", middle)

    driven = {each[1] for each in arm.chain.followers}
    alone = [name for name in names[1:] if name not in driven]
    if alone:
        tree = _tree(arm)
        etree.SubElement(_joint(tree, alone[-1]), "mimic").set("joint", names[0])
        yield mutant("a mimic added", alone[-1])

    tree = _tree(arm)
    meshes = tree.findall("link/collision/geometry/mesh") or tree.findall("link/visual/geometry/mesh")
    if meshes:
        body = meshes[0].getparent().getparent()
        link = body.getparent()
        link.remove(body)
        yield mutant("a mesh removed", str(link.get("name")))


def rewritten(arm: Arm) -> Iterator[Mutant]:
    """Every rewriting that must pass."""
    tree = _tree(arm)
    etree.indent(tree, "\t\t")
    tree.insert(0, etree.Comment(" another comment "))
    yield Mutant("other spacing and a comment", etree.tostring(tree, pretty_print=True), ())

    tree = _tree(arm)
    for element in tree.iter():
        attributes = sorted(element.attrib.items(), reverse=True)
        for name in list(element.attrib):
            del element.attrib[name]
        for name, value in attributes:
            element.set(name, value)
    links, joints = tree.findall("link"), tree.findall("joint")
    random.Random(0).shuffle(links)
    for element in (*joints, *links):
        tree.remove(element)
        tree.append(element)
    yield Mutant("attributes and elements in another order", etree.tostring(tree), ())

    tree = _tree(arm)
    for element in tree.iter("origin"):
        for name in ("xyz", "rpy"):
            if element.get(name):
                element.set(name, " ".join(f"{float(x):.12f}" for x in element.get(name).split()))
    yield Mutant("decimals rounded at 1e-12", etree.tostring(tree), ())

    merged = merged_fixed_joints(arm)
    if merged is not None:
        yield Mutant("fixed joints merged", merged, ())


def merged_fixed_joints(arm: Arm) -> bytes | None:
    """Every fixed joint whose child is a link on the way to the tip taken into the joints that it carries."""
    tree = _tree(arm)
    changed = False
    for joint in [each for each in arm.model.path_between(arm.base, arm.tip)[1:] if each.type == "fixed"]:
        child = joint.child
        if child == arm.tip or any(step.parent == child and step.child == arm.base for step in arm.model.joints):
            continue
        element = _joint(tree, joint.name)
        xyz, rpy = (_numbers(element.find("origin"), name) for name in ("xyz", "rpy"))
        T = np.eye(4)
        T[:3, :3], T[:3, 3] = rotation_of(*rpy), xyz
        parent = element.find("parent").get("link")
        for other in tree.findall("joint"):
            if other.find("parent").get("link") == child:
                _shift(other, T)
                other.find("parent").set("link", parent)
        link, into = (
            next(each for each in tree.iterfind("link") if each.get("name") == name) for name in (child, parent)
        )
        for body in (*link.findall("collision"), *link.findall("visual")):
            _shift(body, T)
            into.append(body)
        tree.remove(link)
        tree.remove(element)
        changed = True
    return etree.tostring(tree) if changed else None


def _shift(element: etree._Element, T: np.ndarray) -> None:
    """Give an element's origin in a frame that ``T`` (4, 4) carries."""
    own = np.eye(4)
    own[:3, :3] = rotation_of(*_numbers(element.find("origin"), "rpy"))
    own[:3, 3] = _numbers(element.find("origin"), "xyz")
    own = T @ own
    if element.find("origin") is None:
        element.insert(0, etree.Element("origin"))
    _set(element, "origin", "xyz", list(own[:3, 3]))
    _set(element, "origin", "rpy", rpy_of(own[:3, :3]))
