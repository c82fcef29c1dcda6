"""Collision and distance of an arm's links, with themselves and with a world, through Pinocchio and coal.

A query goes through these modules: ``collision_model`` decides which pairs are checked (``allowed_collisions``),
``distance_bounds`` decides most pairs without coal, from balls about the links and the near obstacles
(``obstacles``), and ``coal_check`` decides the others with coal (``coal_shapes``: its geometry). ``swept_motions``
proves whole motions free in the same way.

Shapes and worlds need neither Pinocchio nor coal; the modules that do are imported at the first use of one of their
names.
"""

from typing import TYPE_CHECKING

from urdf_ik.support.lazy import attributes

if TYPE_CHECKING:
    from urdf_ik.cell.allowed_collisions import Table
    from urdf_ik.cell.collision_model import CollisionModel, Nearest
    from urdf_ik.cell.obstacles import Obstacle
    from urdf_ik.cell.swept_motions import Motions
    from urdf_ik.cell.world import World

__all__ = ["CollisionModel", "Motions", "Nearest", "Obstacle", "Table", "World"]

_MODULES = {
    "allowed_collisions": ["Table"],
    "collision_model": ["CollisionModel", "Nearest"],
    "obstacles": ["Obstacle"],
    "swept_motions": ["Motions"],
    "world": ["World"],
}
__getattr__ = attributes(__name__, {name: module for module, names in _MODULES.items() for name in names})
