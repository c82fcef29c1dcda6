"""Collision and distance of an arm's links, with themselves and with a world, through Pinocchio and coal.

A query goes through these modules: ``collision_model`` decides which pairs are checked (``allowed_collisions``),
``distance_bounds`` decides most pairs without coal, from balls about the links and the near obstacles
(``obstacle_index``), and ``coal_check`` decides the others with coal (``coal_shapes``: its geometry). ``swept_motions``
proves whole motions free in the same way.

Shapes and worlds need neither Pinocchio nor coal; the modules that do are imported at the first use of one of their
names.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from urdf_ik.cell.allowed_collisions import Table
    from urdf_ik.cell.collision_model import ALWAYS, SAMPLES, SEED, CollisionModel, Nearest
    from urdf_ik.cell.swept_motions import Motions
    from urdf_ik.cell.world import Obstacle, World

__all__ = [
    "ALWAYS",
    "SAMPLES",
    "SEED",
    "CollisionModel",
    "Motions",
    "Nearest",
    "Obstacle",
    "Table",
    "World",
]

_MODULE = {
    "Motions": "swept_motions",
    "Obstacle": "world",
    "Table": "allowed_collisions",
    "World": "world",
}

_MODULES = ("pinocchio_reference", "shapes", "swept_motions", "tool", "world")


def __getattr__(name: str) -> Any:
    """A public name, or a module of this package."""
    if name in __all__:
        return getattr(import_module(f"{__name__}.{_MODULE.get(name, 'collision_model')}"), name)
    if name in _MODULES:
        return import_module(f"{__name__}.{name}")
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
