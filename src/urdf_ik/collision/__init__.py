"""Collision and distance of an arm's links, with themselves and with a world, through Pinocchio and coal.

Shapes and worlds are described without either; the modules that use them are imported with their first name.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from urdf_ik.collision.model import ALWAYS, SAMPLES, SEED, CollisionModel, Nearest

__all__ = [
    "ALWAYS",
    "SAMPLES",
    "SEED",
    "CollisionModel",
    "Nearest",
]


def __getattr__(name: str) -> Any:
    """A public name, or a module of this package."""
    if name in __all__:
        return getattr(import_module(f"{__name__}.model"), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
