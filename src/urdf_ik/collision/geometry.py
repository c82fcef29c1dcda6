"""The collision shapes of a URDF as Pinocchio and coal hold them, meshes only from where they may come from."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

import coal
import numpy as np
import pinocchio as pin
from lxml import etree

from urdf_ik.collision.shapes import Capsule, Sphere
from urdf_ik.errors import UrdfError
from urdf_ik.urdf import resolve_mesh

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from urdf_ik.collision.shapes import Shape
    from urdf_ik.urdf import UrdfModel

    Array = NDArray[np.float64]

BALLS = 4
"""Balls by which each shape of an arm is covered."""


def build(model: UrdfModel, pin_model: Any) -> Any:
    """Pinocchio's geometry model of every ``<collision>`` of a URDF.

    Mesh names are replaced by the paths that :func:`resolve_mesh` found, so Pinocchio opens no other file.

    Raises:
        UrdfError: there is no collision shape, or not all of them can be read: a check would call free what is not.
    """
    if broken := [error for error in model.left_out if "<collision>" in (error.element or "")]:
        raise broken[0]
    tree = etree.fromstring(model.xml)
    for mesh in tree.iterfind("link/collision/geometry/mesh"):
        mesh.set("filename", str(resolve_mesh(model, mesh.get("filename"))))
    for visual in tree.findall("link/visual"):
        visual.getparent().remove(visual)
    try:
        geometry = pin.buildGeomFromUrdfString(pin_model, etree.tostring(tree).decode(), pin.GeometryType.COLLISION)
    except (ValueError, RuntimeError) as error:
        reason = " ".join(str(error).partition("message:")[2].split()) or str(error)
        raise UrdfError(f"a collision shape cannot be read: {reason}", source=model.source) from None
    if not geometry.ngeoms:
        raise UrdfError(
            "no link has a collision shape",
            source=model.source,
            hint="add <collision> to the links that must not touch",
        )
    return geometry


def covering_balls(geometry: Any) -> tuple[Array, Array]:
    """Balls that together hold a shape: centres (BALLS, 3) in its frame and radii (BALLS,) [m].

    It is cut into slices across its longest side, and one ball holds a slice, of a mesh the slice's triangles.
    """
    geometry.computeLocalAABB()
    centres = np.repeat(np.array(geometry.aabb_center).reshape(1, 3), BALLS, axis=0)
    radii = np.full(BALLS, float(geometry.aabb_radius))
    if not isinstance(geometry, coal.BVHModelBase):
        half = 0.5 * (np.array(geometry.aabb_local.max_) - np.array(geometry.aabb_local.min_))
        side = int(np.argmax(half))
        slices = half.copy()
        slices[side] /= BALLS
        if np.isfinite(half).all() and (radius := float(np.linalg.norm(slices))) < radii[0]:
            centres[:, side] += (2.0 * np.arange(BALLS) - BALLS + 1.0) * slices[side]
            radii[:] = radius
        return centres, radii
    vertices = np.array(geometry.vertices())
    corners = vertices[np.array([list(_corners(geometry.tri_indices(i))) for i in range(geometry.num_tris)])]
    low, high = vertices.min(axis=0), vertices.max(axis=0)
    side = int(np.argmax(high - low))
    middle = corners.mean(axis=1)[:, side]
    slices = np.clip(((middle - low[side]) / ((high - low)[side] or 1.0) * BALLS).astype(int), 0, BALLS - 1)
    for i in range(BALLS):
        held = corners[slices == i].reshape(-1, 3)
        if not len(held):
            centres[i], radii[i] = centres[0], radii[0]
            continue
        centres[i] = 0.5 * (held.min(axis=0) + held.max(axis=0))
        radii[i] = np.linalg.norm(held - centres[i], axis=1).max()
    return centres, radii


class RoundedBox(NamedTuple):
    """All points within ``radius`` of a box: holds a shape, closely or exactly.

    Attributes:
        centre: (3,) m.
        half: (3,) m, half of the box's edges.
        radius: m.
    """

    centre: Array
    half: Array
    radius: float


def rounded_box(shape: Shape, geometry: Any) -> RoundedBox:
    """What holds a shape, in its frame: exact for boxes, spheres and capsules."""
    match shape:
        case Sphere(radius):
            return RoundedBox(np.zeros(3), np.zeros(3), radius)
        case Capsule(radius, length):
            return RoundedBox(np.zeros(3), np.array([0.0, 0.0, 0.5 * length]), radius)
    geometry.computeLocalAABB()
    box = geometry.aabb_local
    low, high = np.array(box.min_), np.array(box.max_)
    return RoundedBox(0.5 * (low + high), 0.5 * (high - low), shape.inflation)


def _corners(triangle: Any) -> tuple[int, int, int]:
    return triangle[0], triangle[1], triangle[2]
