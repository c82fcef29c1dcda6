"""The sources of the compiled core and their CMake package, as they are installed with this package."""

from __future__ import annotations

from pathlib import Path

_HERE = Path(__file__).resolve().parent


def core() -> Path:
    """The folder of the core's sources: inside the installed package, or beside it in a checkout.

    Example:
        >>> (core() / "cmake" / "urdf_ikConfig.cmake").is_file()
        True
    """
    installed = _HERE / "core"
    return installed if installed.is_dir() else _HERE.parents[1] / "core"
