"""Lazy imports: a package's public name is imported at its first use."""

import sys
from collections.abc import Callable, Mapping
from importlib import import_module
from typing import Any


def attributes(package: str, names: Mapping[str, str] | None = None) -> Callable[[str], Any]:
    """The ``__getattr__`` of a package: its public names, and its modules. ``dir()`` of the package lists just these.

    ``names``: the module of each public name, relative to the package.
    """
    module_of = names or {}

    def get(name: str) -> Any:
        if name in module_of:
            value = getattr(import_module(f"{package}.{module_of[name]}"), name)
            setattr(sys.modules[package], name, value)
            return value
        if not name.startswith("_"):
            try:
                return import_module(f"{package}.{name}")
            except ModuleNotFoundError as error:
                if error.name != f"{package}.{name}":
                    raise
        raise AttributeError(f"module {package!r} has no attribute {name!r}")

    def listed() -> list[str]:
        from pkgutil import iter_modules

        modules = {each.name for each in iter_modules(sys.modules[package].__path__)}
        return sorted({*module_of, *(name for name in modules if not name.startswith("_"))})

    vars(sys.modules[package])["__dir__"] = listed
    return get
