"""The import of yourdfpy without trimesh, SciPy and NetworkX, which it needs only for meshes and scenes.

yourdfpy imports trimesh for the types in its annotations, for scenes, and for ``trimesh.transformations``, small
functions on matrices. ``import trimesh`` brings a part of SciPy and NetworkX, nine tenths of the time of
``import yourdfpy``. Here the statement ``import trimesh`` of yourdfpy's own module binds a stand-in. The stand-in
imports trimesh at the first use of anything but ``transformations``, so the whole of yourdfpy works as usual. No other
module's imports change, in any thread.
"""

from __future__ import annotations

import builtins
import sys
from collections.abc import Sequence
from functools import lru_cache
from importlib import import_module
from importlib.machinery import ModuleSpec, PathFinder, SourceFileLoader
from importlib.util import find_spec
from types import ModuleType
from typing import Any

_MODULE = "yourdfpy.urdf"  # which imports trimesh
_PARTS = f"{__name__}_parts"  # the name of trimesh's folder, as a package without trimesh's own __init__


def yourdfpy() -> Any:
    """The module yourdfpy.

    Example:
        >>> yourdfpy().URDF.__name__
        'URDF'
    """
    if "yourdfpy" in sys.modules or "trimesh" in sys.modules:
        return import_module("yourdfpy")
    finder = _Finder()
    sys.meta_path.insert(0, finder)
    try:
        return import_module("yourdfpy")
    except Exception:  # another release of yourdfpy may use more of trimesh when it is imported
        finder.active = False
        return import_module("yourdfpy")
    finally:
        sys.meta_path.remove(finder)


class _Finder:
    """Finds yourdfpy's one module that imports trimesh, and nothing else."""

    def __init__(self) -> None:
        self.active = True

    def find_spec(
        self, name: str, path: Sequence[str] | None = None, target: ModuleType | None = None
    ) -> ModuleSpec | None:
        if name != _MODULE or not self.active:
            return None
        spec = PathFinder.find_spec(name, path, target)
        if spec is not None and isinstance(spec.loader, SourceFileLoader):
            spec.loader = _Loader(name, spec.loader.path)
        return spec


class _Loader(SourceFileLoader):
    """Runs the module with an ``__import__`` of its own."""

    def exec_module(self, module: ModuleType) -> None:
        trimesh = _Trimesh("trimesh")

        def own_import(name: str, *rest: Any) -> Any:
            return trimesh if name.split(".")[0] == "trimesh" else builtins.__import__(name, *rest)

        vars(module)["__builtins__"] = {**vars(builtins), "__import__": own_import}
        super().exec_module(module)
        vars(trimesh)["_annotating"] = False


class _Trimesh(ModuleType):
    """Stands for trimesh, which it imports once something of it is used.

    While yourdfpy is being imported, an attribute is used in an annotation, and its name does.
    """

    _annotating = True

    def __getattr__(self, name: str) -> Any:
        if name == "transformations":
            return _transformations()
        if self._annotating:
            return f"trimesh.{name}"
        return getattr(import_module("trimesh"), name)


@lru_cache(maxsize=1)
def _transformations() -> ModuleType:
    """trimesh.transformations, without the rest of trimesh."""
    spec = find_spec("trimesh")
    folder = ModuleType(_PARTS)
    folder.__path__ = list(spec.submodule_search_locations or []) if spec is not None else []
    sys.modules[_PARTS] = folder
    return import_module(f"{_PARTS}.transformations")
