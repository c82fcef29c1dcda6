"""The search for ROS packages, in given folders and in those that the environment variables name."""

from __future__ import annotations

import os
from collections.abc import Iterator, Sequence
from pathlib import Path

from lxml import etree

MANIFEST = "package.xml"
DEEPEST = 5
"""Greatest depth of the search below the folders of ROS_PACKAGE_PATH."""


def find(name: str, roots: Sequence[Path]) -> Path | None:
    """The folder of a ROS package.

    Args:
        name: the package's name.
        roots: folders that are searched first: each is a package itself, or holds packages.

    Returns:
        The folder; None if neither ``roots`` nor AMENT_PREFIX_PATH nor ROS_PACKAGE_PATH has it.
    """
    if not name or name != Path(name).name or name == "..":
        return None
    for root in roots:
        if is_package(root, name):
            return root
        if (root / name).is_dir():
            return root / name
    return next(_in_environment(name), None)


def own_package(file: Path) -> Path | None:
    """The folder of a file's ROS package: the nearest parent folder with a package.xml."""
    return next((folder for folder in file.parents if (folder / MANIFEST).is_file()), None)


def is_package(folder: Path, name: str) -> bool:
    """Whether a folder is the package of that name, by its manifest or by its own name."""
    manifest = folder / MANIFEST
    if folder.name == name or not manifest.is_file():
        return folder.name == name
    try:
        parser = etree.XMLParser(resolve_entities=False, no_network=True)
        return bool(etree.parse(str(manifest), parser).getroot().findtext("name", "").strip() == name)
    except (OSError, etree.XMLSyntaxError):
        return False


def _in_environment(name: str) -> Iterator[Path]:
    """The package's folders by AMENT_PREFIX_PATH (ROS 2), then by ROS_PACKAGE_PATH (ROS 1)."""
    for prefix in _folders("AMENT_PREFIX_PATH"):
        if (prefix / "share" / name).is_dir():
            yield prefix / "share" / name
    for root in _folders("ROS_PACKAGE_PATH"):
        waiting = [(root, 0)]
        for folder, depth in waiting:
            if (folder / MANIFEST).is_file():
                if is_package(folder, name):
                    yield folder
            elif depth < DEEPEST:
                waiting += [(each, depth + 1) for each in _below(folder)]


def _below(folder: Path) -> list[Path]:
    try:
        return sorted(each for each in folder.iterdir() if each.is_dir() and not each.name.startswith("."))
    except OSError:
        return []


def _folders(variable: str) -> list[Path]:
    return [Path(each) for each in os.environ.get(variable, "").split(os.pathsep) if each]
