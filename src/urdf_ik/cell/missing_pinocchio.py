"""A cell where Pinocchio is not installed: nothing is checked for contact, and what needs Pinocchio says so.

Loading, kinematics, solutions, limits, pictures and exports do without it. Its wheels (``pin`` on PyPI, which brings
coal) are for Linux and macOS only.
"""

from importlib.util import find_spec
from typing import Any

from urdf_ik.errors import MissingPackage

PACKAGES = ("pinocchio", "coal")
UNCHECKED = "Pinocchio is missing (pip install pin)"


def installed() -> bool:
    """Whether Pinocchio and coal can be imported."""
    try:
        return all(find_spec(name) is not None for name in PACKAGES)
    except ModuleNotFoundError:
        return False


def needed(what: str) -> MissingPackage:
    """The error of something that cannot be done without it."""
    where = "Linux and macOS; it has no wheels for Windows"
    return MissingPackage(f"{what} need Pinocchio, which is not installed: pip install pin ({where})")


class _Unchecked:
    """Replaces the collision model: it has no shapes, and every query raises MissingPackage."""

    has_geometry, is_changed, missing, unchecked = False, False, UNCHECKED, UNCHECKED

    def in_world(self, world: Any) -> Any:
        """Itself; obstacles cannot be checked."""
        if world is not None:
            raise needed("contacts")
        return self

    def __getattr__(self, name: str) -> Any:
        if name.startswith("_"):
            raise AttributeError(name)
        raise needed("contacts")


def unchecked() -> Any:
    """A replacement of an arm's collision model."""
    return _Unchecked()
