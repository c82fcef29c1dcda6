"""The one decorator that compiles the kernels, and the place where their machine code is cached.

Numba's cache notices a change of the file that holds a function, but not a change of the functions that it
calls in other files. The cache directory therefore carries a digest of every kernel's source: any edit, and
any new release, starts a fresh one.
"""

from __future__ import annotations

import hashlib
import os
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar

import numba
from numba.core import config

_Function = TypeVar("_Function", bound=Callable[..., Any])


def _digest() -> str:
    """Short digest of the kernels' sources and of the compiler's version."""
    seen = hashlib.sha256(f"{numba.__version__} {sys.version_info[:2]}".encode())
    for file in sorted(Path(__file__).parent.glob("*.py")):
        seen.update(file.read_bytes())
    return seen.hexdigest()[:16]


def _root() -> Path:
    """The user's cache folder, by the platform's own convention."""
    if given := os.environ.get("URDF_IK_CACHE_DIR") or os.environ.get("NUMBA_CACHE_DIR"):
        return Path(given)
    if sys.platform == "win32":
        return Path(os.environ.get("LOCALAPPDATA", Path.home() / "AppData" / "Local")) / "urdf-ik"
    if sys.platform == "darwin":
        return Path.home() / "Library" / "Caches" / "urdf-ik"
    return Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "urdf-ik"


def _directory() -> Path:
    """A writable directory for this version of the kernels."""
    name = f"kernels-{_digest()}"
    for root in (_root, lambda: Path(tempfile.gettempdir()) / f"urdf-ik-{os.getuid() if hasattr(os, 'getuid') else 0}"):
        try:
            path = root() / name
            path.mkdir(parents=True, exist_ok=True)
        except (OSError, RuntimeError):
            continue
        if os.access(path, os.W_OK):
            return path
    return Path(tempfile.mkdtemp(prefix="urdf-ik-"))


CACHE_DIRECTORY = _directory()
_OPTIONS: dict[str, Any] = {"nogil": True, "error_model": "numpy", "fastmath": {"contract"}}


def kernel(function: _Function) -> _Function:
    """Compile ``function`` when it is first called, without the GIL, and keep its machine code.

    Division by zero gives an infinity or NaN, as in NumPy: a check would keep loops from being vectorised.
    ``contract`` lets the compiler fuse a multiplication with an addition; nothing else of ``fastmath`` is on.
    """
    given = config.CACHE_DIR  # type: ignore[attr-defined]
    config.CACHE_DIR = str(CACHE_DIRECTORY)  # type: ignore[attr-defined]
    try:
        return numba.njit(cache=True, **_OPTIONS)(function)  # type: ignore[no-any-return]
    finally:
        config.CACHE_DIR = given  # type: ignore[attr-defined]


def step(function: _Function) -> _Function:
    """Compile ``function`` into its callers' machine code, however large: a step of a loop over a block."""
    return numba.njit(forceinline=True, **_OPTIONS)(function)  # type: ignore[no-any-return]


def inlined(function: _Function) -> _Function:
    """Compile ``function`` into its callers.

    For the stages of a block: a loop is vectorised only where the compiler sees the workspace's shape and the
    row numbers as constants.
    """
    return numba.njit(inline="always", **_OPTIONS)(function)  # type: ignore[no-any-return]
