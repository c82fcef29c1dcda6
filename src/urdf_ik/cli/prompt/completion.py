"""Shell completion: names and files of robots, their links, files of numbers."""

from __future__ import annotations

import glob
from contextlib import suppress
from pathlib import Path
from typing import Any

from urdf_ik.errors import UrdfIkError


def robots_and_files(incomplete: str) -> list[str]:
    """Completions of a robot: names that begin with the text, folders and robot files.

    Example:
        >>> robots_and_files("zyy")
        ['zyyzyz_6r']
    """
    from urdf_ik.model import catalogue, downloads

    names = [name for name in (*catalogue.names(), *downloads.names()) if name.startswith(incomplete)]
    return [*names, *_files(incomplete, (".urdf", ".xacro", ".xml"))]


def data_files(incomplete: str) -> list[str]:
    """Completions of a file of poses or joint vectors: folders, and files of the formats that are read."""
    return _files(incomplete, (".csv", ".json", ".npy", ".npz"))


def links(ctx: Any, incomplete: str) -> list[str]:
    """Completions of a link of the robot that is named before it; none where it cannot be read."""
    from urdf_ik.arm.loading import read

    with suppress(UrdfIkError):
        return [name for name in read(ctx.params["robot"])[0].links if name.startswith(incomplete)]
    return []


def _files(incomplete: str, ends: tuple[str, ...]) -> list[str]:
    folder, _, start = incomplete.rpartition("/")
    files = []
    for found in sorted(Path(folder or ("/" if incomplete.startswith("/") else ".")).glob(f"{glob.escape(start)}*")):
        written = f"{incomplete[: len(incomplete) - len(start)]}{found.name}"
        if found.is_dir():
            files.append(f"{written}/")
        elif found.name.removesuffix(".gz").endswith(ends):
            files.append(written)
    return files
