"""workspace(): creates a map in memory, or in a store block by block."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path
from typing import Any, overload

import numpy as np
from numpy.typing import ArrayLike, NDArray

from urdf_ik.arm import Arm
from urdf_ik.cell import World
from urdf_ik.errors import ArgumentError, UnsupportedArm
from urdf_ik.maps.workspaces.grid import grid_of, require_memory, require_room
from urdf_ik.maps.workspaces.orientations import NOTHING, sampled, samples
from urdf_ik.maps.workspaces.question import HELD, Question
from urdf_ik.maps.workspaces.store.block_jobs import fill
from urdf_ik.maps.workspaces.store.stored_map import StoredMap
from urdf_ik.maps.workspaces.workspace_map import WorkspaceMap
from urdf_ik.support import inputs

CHUNK = 2**14
"""Poses that are solved at a time: so few that their answers stay in the processor's cache."""
MAX_SAMPLES = 2**16 - 1
"""Greatest number of orientations at a position: it is kept in 16 bits."""

Progress = Callable[[int, int], object]


@overload
def workspace(
    arm: Arm,
    voxel: float = ...,
    orientations: int = ...,
    *,
    bounds: ArrayLike | None = ...,
    within_limits: bool = ...,
    collision_free: bool = ...,
    world: World | None = ...,
    manipulability: bool = ...,
    margin: bool = ...,
    clearance: bool = ...,
    redundancy: float | None = ...,
    output: str | os.PathLike[str] | None = ...,
    store: None = ...,
    client: None = ...,
    block: None = ...,
    threads: inputs.Threads = ...,
    chunk: int = ...,
    progress: Progress | None = ...,
) -> WorkspaceMap: ...


@overload
def workspace(
    arm: Arm,
    voxel: float = ...,
    orientations: int = ...,
    *,
    bounds: ArrayLike | None = ...,
    within_limits: bool = ...,
    collision_free: bool = ...,
    world: World | None = ...,
    manipulability: bool = ...,
    margin: bool = ...,
    clearance: bool = ...,
    redundancy: float | None = ...,
    output: None = ...,
    store: str | os.PathLike[str],
    client: Any = ...,
    block: int | None = ...,
    threads: inputs.Threads = ...,
    chunk: int = ...,
    progress: Progress | None = ...,
) -> StoredMap: ...


def workspace(
    arm: Arm,
    voxel: float = 0.1,
    orientations: int = 200,
    *,
    bounds: ArrayLike | None = None,
    within_limits: bool = True,
    collision_free: bool = False,
    world: World | None = None,
    manipulability: bool = False,
    margin: bool = False,
    clearance: bool = False,
    redundancy: float | None = None,
    output: str | os.PathLike[str] | None = None,
    store: str | os.PathLike[str] | None = None,
    client: Any = None,
    block: int | None = None,
    threads: inputs.Threads = 1,
    chunk: int = CHUNK,
    progress: Progress | None = None,
) -> WorkspaceMap | StoredMap:
    """Solve every voxel's centre in well-spread orientations, and count.

    The targets are those of ``arm.task``: poses; positions with directions, or positions alone, of arms with fewer
    joints; points or poses in the plane of a planar arm, in the plane's coordinates.

    With ``store`` the map is made block by block on the disk, and memory holds a few blocks. Called again after a kill
    it continues: it checks the finished blocks, repeats those whose bytes have changed, and makes the missing ones. The
    map has the same bytes after any kill and with any number of workers.

    Args:
        arm: the arm.
        voxel: m, edge of a voxel.
        orientations: number of them at each position.
        bounds: (2, 3) m, lower and upper corner; default: all that the links' lengths allow.
        within_limits: count the solutions that are inside the limits, too; they are the ones that then matter.
        collision_free: of these, count the ones free of collision, too; it takes far longer.
        world: obstacles that count for ``collision_free`` and ``clearance``; default: only the arm itself.
        manipulability: find the greatest one of each pose's solutions.
        margin: find the greatest limit margin of each pose's solutions, of their images nearest to zero turns.
        clearance: find the greatest clearance [m] of each pose's solutions; it takes far longer.
        redundancy: value of the parameter of an arm with seven joints; default: the arm's default.
        output: file to save the map to; that it fits is checked before any work.
        store: folder of a Zarr group to make the map in; see :class:`StoredMap`.
        client: a ``distributed.Client`` whose workers make the blocks of a store; default: this process does.
        block: poses of a block of a store, at most; default: about a second's or a few seconds' work.
        threads: number of threads that solve, or 'auto'.
        chunk: poses that are solved at a time; the map does not depend on it.
        progress: called with the number of solved poses, and of all.

    Raises:
        ArgumentError: an invalid number, or a map that does not fit in memory.
        UnsupportedArm: no solver takes this arm.
        UrdfError: the URDF has no collision shapes, and collisions are asked for.
        JobError: the map does not fit on the disk; the store is in use, is of another question, or cannot be written;
            or the scheduler or the workers cannot go on.

    Example:
        >>> import urdf_ik
        >>> found = workspace(urdf_ik.load("planar_2r"), voxel=0.05, orientations=4)
        >>> found.grid.shape, round(float(found.reach([1, 0, 0])[-1, 1]), 3)
        ((8, 8, 1), 0.2)
        >>> workspace(urdf_ik.load("planar_2r"), voxel=0.05, orientations=4, store="map.zarr").complete
        True
    """
    inputs.arm(arm)
    if not arm.structure.branches:
        raise UnsupportedArm(f"{arm.name}: no solver for this arm yet. {arm.structure}")
    orientations = inputs.whole(orientations, "orientations", low=1, high=MAX_SAMPLES)
    inputs.callback(progress, "progress")
    chunk, threads = inputs.whole(chunk, "chunk", low=1), inputs.threads(threads)
    if store is None and (client is not None or block is not None):
        raise ArgumentError("client and block are for maps in a store; give store='map.zarr', too")
    if store is not None and output is not None:
        raise ArgumentError("a store and an output are given; leave one of the two out")
    if world is not None and not (collision_free or clearance):
        raise ArgumentError("world= has no effect without collision_free=True or clearance=True")
    within_limits, collision_free, manipulability, margin, clearance = (
        inputs.flag(value, name)
        for value, name in (
            (within_limits, "within_limits"), (collision_free, "collision_free"), (manipulability, "manipulability"),
            (margin, "margin"), (clearance, "clearance"),
        )
    )  # fmt: skip
    wanted = {
        "solutions": True,
        "within": within_limits or collision_free or clearance,
        "free": collision_free,
        "manipulability": manipulability,
        "margin": margin,
        "clearance": clearance,
        "branch_poses": True,
    }
    count = 1 if sampled(arm) == NOTHING else orientations
    asked = Question(
        arm,
        grid_of(arm, voxel, bounds),
        samples(arm, count),
        tuple(name for name, on in wanted.items() if on),
        world,
        redundancy,
        threads,
        max(1, chunk // count),
    )
    if store is not None:
        return fill(asked, store, client, block, progress)
    return _in_memory(asked, None if output is None else inputs.path(output, "output"), progress)


def _in_memory(asked: Question, output: Path | None, progress: Progress | None) -> WorkspaceMap:
    grid, count = asked.grid, len(asked.samples)
    size = asked.size(grid.count)
    require_memory(grid, count, size + asked.scratch())
    if output is not None:
        require_room(grid, count, size, output)
    found: dict[str, NDArray[Any]] = {
        name: np.empty(asked.shape(name, (grid.count,)), HELD[name].kind) for name in asked.holds
    }
    solver = asked.solver()
    for start in range(0, grid.count, asked.at_once):
        part = slice(start, min(start + asked.at_once, grid.count))
        for name, values in solver.answers(grid.centres(part)).items():
            found[name][part] = values
        if progress is not None:
            progress(part.stop * count, grid.count * count)
    shaped: dict[str, Any] = {name: array.reshape(*grid.shape, -1) for name, array in found.items()}
    for array in (*shaped.values(), asked.samples):
        array.setflags(write=False)
    made = WorkspaceMap(asked.about(), grid, asked.samples, **shaped)
    if output is not None:
        made.save(output)
    return made
