"""A serial chain from a base link to a tip link, as screw axes at the zero configuration."""

from __future__ import annotations

from urdf_ik.chain.serial import MOVABLE, Chain, Follower, TreeJoint, followed, held_values

__all__ = [
    "MOVABLE",
    "Chain",
    "Follower",
    "TreeJoint",
    "followed",
    "held_values",
]
