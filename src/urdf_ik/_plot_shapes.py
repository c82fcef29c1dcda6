"""Stick figures and the primitive shapes of links, as arrays that any drawing can use."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Iterator

    from numpy.typing import NDArray

    from urdf_ik.arm import Arm

    Array = NDArray[np.float64]

_AROUND = 17
_POINT = 1e-12
_CORNERS = np.array([[x, y, z] for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)])
_FACES = ((0, 1, 3, 2), (4, 5, 7, 6), (0, 1, 5, 4), (2, 3, 7, 6), (0, 2, 6, 4), (1, 3, 7, 5))


def chain_links(arm: Arm) -> tuple[str, ...]:
    """Links from base to tip."""
    path = arm.model.path_between(arm.base, arm.tip)
    links = [arm.base]
    for joint in path:
        links.append(joint.child if joint.parent == links[-1] else joint.parent)
    return tuple(links)


def stick(arm: Arm, q: Array) -> Array:
    """(k, 3) m, the frames' origins of the chain's links at ``q`` (n,), base to tip."""
    poses = arm.link_poses(q)
    return np.array([poses[link][:3, 3] for link in chain_links(arm)])


def faces(arm: Arm, q: Array) -> Iterator[tuple[str, list[Array]]]:
    """Link and polygons (k, 3) m, in the base, of each box, cylinder and sphere that the links show; no meshes."""
    poses = arm.link_poses(q)
    for link in arm.model.links:
        description = arm.model.robot.link_map[link]
        for part in description.visuals or description.collisions:
            polygons = _polygons(part.geometry)
            if polygons:
                T = poses[link] if part.origin is None else poses[link] @ part.origin
                yield link, [polygon @ T[:3, :3].T + T[:3, 3] for polygon in polygons]


def _polygons(geometry: Any) -> list[Array]:
    if geometry is None:
        return []
    if geometry.box is not None:
        corners = _CORNERS * np.asarray(geometry.box.size, dtype=np.float64)
        return [corners[list(face)] for face in _FACES]
    if geometry.cylinder is not None:
        half = 0.5 * geometry.cylinder.length
        return _turned(geometry.cylinder.radius * np.array([0.0, 1.0, 1.0, 0.0]), half * np.array([-1, -1, 1, 1]))
    if geometry.sphere is not None:
        angles = np.linspace(-0.5 * np.pi, 0.5 * np.pi, 9)
        return _turned(geometry.sphere.radius * np.abs(np.cos(angles)), geometry.sphere.radius * np.sin(angles))
    return []


def _turned(radii: Array, heights: Array) -> list[Array]:
    """Polygons of an outline (radius, height) turned about z."""
    angles = np.linspace(0.0, 2.0 * np.pi, _AROUND)
    ring = np.stack([np.cos(angles), np.sin(angles)], axis=-1)
    points = [np.column_stack([r * ring, np.full(_AROUND, z)]) for r, z in zip(radii, heights, strict=True)]
    return [
        # A quadrilateral with two corners on the axis is a triangle; its normal would be none.
        np.array([low[i], low[i + 1], high[i + 1], high[i]])[_corners(bottom, top)]
        for low, high, bottom, top in zip(points[:-1], points[1:], radii[:-1], radii[1:], strict=True)
        for i in range(_AROUND - 1)
    ]


def _corners(bottom: float, top: float) -> list[int]:
    return [0, 2, 3] if bottom < _POINT else [0, 1, 2] if top < _POINT else [0, 1, 2, 3]
