"""Inverse reachability: where to put an arm's base, so that it reaches given poses or follows a given path.

>>> import urdf_ik
>>> arm = urdf_ik.load("zyyzyz_6r")
>>> targets = arm.fk([[0.3, -0.5, 0.8, 0.4, 0.7, -0.2], [0.5, -0.4, 0.9, 0.1, 0.6, 0.3]])
>>> found = urdf_ik.maps.placement(arm, targets, bounds=[[-0.5, -0.5, 0.0], [0.5, 0.5, 0.0]], step=0.25)
>>> best = found.best()
>>> best.reached, bool(best.margin > 0.0)
(2, True)
"""

from urdf_ik.maps.placements.creation import BASES, BASES_OF_A_PATH, placement
from urdf_ik.maps.placements.placement_map import SHOWN, Place, PlacementMap, opened

__all__ = ["BASES", "BASES_OF_A_PATH", "SHOWN", "Place", "PlacementMap", "opened", "placement"]
