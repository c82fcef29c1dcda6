"""The collision shapes of a URDF as Pinocchio and coal hold them, meshes only from where they may come from."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
import pinocchio as pin
from lxml import etree

from urdf_ik.errors import UrdfError
from urdf_ik.urdf import resolve_mesh

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from urdf_ik.urdf import UrdfModel

    Array = NDArray[np.float64]


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


def bounding_spheres(shapes: Any) -> tuple[Array, Array]:
    """Centres (m, 3) in the shapes' frames and radii (m,) [m]."""
    centres, radii = np.empty((len(shapes), 3)), np.empty(len(shapes))
    for i, shape in enumerate(shapes):
        shape.geometry.computeLocalAABB()
        centres[i], radii[i] = shape.geometry.aabb_center, shape.geometry.aabb_radius
    return centres, radii
