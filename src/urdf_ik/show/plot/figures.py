"""Stick figures and the shapes of links, as arrays that any drawing can use."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from urdf_ik.arm import Arm
from urdf_ik.ik.solutions.tables import stick
from urdf_ik.model import link_shapes
from urdf_ik.typing import Array

_DRAWS, _SEED = 200, 0


__all__ = ["Bodies", "Body", "bodies", "placed", "stick", "surroundings"]


class Body(NamedTuple):
    """One shape of a link.

    Attributes:
        link: the link.
        triangles: (k, 3, 3) m, corners in the link's frame.
    """

    link: str
    triangles: Array


class Bodies(NamedTuple):
    """What the links of an arm look like.

    Attributes:
        shapes: one a box, cylinder, sphere or mesh.
        missing: why the others are not there.
    """

    shapes: tuple[Body, ...]
    missing: tuple[str, ...]


def bodies(arm: Arm) -> Bodies:
    """The shapes of all links, coarsely, read from the URDF and its meshes."""
    found = link_shapes.read(arm.model, coarse=True)
    # A triangle without an area has no normal, and so no shade.
    solid = [(body.link, body.mesh.triangles[body.mesh.nondegenerate_faces()]) for body in found.bodies]
    shapes = tuple(Body(link, np.asarray(triangles, dtype=np.float64)) for link, triangles in solid if len(triangles))
    return Bodies(shapes, found.missing)


def placed(arm: Arm, found: Bodies, q: Array) -> list[Array]:
    """Triangles (k, 3, 3) m of each body in the base, at ``q`` (n,)."""
    poses = arm.link_poses(q)
    return [body.triangles @ poses[body.link][:3, :3].T + poses[body.link][:3, 3] for body in found.shapes]


def surroundings(arm: Arm, ranges: Array) -> Array:
    """(k, 3) m, where the frames of the chain's links are at seeded joint vectors within ``ranges`` (n, 2)."""
    draws = np.random.default_rng(_SEED).uniform(ranges[:, 0], ranges[:, 1], (_DRAWS, arm.dof))
    return stick(arm.chain, draws).reshape(-1, 3)
