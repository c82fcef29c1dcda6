"""The conversion of xacro and MJCF to URDF."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from pathlib import Path

from urdf_ik.errors import UrdfError
from urdf_ik.model import mjcf, xacro_files
from urdf_ik.model.xml import Source, prolog_end

_XACRO_NAME = re.compile(r"\.xacro$", re.IGNORECASE)
_MUJOCO = re.compile(r"<mujoco[\s/>]")


def as_urdf(
    source: Source, roots: Sequence[Path], xacro_args: Mapping[str, object] | None
) -> tuple[Source, tuple[UrdfError, ...]]:
    """The source as URDF text.

    Args:
        source: the opened file or text.
        roots: folders that are searched first for ROS packages.
        xacro_args: values of a xacro's arguments; not None makes any source a xacro.

    Returns:
        The URDF, and an error for each shape that a URDF cannot hold.

    Raises:
        UrdfError: the xacro or the MJCF cannot be read.
        MissingPackage: the package that reads it is not installed.
    """
    if xacro_args is not None or _XACRO_NAME.search(source.name):
        return xacro_files.expanded(source, roots, xacro_args or {}), ()
    if _MUJOCO.match(source.text, prolog_end(source.text)):
        return mjcf.as_urdf(source)
    return source, ()
