"""The parts of an SRDF that are read: pairs of links that may touch, and named chains."""

import os
from collections.abc import Collection
from contextlib import suppress
from pathlib import Path
from typing import Any

from urdf_ik.errors import UrdfError
from urdf_ik.model.urdf.checks import Defects, UrdfWarning
from urdf_ik.model.xml import child, children, open_source, parse, tag
from urdf_ik.support.text import meant

__all__ = ["chain_groups", "disabled_pairs", "groups_beside"]

_FOLDERS = (".", "../srdf", "../config", "../moveit")
"""Folders that may hold a URDF's SRDF, relative to the URDF's folder."""
_MOST = 20
_ELEMENTS = (
    "disable_collisions", "enable_collisions", "disable_default_collisions", "group", "group_state", "end_effector",
    "virtual_joint", "passive_joint", "joint_property", "link_sphere_approximation", "rotor_params", "specificities",
)  # fmt: skip
"""Elements of an SRDF (MoveIt's srdfdom, and Pinocchio's rotor_params)."""
_LINKS = ("link1", "link2", "base_link", "tip_link", "parent_link", "child_link", "link")
"""Attributes that name links."""
_ATTRIBUTES = (
    *_LINKS, "name", "reason", "parent_group", "group", "component_name", "type", "parent_frame", "value",
    "joint_name", "property_name", "center", "radius", "mass", "gear_ratio",
)  # fmt: skip
"""Attributes of these elements, and of what they hold."""


def disabled_pairs(source: str | os.PathLike[str] | bytes, links: Collection[str]) -> tuple[tuple[str, str], ...]:
    """Pairs of links, in the file's order, of the ``<disable_collisions>`` elements of an SRDF.

    Those of other links are left out: an SRDF often serves a robot with and without its hand. See :func:`defects_of`.

    Args:
        source: a path, or XML text.
        links: names of the URDF's links.

    Raises:
        UrdfError: the SRDF cannot be read.
    """
    found = children(_opened(source)[0], "disable_collisions")
    pairs = [(each.get("link1"), each.get("link2")) for each in found]
    return tuple((first, second) for first, second in pairs if first in links and second in links)


def defects_of(source: str | os.PathLike[str] | bytes, links: Collection[str]) -> tuple[UrdfWarning, ...]:
    """Elements and attributes that SRDF does not have, and links that the URDF does not have, in one warning.

    Raises:
        UrdfError: the SRDF cannot be read.
    """
    root, name = _opened(source)
    found, missing = Defects(), dict[str, Any]()

    def slip(rule: str, at: Any, problem: str, wrong: str, valid: Collection[str]) -> None:
        problem, hint = f"{problem}{meant(wrong, valid)}", f"one of {', '.join(valid)}"
        found.add(rule, UrdfError(problem, source=name, line=at.sourceline, element=f"<{tag(at)}>", hint=hint))

    for element in root.iterchildren("{*}*"):
        kind = tag(element)
        if kind and kind not in _ELEMENTS:
            slip("srdf element", element, "SRDF has no such element", kind, _ELEMENTS)
        for each in filter(tag, element.iter("{*}*")):
            for key in each.attrib if kind in _ELEMENTS and kind != "specificities" else ():
                if key not in _ATTRIBUTES and "}" not in key:
                    slip("srdf element", each, f"SRDF has no attribute {key!r}", key, _ATTRIBUTES)
            named = [each.get(key) for key in _LINKS] + ([each.get("name")] if tag(each) == "link" else [])
            missing |= {link: each for link in named if link and link not in links and link not in missing}
    if missing:
        first = next(iter(missing))
        shown = ", ".join(list(missing)[:_MOST]) + (f" ... ({len(missing)})" if len(missing) > _MOST else "")
        problem = f"the URDF has no link{'s' * (len(missing) > 1)} {shown}"
        slip("srdf link", missing[first], problem, first, links)
    return tuple(found.found)


def chain_groups(
    source: str | os.PathLike[str] | bytes, links: Collection[str], *, strict: bool = True
) -> tuple[tuple[str, tuple[str, str]], ...]:
    """Read the ``<group>`` elements of an SRDF that hold one ``<chain>``.

    Args:
        source: a path, or XML text.
        links: names of the URDF's links.
        strict: whether a link that the URDF does not have is an error; else its group is left out.

    Returns:
        Name, and base link and tip link, of each such group, in the file's order.

    Raises:
        UrdfError: the SRDF cannot be read, or names a link that the URDF does not have.

    Example:
        >>> text = '<robot name="r"><group name="arm"><chain base_link="base" tip_link="hand"/></group></robot>'
        >>> chain_groups(text, ["base", "hand"])
        (('arm', ('base', 'hand')),)
    """
    root, name = _opened(source)
    groups = []
    for group in children(root, "group"):
        found = list(children(group, "chain"))
        ends = [each.get(key) for each in found for key in ("base_link", "tip_link")]
        if len(found) == 1 and group.get("name") and (strict or all(end in links for end in ends)):
            groups.append((group.get("name"), _two_links(found[0], "base_link", "tip_link", links, name)))
    return tuple(groups)


def groups_beside(path: Path, robot: str, links: Collection[str]) -> dict[str, tuple[str, str]]:
    """The groups with a ``<chain>`` in the SRDFs beside a URDF.

    The search covers the URDF's own folder, and ``srdf``, ``config`` and ``moveit`` beside it. An SRDF counts if it
    has the robot's name. An SRDF that cannot be read, or that names links of another URDF, is skipped.

    Args:
        path: the URDF's file.
        robot: its robot's name.
        links: names of its links.

    Returns:
        Base link and tip link by the group's name, those of the file with the URDF's name first.
    """
    groups: dict[str, tuple[str, str]] = {}
    for file in _beside(path, robot):
        with suppress(UrdfError):
            groups = dict(chain_groups(file, links)) | groups
    return groups


def _beside(path: Path, robot: str) -> list[Path]:
    """The SRDFs of a robot beside its URDF, the one with the URDF's name first."""
    found = []
    for file in (file for folder in _FOLDERS for file in sorted((path.parent / folder).glob("*.srdf"))[:_MOST]):
        with suppress(UrdfError):
            found += [file] * (_opened(file)[0].get("name") == robot)
    return sorted(found, key=lambda each: each.stem != path.name.split(".")[0])


def _opened(source: str | os.PathLike[str] | bytes) -> tuple[Any, str]:
    """The root element of an SRDF, and the file's name in messages."""
    opened = open_source(source)
    root = parse(opened)
    if child(root, "link") is not None or child(root, "joint") is not None:
        raise UrdfError("this is a URDF, not an SRDF", source=opened.name, hint="give the SRDF that belongs to it")
    return root, opened.name


def _two_links(element: Any, first: str, second: str, links: Collection[str], source: str) -> tuple[str, str]:
    """The two links that an element names."""
    pair = []
    for attribute in (first, second):
        name = element.get(attribute)
        if name not in links:
            problem = f"{attribute} is missing" if name is None else f"{attribute}={name!r}: the URDF has no such link"
            hint, label = meant(name or "", links).removeprefix("; ") or f"links: {', '.join(links)}", tag(element)
            raise UrdfError(problem, source=source, line=element.sourceline, element=f"<{label}>", hint=hint)
        pair.append(name)
    return pair[0], pair[1]
