"""Self-collision and distance of an arm's links through coal, by Pinocchio's geometry model of the URDF."""

from __future__ import annotations

from urdf_ik.collision.model import ALWAYS, SAMPLES, SEED, CollisionModel, Nearest

__all__ = [
    "ALWAYS",
    "SAMPLES",
    "SEED",
    "CollisionModel",
    "Nearest",
]
