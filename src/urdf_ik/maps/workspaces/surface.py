"""The boundary of the reached region: a mesh of the faces between reached voxels and others."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from urdf_ik.maps.workspaces.store.stored_map import StoredMap
from urdf_ik.maps.workspaces.workspace_map import WorkspaceMap
from urdf_ik.support import inputs

# Corners of the face of a unit cube at the far end of each axis, counter-clockwise as seen from outside.
_FACES = (
    ((1, 0, 0), (1, 1, 0), (1, 1, 1), (1, 0, 1)),
    ((0, 1, 0), (0, 1, 1), (1, 1, 1), (1, 1, 0)),
    ((0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1)),
)


class Surface(NamedTuple):
    """A closed mesh of triangles.

    Attributes:
        vertices: (v, 3) m.
        faces: (f, 3) numbers of vertices, counter-clockwise as seen from outside.
    """

    vertices: NDArray[np.float64]
    faces: NDArray[np.intp]


def boundary(found: WorkspaceMap | StoredMap, least: float = 0.0) -> Surface:
    """The boundary of the voxels that are reached in more than a share ``least`` of the orientations.

    Example:
        >>> import urdf_ik
        >>> found = urdf_ik.maps.workspace(urdf_ik.load("zyyzyz_6r"), voxel=0.5, orientations=4)
        >>> mesh = boundary(found)
        >>> mesh.faces.shape[1], bool(np.ptp(mesh.vertices[:, 0]) > 1.0)
        (3, True)
    """
    inputs.kind(found, "totals", "found", "a map of a workspace")
    least = inputs.number(least, "least")
    with np.errstate(invalid="ignore"):
        inside = np.nan_to_num(found.values("reach")) > least
    padded = np.pad(inside, 1)
    quads = []
    for axis, face in enumerate(_FACES):
        corners = np.array(face)
        low = corners.copy()
        low[:, axis] = 0
        beyond = np.roll(padded, -1, axis)[1:-1, 1:-1, 1:-1]
        before = np.roll(padded, 1, axis)[1:-1, 1:-1, 1:-1]
        quads.append(np.argwhere(inside & ~beyond)[:, None] + corners)
        quads.append(np.argwhere(inside & ~before)[:, None] + low[::-1])
    points = np.concatenate(quads)
    places, which = np.unique(points.reshape(-1, 3), axis=0, return_inverse=True)
    corner = which.reshape(-1, 4)
    faces = np.concatenate([corner[:, [0, 1, 2]], corner[:, [0, 2, 3]]]).astype(np.intp)
    return Surface(np.asarray(found.grid.lower + found.grid.voxel * places), faces)
