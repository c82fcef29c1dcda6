"""PlacementMap: the scores of every base position of a grid, and the best positions."""

import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from urdf_ik.errors import ArgumentError
from urdf_ik.maps.grid import Grid
from urdf_ik.maps.store import BlockStore, Variable
from urdf_ik.model.poses import pose
from urdf_ik.support import inputs
from urdf_ik.typing import Array

FORMAT = "urdf-ik placements"
SCORES = {
    "reached": Variable(np.uint32, "heading", "number of targets that are reached"),
    "solutions": Variable(np.uint16, "heading", "least number of solutions of any target"),
    "branches": Variable(np.uint16, "heading", "number of branches that reach every target"),
    "margin": Variable(np.float32, "heading", "least limit margin of any target, of its best solution"),
    "clearance": Variable(np.float32, "heading", "least clearance of any target, of its best solution", "m"),
    "followed": Variable(np.uint8, "heading", "1 where the path is followed without a jump"),
    "cost": Variable(np.float32, "heading", "least cost of following the path"),
}
"""The scores of a base position; a score of all targets is 0, or NaN, where one of them is not reached."""
_RANKING = (("reached", 1), ("followed", 1), ("margin", 1), ("cost", -1), ("branches", 1), ("clearance", 1))
"""Scores in the order in which they decide which place is better, with the sign that makes more better."""
SHOWN = {name: score.words for name, score in SCORES.items()}
"""Names of the scores, with their descriptions."""


class Place(NamedTuple):
    """A base position with its scores; see :class:`PlacementMap`.

    Attributes:
        pose: (4, 4) m, the base link in the cell.
        reached: number of targets that are reached.
        solutions: least number of solutions of any target.
        branches: number of branches that reach every target.
        margin: least limit margin of any target; NaN where one is not reached.
        clearance: m, the least of any target; NaN where one is not reached or it was not computed.
        followed: whether the path is followed; None where the targets are no path.
        cost: of following it; NaN where it is not followed.
    """

    pose: Array
    reached: int
    solutions: int
    branches: int
    margin: float
    clearance: float = float("nan")
    followed: bool | None = None
    cost: float = float("nan")


@dataclass(frozen=True, eq=False)
class PlacementMap:
    """Base positions x headings, with how targets are reached from there.

    Attributes:
        about: the arm and the question.
        grid: positions of the base link in the cell, the voxels' centres (X, Y, Z).
        headings: (H,) rad, turns of the base link about the cell's z axis.
        mount: (3, 3) the base link's rotation at heading zero.
        targets: (m, 4, 4) m, in the cell.
        arrays: the scores by name.
        reached: (X, Y, Z, H) number of targets that are reached; like each name of ``SCORES``, None where it was not
            computed.
        solutions: least number of solutions of any target; 0 where one is not reached.
        branches: number of branches that reach every target.
        margin: of each target the greatest limit margin of its solutions, of these the least: 0 at a limit and 1 in
            the middle of all; NaN where a target is not reached.
        clearance: m, the same of the clearance.
        followed: 1 where the path is followed without a jump.
        cost: the cost of that, NaN where it is not followed.
    """

    about: dict[str, Any]
    grid: Grid
    headings: Array
    mount: Array = field(repr=False)
    targets: Array = field(repr=False)
    arrays: Mapping[str, NDArray[Any]] = field(repr=False)

    def __getattr__(self, name: str) -> Any:
        if name not in SCORES:
            raise AttributeError(f"{type(self).__name__} has no attribute {name!r}")
        return self.arrays.get(name)

    def __repr__(self) -> str:
        shape = " x ".join(map(str, self.grid.shape))
        best = f"at best {int(self.reached.max())} of {len(self.targets)} targets reached"
        return f"<PlacementMap of {self.about['robot']}: {shape} positions x {len(self.headings)} headings, {best}>"

    def values(self, what: str = "reached") -> Array:
        """One score at every position and heading (X, Y, Z, H), NaN where it means nothing.

        Raises:
            ArgumentError: there is no such score, or nobody asked for it.
        """
        if what not in self.arrays:
            raise ArgumentError(f"the map contains no {what!r}; it contains {', '.join(self.arrays)}")
        scores = self.arrays[what]
        if what == "reached":
            return np.asarray(scores, dtype=np.float64)
        return np.where(self.reached == len(self.targets), scores, np.nan).astype(np.float64)

    def best(self) -> Place:
        """The best place; see :meth:`places`."""
        return self.places(1)[0]

    def places(self, count: int = 5) -> tuple[Place, ...]:
        """The best places, best first.

        They are ranked by the number of targets that are reached; then by whether the path is followed; then by the
        limit margin; then by the path's cost, or the number of branches that reach everything; then by the clearance.

        Raises:
            ArgumentError: fewer than one is asked for.
        """
        count = inputs.whole(count, "count", low=1)
        keys = [
            np.nan_to_num(np.asarray(sign * self.arrays[name], np.float64), nan=-np.inf).ravel()
            for name, sign in _RANKING
            if name in self.arrays
        ]
        order = np.lexsort(keys[::-1])[::-1][:count]
        return tuple(self._place(index) for index in np.array(np.unravel_index(order, self.reached.shape)).T.tolist())

    def base(self, index: Sequence[int]) -> Array:
        """(4, 4) m, pose of the base link in the cell at a position and heading (4,) of the map."""
        *place, heading = index
        position = [self.grid.coordinates(axis)[at] for axis, at in enumerate(place)]
        return base_pose(position, float(self.headings[heading]), self.mount)

    def _place(self, index: Sequence[int]) -> Place:
        scores = {name: array[tuple(index)].item() for name, array in self.arrays.items()}
        if "followed" in scores:
            scores["followed"] = bool(scores["followed"])
        return Place(self.base(index), **scores)


def opened(path: str | os.PathLike[str]) -> PlacementMap:
    """A map that ``urdf_ik.maps.placement(..., store=path)`` computed, in memory.

    Raises:
        JobError: the folder is no such store, or is not complete.
    """
    store = BlockStore(path, FORMAT)
    headings, mount = (np.array(store.about[name], dtype=np.float64) for name in ("headings", "mount"))
    targets = np.asarray(store.group["targets"][...])
    arrays = {name: store.array(name, store.grid.whole) for name in store.names}
    return PlacementMap(store.about, store.grid, headings, mount, targets, arrays)


def base_pose(position: ArrayLike, heading: float, mount: Array) -> Array:
    """(4, 4) pose of the base link in the cell."""
    T = pose(position, rotvec=[0.0, 0.0, heading])
    T[:3, :3] = T[:3, :3] @ mount
    return T
