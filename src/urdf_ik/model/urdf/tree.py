"""Checks of all links and joints of a URDF together: unique names, one tree, no circles of mimics."""

from collections.abc import Iterable, Mapping
from dataclasses import replace
from typing import Any

from urdf_ik.errors import UrdfError, listed
from urdf_ik.model.urdf.checks import MOVABLE, Defects, Joint, Place, Written, check_joint, check_name, label_of
from urdf_ik.model.xml import XACRO_HINT, child, children, is_xacro, written_tag
from urdf_ik.support.text import meant

MAX_LINKS = 500
"""Pinocchio crashes on chains of a few thousand links and yourdfpy hangs before that."""
_SHOWN = 8
"""An error lists at most so many joints or links of a circle."""
VERSIONS = ("1.0", "1.1", "1.2")


def check_robot(robot: Any, source: str, defects: Defects) -> str:
    """Name of the robot, or ''; unresolved xacro instructions are recorded as defects."""
    place = Place(source, robot, "<robot>")
    if (version := robot.get("version", "1.0")) not in VERSIONS:
        place.fail(f"unknown version {version!r}", hint=f"one of {', '.join(VERSIONS)}, or none")
    name: str | None = robot.get("name")
    if name is None:
        defects.add("robot name", place.error("the robot has no name", hint='write <robot name="...">'))
    for element in robot:
        if is_xacro(element):
            left = Place(source, element, f"<{written_tag(element)}>")
            defects.add("robot xacro", left.error("an unresolved xacro instruction", hint=XACRO_HINT))
    return name or ""


def check_links(robot: Any, source: str, defects: Defects) -> dict[str, Any]:
    """Link elements by name, in the file's order; links without a name, or with one that is taken, are omitted."""
    links: dict[str, Any] = {}
    for element in children(robot, "link"):
        place = Place(source, element, label_of(element))
        name: str = element.get("name") or ""
        try:
            check_name(place)
        except UrdfError as error:
            defects.add("link xacro" if name else "link name", error, links=[name] if name else [])
        if name in links:
            problem = f"the link name {name!r} is taken by line {links[name].sourceline}"
            twice = place.error(problem, hint="give each link a different name")
            defects.add("link twice", twice, links=[name], collides=_collides([element]))
        elif name:
            links[name] = element
        if len(links) > MAX_LINKS:
            place.fail(f"more than {MAX_LINKS} links", hint=f"keep to {MAX_LINKS} links: split the robot")
    if not links:
        left = defects.found[0].error if defects.found else None
        hint = left.hint if left is not None and left.hint == XACRO_HINT else "a robot has one <link> at least"
        Place(source, robot, "<robot>").fail("there is no <link>", hint=hint)
    return links


def check_joints(
    robot: Any, links: dict[str, Any], source: str, defects: Defects
) -> tuple[list[Joint], dict[str, Written]]:
    """Joints between two links, in the file's order, and their texts by name; tree and mimics are not checked yet."""
    joints: dict[str, Joint] = {}
    written: dict[str, Written] = {}
    for count, element in enumerate(children(robot, "joint"), 1):
        place = Place(source, element, label_of(element))
        if count > MAX_LINKS:
            place.fail(f"more than {MAX_LINKS} joints", hint=f"keep to {MAX_LINKS} links: split the robot")
        if (checked := check_joint(place, links, joints, defects)) is not None:
            joint, written[checked[0].name] = checked
            joints[joint.name] = joint
    return list(joints.values()), written


def check_tree(
    joints: list[Joint], written: Mapping[str, Written], links: dict[str, Any], source: str, defects: Defects
) -> tuple[str, list[Joint], dict[str, Any]]:
    """The root link, and the joints and links of its tree: of several trees the one with most moving joints."""
    parent_of: dict[str, Joint] = {}
    for joint in joints:
        other = parent_of.setdefault(joint.child, joint)
        if other is not joint:
            place = written[joint.name].place
            problem = f"link {joint.child!r} has two parents: this joint and {other.name!r} at line {other.line}"
            hint = "a link is the child of one joint only; a closed loop cannot be written as a URDF"
            error = place.error(problem, hint=hint, at=child(place.element, "child"))
            defects.add("two parents", error, joints=[other.name, joint.name])
    first = next((link for link in links if link not in parent_of), "")
    if len(parent_of) + 1 == len(links) == len(_below(first, parent_of)):  # one tree
        return first, list(parent_of.values()), links
    circles = _circles(links, parent_of, written)
    trees = {root: _below(root, parent_of) for root in links if root not in parent_of}
    if not trees:
        raise circles[0][0]
    moving = {root: sum(parent_of[link].type in MOVABLE for link in tree - {root}) for root, tree in trees.items()}
    root = max(trees, key=lambda each: moving[each])  # the first in the file if several have as many
    for start, apart in trees.items():
        if start != root:
            error = Place(source, links[start], label_of(links[start])).error(
                f"{len(trees)} links have no parent ({listed(trees, 10)}), so the robot falls into parts",
                hint="join them with fixed joints, or remove all but one",
            )
            circles.append((error, apart))
    for error, apart in circles:
        carriers = [parent_of[link] for link in links if link in apart and link in parent_of]
        moving_apart = [joint.name for joint in carriers if joint.type in MOVABLE]
        collides = _collides(links[link] for link in apart)
        defects.add("parts", error, joints=moving_apart, links=sorted(apart), collides=collides)
    kept = {link: element for link, element in links.items() if link in trees[root]}
    return root, [joint for joint in parent_of.values() if joint.child in kept], kept


def check_mimics(joints: list[Joint], written: Mapping[str, Written], defects: Defects) -> list[Joint]:
    """The joints, without each ``<mimic>`` that names no movable joint; a circle of mimics loses one of them."""
    by_name = {joint.name: joint for joint in joints}
    for joint in joints:
        name = joint.name
        if joint.mimic is not None and (error := _refused_driver(joint, by_name, written[name].place)) is not None:
            by_name[name] = replace(joint, mimic=None)
            defects.add("mimic", error, joints=[name])
    for circle in _loops({name: joint.mimic[0] for name, joint in by_name.items() if joint.mimic is not None}):
        k = circle.index(first := min(circle, key=list(by_name).index))
        shown = _shown([*circle[k:], *circle[:k], first], " -> ")
        problem = "it mimics itself" + (f", through {shown}" if len(circle) > 1 else "")
        hint, place = "let one joint of the circle move by itself", written[first].place
        error = place.error(problem, hint=hint, at=child(place.element, "mimic"))
        defects.add("mimic", error, joints=[first])
        by_name[first] = replace(by_name[first], mimic=None)
    return list(by_name.values())


def _loops(after: Mapping[str, str]) -> list[list[str]]:
    """Every circle of names, each of which the next one is ``after``."""
    loops: list[list[str]] = []
    known: set[str] = set()
    for start in after:
        walked: list[str] = []
        name = start
        while name in after and name not in known:
            known.add(name)
            walked.append(name)
            name = after[name]
        if name in walked:
            loops.append(walked[walked.index(name) :])
    return loops


def _shown(circle: list[str], mark: str) -> str:
    """A circle in words, its last name the first one again."""
    return mark.join([*circle[:-1][:_SHOWN], *["..."] * (len(circle) > _SHOWN + 1), circle[-1]])


def _below(root: str, parent_of: Mapping[str, Joint]) -> set[str]:
    """The links of the tree below a link, itself included."""
    carried: dict[str, list[str]] = {}
    for link, joint in parent_of.items():
        carried.setdefault(joint.parent, []).append(link)
    found, waiting = {root}, [root]
    while waiting:
        new = [link for link in carried.get(waiting.pop(), ()) if link not in found]
        found.update(new)
        waiting += new
    return found


def _circles(
    links: Mapping[str, Any], parent_of: Mapping[str, Joint], written: Mapping[str, Written]
) -> list[tuple[UrdfError, set[str]]]:
    """For each circle of links its error, and the links in it and below it."""
    circles = []
    for loop in _loops({link: parent_of[link].parent for link in links if link in parent_of}):
        problem = f"the links form a cycle: {_shown([*loop, loop[0]], ' <- ')}"
        hint = "remove the joint that closes the cycle, so that the links form a tree"
        place = written[parent_of[loop[0]].name].place
        circles.append((place.error(problem, hint=hint), _below(loop[0], parent_of)))
    return circles


def _collides(elements: Iterable[Any]) -> bool:
    """Whether one of these links has a collision shape."""
    return any(child(element, "collision") is not None for element in elements)


def _refused_driver(joint: Joint, joints: Mapping[str, Joint], place: Place) -> UrdfError | None:
    """The error of a joint that mimics a missing joint, or one without a single value."""
    driver = joint.mimic[0] if joint.mimic else ""
    element = child(place.element, "mimic")
    if driver not in joints:
        hint = f"name a joint of this URDF{meant(driver, joints)}"
        return place.error(f"it mimics {driver!r}, and there is no such joint", hint=hint, at=element)
    if (kind := joints[driver].type) not in MOVABLE:
        why = "does not move" if kind == "fixed" else "has no single value"
        problem = f"it mimics {driver!r}, a {kind} joint, which {why}"
        return place.error(problem, hint=f"mimic a {', '.join(MOVABLE)} joint", at=element)
    return None
