"""Operations on stored maps, block by block: cut out a part, join two side by side, compare two."""

from __future__ import annotations

import os
from collections.abc import Mapping
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from urdf_ik.errors import ArgumentError
from urdf_ik.maps.engine import zarr_writer
from urdf_ik.maps.engine.store_folder import read_question
from urdf_ik.maps.workspaces.grid import Grid
from urdf_ik.maps.workspaces.question import HELD
from urdf_ik.maps.workspaces.store.block_jobs import Layout, write
from urdf_ik.maps.workspaces.store.blocks import Blocks, Part
from urdf_ik.maps.workspaces.store.stored_map import StoredMap
from urdf_ik.support import inputs

_OF_ONE_STORE = ("grid", "block", "holds")  # what may differ between maps that are joined
_ALIGNED = 1e-6  # share of a voxel by which the lattices of two maps may be off


class Differences(NamedTuple):
    """Differences of two maps of one grid.

    Attributes:
        poses: number of poses.
        only_first: number of poses that are reached in the first map only.
        only_second: number of poses that are reached in the second map only.
        more: number of poses of both that have more solutions in the second map.
        fewer: number of poses of both that have fewer solutions in the second map.
        voxels_only_first: number of voxels that are reached in the first map only.
        voxels_only_second: number of voxels that are reached in the second map only.
    """

    poses: int
    only_first: int
    only_second: int
    more: int
    fewer: int
    voxels_only_first: int
    voxels_only_second: int


def differences(first: StoredMap, second: StoredMap) -> Differences:
    """The differences of two maps, by the solutions that count in each; one block at a time is in memory.

    Raises:
        ArgumentError: the maps have other grids or orientations.
        JobError: a block is not there, or damaged.

    Example:
        >>> import urdf_ik
        >>> arm = urdf_ik.load("planar_2r")
        >>> one = urdf_ik.maps.workspace(arm, 0.05, 4, store="one.zarr")
        >>> other = urdf_ik.maps.workspace(arm, 0.05, 4, within_limits=False, store="other.zarr")
        >>> differences(one, other).only_first
        0
    """
    _stores(first=first, second=second)
    if first.grid.described() != second.grid.described() or not np.array_equal(first.samples, second.samples):
        raise ArgumentError(f"{first.path} and {second.path} are of other grids or orientations; make them alike")
    found = np.zeros(7, dtype=np.int64)
    for part in first.blocks.parts():
        one, other = (each.array(each.about.counted, part).astype(np.int16) for each in (first, second))
        a, b = one > 0, other > 0
        here, there = a.any(axis=-1), b.any(axis=-1)
        found += [
            one.size, (a & ~b).sum(), (b & ~a).sum(), (a & b & (other > one)).sum(), (a & b & (other < one)).sum(),
            (here & ~there).sum(), (there & ~here).sum(),
        ]  # fmt: skip
    return Differences(*found.tolist())


def cut(source: StoredMap, path: str | os.PathLike[str], bounds: ArrayLike) -> StoredMap:
    """The voxels whose centres are inside bounds (2, 3) m, as a store of its own; a block at a time is in memory.

    Raises:
        ArgumentError: invalid bounds.
        JobError: a block is not there, or the new store cannot be written.

    Example:
        >>> import urdf_ik
        >>> found = urdf_ik.maps.workspace(urdf_ik.load("planar_2r"), 0.05, 4, store="map.zarr")
        >>> cut(found, "part.zarr", [[0, 0, -1], [0.2, 0.2, 1]]).grid.shape
        (4, 4, 1)
    """
    _stores(source=source)
    part = source.grid.part(bounds)
    grid = source.grid.cut(part)
    starts = (part[0].start, part[1].start, part[2].start)
    return _copied(path, grid, [(source, (-starts[0], -starts[1], -starts[2]))])


def join(first: StoredMap, second: StoredMap, path: str | os.PathLike[str]) -> StoredMap:
    """Two maps that fill a box together, as one store; where they overlap, the first one counts.

    Raises:
        ArgumentError: they are of other arms, voxels or orientations, or do not fill a box; or it does not fit on the
            disk.
        JobError: a block is not there, or the new store cannot be written.

    Example:
        >>> import urdf_ik
        >>> found = urdf_ik.maps.workspace(urdf_ik.load("planar_2r"), 0.05, 4, store="map.zarr")
        >>> left = cut(found, "left.zarr", [[-1, -1, -1], [0, 1, 1]])
        >>> right = cut(found, "right.zarr", [[0, -1, -1], [1, 1, 1]])
        >>> join(left, right, "whole.zarr").grid.shape
        (8, 8, 1)
    """
    _stores(first=first, second=second)
    one, other = (_question(each) for each in (first, second))
    differing = sorted(name for name in {*one, *other} if one.get(name) != other.get(name))
    if differing or first.grid.voxel != second.grid.voxel:
        names = ", ".join(differing) or "the voxel"
        raise ArgumentError(
            f"{first.path} and {second.path} differ in {names}; only maps of one question can be joined"
        )
    voxel = first.grid.voxel
    lower = np.minimum(first.grid.lower, second.grid.lower)
    offsets = [(each.grid.lower - lower) / voxel for each in (first, second)]
    if max(float(np.abs(offset - np.round(offset)).max()) for offset in offsets) > _ALIGNED:
        raise ArgumentError(f"the voxels of {first.path} and {second.path} do not lie on one lattice")
    whole = [np.round(offset).astype(int) for offset in offsets]
    ends = [start + np.array(each.grid.shape) for start, each in zip(whole, (first, second), strict=True)]
    x, y, z = (int(count) for count in np.maximum(*ends))
    covered = np.zeros((x, y, z), dtype=np.bool_)
    for start, end in zip(whole, ends, strict=True):
        covered[tuple(slice(a, b) for a, b in zip(start, end, strict=True))] = True
    if not covered.all():
        raise ArgumentError(
            f"{first.path} and {second.path} do not fill a box together; cut them, or map what is missing"
        )
    sources = [
        (each, (int(start[0]), int(start[1]), int(start[2])))
        for each, start in zip((first, second), whole, strict=True)
    ]
    return _copied(path, Grid(lower, voxel, (x, y, z)), sources)


Placed = tuple[StoredMap, tuple[int, int, int]]
"""A map, and the place of its first voxel in another grid."""


def _copied(path: str | os.PathLike[str], grid: Grid, sources: list[Placed]) -> StoredMap:
    first = sources[0][0]
    holds = tuple(name for name in first.holds if all(name in each.holds for each, _ in sources))
    blocks = Blocks.of(grid, first.blocks.most)
    layout = Layout(first.about, grid, first.samples, holds, blocks)
    question = {
        **read_question(first.path), "grid": grid.described(), "holds": list(holds), "block": list(blocks.shape)
    }  # fmt: skip
    write(layout, question, path, _Copying(sources, layout), None, None)
    return StoredMap(path)


class _Copying:
    """Makes the files of a block from the blocks of other maps."""

    def __init__(self, sources: list[Placed], layout: Layout) -> None:
        self._sources, self._layout = sources, layout

    def __call__(self, chunk: int) -> Mapping[str, bytes]:
        """The files of a block."""
        part = self._layout.blocks.part(chunk)
        arrays = {plan.name: self._array(plan, part) for plan in self._layout.plans}
        return self._encoder.files(self._layout.blocks.place(chunk), arrays)

    def _array(self, plan: zarr_writer.ArrayPlan, part: Part) -> NDArray[Any]:
        shape = tuple(each.stop - each.start for each in part)
        found = np.full((*shape, plan.shape[-1]), plan.fill, dtype=HELD[plan.name].kind)
        for source, start in reversed(self._sources):
            inner = [
                slice(max(each.start, first), min(each.stop, first + count))
                for each, first, count in zip(part, start, source.grid.shape, strict=True)
            ]
            if any(each.start >= each.stop for each in inner):
                continue
            x, y, z = (slice(each.start - first, each.stop - first) for each, first in zip(inner, start, strict=True))
            to = tuple(
                slice(each.start - whole.start, each.stop - whole.start)
                for each, whole in zip(inner, part, strict=True)
            )
            found[to] = source.array(plan.name, (x, y, z))
        return found

    @cached_property
    def _encoder(self) -> zarr_writer.Encoder:
        return zarr_writer.Encoder(self._layout.plans)


def _stores(**given: Any) -> None:
    """Check that every argument is a stored map."""
    for name, value in given.items():
        inputs.kind(value, "blocks", name, "a store of a map, as urdf_ik.maps.workspaces.opened gives it,")


def _question(stored: StoredMap) -> dict[str, Any]:
    return {name: value for name, value in read_question(stored.path).items() if name not in _OF_ONE_STORE}
