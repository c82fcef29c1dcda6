"""placement(): scores base positions in memory, or in a store block by block."""

from __future__ import annotations

import math
import os
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from urdf_ik.arm import Arm
from urdf_ik.cell import World
from urdf_ik.errors import ArgumentError, UnsupportedArm
from urdf_ik.maps.engine import Folder, free_space, run, zarr_writer
from urdf_ik.maps.engine.store_folder import checked_path, finished
from urdf_ik.maps.placements.placement_map import FORMAT, VERSION, PlacementMap, opened
from urdf_ik.maps.placements.scores import AXES, SCORES, Asked, Scoring, headings
from urdf_ik.maps.workspaces import Grid
from urdf_ik.model.poses import as_pose_array
from urdf_ik.support import inputs
from urdf_ik.support.text import quoted
from urdf_ik.support.tolerances import DEFAULT, LARGEST
from urdf_ik.typing import Array

MOST_TURNS = 3600
"""Headings at each position."""
MOST_POSITIONS = 10**9
"""Of the base, at one heading."""
_ROUNDING = 1e-9  # share of a step by which the bounds may be off a whole number of steps


def placement(
    arm: Arm,
    T: Any,
    *,
    bounds: ArrayLike,
    step: float,
    turns: int = 1,
    mount: ArrayLike | None = None,
    path: bool = False,
    world: World | None = None,
    margin: float = 0.0,
    collisions: bool | None = None,
    store: str | os.PathLike[str] | None = None,
    client: Any = None,
    threads: inputs.Threads = 1,
    progress: Callable[[int, int], object] | None = None,
) -> PlacementMap:
    """Score every base position on a grid by how the arm reaches targets from there: inverse reachability.

    A target counts as reached where a solution is within the limits and, where collisions are looked for, free of them.
    An arm with a redundancy parameter is asked at sixteen values of it; for a path, ``arm.follow`` searches
    them all, and is asked from every position that reaches all waypoints.

    Args:
        arm: the arm.
        T: (m, 4, 4) m, targets in the cell; the waypoints of a path in their order.
        bounds: (2, 3) m, lower and upper corner of the positions of the base link in the cell; equal numbers for an
            axis stand for one position on it.
        step: m from one position to the next.
        turns: number of headings at each position, evenly spaced turns about the cell's z axis from zero on.
        mount: (3, 3) rotation of the base link in the cell at heading zero, such as that of an arm that hangs from the
            ceiling; default: none.
        path: whether the targets are a path.
        world: obstacles, placed in the cell.
        margin: m that bodies must stay apart.
        collisions: whether collisions are looked for; default: where there is a world.
        store: folder of a Zarr group to make the map in; it is gone on with after a kill. Default: in memory.
        client: a ``distributed.Client`` whose workers fill the store; default: this process does.
        threads: number of threads that solve, or 'auto'.
        progress: called with the number of positions behind us, and of all.

    Raises:
        ArgumentError: bounds, a step, a number of turns or a mount that makes no sense; or a map that does not fit in
            memory.
        PoseError: a target is no pose.
        UnsupportedArm: no solver takes this arm.
        UrdfError: the URDF has no collision shapes, and collisions are looked for.
        JobError: the store is in use, is of another question, does not fit on the disk or cannot be written.
        JobError: a scheduler or workers that cannot do the work.

    Example:
        >>> import urdf_ik
        >>> arm = urdf_ik.load("zyyzyz_6r")
        >>> line = urdf_ik.line(urdf_ik.pose([1.0, -0.2, 1.0]), urdf_ik.pose([1.0, 0.2, 1.0]), 20)
        >>> found = placement(arm, line, bounds=[[-0.5, 0, 0], [0.5, 0, 0]], step=0.5, path=True)
        >>> found.followed[:, 0, 0, 0].tolist()
        [1, 0, 0]
    """
    inputs.arm(arm)
    if not arm.structure.branches:
        raise UnsupportedArm(f"{arm.name}: no solver for this arm yet. {arm.structure}")
    targets = as_pose_array(T).reshape(-1, 4, 4)
    if not len(targets):
        raise ArgumentError("no targets given; one is the least")
    turns, threads = inputs.whole(turns, "turns", low=1, high=MOST_TURNS), inputs.threads(threads)
    margin, path = inputs.number(margin, "margin", low=0.0, unit="m"), inputs.flag(path, "path")
    collisions = None if collisions is None else inputs.flag(collisions, "collisions")
    if world is not None:
        inputs.kind(world, "snapshot", "world", "a urdf_ik.World")
    inputs.callback(progress, "progress")
    if store is None and client is not None:
        raise ArgumentError("client is for maps in a store; give store='bases.zarr', too")
    if world is not None and collisions is False:
        raise ArgumentError("a world is given with collisions=False; leave one of the two out")
    asked = Asked(
        arm, np.ascontiguousarray(targets), _positions(bounds, step), headings(turns), _mount(mount), path, world,
        float(margin), world is not None if collisions is None else collisions, threads,
    )  # fmt: skip
    job, blocks = Scoring(asked), asked.blocks
    each = sum(np.dtype(SCORES[name].kind).itemsize for name in asked.holds) * turns
    what = f"{asked.grid.count:.4g} base positions x {turns} headings"
    hint = "take a larger step, fewer turns or narrower bounds"
    free_space.require_memory(each * asked.grid.count, what, hint)  # the map of a store is read when it is made

    def tick(done: int, total: int) -> None:
        if progress is not None:
            progress(done * asked.grid.count // total, asked.grid.count)

    if store is None:
        shape = (*asked.grid.shape, turns)
        arrays: dict[str, Any] = {name: np.empty(shape, SCORES[name].kind) for name in asked.holds}
        for block, part in enumerate(blocks.parts()):
            for name, values in job.arrays(block).items():
                arrays[name][part] = values
            tick(block + 1, blocks.count)
        return PlacementMap(asked.described(), asked.grid, asked.headings, asked.mount, asked.targets, **arrays)
    path_of_store = checked_path(store)
    left = blocks.count - len(finished(path_of_store))
    free_space.require_disk(path_of_store, each * math.prod(blocks.shape) * left, what, hint)
    question = {**asked.described(), "format": FORMAT, "version": VERSION, "block": list(blocks.shape)}
    about = {"format": FORMAT, "version": VERSION, "complete": False, **asked.described()}
    files = zarr_writer.group_files(asked.plans, _coordinates(asked), about)
    complete = zarr_writer.with_attributes(files, {"complete": True})
    with Folder(path_of_store, question, blocks.count, files, complete) as kept:
        run(job, kept, client=client, progress=tick)
        kept.finish()
    return opened(path_of_store)


def _coordinates(asked: Asked) -> tuple[zarr_writer.Coordinate, ...]:
    metres = {"units": "m"}
    return (
        *(zarr_writer.Coordinate(name, (name,), asked.grid.coordinates(k), metres) for k, name in enumerate(AXES[:3])),
        zarr_writer.Coordinate("heading", ("heading",), asked.headings, {"units": "rad"}),
        zarr_writer.Coordinate("targets", ("target", "row", "column"), asked.targets, metres),
    )


def _positions(bounds: ArrayLike, step: float) -> Grid:
    """Positions from the lower corner to the upper one, as voxels around them."""
    box = inputs.real(bounds, "bounds", "[[x, y, z], [x, y, z]] m")
    if box.shape != (2, 3) or inputs.first_bad(box) is not None or (box[0] > box[1]).any():
        needed = "[[x, y, z], [x, y, z]] m are needed, lower ones first"
        raise ArgumentError(f"bounds {quoted(box.tolist())} given; {needed}")
    step = inputs.number(step, "step", low=1.0 / LARGEST, unit="m")
    counts = np.floor((box[1] - box[0]) / step + _ROUNDING) + 1.0
    if not counts.prod() <= MOST_POSITIONS:
        raise ArgumentError(
            f"bounds {box.tolist()} with a step of {step:g} m are {counts.prod():.3g} positions, and at most "
            f"{MOST_POSITIONS:,} are looked at; take a larger step"
        )
    x, y, z = (int(count) for count in counts)
    return Grid(np.asarray(box[0] - 0.5 * step), float(step), (x, y, z))


def _mount(mount: ArrayLike | None) -> Array:
    if mount is None:
        return np.eye(3)
    R = inputs.real(mount, "mount", "a rotation matrix (3, 3)").copy()
    if R.shape != (3, 3) or np.abs(R @ R.T - np.eye(3)).max(initial=0.0) > DEFAULT.rotation or np.linalg.det(R) < 0.0:
        raise ArgumentError(
            f"mount={R.tolist()} given; a rotation matrix (3, 3) is needed, such as urdf_ik.pose(...)[:3, :3]"
        )
    return R
