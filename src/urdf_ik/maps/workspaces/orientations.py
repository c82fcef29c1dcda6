"""Well-spread orientations, directions and angles; targets of an arm's task from them; the cells that targets are in.

Rotations lie on super-Fibonacci spirals (Alexa, "Super-Fibonacci Spirals: Fast, Low-Discrepancy Sampling of SO(3)",
CVPR 2022, algorithm 1), directions on a Fibonacci lattice of the sphere (Swinbank and Purser, "Fibonacci grids: A novel
approach to global modelling", Quarterly Journal of the Royal Meteorological Society 132, 2006).
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from urdf_ik.arm import Arm
from urdf_ik.errors import ArgumentError
from urdf_ik.maps.grid import Grid
from urdf_ik.model.poses import check_poses, pose
from urdf_ik.support.tolerances import DEFAULT
from urdf_ik.typing import Array

_PHI = np.sqrt(2.0)
_PSI = 1.533751168755204288118041  # the positive root of psi^4 = psi + 4
_GOLDEN = 0.5 * (1.0 + np.sqrt(5.0))

ALL, DIRECTIONS, TURNS, ANGLES, NOTHING = (
    "rotations on super-Fibonacci spirals",
    "directions on a Fibonacci lattice",
    "evenly spaced turns about the axis that the joints share",
    "evenly spaced angles",
    "nothing: the task is a position",
)
"""Descriptions of the samples at each position, by task."""


def rotations(n: int) -> Array:
    """(n, 3, 3) rotation matrices, evenly spread over all orientations."""
    s = np.arange(n) + 0.5
    inner, outer = np.sqrt(s / n), np.sqrt(1.0 - s / n)
    alpha, beta = 2.0 * np.pi * s / _PHI, 2.0 * np.pi * s / _PSI
    quat = np.stack([inner * np.sin(alpha), inner * np.cos(alpha), outer * np.sin(beta), outer * np.cos(beta)], axis=-1)
    return np.array([pose(np.zeros(3), quat_xyzw=q)[:3, :3] for q in quat]).reshape(n, 3, 3)


def directions(n: int) -> Array:
    """(n, 3) unit vectors, evenly spread over the sphere."""
    z = 1.0 - (2.0 * np.arange(n) + 1.0) / n
    turn = 2.0 * np.pi * np.arange(n) / _GOLDEN
    across = np.sqrt(1.0 - z**2)
    return np.stack([across * np.cos(turn), across * np.sin(turn), z], axis=-1)


def sampled(arm: Arm) -> str:
    """Description of the samples that the arm's task needs at each position.

    Raises:
        ArgumentError: the arm reaches only few orientations, and others at every position.
    """
    by_task = {"position and axis": DIRECTIONS, "planar pose": ANGLES, "position": NOTHING, "planar position": NOTHING}
    if arm.task in by_task:
        return by_task[arm.task]
    if arm.dof >= 6:
        return ALL
    axes = arm.chain.H[~arm.chain.prismatic]
    if len(axes) and np.linalg.norm(np.cross(axes, axes[0]), axis=1).max() < DEFAULT.contract:
        return TURNS
    raise ArgumentError(
        f"{arm.name}: {arm.dof} joints take other orientations at every position, and none that is drawn is among them"
    )


def samples(arm: Arm, n: int) -> Array:
    """Samples at each position: (n, 3, 3) rotations, (n, 3) directions or (n, 1) rad; (1, 0) for a position task."""
    kind = sampled(arm)
    angles = 2.0 * np.pi * np.arange(n) / n - np.pi
    if kind == ALL:
        return rotations(n)
    if kind == TURNS:
        axis, R = arm.chain.H[~arm.chain.prismatic][0], arm.chain.R_tip
        return np.array([pose(np.zeros(3), rotvec=angle * axis)[:3, :3] @ R for angle in angles])
    if kind == DIRECTIONS:
        return directions(n)
    return angles.reshape(n, 1) if kind == ANGLES else np.zeros((1, 0))


class Targets:
    """Targets of a task at positions x samples, written into memory that is used again."""

    def __init__(self, task: str, chosen: Array, positions: int) -> None:
        """Make room for ``positions`` positions at a time."""
        self._planar = task.startswith("planar")
        self._of_poses = task == "pose"
        if self._of_poses:
            self._room = np.zeros((positions, len(chosen), 4, 4))
            self._room[..., :3, :3], self._room[..., 3, 3] = chosen, 1.0
        else:
            coordinates = 2 if self._planar else 3
            self._room = np.empty((positions, len(chosen), coordinates + chosen.shape[1]))
            self._room[..., coordinates:] = chosen

    def at(self, positions: Array) -> Array:
        """Targets (k * samples, ...) at positions (k, 3) m, valid until the next call; position by position."""
        room = self._room[: len(positions)]
        if self._of_poses:
            room[..., :3, 3] = positions[:, None]
            return room.reshape(-1, 4, 4)
        coordinates = 2 if self._planar else 3
        room[..., :coordinates] = positions[:, None, :coordinates]
        return room.reshape(-1, room.shape[-1])


MANY = 512
"""Orientations beyond which a tree finds the nearest one faster than a comparison with all of them."""
_COMPARISONS = 2**15  # at a time: they stay in the cache, and are too few for BLAS to start threads for
# Shape of one target of each task, in words.
_TARGETS = {
    "pose": ((4, 4), "poses (m, 4, 4)"),
    "position and axis": ((6,), "positions with directions (m, 6)"),
    "position": ((3,), "positions (m, 3) m"),
    "planar pose": ((3,), "x, y and the angle in the plane (m, 3)"),
    "planar position": ((2,), "x and y in the plane (m, 2)"),
}


def cells(
    grid: Grid, chosen: Array, task: str, targets: Any
) -> tuple[NDArray[np.intp], NDArray[np.intp], NDArray[np.bool_]]:
    """The cells of a map that targets of its task are in.

    Returns:
        (m, 3) number of the voxel along each axis, zeros outside the grid; (m,) number of the nearest orientation; (m,)
        whether a target is inside the grid.

    Raises:
        ArgumentError: the targets are of another shape.
        PoseError: one is no pose.
    """
    shape, words = _TARGETS[task]
    array = np.asarray(targets, dtype=np.float64)
    if array.shape[1:] != shape:
        raise ArgumentError(f"targets of shape {array.shape} given; the map's task is {task!r}, which takes {words}")
    if task == "pose":
        voxels, inside = grid.places(array[:, :3, 3])
        return voxels, _nearest_rotation(chosen, array), inside
    coordinates = 2 if task.startswith("planar") else 3
    voxels, inside = grid.places(np.pad(array[:, :coordinates], ((0, 0), (0, 3 - coordinates))))
    return voxels, _nearest_sample(chosen, array[:, coordinates:]), inside


def _nearest_rotation(chosen: Array, poses: Array) -> NDArray[np.intp]:
    """The rotation (S, 3, 3) that is the least turn away, one for each pose (m, 4, 4)."""
    rotations, known = check_poses(poses)[:, :3, :3].reshape(-1, 9), chosen.reshape(-1, 9)
    if len(known) > MANY:
        return np.asarray(_tree(known).query(rotations)[1], dtype=np.intp)
    nearest = np.empty(len(rotations), dtype=np.intp)
    rows = _COMPARISONS // len(known)
    for start in range(0, len(rotations), rows):
        part = slice(start, start + rows)
        # As rows of nine numbers the product of two is 1 + 2 cos of the angle between them, the trace of A^T B: the
        # nearest one has the greatest product, and is also the nearest point.
        nearest[part] = (rotations[part] @ known.T).argmax(axis=1)
    return nearest


def _nearest_sample(chosen: Array, asked: Array) -> NDArray[np.intp]:
    """The same of directions (S, 3), of angles (S, 1) rad, and of nothing (1, 0)."""
    if chosen.shape[1] == 0:
        return np.zeros(len(asked), dtype=np.intp)
    if chosen.shape[1] == 1:
        chosen, asked = (np.column_stack([np.cos(angles), np.sin(angles)]) for angles in (chosen, asked))
    else:
        asked = asked / np.maximum(np.linalg.norm(asked, axis=1, keepdims=True), DEFAULT.contract)
    return np.asarray(_tree(chosen).query(asked)[1], dtype=np.intp)


def _tree(points: Array) -> Any:
    from scipy.spatial import cKDTree  # only a look-up needs it

    return cKDTree(points)
