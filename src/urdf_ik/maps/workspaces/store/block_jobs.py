"""The job that solves the blocks of a map, and the layout of the store that keeps them."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from dataclasses import asdict
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from urdf_ik.errors import ArgumentError
from urdf_ik.maps.engine import Folder, run, zarr_writer
from urdf_ik.maps.engine.store_folder import checked_path, finished
from urdf_ik.maps.workspaces.grid import AXES, Grid, require_memory, require_room
from urdf_ik.maps.workspaces.question import HELD, Question
from urdf_ik.maps.workspaces.store.blocks import Blocks
from urdf_ik.maps.workspaces.store.stored_map import FORMAT, VERSION, StoredMap
from urdf_ik.maps.workspaces.workspace_map import About

BLOCK = 2**20
"""Poses of a block where each step of the solution is a quadratic: about a second's work."""
BLOCK_OF_GENERAL_ARMS = 2**16
"""The same for other arms, whose poses take tens of times as long."""
BLOCK_WITH_COLLISIONS = 2**14
"""The same where collisions are looked for."""


def fill(
    asked: Question,
    path: str | os.PathLike[str],
    client: Any,
    block: int | None,
    progress: Callable[[int, int], object] | None,
) -> StoredMap:
    """Make all blocks of a map that are not in the store yet."""
    if block is not None and block < 1:
        raise ArgumentError(f"{block} poses a block given; 1 or more are needed")
    count = len(asked.samples)
    blocks = Blocks.of(asked.grid, max(1, (block or _usual_block(asked)) // count))
    require_memory(asked.grid, count, asked.size(blocks.most) + asked.scratch())
    layout = Layout.of(asked, blocks)
    question = {**asked.described(), "format": FORMAT, "version": VERSION, "block": list(blocks.shape)}
    write(layout, question, path, Solving(asked, layout), client, progress)
    return StoredMap(path)


class Layout:
    """The arrays of a map's store.

    Args:
        about: what the map is of.
        grid: its voxels.
        samples: (S, ...) what is sampled at each position.
        holds: names of the arrays.
        blocks: how the grid is cut.
    """

    def __init__(
        self, about: About, grid: Grid, samples: NDArray[np.float64], holds: tuple[str, ...], blocks: Blocks
    ) -> None:
        self.about, self.grid, self.samples, self.blocks = about, grid, samples, blocks
        last = {"orientation": len(samples), "branch": len(about.branches)}
        self.plans = tuple(
            zarr_writer.ArrayPlan(
                name,
                (*AXES, HELD[name].per),
                (*grid.shape, last[HELD[name].per]),
                (*blocks.shape, last[HELD[name].per]),
                np.dtype(HELD[name].kind).name,
                HELD[name].fill,
                {"long_name": HELD[name].words, "units": HELD[name].units},
            )
            for name in holds
        )

    @classmethod
    def of(cls, asked: Question, blocks: Blocks) -> Layout:
        """The layout that answers a question."""
        return cls(asked.about(), asked.grid, asked.samples, asked.holds, blocks)

    @property
    def coordinates(self) -> tuple[zarr_writer.Coordinate, ...]:
        """Centres of the voxels, and what was sampled."""
        inner = ("row", "column")[: self.samples.ndim - 1]
        centres = [
            zarr_writer.Coordinate(
                name, (name,), self.grid.coordinates(k), {"units": "m", "long_name": f"voxels' centres, {name}"}
            )
            for k, name in enumerate(AXES)
        ]
        words = {"long_name": self.about.sampled, "units": "rad" if self.samples.shape[1:] == (1,) else "1"}
        return (
            *centres,
            zarr_writer.Coordinate("orientation", ("orientation",), np.arange(len(self.samples))),
            zarr_writer.Coordinate("samples", ("orientation", *inner), self.samples, words),
        )

    @property
    def attributes(self) -> dict[str, Any]:
        """The attributes of the group."""
        return {
            "format": FORMAT,
            "version": VERSION,
            "complete": False,
            **asdict(self.about),
            "grid": self.grid.described(),
            "block": list(self.blocks.shape),
        }


class Solving:
    """Makes the files of a block by solving its poses."""

    def __init__(self, asked: Question, layout: Layout) -> None:
        self._asked, self._plans, self._blocks = asked, layout.plans, layout.blocks

    def __getstate__(self) -> dict[str, Any]:
        return {"_asked": self._asked, "_plans": self._plans, "_blocks": self._blocks}

    def __call__(self, chunk: int) -> Mapping[str, bytes]:
        """The files of a block."""
        solver, encoder = self._tools
        part = self._blocks.part(chunk)
        found = solver.answers(self._asked.grid.centres_of(part))
        shape = tuple(each.stop - each.start for each in part)
        arrays = {name: values.reshape(*shape, -1) for name, values in found.items()}
        files: Mapping[str, bytes] = encoder.files(self._blocks.place(chunk), arrays)
        return files

    @cached_property
    def _tools(self) -> Any:
        return self._asked.solver(), zarr_writer.Encoder(self._plans)


def write(
    layout: Layout,
    question: Mapping[str, Any],
    path: str | os.PathLike[str],
    job: Any,
    client: Any,
    progress: Callable[[int, int], object] | None,
) -> None:
    """Make a map's store, or go on with it; ``progress`` is called with poses.

    Raises:
        JobError: the missing blocks do not fit on the disk; the store is in use, is of another question, or cannot be
            written.
    """
    zarr_writer.package()
    grid, blocks = layout.grid, layout.blocks
    left = blocks.count - len(finished(checked_path(path)))
    size = sum(int(np.prod(plan.chunk)) * np.dtype(plan.kind).itemsize for plan in layout.plans) * left
    require_room(grid, len(layout.samples), min(size, sum(_bytes(plan) for plan in layout.plans)), checked_path(path))
    poses = grid.count * len(layout.samples)

    def tick(done: int, total: int) -> None:
        if progress is not None:
            progress(done * poses // total, poses)

    files = zarr_writer.group_files(layout.plans, layout.coordinates, layout.attributes)
    with Folder(path, question, blocks.count, files, zarr_writer.with_attributes(files, {"complete": True})) as store:
        run(job, store, client=client, progress=tick)
        store.finish()


def _bytes(plan: zarr_writer.ArrayPlan) -> int:
    return int(np.prod(plan.shape)) * np.dtype(plan.kind).itemsize


def _usual_block(asked: Question) -> int:
    if asked.pairs is not None:
        return BLOCK_WITH_COLLISIONS
    return BLOCK if asked.arm.structure.by_quadratics else BLOCK_OF_GENERAL_ARMS
