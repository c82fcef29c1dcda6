"""Sums over a map, computed block by block."""

from __future__ import annotations

from collections.abc import Iterable
from typing import NamedTuple


class BranchShare(NamedTuple):
    """How much of the workspace one branch covers.

    Attributes:
        voxels: share of the voxels that are reached.
        poses: share of the poses that are reached.
    """

    voxels: float
    poses: float


class Totals(NamedTuple):
    """Sums over a whole map.

    Attributes:
        poses: number of poses.
        reached_poses: number of poses that are reached.
        voxels: number of voxels.
        reached_voxels: number of voxels that are reached in any orientation.
        dexterous_voxels: number of voxels that are reached in every orientation.
        solutions: of each count that the map holds, its sum.
        branch_voxels: number of voxels that each branch reaches in any orientation, by name.
        branch_poses: number of poses that each branch reaches, by name.
    """

    poses: int
    reached_poses: int
    voxels: int
    reached_voxels: int
    dexterous_voxels: int
    solutions: dict[str, int]
    branch_voxels: dict[str, int]
    branch_poses: dict[str, int]

    @property
    def branch_shares(self) -> dict[str, BranchShare]:
        """How much of what is reached each branch covers, by name; zeros where nothing is reached."""
        voxels, poses = max(1, self.reached_voxels), max(1, self.reached_poses)
        return {
            name: BranchShare(self.branch_voxels[name] / voxels, self.branch_poses[name] / poses)
            for name in self.branch_poses
        }


def summed(parts: Iterable[Totals]) -> Totals:
    """The totals of a map from those of its blocks; there is one or more.

    Example:
        >>> one = Totals(4, 2, 2, 1, 0, {"solutions": 3}, {"elbow up": 1}, {"elbow up": 2})
        >>> summed([one, one]).solutions
        {'solutions': 6}
    """
    first, *others = parts
    for other in others:
        first = Totals(
            first.poses + other.poses,
            first.reached_poses + other.reached_poses,
            first.voxels + other.voxels,
            first.reached_voxels + other.reached_voxels,
            first.dexterous_voxels + other.dexterous_voxels,
            _added(first.solutions, other.solutions),
            _added(first.branch_voxels, other.branch_voxels),
            _added(first.branch_poses, other.branch_poses),
        )
    return first


def _added(one: dict[str, int], other: dict[str, int]) -> dict[str, int]:
    return {name: one[name] + other[name] for name in one}
