"""StoredMap: a map in a store, read block by block."""

from __future__ import annotations

import os
from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from urdf_ik.errors import JobError, printable
from urdf_ik.maps.engine import free_space
from urdf_ik.maps.engine.store_folder import finished, read_question
from urdf_ik.maps.engine.zarr_reader import OpenedGroup
from urdf_ik.maps.workspaces.cells import cells
from urdf_ik.maps.workspaces.grid import Grid, require_memory
from urdf_ik.maps.workspaces.question import HELD
from urdf_ik.maps.workspaces.store.blocks import Blocks, Part
from urdf_ik.maps.workspaces.totals import Totals, summed
from urdf_ik.maps.workspaces.workspace_map import About, MapSlice, WorkspaceMap, read
from urdf_ik.support import inputs
from urdf_ik.support.files import name_of
from urdf_ik.support.text import quoted
from urdf_ik.typing import Array

FORMAT, VERSION = "urdf-ik workspace map in Zarr", 1


class StoredMap:
    """A map in a Zarr group, read block by block; only a full load reads all of it.

    Any Zarr reader can read the group, such as ``xarray.open_zarr(path)``. Each array has the dimensions x, y, z and
    orientation, or x, y, z and branch; coordinates are in metres. The group's attributes hold the fields of ``about``.

    Attributes:
        path: the store.
        about: the arm and the question.
        grid: the voxels (X, Y, Z).
        samples: (S, ...) samples at each position: rotation matrices, directions or angles.
        holds: names of the arrays.
        blocks: the division of the grid into blocks.

    Raises:
        JobError: there is no such store, or it is damaged.

    Example:
        >>> import urdf_ik
        >>> made = urdf_ik.maps.workspace(urdf_ik.load("planar_2r"), 0.05, 4, store="map.zarr")
        >>> found = StoredMap("map.zarr")
        >>> found.about.robot, found.grid.shape, found.complete
        ('planar_2r', (8, 8, 1), True)
    """

    def __init__(self, path: str | os.PathLike[str]) -> None:
        self.path = inputs.path(path, "path", JobError)
        question = read_question(self.path)
        if question.get("format") != FORMAT:
            raise JobError(f"{self.path} is no workspace map: it is of the format {quoted(question.get('format'))}")
        if question.get("version") != VERSION:
            found = quoted(question.get("version"))
            raise JobError(f"{self.path} is of version {found}; this package reads {VERSION}")
        try:
            self.about = About.read(question)
            self.grid = Grid.from_described(question["grid"])
            self.holds: tuple[str, ...] = tuple(question["holds"])
            self.blocks = Blocks.from_described(self.grid.shape, question["block"])
            if unknown := [name for name in self.holds if name not in HELD]:
                raise JobError(f"there is no array {quoted(unknown[0])}")
        except (KeyError, TypeError, ValueError) as error:
            raise JobError(f"{name_of(self.path)} is a damaged store: {printable(error, 200)}") from None
        self._group = OpenedGroup(self.path)
        self.samples: Array = self._group.read("samples")
        last = {"orientation": len(self.samples), "branch": len(self.about.branches)}
        for name in self.holds:
            if self._group.shape(name) != (*self.grid.shape, last[HELD[name].per]):
                raise JobError(f"{name_of(self.path)} is a damaged store: {name} is not of the grid's shape")

    def __repr__(self) -> str:
        shape = " x ".join(map(str, self.grid.shape))
        state = "" if self.complete else ", not complete"
        return f"<StoredMap {str(self.path)!r}: {self.about.robot}, {shape} voxels x {len(self.samples)}{state}>"

    @property
    def complete(self) -> bool:
        """Whether all blocks are there; if not, ``workspace`` with the same store goes on with it."""
        return len(finished(self.path)) == self.blocks.count

    def array(self, name: str, part: Part) -> NDArray[Any]:
        """One array in a box of voxels.

        Raises:
            JobError: a block of it is not there, or damaged; or the map does not hold this.

        Example:
            >>> import urdf_ik
            >>> found = urdf_ik.maps.workspace(urdf_ik.load("planar_2r"), 0.05, 4, store="map.zarr")
            >>> found.array("solutions", (slice(0, 2), slice(0, 8), slice(0, 1))).shape
            (2, 8, 1, 1)
        """
        if not isinstance(name, str) or name not in self.holds:
            raise JobError(f"{self.path} holds no {quoted(name)}; it holds {', '.join(self.holds)}")
        spans = (
            range(each.start // side, -(-each.stop // side)) for each, side in zip(part, self.blocks.shape, strict=True)
        )
        self._require(np.ravel_multi_index(np.meshgrid(*spans, indexing="ij"), self.blocks.along).ravel())
        return self._group.read(name, part, free_space.available_memory())

    def read(self, bounds: ArrayLike | None = None) -> WorkspaceMap:
        """The map, or the voxels whose centres are inside bounds (2, 3) m, in memory.

        Raises:
            ArgumentError: the bounds make no sense, or what is asked for does not fit in memory.
            JobError: a block of it is not there, or damaged.

        Example:
            >>> import urdf_ik
            >>> found = urdf_ik.maps.workspace(urdf_ik.load("planar_2r"), 0.05, 4, store="map.zarr")
            >>> found.read([[0, 0, -1], [0.2, 0.2, 1]]).grid.shape
            (4, 4, 1)
        """
        return self._box(self._whole if bounds is None else self.grid.part(bounds))

    def values(self, what: str = "reach") -> Array:
        """One number a voxel (X, Y, Z); see :meth:`WorkspaceMap.values`.

        Example:
            >>> import urdf_ik
            >>> found = urdf_ik.maps.workspace(urdf_ik.load("planar_2r"), 0.05, 4, store="map.zarr")
            >>> float(np.nanmax(found.values("reach")))
            1.0
        """
        found = np.empty(self.grid.shape)
        for part, block in self._each():
            found[part] = block.values(what)
        return found

    def slice(self, axis: str = "z", at: float = 0.0, what: str = "reach") -> MapSlice:
        """The layer of voxels across an axis that holds the coordinate ``at`` [m]; no other one is read.

        Raises:
            ArgumentError: there is no such axis or value, or the coordinate is outside the grid.
            JobError: a block of it is not there, or damaged.

        Example:
            >>> import urdf_ik
            >>> found = urdf_ik.maps.workspace(urdf_ik.load("planar_2r"), 0.05, 4, store="map.zarr")
            >>> found.slice().values.shape
            (8, 8)
        """
        k, layer = self.grid.layer(axis, at)
        part = [*self._whole]
        part[k] = slice(layer, layer + 1)
        return self._box((part[0], part[1], part[2])).slice(axis, float(self.grid.coordinates(k)[layer]), what)

    def totals(self) -> Totals:
        """Sums over the whole map.

        Example:
            >>> import urdf_ik
            >>> found = urdf_ik.maps.workspace(urdf_ik.load("planar_2r"), 0.05, 4, store="map.zarr")
            >>> found.totals().reached_voxels == int(found.read().reached.sum())
            True
        """
        return summed(block.totals() for _, block in self._each())

    def look_up(self, targets: Any, what: str | None = None) -> NDArray[Any]:
        """Values of an array in the cells of targets; see :meth:`WorkspaceMap.look_up`.

        Each block is read once.

        Example:
            >>> import urdf_ik
            >>> found = urdf_ik.maps.workspace(urdf_ik.load("planar_2r"), 0.05, 4, store="map.zarr")
            >>> found.look_up([[0.15, 0.05], [9.0, 9.0]]).tolist()
            [1, 0]
        """
        name = self.about.counted if what is None else what
        at = cells(self.grid, self.samples, self.about.task, targets)
        numbers = np.ravel_multi_index(tuple((at.voxels // self.blocks.shape).T), self.blocks.along)
        numbers = np.where(at.inside, numbers, -1)
        order = np.argsort(numbers, kind="stable")
        asked, starts = np.unique(numbers[order], return_index=True)
        found: NDArray[Any] | None = None
        for block, mine in zip(asked, np.split(order, starts[1:]), strict=True):
            if block < 0:
                continue
            part = self.blocks.part(int(block))
            values = self.array(name, part)
            if found is None:
                found = np.full(len(numbers), np.nan if values.dtype.kind == "f" else 0, values.dtype)
            places = at.voxels[mine] - [each.start for each in part]
            found[mine] = values[(*places.T, at.samples[mine])]
        return np.zeros(len(numbers), np.uint8) if found is None else found

    def _require(self, wanted: NDArray[np.intp]) -> None:
        """Check that every block was computed: Zarr would read a missing one as zeros."""
        done = finished(self.path)
        if len(done) == self.blocks.count:
            return
        missing = [int(block) for block in wanted if int(block) not in done]
        if missing:
            raise JobError(
                f"{self.path} is not complete: {len(missing)} of the {len(wanted)} blocks that are asked for are not "
                "made yet; run what makes the map again, with the same store"
            )

    @property
    def _whole(self) -> Part:
        x, y, z = (slice(0, end) for end in self.grid.shape)
        return x, y, z

    def _box(self, part: Part) -> WorkspaceMap:
        grid = self.grid.cut(part)
        share = grid.count / self.grid.count
        require_memory(grid, len(self.samples), int(share * sum(self._group.nbytes(name) for name in self.holds)))
        arrays: dict[str, Any] = {name: self.array(name, part) for name in self.holds}
        return WorkspaceMap(self.about, grid, self.samples, **arrays)

    def _each(self) -> Iterator[tuple[Part, WorkspaceMap]]:
        """The blocks one after the other."""
        for part in self.blocks.parts():
            yield part, self._box(part)


def opened(path: str | os.PathLike[str]) -> WorkspaceMap | StoredMap:
    """A map in a store, or in a file that :meth:`WorkspaceMap.save` wrote.

    Raises:
        JobError: the folder is no store of a map, or it is damaged.
        ArgumentError: the file cannot be read, or is no map.

    Example:
        >>> import urdf_ik
        >>> made = urdf_ik.maps.workspace(urdf_ik.load("planar_2r"), 0.05, 4, store="map.zarr")
        >>> opened("map.zarr").grid.shape
        (8, 8, 1)
    """
    where = inputs.path(path, "path")
    return StoredMap(where) if os.path.isdir(where) else read(where)
