"""The sources of the compiled core and their CMake package, as they are installed with this package."""

from pathlib import Path

_PACKAGE = Path(__file__).resolve().parents[1]


def core() -> Path:
    """The folder of the core's sources: inside the installed package, or beside it in a checkout.

    Example:
        >>> (core() / "cmake" / "urdf_ikConfig.cmake").is_file()
        True
    """
    installed = _PACKAGE / "bundled" / "core"
    return installed if installed.is_dir() else _PACKAGE.parent / "core"
