"""Worlds of random obstacles."""

import numpy as np
from numpy.typing import NDArray

from urdf_ik import Box, Capsule, Cylinder, Points, Sphere, World, pose
from urdf_ik.cell.shapes import Shape


def random_shape(rng: np.random.Generator, size: float) -> Shape:
    """A shape of any kind that is finite and no mesh."""
    a, b = rng.uniform(0.3, 1.0, 2) * size
    return [
        lambda: Box((a, b, 0.5 * size)),
        lambda: Sphere(a),
        lambda: Cylinder(0.5 * a, b),
        lambda: Capsule(0.3 * a, b),
        lambda: Box((0.001, 3.0 * b, 3.0 * b)),
        lambda: Points(rng.normal(size=(20, 3)) * b, 0.01),
    ][int(rng.integers(6))]()


def random_pose(rng: np.random.Generator, near: float, far: float) -> NDArray[np.float64]:
    """A pose in a ball shell about the base."""
    at = rng.normal(size=3)
    return pose(rng.uniform(near, far) * at / np.linalg.norm(at), rpy=rng.uniform(-3, 3, 3))


def random_world(rng: np.random.Generator, count: int, size: float, near: float, far: float) -> World:
    """``count`` obstacles of all kinds."""
    world = World()
    for i in range(count):
        world.add(f"o{i}", random_shape(rng, size), random_pose(rng, near, far))
    return world
