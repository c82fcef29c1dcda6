"""Well-spread orientations, directions and angles, and targets of an arm's task from them.

Rotations lie on super-Fibonacci spirals (Alexa, "Super-Fibonacci Spirals: Fast, Low-Discrepancy Sampling of SO(3)",
CVPR 2022, algorithm 1), directions on a Fibonacci lattice of the sphere (Swinbank and Purser, "Fibonacci grids: A novel
approach to global modelling", Quarterly Journal of the Royal Meteorological Society 132, 2006).
"""

import numpy as np

from urdf_ik.arm import Arm
from urdf_ik.errors import ArgumentError
from urdf_ik.model.poses import pose
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
    return pose(np.zeros(3), quat_xyzw=quat)[:, :3, :3]


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
        return pose(np.zeros(3), rotvec=angles[:, None] * axis)[:, :3, :3] @ R
    if kind == DIRECTIONS:
        return directions(n)
    return angles.reshape(n, 1) if kind == ANGLES else np.zeros((1, 0))


def targets(task: str, chosen: Array, positions: Array) -> Array:
    """Targets (k * S, ...) of a task at positions (k, 3) m with samples (S, ...), position by position."""
    shape = (len(positions), len(chosen))
    if task == "pose":
        T = np.zeros((*shape, 4, 4))
        T[..., :3, :3], T[..., :3, 3], T[..., 3, 3] = chosen, positions[:, None], 1.0
        return T.reshape(-1, 4, 4)
    coordinates = 2 if task.startswith("planar") else 3
    at = np.empty((*shape, coordinates + chosen.shape[1]))
    at[..., :coordinates], at[..., coordinates:] = positions[:, None, :coordinates], chosen
    return at.reshape(-1, at.shape[-1])
