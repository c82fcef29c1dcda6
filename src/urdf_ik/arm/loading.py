"""From a URDF to an arm that is ready to be solved."""

from __future__ import annotations

import os
import re
from pathlib import Path
from typing import IO, TYPE_CHECKING, Any

from urdf_ik import catalogue, urdf
from urdf_ik.arm.arm import Arm
from urdf_ik.chain import from_urdf

if TYPE_CHECKING:

    from collections.abc import Mapping, Sequence


def load(
    source: str | os.PathLike[str] | IO[Any],
    base: str | None = None,
    tip: str | None = None,
    *,
    locked: Mapping[str, float] | None = None,
    mesh_roots: Sequence[str | os.PathLike[str]] = (),
) -> Arm:
    """Read a URDF and prepare its solver.

    Args:
        source: a path, XML text, an open file, or a catalogue name such as 'zyyzyz_6r' or 'ur5'.
        base: base link; default: the root, where only one chain comes into question.
        tip: tip link; default: the end of the only movable chain.
        locked: joints of the chain that are held at these values [rad or m]; the arm is that of the others. An arm
            with more than seven joints needs it to be solved.
        mesh_roots: folders that meshes may be read from, besides the URDF's own.

    Raises:
        UrdfError: the URDF is broken; the error names line, element and hint.
        ChainError: base, tip or a locked joint is unknown, or base or tip ambiguous; the error lists the candidates.
        JointVectorError: a locked joint's value is no finite number.
        CatalogueError: a name that the catalogue does not hold.
        UnsupportedArm: a joint of the chain cannot be handled.

    Example:
        >>> load("zyyzyz_6r")
        <Arm 'zyyzyz_6r': base_link to tool0, 6R spherical wrist, 2||3 and 1x2>
    """
    if isinstance(source, str) and _is_name(source):
        entry = catalogue.resolve(source)
        source = entry.path
        base, tip = entry.base if base is None else base, entry.tip if tip is None else tip
        mesh_roots = (*([mesh_roots] if isinstance(mesh_roots, str | os.PathLike) else mesh_roots), *entry.package_dirs)
    model = urdf.read(source, mesh_roots=mesh_roots)
    return Arm(model, from_urdf(model, base, tip).lock({} if locked is None else locked))


def _is_name(source: str) -> bool:
    """Whether ``source`` can only be meant as a catalogue name: no markup, no folder, no ending, no such file."""
    if not re.fullmatch(r"[\w-]+", source):
        return False
    try:
        return not Path(source).exists()
    except OSError:  # too long to be the name of a file
        return True
