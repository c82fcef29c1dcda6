"""What links and obstacles look like, as arrays and meshes that any drawing can use."""

from collections.abc import Iterable
from typing import Any

import numpy as np
import trimesh

from urdf_ik.arm import Arm
from urdf_ik.cell.shapes import Box, Capsule, Cylinder, HalfSpace, Mesh, Points, Shape, Sphere
from urdf_ik.errors import ArgumentError
from urdf_ik.ik.solutions.tables import stick
from urdf_ik.kinematics.dh.frames import any_normal, frame
from urdf_ik.model import link_shapes
from urdf_ik.typing import Array

__all__ = ["Body", "bodies", "half_extents", "placed", "stick", "surroundings", "triangles"]

_DRAWS, _SEED = 200, 0
_PLANE = 0.01
"""Thickness [m] of the plate that shows a half-space; its top is the plane."""


Body = tuple[str, Array]
"""A link, and the triangles (k, 3, 3) m of one of its shapes in the link's frame."""


def bodies(arm: Arm) -> tuple[tuple[Body, ...], tuple[str, ...]]:
    """The shapes of all links, coarsely, read from the URDF and its meshes; and why others are missing."""
    found, missing = link_shapes.read(arm.model, coarse=True)
    # A triangle without an area has no normal, and so no shade.
    solid = [(link, mesh.triangles[mesh.nondegenerate_faces()]) for link, mesh in found]
    shapes = tuple((link, np.asarray(triangles, dtype=np.float64)) for link, triangles in solid if len(triangles))
    return shapes, missing


def placed(arm: Arm, shapes: Iterable[Body], q: Array) -> list[Array]:
    """Triangles (k, 3, 3) m of each shape in the base, at ``q`` (n,)."""
    poses = arm.link_poses(q)
    return [triangles @ poses[link][:3, :3].T + poses[link][:3, 3] for link, triangles in shapes]


def surroundings(arm: Arm, ranges: Array) -> Array:
    """(k, 3) m, where the frames of the chain's links are at seeded joint vectors within ``ranges`` (n, 2)."""
    draws = np.random.default_rng(_SEED).uniform(ranges[:, 0], ranges[:, 1], (_DRAWS, arm.dof))
    return stick(arm.chain, draws).reshape(-1, 3)


def half_extents(shape: Shape) -> Array:
    """(3,) m, half of the box around a shape in its own frame; of a mesh, whose file may be large, zero."""
    match shape:
        case Box():
            return 0.5 * np.array(shape.size)
        case Sphere():
            return np.full(3, shape.radius)
        case Cylinder() | Capsule():
            end = shape.radius if isinstance(shape, Capsule) else 0.0
            return np.array([shape.radius, shape.radius, 0.5 * shape.length + end])
        case Points():
            return np.asarray(np.abs(shape.points).max(axis=0) + shape.radius)
    return np.zeros(3)


def triangles(shape: Shape, size: float) -> Any:
    """A ``Trimesh``, the surface of a shape in its own frame; of a half-space a plate of four times ``size`` [m].

    Raises:
        ArgumentError: a mesh is not there, or cannot be read.
    """
    match shape:
        case Box():
            return trimesh.creation.box(shape.size)
        case Sphere():
            return trimesh.creation.icosphere(subdivisions=3, radius=shape.radius)
        case Cylinder():
            return trimesh.creation.cylinder(shape.radius, shape.length, sections=32)
        case Capsule():
            return link_shapes.capsule(shape.radius, shape.length, [32, 32])
        case HalfSpace():
            plate = trimesh.creation.box((4.0 * size, 4.0 * size, _PLANE))
            normal = np.array(shape.normal)
            middle = normal * (shape.offset - 0.5 * _PLANE)
            return plate.apply_transform(frame(normal, any_normal(normal), middle))
        case Mesh():
            # As coal has read it, since that is what is asked about contacts.
            from urdf_ik.cell.coal_shapes import geometry

            solid = geometry(shape)
            faces = [[one[k] for k in range(3)] for one in map(solid.tri_indices, range(solid.num_tris))]
            return trimesh.Trimesh(np.array(solid.vertices()), np.array(faces), process=False)
    raise ArgumentError(f"a {type(shape).__name__} cannot be drawn")
