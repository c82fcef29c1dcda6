"""Shell completion of a robot: names and files."""

from __future__ import annotations

import glob
from pathlib import Path


def robots_and_files(incomplete: str) -> list[str]:
    """Completions of a robot: names that begin with the text, folders and robot files.

    Example:
        >>> robots_and_files("zyy")
        ['zyyzyz_6r']
    """
    from urdf_ik.model import catalogue, downloads

    names = [name for name in (*catalogue.names(), *downloads.names()) if name.startswith(incomplete)]
    folder, _, start = incomplete.rpartition("/")
    files = []
    for found in sorted(Path(folder or ("/" if incomplete.startswith("/") else ".")).glob(f"{glob.escape(start)}*")):
        written = f"{incomplete[: len(incomplete) - len(start)]}{found.name}"
        if found.is_dir():
            files.append(f"{written}/")
        elif found.name.removesuffix(".gz").endswith((".urdf", ".xacro", ".xml")):
            files.append(written)
    return [*names, *files]
