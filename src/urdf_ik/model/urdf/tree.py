"""What the links and joints of a URDF must hold together: names of their own, and one tree."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from urdf_ik.errors import listed, printable
from urdf_ik.model.urdf.checks import MOVABLE, Place, RawJoint, check_joint, check_name, label_of
from urdf_ik.model.xml import XACRO_HINT, child, children, is_xacro, written_tag
from urdf_ik.support.text import nearest, quoted

if TYPE_CHECKING:
    from collections.abc import Sequence

MAX_LINKS = 500
"""Pinocchio crashes on chains of a few thousand links and yourdfpy hangs before that."""
_SHOWN = 8
"""Joints or links of a circle that an error lists at most."""
VERSIONS = ("1.0", "1.1", "1.2")


def check_robot(robot: Any, source: str) -> str:
    """Name of the robot, which may be empty but not missing; its version and its parts' namespaces are known.

    Raises:
        UrdfError: no name, another version of the format, or an instruction of xacro that could have made
            links or joints.
    """
    place = Place(source, robot, "<robot>")
    name: str | None = robot.get("name")
    if name is None:
        place.fail("the robot has no name", hint='write <robot name="...">')
    if (version := robot.get("version", "1.0")) not in VERSIONS:
        place.fail(f"unknown version {quoted(version)}", hint=f"one of {', '.join(VERSIONS)}, or none")
    for element in robot:
        if is_xacro(element):
            label = f"<{written_tag(element)}>"
            Place(source, element, label).fail("an unresolved xacro instruction", hint=XACRO_HINT)
    return name


def check_links(robot: Any, source: str) -> dict[str, Any]:
    """Link elements by name, in the file's order.

    Raises:
        UrdfError: a link without a name of its own, no link, or too many.
    """
    links: dict[str, Any] = {}
    for element in children(robot, "link"):
        place = Place(source, element, label_of(element))
        name = check_name(place)
        if name in links:
            first = links[name].sourceline
            problem = f"the link name {quoted(name)} is taken by line {first}"
            place.fail(problem, hint="give each link a name of its own")
        links[name] = element
        if len(links) > MAX_LINKS:
            place.fail(f"more than {MAX_LINKS} links", hint=f"keep to {MAX_LINKS} links: split the robot")
    if not links:
        Place(source, robot, "<robot>").fail("there is no <link>", hint="a robot has one <link> at least")
    return links


def check_joints(robot: Any, links: dict[str, Any], source: str) -> list[RawJoint]:
    """Joints with sound attributes, in the file's order; their tree is not checked yet.

    Raises:
        UrdfError: a joint that is broken, or whose name or mimic clashes with another's.
    """
    joints: dict[str, RawJoint] = {}
    for element in children(robot, "joint"):
        joint = check_joint(Place(source, element, label_of(element)), links)
        if joint.name in joints:
            problem = f"the joint name {quoted(joint.name)} is taken by line {joints[joint.name].line}"
            joint.place.fail(problem, hint="give each joint a name of its own")
        joints[joint.name] = joint
        if len(joints) > MAX_LINKS:
            joint.place.fail(f"more than {MAX_LINKS} joints", hint=f"keep to {MAX_LINKS} links: split the robot")
    _check_lengths(joints)
    _check_mimics(joints)
    return list(joints.values())


def check_tree(joints: Sequence[RawJoint], links: dict[str, Any], source: str) -> str:
    """Check that the joints make one tree of all links; gives its root link.

    Raises:
        UrdfError: a link with two parents, a cycle, or several roots.
    """
    parent_of: dict[str, RawJoint] = {}
    for joint in joints:
        other = parent_of.setdefault(joint.child, joint)
        if other is not joint:
            joint.place.fail(
                f"link {quoted(joint.child)} has two parents: this joint and {quoted(other.name)} at line {other.line}",
                hint="a link is the child of one joint only; a closed loop cannot be written as a URDF",
                at=child(joint.place.element, "child"),
            )
    sound: set[str] = set()
    for link in links:
        walked: dict[str, None] = {}
        while link in parent_of and link not in sound:
            if link in walked:
                loop = list(walked)[list(walked).index(link) :]
                shown = " <- ".join(map(printable, [*loop[:_SHOWN], *(["..."] if len(loop) > _SHOWN else []), link]))
                problem = f"the links form a cycle: {shown}"
                hint = "remove the joint that closes the cycle, so that the links form a tree"
                parent_of[link].place.fail(problem, hint=hint)
            walked[link] = None
            link = parent_of[link].parent
        sound.update(walked)
    roots = [link for link in links if link not in parent_of]
    if len(roots) > 1:
        Place(source, links[roots[1]], label_of(links[roots[1]])).fail(
            f"{len(roots)} links have no parent ({listed(roots, 10)}), so the robot falls into parts",
            hint="join them with fixed joints, or remove all but one",
        )
    return roots[0]


_LOST = 1e-25
"""Share of all lengths below which one is no number that was meant: what rounding leaves of zero is 1e-17 or so."""


def _check_lengths(joints: dict[str, RawJoint]) -> None:
    """Refuse steps from joint to joint so short that they are lost beside the others, though they are not zero."""
    lengths = {name: math.hypot(*map(float, joint.origin.get("xyz", "0").split())) for name, joint in joints.items()}
    size = sum(lengths.values())
    for name, length in lengths.items():
        if 0.0 < length < _LOST * size:
            place = joints[name].place
            origin = child(place.element, "origin")
            place.fail(
                f"xyz={quoted(origin.get('xyz'))} is {length:.3g} m long, no digit beside the URDF's {size:.3g} m",
                hint='write xyz="0 0 0"',
                at=origin,
            )


def _check_mimics(joints: dict[str, RawJoint]) -> None:
    sound: set[str] = set()  # joints whose row of mimics ends at one that moves by itself
    for joint in joints.values():
        if joint.mimic is None:
            continue
        element = child(joint.place.element, "mimic")
        driver = joint.mimic[0]
        if driver not in joints:
            close = nearest(driver, joints)
            hint = "name a joint of this URDF" + (f"; did you mean {listed(close)}?" if close else "")
            joint.place.fail(f"it mimics {quoted(driver)}, and there is no such joint", hint=hint, at=element)
        if (kind := joints[driver].type) not in MOVABLE:
            why = "does not move" if kind == "fixed" else "has no single value"
            problem = f"it mimics {quoted(driver)}, a {kind} joint, which {why}"
            joint.place.fail(problem, hint=f"mimic a {', '.join(MOVABLE)} joint", at=element)
        followed = {joint.name: None}
        while driver in joints and driver not in sound:
            if driver == joint.name:
                way = " -> ".join(printable(name) for name in [*list(followed)[:_SHOWN], "..."][: len(followed)])
                problem = "it mimics itself" + (f", through {way} -> {printable(driver)}" if len(followed) > 1 else "")
                joint.place.fail(problem, hint="let one joint of the circle move by itself", at=element)
            mimic = joints[driver].mimic
            if mimic is None or driver in followed:  # a circle further on is the fault of the joints in it
                break
            followed[driver] = None
            driver = mimic[0]
        sound.update(followed)
