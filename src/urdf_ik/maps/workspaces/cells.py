"""The cell of a map that a target lies in: its voxel, and the nearest sampled orientation."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from urdf_ik.errors import ArgumentError
from urdf_ik.maps.workspaces.grid import Grid
from urdf_ik.model.poses import check_poses
from urdf_ik.support import inputs
from urdf_ik.support.tolerances import DEFAULT
from urdf_ik.typing import Array

MANY = 512
"""Orientations beyond which a tree finds the nearest one faster than a comparison with all of them."""
_AT_ONCE = 2**15  # comparisons at a time: they stay in the cache, and are too few for BLAS to start threads for
# Shape of one target of each task, and what it is.
_TARGETS = {
    "pose": ((4, 4), "poses (m, 4, 4)"),
    "position and axis": ((6,), "positions with directions (m, 6)"),
    "position": ((3,), "positions (m, 3) m"),
    "planar pose": ((3,), "x, y and the angle in the plane (m, 3)"),
    "planar position": ((2,), "x and y in the plane (m, 2)"),
}


class Cells(NamedTuple):
    """Cells of a map.

    Attributes:
        voxels: (m, 3) number of the voxel along each axis; zeros outside the grid.
        samples: (m,) number of the nearest orientation.
        inside: (m,) whether a target is inside the grid.
    """

    voxels: NDArray[np.intp]
    samples: NDArray[np.intp]
    inside: NDArray[np.bool_]


def cells(grid: Grid, samples: Array, task: str, targets: Any) -> Cells:
    """The cells that targets of a map's task are in.

    Raises:
        ArgumentError: the targets are of another shape.

    Example:
        >>> from urdf_ik.maps.workspaces import Grid
        >>> at = cells(Grid(np.zeros(3), 0.1, (2, 2, 1)), np.zeros((1, 0)), "position", [[0.15, 0.05, 0.05]])
        >>> at.voxels.tolist(), at.inside.tolist()
        ([[1, 0, 0]], [True])
    """
    shape, words = _TARGETS[task]
    given = inputs.real(targets, "targets", words)
    if given.shape[1:] != shape:
        raise ArgumentError(f"targets of shape {given.shape} given; the map's task is {task!r}, which takes {words}")
    if task == "pose":
        voxels, inside = grid.places(given[:, :3, 3])
        return Cells(voxels, _nearest_rotation(samples, given), inside)
    coordinates = 2 if task.startswith("planar") else 3
    positions = given[:, :coordinates]
    if coordinates == 2:
        positions = np.column_stack([positions, np.zeros(len(given))])
    voxels, inside = grid.places(positions)
    return Cells(voxels, _nearest_of(samples, given[:, coordinates:]), inside)


def _nearest_rotation(samples: Array, poses: Array) -> NDArray[np.intp]:
    """The rotation (S, 3, 3) that is the least turn away, one for each pose (m, 4, 4)."""
    rotations, known = check_poses(poses)[:, :3, :3].reshape(-1, 9), samples.reshape(-1, 9)
    if len(known) > MANY:
        return np.asarray(_tree(known).query(rotations)[1], dtype=np.intp)
    found = np.empty(len(rotations), dtype=np.intp)
    rows = _AT_ONCE // len(known)
    for start in range(0, len(rotations), rows):
        part = slice(start, start + rows)
        # As rows of nine numbers the product of two is 1 + 2 cos of the angle between them, the trace of A^T B: the
        # nearest one has the greatest product, and is also the nearest point.
        found[part] = (rotations[part] @ known.T).argmax(axis=1)
    return found


def _nearest_of(samples: Array, given: Array) -> NDArray[np.intp]:
    """The same of directions (S, 3), of angles (S, 1) rad, and of nothing (1, 0)."""
    if samples.shape[1] == 0:
        return np.zeros(len(given), dtype=np.intp)
    if samples.shape[1] == 1:
        samples, given = (np.column_stack([np.cos(each), np.sin(each)]) for each in (samples, given))
    else:
        given = given / np.maximum(np.linalg.norm(given, axis=1, keepdims=True), DEFAULT.contract)
    return np.asarray(_tree(samples).query(given)[1], dtype=np.intp)


def _tree(points: Array) -> Any:
    from scipy.spatial import cKDTree  # only a look-up needs it

    return cKDTree(points)
