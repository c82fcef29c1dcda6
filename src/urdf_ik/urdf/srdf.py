"""Pairs of links that an SRDF allows to touch."""

from __future__ import annotations

import difflib
from typing import TYPE_CHECKING

from urdf_ik.errors import UrdfError
from urdf_ik.urdf.xml import child, children, open_source, parse

if TYPE_CHECKING:
    import os
    from collections.abc import Collection

__all__ = ["disabled_pairs"]


def disabled_pairs(source: str | os.PathLike[str] | bytes, links: Collection[str]) -> tuple[tuple[str, str], ...]:
    """Read the ``<disable_collisions>`` of an SRDF; its other elements are not looked at.

    Args:
        source: a path, or XML text.
        links: names of the URDF's links.

    Returns:
        Pairs of link names, in the file's order.

    Raises:
        UrdfError: the SRDF cannot be read, or names a link that the URDF does not have.
    """
    opened = open_source(source)
    root = parse(opened)
    if child(root, "link") is not None or child(root, "joint") is not None:
        raise UrdfError("this is a URDF, not an SRDF", source=opened.name, hint="give the SRDF that belongs to it")
    pairs = []
    for element in children(root, "disable_collisions"):
        pair = []
        for attribute in ("link1", "link2"):
            name = element.get(attribute)
            if name not in links:
                close = difflib.get_close_matches(name or "", links, n=3)
                raise UrdfError(
                    f"{attribute} is missing" if name is None else f"{attribute}={name!r}: the URDF has no such link",
                    source=opened.name,
                    line=element.sourceline,
                    element="<disable_collisions>",
                    hint=f"did you mean {' or '.join(close)}?" if close else f"links: {', '.join(links)}",
                )
            pair.append(name)
        pairs.append((pair[0], pair[1]))
    return tuple(pairs)
