"""Where an arm's tip can be: the exact region of planar arms, a map of the solutions of any other."""

from __future__ import annotations

import hashlib
import os
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np

from urdf_ik import inputs
from urdf_ik.angles import TURN
from urdf_ik.errors import UnsupportedArm, WorkspaceError
from urdf_ik.solutions import limits as joint_limits
from urdf_ik.workspace.grid import grid_of, require_room
from urdf_ik.workspace.maps import About, WorkspaceMap
from urdf_ik.workspace.sampling import NOTHING, Targets, sampled, samples

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

    from urdf_ik.arm import Arm

    Array = NDArray[np.float64]
    Mask = NDArray[np.bool_]

CHUNK = 4096
"""Poses that are solved at a time: their answers stay in the processor's cache."""
MAX_SAMPLES = 2**16 - 1
"""Orientations at a position: their number is kept in 16 bits."""
_WORD = 8  # as many branches, a byte each, are one machine word


def compute(
    arm: Arm,
    voxel: float = 0.1,
    orientations: int = 200,
    *,
    bounds: ArrayLike | None = None,
    within_limits: bool = True,
    collision_free: bool = False,
    manipulability: bool = False,
    margin: bool = False,
    redundancy: float | None = None,
    output: str | os.PathLike[str] | None = None,
    threads: int = 1,
    chunk: int = CHUNK,
    progress: Callable[[int, int], object] | None = None,
) -> WorkspaceMap:
    """Solve every voxel's centre in well-spread orientations, and count.

    What the arm controls, ``arm.task``, is what is asked for: poses; positions with directions, or positions alone,
    of arms with fewer joints; points or poses in its plane of a planar arm, in the plane's coordinates.

    Args:
        arm: the arm.
        voxel: m, edge of a voxel.
        orientations: number of them at each position.
        bounds: (2, 3) m, lower and upper corner; default: all that the links' lengths allow.
        within_limits: count the solutions that are inside the limits, too; they are the ones that then matter.
        collision_free: of these, count the ones free of self-collision, too; it takes far longer.
        manipulability: find the greatest one of each pose's solutions.
        margin: find the greatest limit margin of each pose's solutions, of their images nearest to zero turns.
        redundancy: value of the parameter of an arm with seven joints; default: the arm's default.
        output: file to save the map to; that it fits is checked before any work.
        threads: number of threads that solve.
        chunk: poses that are solved at a time; the map does not depend on it.
        progress: called with the number of poses behind us, and of all.

    Raises:
        WorkspaceError: a number that makes no sense, or a map that does not fit in memory or on the disk.
        UnsupportedArm: no solver takes this arm.
        UrdfError: the URDF has no collision shapes, and ``collision_free`` asks for them.

    Example:
        >>> import urdf_ik
        >>> found = compute(urdf_ik.load("planar_2r"), voxel=0.05, orientations=4)
        >>> found.grid.shape, round(float(found.reach([1, 0, 0])[-1, 1]), 3)
        ((8, 8, 1), 0.2)
    """
    inputs.arm(arm, error=WorkspaceError)
    if not arm.structure.branches:
        raise UnsupportedArm(f"{arm.name}: no solver for this arm yet. {arm.structure}")
    orientations = inputs.whole(orientations, "orientations", WorkspaceError, low=1, high=MAX_SAMPLES)
    chunk, threads = (
        inputs.whole(value, name, WorkspaceError, low=1) for value, name in ((chunk, "chunk"), (threads, "threads"))
    )
    grid = grid_of(arm, voxel, bounds)
    path = None if output is None else inputs.path(output, "output", WorkspaceError)
    branches = arm.for_task(arm.task).structure.branches
    count = 1 if sampled(arm) == NOTHING else orientations
    in_limits = within_limits or collision_free
    poses, columns = grid.count * count, len(branches)
    each = 1 + in_limits + collision_free + 4 * (manipulability + margin)
    scratch = max(chunk, count) * (128 + 20 * columns * (arm.dof + 1) * 8)
    require_room(grid, count, poses * each + grid.count * columns * 2, scratch, path)
    chosen = samples(arm, count)
    counts = {"solutions": np.zeros((grid.count, count), np.uint8)}
    counts |= {name: np.zeros_like(counts["solutions"]) for name, on in _filters(in_limits, collision_free) if on}
    best = {
        name: np.full((grid.count, count), np.nan, np.float32)
        for name, on in (("manipulability", manipulability), ("margin", margin))
        if on
    }
    branch_poses = np.zeros((grid.count, columns), np.uint16)
    step = max(1, chunk // count)
    targets = Targets(arm.task, chosen, step)
    held = {} if redundancy is None else {"redundancy": redundancy}
    for start in range(0, grid.count, step):
        part = slice(start, min(start + step, grid.count))
        found = arm.ik(targets.at(grid.centres(part)), task=arm.task, threads=threads, **held)
        counting = _Counting(arm, found.q, found.valid)
        counts["solutions"][part] = counting.counts().reshape(-1, count)
        if in_limits:
            counting.keep_within_limits()
            counts["within"][part] = counting.counts().reshape(-1, count)
        if collision_free:
            counting.keep_free()
            counts["free"][part] = counting.counts().reshape(-1, count)
        for name, values in best.items():
            values[part] = counting.greatest(getattr(counting, name)()).reshape(-1, count)
        branch_poses[part] = _sum_over_samples(counting.kept, count)
        if progress is not None:
            progress(part.stop * count, poses)
    arrays: dict[str, NDArray[Any]] = {**counts, **best, "branch_poses": branch_poses}
    shaped: dict[str, Any] = {name: array.reshape(*grid.shape, -1) for name, array in arrays.items()}
    for array in (*shaped.values(), chosen):
        array.setflags(write=False)
    found_map = WorkspaceMap(_about(arm, branches, list(counts)[-1], redundancy), grid, chosen, **shaped)
    if path is not None:
        found_map.save(path)
    return found_map


def _filters(in_limits: bool, collision_free: bool) -> tuple[tuple[str, bool], ...]:
    return (("within", in_limits), ("free", collision_free))


def _sum_over_samples(kept: Mask, count: int) -> NDArray[np.uint16]:
    """(k, B) number of poses with a solution, of (k * count, B)."""
    columns = kept.shape[1]
    if columns != _WORD:
        return np.asarray(kept.reshape(-1, count, columns).sum(axis=1, dtype=np.uint16))
    # Eight branches at a time: their bytes are added as one word, and no more of them than a byte can count.
    words = kept.view(np.uint64).reshape(-1, count)
    sums = np.add.reduceat(words, np.arange(0, count, 255), axis=1).view(np.uint8)
    return np.asarray(sums.reshape(len(words), -1, columns).sum(axis=1, dtype=np.uint16))


def _about(arm: Arm, branches: tuple[str, ...], counted: str, redundancy: float | None) -> About:
    from urdf_ik import __version__

    free = arm.redundancy
    return About(
        robot=arm.name,
        urdf_sha256=hashlib.sha256(arm.model.xml).hexdigest(),
        base=arm.base,
        tip=arm.tip,
        joints=arm.joint_names,
        limits=tuple(
            (None if np.isinf(lower) else lower, None if np.isinf(upper) else upper)
            for lower, upper in arm.limits.tolist()
        ),
        locked=arm.locked,
        task=arm.task,
        sampled=sampled(arm),
        branches=branches,
        counted=counted,
        redundancy=None if free is None else float(free.default if redundancy is None else redundancy),
        made_by=__version__,
    )


class _Counting:
    """The solutions of a chunk, fewer with every filter; joint vectors are looked at where there are any."""

    def __init__(self, arm: Arm, q: Array, valid: Mask) -> None:
        self.kept = valid
        self._arm, self._all = arm, q
        self._q: Array | None = None
        turning = ~arm.chain.prismatic
        lower, upper = arm.limits.T
        # A joint that turns all the way round has an image inside whatever its value.
        self._limited = np.flatnonzero(~(turning & (upper - lower >= TURN)))
        self._turning = turning

    @property
    def vectors(self) -> Array:
        """(k, n) the solutions that are left, pose by pose."""
        if self._q is None:
            self._q = self._all[self.kept]
        return self._q

    def counts(self) -> NDArray[Any]:
        """(m,) number of solutions left of each pose."""
        if self.kept.shape[1] == _WORD:
            return np.asarray(np.bitwise_count(self.kept.view(np.uint64))[:, 0])
        return np.asarray(np.sum(self.kept, axis=-1, dtype=np.intp))

    def keep_within_limits(self) -> None:
        """Drop solutions without an image inside the limits."""
        some = self._limited
        q, (lower, upper) = self.vectors[:, some], self._arm.limits[some].T
        # Most are inside as they are; their images are looked for only where they are not.
        inside = ((q >= lower) & (q <= upper)).all(axis=-1)
        out = np.flatnonzero(~inside)
        first, last = joint_limits.image_range(q[out], self._arm.limits[some], self._turning[some])
        inside[out] = (first <= last).all(axis=-1)
        self._keep(inside)

    def keep_free(self) -> None:
        """Drop solutions in which links collide."""
        self._keep(~np.asarray(self._arm.collision_model.in_collision(self.vectors), dtype=np.bool_))

    def manipulability(self) -> Array:
        """(k,) of the solutions that are left; for positions that of the tip's translation."""
        return self._arm.manipulability(self.vectors, self._arm.control.part)

    def margin(self) -> Array:
        """(k,) least distance to a limit as a share of half the joint's range; negative outside, 1 without limits."""
        image = joint_limits.nearest_image(self.vectors, self._arm.limits, self._turning)[0]
        return joint_limits.margin(np.where(np.isnan(image), self.vectors, image), self._arm.limits)

    def greatest(self, values: Array) -> Array:
        """(m,) greatest of the values (k,) of each pose's solutions, NaN for a pose without one."""
        spread = np.full(self.kept.shape, -np.inf)
        spread[self.kept] = values
        best = spread.max(axis=-1)
        return np.where(np.isneginf(best), np.nan, best)

    def _keep(self, good: Mask) -> None:
        kept = self.kept.copy()
        kept[self.kept] = good
        self.kept, self._q = kept, self.vectors[good]
