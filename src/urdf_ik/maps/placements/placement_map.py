"""PlacementMap: the scores of every base position of a grid, and the best positions."""

from __future__ import annotations

import os
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from urdf_ik.errors import ArgumentError, JobError, printable
from urdf_ik.maps.engine import free_space
from urdf_ik.maps.engine.store_folder import finished, read_question
from urdf_ik.maps.engine.zarr_reader import OpenedGroup
from urdf_ik.maps.placements.scores import SCORES
from urdf_ik.maps.workspaces import Grid
from urdf_ik.maps.workspaces.store.blocks import Blocks
from urdf_ik.model.poses import pose
from urdf_ik.support import inputs
from urdf_ik.support.files import name_of
from urdf_ik.support.text import quoted
from urdf_ik.typing import Array

FORMAT, VERSION = "urdf-ik placements", 1
SHOWN = {name: score.words for name, score in SCORES.items()}
"""What a base position can be asked for, and what that is."""


class Place(NamedTuple):
    """A base position with its scores; see :class:`PlacementMap`.

    Attributes:
        pose: (4, 4) m, the base link in the cell.
        reached: number of targets that are reached.
        solutions: least number of solutions of any target.
        branches: number of branches that reach every target.
        margin: least limit margin of any target; NaN where one is not reached.
        clearance: m, the least of any target; NaN where one is not reached, or where nobody asked.
        followed: whether the path is followed; None where there is none.
        cost: of following it; NaN where it is not followed.
    """

    pose: Array
    reached: int
    solutions: int
    branches: int
    margin: float
    clearance: float
    followed: bool | None
    cost: float


@dataclass(frozen=True, eq=False)
class PlacementMap:
    """Base positions x headings, with how targets are reached from there.

    Attributes:
        about: the arm and the question.
        grid: positions of the base link in the cell, the voxels' centres (X, Y, Z).
        headings: (H,) rad, turns of the base link about the cell's z axis.
        mount: (3, 3) the base link's rotation at heading zero.
        targets: (m, 4, 4) m, in the cell.
        reached: (X, Y, Z, H) number of targets that are reached.
        solutions: (X, Y, Z, H) least number of solutions of any target; 0 where one is not reached.
        branches: (X, Y, Z, H) number of branches that reach every target.
        margin: (X, Y, Z, H) of each target the greatest limit margin of its solutions, of these the least: 0 at a limit
            and 1 in the middle of all; NaN where a target is not reached.
        clearance: (X, Y, Z, H) m, the same of the clearance; None where collisions were not looked for.
        followed: (X, Y, Z, H) 1 where the path is followed without a jump; None where the targets are no path.
        cost: (X, Y, Z, H) the cost of that, NaN where it is not followed; None where the targets are no path.

    Example:
        >>> import urdf_ik
        >>> arm = urdf_ik.load("zyyzyz_6r")
        >>> found = urdf_ik.maps.placement(arm, arm.fk([0.3] * 6), bounds=[[-1, -1, 0], [1, 1, 0]], step=0.5, turns=2)
        >>> found.reached.shape, int(found.reached.max())
        ((5, 5, 1, 2), 1)
    """

    about: dict[str, Any]
    grid: Grid
    headings: Array
    mount: Array = field(repr=False)
    targets: Array = field(repr=False)
    reached: NDArray[np.uint32] = field(repr=False)
    solutions: NDArray[np.uint16] = field(repr=False)
    branches: NDArray[np.uint16] = field(repr=False)
    margin: NDArray[np.float32] = field(repr=False)
    clearance: NDArray[np.float32] | None = field(repr=False, default=None)
    followed: NDArray[np.uint8] | None = field(repr=False, default=None)
    cost: NDArray[np.float32] | None = field(repr=False, default=None)

    def __repr__(self) -> str:
        shape = " x ".join(map(str, self.grid.shape))
        best = f"at best {int(self.reached.max())} of {len(self.targets)} targets reached"
        return f"<PlacementMap of {self.about['robot']}: {shape} positions x {len(self.headings)} headings, {best}>"

    def values(self, what: str = "reached") -> Array:
        """One score at every position and heading (X, Y, Z, H), NaN where it means nothing.

        Raises:
            ArgumentError: there is no such score, or nobody asked for it.

        Example:
            >>> import urdf_ik
            >>> arm = urdf_ik.load("zyyzyz_6r")
            >>> found = urdf_ik.maps.placement(arm, arm.fk([0.3] * 6), bounds=[[-1, -1, 0], [1, 1, 0]], step=0.5)
            >>> float(np.nanmax(found.values("solutions")))
            8.0
        """
        found = getattr(self, what) if isinstance(what, str) and what in SCORES else None
        if found is None:
            held = ", ".join(name for name in SCORES if getattr(self, name) is not None)
            raise ArgumentError(f"the map holds no {quoted(what)}; it holds {held}")
        if what == "reached":
            return np.asarray(found, dtype=np.float64)
        return np.where(self.reached == len(self.targets), found, np.nan).astype(np.float64)

    def best(self) -> Place:
        """The best place; see :meth:`places`.

        Example:
            >>> import urdf_ik
            >>> arm = urdf_ik.load("zyyzyz_6r")
            >>> found = urdf_ik.maps.placement(arm, arm.fk([0.3] * 6), bounds=[[-1, -1, 0], [1, 1, 0]], step=0.5)
            >>> found.best().reached
            1
        """
        return self.places(1)[0]

    def places(self, count: int = 5) -> tuple[Place, ...]:
        """The best places, best first.

        They are ranked by the number of targets that are reached; then by whether the path is followed; then by the
        limit margin; then by the path's cost, or the number of branches that reach everything; then by the clearance.

        Raises:
            ArgumentError: fewer than one is asked for.

        Example:
            >>> import urdf_ik
            >>> arm = urdf_ik.load("zyyzyz_6r")
            >>> found = urdf_ik.maps.placement(arm, arm.fk([0.3] * 6), bounds=[[-1, -1, 0], [1, 1, 0]], step=0.5)
            >>> [place.reached for place in found.places(2)]
            [1, 1]
        """
        count = inputs.whole(count, "count", low=1)
        keys = [self.reached, self._or_zero(self.followed), self._or_least(self.margin)]
        keys += [-self._or_greatest(self.cost), self.branches.astype(np.float64), self._or_least(self.clearance)]
        order = np.lexsort([np.asarray(key, np.float64).ravel() for key in reversed(keys)])[::-1][:count]
        return tuple(self._place(index) for index in np.array(np.unravel_index(order, self.reached.shape)).T)

    def base(self, index: tuple[int, int, int, int]) -> Array:
        """(4, 4) m, pose of the base link in the cell at a position and heading of the map.

        Example:
            >>> import urdf_ik
            >>> arm = urdf_ik.load("zyyzyz_6r")
            >>> found = urdf_ik.maps.placement(arm, arm.fk([0.3] * 6), bounds=[[-1, -1, 0], [1, 1, 0]], step=0.5)
            >>> found.base((0, 1, 0, 0))[:3, 3].tolist()
            [-1.0, -0.5, 0.0]
        """
        sizes = (*self.grid.shape, len(self.headings))
        if not isinstance(index, tuple | list) or len(index) != len(sizes):
            raise ArgumentError(f"index={quoted(index)} given; four whole numbers are needed")
        x, y, z, heading = (inputs.whole(each, "index", high=size - 1) for each, size in zip(index, sizes, strict=True))
        position = [self.grid.coordinates(axis)[at] for axis, at in enumerate((x, y, z))]
        found = pose(position, rotvec=[0.0, 0.0, float(self.headings[heading])])
        found[:3, :3] = found[:3, :3] @ self.mount
        return found

    def _place(self, index: Any) -> Place:
        at = (int(index[0]), int(index[1]), int(index[2]), int(index[3]))
        return Place(
            self.base(at),
            int(self.reached[at]),
            int(self.solutions[at]),
            int(self.branches[at]),
            float(self.margin[at]),
            float("nan") if self.clearance is None else float(self.clearance[at]),
            None if self.followed is None else bool(self.followed[at]),
            float("nan") if self.cost is None else float(self.cost[at]),
        )

    def _or_zero(self, scores: Any) -> Any:
        return np.zeros(self.reached.shape) if scores is None else scores

    def _or_least(self, scores: Any) -> Any:
        return np.zeros(self.reached.shape) if scores is None else np.where(np.isnan(scores), -np.inf, scores)

    def _or_greatest(self, scores: Any) -> Any:
        return np.zeros(self.reached.shape) if scores is None else np.where(np.isnan(scores), np.inf, scores)


def opened(path: str | os.PathLike[str]) -> PlacementMap:
    """A map that ``urdf_ik.maps.placement(..., store=path)`` made, in memory.

    Raises:
        JobError: the folder is no such store, is not complete, or is damaged.

    Example:
        >>> import urdf_ik
        >>> arm = urdf_ik.load("zyyzyz_6r")
        >>> made = urdf_ik.maps.placement(
        ...     arm, arm.fk([0.3] * 6), bounds=[[-1, -1, 0], [1, 1, 0]], step=0.5, store="bases.zarr")
        >>> bool((opened("bases.zarr").reached == made.reached).all())
        True
    """
    folder = inputs.path(path, "path", JobError)
    about = read_question(folder)
    if about.get("format") != FORMAT or about.get("version") != VERSION:
        raise JobError(f"{folder} holds no placements that this package reads, but {quoted(about.get('format'))}")
    try:
        grid = Grid.from_described(about["grid"])
        blocks = Blocks.from_described(grid.shape, about["block"])
        if (done := len(finished(folder))) < blocks.count:
            raise JobError(
                f"{folder} is not complete: {done} of {blocks.count} blocks are there; run what makes it again"
            )
        group, most = OpenedGroup(folder), free_space.available_memory()
        if unknown := [name for name in about["holds"] if name not in SCORES]:
            raise JobError(f"{name_of(folder)} is a damaged store: there is no score {quoted(unknown[0])}")
        arrays: dict[str, Any] = {name: group.read(name, None, most) for name in about["holds"]}
        shape = (*grid.shape, len(about["headings"]))
        if wrong := [name for name, array in arrays.items() if array.shape != shape]:
            raise JobError(f"{name_of(folder)} is a damaged store: {wrong[0]} is not of the grid's shape")
        return PlacementMap(
            {name: value for name, value in about.items() if name not in ("format", "version", "block")},
            grid,
            np.array(about["headings"], dtype=np.float64),
            np.array(about["mount"], dtype=np.float64),
            group.read("targets"),
            **arrays,
        )
    except JobError:
        raise
    except Exception as error:  # whatever a question leads to that was not written by this package
        reason = printable(f"{type(error).__name__} {error}", 200)
        raise JobError(f"{name_of(folder)} is a damaged store: {reason}") from None
