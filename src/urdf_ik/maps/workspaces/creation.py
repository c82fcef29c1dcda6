"""workspace() and stored_workspace(): the map of an arm in memory, or in a store block by block."""

import math
import os
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from urdf_ik.arm import Arm
from urdf_ik.cell import World
from urdf_ik.errors import ArgumentError, UnsupportedArm
from urdf_ik.ik.solutions import limits as joint_limits
from urdf_ik.maps import cluster
from urdf_ik.maps.grid import AXES, Blocks, Grid, Part, checked_bounds
from urdf_ik.maps.store import VARIABLES, Coordinate, Pairs, Progress, about_arm, digest, fill
from urdf_ik.maps.workspaces.workspace_map import (
    WorkspaceMap,
    opened,
    require_memory,
    sample_coordinates,
)
from urdf_ik.model.poses import pose
from urdf_ik.support import inputs
from urdf_ik.support.tolerances import DEFAULT
from urdf_ik.typing import Array, Threads

Mask = NDArray[np.bool_]

CHUNK = 2**14
"""Poses that are solved at a time: so few that their answers stay in the processor's cache."""
MAX_SAMPLES = 2**16 - 1
"""Greatest number of orientations at a position: it is stored in 16 bits."""
BLOCK = 2**20
"""Poses of a block where each step of the solution is a quadratic: about a second's work."""
BLOCK_OF_GENERAL_ARMS = 2**16
"""The same for other arms, whose poses take tens of times as long."""
BLOCK_WITH_COLLISIONS = 2**14
"""The same where collisions are looked for."""
_MOST_VOXELS = 2**53  # beyond it not even their number can be written
_ROUNDING = 1e-9  # share of a voxel by which bounds may exceed a whole number of voxels


def workspace(
    arm: Arm,
    voxel: float = 0.1,
    orientations: int = 200,
    *,
    progress: Progress | None = None,
    **options: Any,
) -> WorkspaceMap:
    """Solve every voxel's centre in well-spread orientations, and count.

    The targets are those of ``arm.task``: poses; positions with directions, or positions alone, of arms with fewer
    joints; points or poses in the plane of a planar arm, in the plane's coordinates.

    Args:
        arm: the arm.
        voxel: m, edge of a voxel.
        orientations: number of them at each position.
        progress: called with the number of solved poses, and of all.
        **options: any of the following.

            - bounds: (2, 3) m, lower and upper corner; default: all that the links' lengths allow.
            - within_limits=True: count the solutions within the limits, too; they are the ones that then matter.
            - collision_free=False: of these, count the ones free of collision, too; it takes far longer.
            - world: obstacles that count for ``collision_free`` and ``clearance``; default: only the arm itself.
            - manipulability=False: find the greatest one of each pose's solutions.
            - margin=False: find the greatest limit margin of each pose's solutions, of their images nearest to zero.
            - clearance=False: find the greatest clearance [m] of each pose's solutions; it takes far longer.
            - redundancy: value of the parameter of an arm with seven joints; default: the arm's default.
            - threads=1: number of threads that solve, or 'auto'.
            - chunk: poses that are solved at a time; the map does not depend on it.

    Raises:
        ArgumentError: an invalid number, or a map that does not fit in memory.
        UnsupportedArm: no solver takes this arm.
        UrdfError: the URDF has no collision shapes, and collisions are asked for.

    Example:
        >>> import urdf_ik
        >>> found = workspace(urdf_ik.load("planar_2r"), voxel=0.05, orientations=4)
        >>> found.grid.shape, found.slice("z", 0.0).axes
        ((8, 8, 1), ('x', 'y'))
    """
    question = _question(arm, voxel, orientations, None, **options)
    grid, count = question.grid, len(question.samples)
    require_memory(grid, count, question.memory(grid.shape))
    arrays = question.computed(progress, grid.count * count)
    question.samples.setflags(write=False)
    return WorkspaceMap(question.described(), grid, question.samples, arrays)


def stored_workspace(
    arm: Arm,
    store: str | os.PathLike[str],
    voxel: float = 0.1,
    orientations: int = 200,
    *,
    client: Any = None,
    block: int | None = None,
    progress: Progress | None = None,
    **options: Any,
) -> WorkspaceMap:
    """The map of :func:`workspace` in a Zarr group, computed block by block; memory contains a few blocks.

    Called again after a kill it continues with the missing blocks. The arrays are the same after any kill and with any
    number of workers.

    Args:
        arm: the arm.
        store: folder of the Zarr group.
        voxel: m, edge of a voxel.
        orientations: number of them at each position.
        client: a ``distributed.Client`` whose workers compute the blocks; default: this process does.
        block: greatest number of poses of a block; default: about a second's or a few seconds' work.
        progress: called with the number of solved poses, and of all.
        **options: those of :func:`workspace`.

    Raises:
        ArgumentError: an invalid number, or a block that does not fit in memory.
        UnsupportedArm: no solver takes this arm.
        UrdfError: the URDF has no collision shapes, and collisions are asked for.
        MissingPackage: Zarr or Dask is not installed.
        JobError: the map does not fit on the disk; the store is one of another question, or cannot be written; or the
            scheduler or the workers cannot go on.

    Example:
        >>> import urdf_ik
        >>> stored_workspace(urdf_ik.load("planar_2r"), "map.zarr", voxel=0.05, orientations=4).complete
        True
    """
    question = _question(arm, voxel, orientations, block, **options)
    grid, count = question.grid, len(question.samples)
    require_memory(grid, count, question.memory(question.blocks.shape))
    fill(store, question, client, progress, grid.count * count)
    return opened(store)


def _question(
    arm: Arm,
    voxel: float,
    orientations: int,
    block: int | None,
    *,
    bounds: ArrayLike | None = None,
    within_limits: bool = True,
    collision_free: bool = False,
    world: World | None = None,
    manipulability: bool = False,
    margin: bool = False,
    clearance: bool = False,
    redundancy: float | None = None,
    threads: Threads = 1,
    chunk: int = CHUNK,
) -> "Question":
    if not arm.structure.branches:
        raise UnsupportedArm(f"{arm.name}: no solver for this arm yet. {arm.structure}")
    if world is not None and not (collision_free or clearance):
        raise ArgumentError("world= has no effect without collision_free=True or clearance=True")
    orientations = inputs.whole(orientations, "orientations", low=1, high=MAX_SAMPLES)
    count = 1 if sampled(arm) == NOTHING else orientations
    wanted = {
        "solutions": True,
        "within": within_limits or collision_free or clearance,
        "free": collision_free,
        "manipulability": manipulability,
        "margin": margin,
        "clearance": clearance,
        "branch_poses": True,
    }
    usual = BLOCK if arm.structure.by_quadratics else BLOCK_OF_GENERAL_ARMS
    if collision_free or clearance:
        usual = BLOCK_WITH_COLLISIONS
    most = usual if block is None else inputs.whole(block, "block", low=1)
    return Question(
        arm=arm,
        world=world,
        grid=grid_of(arm, voxel, bounds),
        names=tuple(name for name, on in wanted.items() if on),
        most=max(1, most // count),
        threads=inputs.threads(threads),
        pairs=arm.cell.collisions.checked_pairs if collision_free or clearance else None,
        lengths={"orientation": count, "branch": len(arm.for_task(arm.task).structure.branches)},
        samples=samples(arm, count),
        redundancy=redundancy,
        at_once=max(1, inputs.whole(chunk, "chunk", low=1) // count),
    )


@dataclass(frozen=True, eq=False)
class Question:
    """All that the arrays of a workspace map depend on; pickled for workers.

    Attributes:
        arm: the arm.
        world: obstacles, or None.
        grid: the voxels.
        names: names of the requested arrays, some of ``VARIABLES``.
        most: greatest number of voxels of a block.
        threads: number of threads that solve.
        pairs: pairs of links that are checked for collision; None without a collision check.
        lengths: lengths of the dimensions after x, y and z, by name.
        samples: (S, ...) orientations, directions or angles at each position.
        redundancy: value of the redundancy parameter, or None.
        at_once: positions that are solved at a time.
    """

    arm: Arm
    world: World | None
    grid: Grid
    names: tuple[str, ...]
    most: int
    threads: int
    pairs: Pairs | None
    lengths: Mapping[str, int]
    samples: Array = field(repr=False)
    redundancy: float | None
    at_once: int

    @property
    def blocks(self) -> Blocks:
        """The division of the grid."""
        return Blocks.cut(self.grid.shape, self.most)

    @property
    def coordinates(self) -> dict[str, Coordinate]:
        """The voxels' centres and the samples, with what they are."""
        words = {"units": "m", "long_name": "voxels' centres"}
        centres = {name: ((name,), self.grid.coordinates(k), words) for k, name in enumerate(AXES)}
        return {**centres, **sample_coordinates(self.described(), self.samples)}

    def shape(self, name: str, positions: tuple[int, ...]) -> tuple[int, ...]:
        """Shape of an array at positions of some shape."""
        return (*positions, self.lengths[VARIABLES[name].last])

    def memory(self, box: tuple[int, ...]) -> int:
        """Memory that a box of voxels takes: its arrays, and what solving needs in addition [bytes]."""
        arrays = (math.prod(self.shape(name, box)) * np.dtype(VARIABLES[name].kind).itemsize for name in self.names)
        solved = 128 + 20 * self.lengths["branch"] * (self.arm.dof + 1) * 8
        return sum(arrays) + self.at_once * len(self.samples) * solved

    def described(self) -> dict[str, Any]:
        """The question in JSON, for a store."""
        arm, free = self.arm, self.arm.redundancy
        return {
            **about_arm(arm, self.pairs, self.world),
            "instructions": cluster.versions()["instructions"],
            "grid": self.grid.described(),
            "holds": list(self.names),
            "joints": list(arm.joint_names),
            "limits": [[value if np.isfinite(value) else None for value in pair] for pair in arm.limits.tolist()],
            "task": arm.task,
            "sampled": sampled(arm),
            "branches": list(arm.for_task(arm.task).structure.branches),
            # The last filter: its solutions count for branches, manipulability, margin and clearance.
            "counted": next(name for name in ("free", "within", "solutions") if name in self.names),
            "redundancy": None if free is None else float(free.default if self.redundancy is None else self.redundancy),
            "drawn": {"count": len(self.samples), "sha256": digest(self.samples.tobytes())},
        }

    def computed(self, progress: Progress | None, units: int) -> dict[str, NDArray[Any]]:
        """All arrays in memory, block by block, read-only; ``progress``: finished units, and their number."""
        arrays: dict[str, NDArray[Any]] = {
            name: np.empty(self.shape(name, self.grid.shape), VARIABLES[name].kind) for name in self.names
        }
        for done, part in enumerate(self.blocks.parts(), 1):
            for name, values in self.solved(part).items():
                arrays[name][part] = values
            if progress is not None:
                progress(done * units // self.blocks.count, units)
        for array in arrays.values():
            array.setflags(write=False)
        return arrays

    def solved(self, part: Part) -> dict[str, NDArray[Any]]:
        """The arrays of a box of voxels."""
        positions = self.grid.centres_in(part)
        chunks = [
            self._answers(positions[start : start + self.at_once]) for start in range(0, len(positions), self.at_once)
        ]
        shape = tuple(side.stop - side.start for side in part)
        return {name: np.concatenate([chunk[name] for chunk in chunks]).reshape(*shape, -1) for name in self.names}

    def _answers(self, positions: Array) -> dict[str, NDArray[Any]]:
        """Every array at positions (k, 3) m: (k, S), or (k, B) for counts by branch."""
        arm, count = self.arm, len(self.samples)
        solved = arm.ik(
            targets(arm.task, self.samples, positions), task=arm.task, threads=self.threads, redundancy=self.redundancy
        )
        counting = Counting(arm, solved.q, solved.valid)
        columns: dict[str, NDArray[Any]] = {"solutions": counting.counts()}
        if "within" in self.names:
            counting.keep_within_limits()
            columns["within"] = counting.counts()
        if "free" in self.names:
            counting.keep_free(self.world)
            columns["free"] = counting.counts()
        measures: dict[str, Callable[[], Array]] = {
            "manipulability": counting.manipulability,
            "margin": counting.margin,
            "clearance": lambda: counting.clearance(self.world),
        }
        columns |= {name: counting.greatest(measure()) for name, measure in measures.items() if name in self.names}
        arrays = {name: values.reshape(-1, count).astype(VARIABLES[name].kind) for name, values in columns.items()}
        return {**arrays, "branch_poses": sum_over_samples(counting.kept, count)}


def grid_of(arm: Arm, voxel: float, bounds: ArrayLike | None) -> Grid:
    """The voxels over all that an arm could reach without limits, or over ``bounds`` (2, 3) m.

    Raises:
        ArgumentError: the edge or the bounds are invalid.
    """
    voxel = inputs.number(voxel, "voxel", above=0.0, unit="m")
    lower, upper = _reach_box(arm) if bounds is None else checked_bounds(bounds)
    if arm.task.startswith("planar"):
        lower[2], upper[2] = -0.5 * voxel, 0.5 * voxel
    if not np.isfinite(upper - lower).all():
        raise ArgumentError(f"{arm.name}: a joint slides without a limit; give bounds [[x, y, z], [x, y, z]] m")
    with np.errstate(over="ignore"):
        steps = (upper - lower) / voxel
        if not float(np.prod(np.maximum(steps, 1.0))) <= _MOST_VOXELS:
            raise ArgumentError(
                f"voxels of {voxel:g} m over {' x '.join(f'{length:g}' for length in upper - lower)} m are too many; "
                "take larger voxels, or narrower bounds"
            )
    counts = [max(1, math.ceil(float(step) - _ROUNDING)) for step in steps]
    # Whole voxels, centred on the requested middle.
    lower = 0.5 * (lower + upper) - 0.5 * voxel * np.array(counts, dtype=np.float64)
    return Grid(lower, float(voxel), tuple(counts))


def _reach_box(arm: Arm) -> tuple[Array, Array]:
    """A box (3,), (3,) m around all positions of the tip, from the lengths of the links and slides."""
    chain = arm.chain
    middle, first = chain.P[0].copy(), chain.P[1].copy()
    if not chain.prismatic[0]:
        # Any point of the first axis will do; the one across from the second joint is nearest.
        middle += (first @ chain.H[0]) * chain.H[0]
        first -= (first @ chain.H[0]) * chain.H[0]
    reach = float(np.linalg.norm(first) + np.linalg.norm(chain.P[2:], axis=1).sum())
    reach += float(np.abs(chain.limits[chain.prismatic]).max(axis=1, initial=0.0).sum())
    plane = arm.solver.control.plane
    if plane is not None:
        middle = np.append(plane.axes @ middle, 0.0)
    return middle - reach, middle + reach


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
    """(n, 3, 3) rotation matrices on super-Fibonacci spirals, evenly spread over all orientations.

    Alexa, "Super-Fibonacci Spirals: Fast, Low-Discrepancy Sampling of SO(3)", CVPR 2022, algorithm 1.
    """
    s = np.arange(n) + 0.5
    inner, outer = np.sqrt(s / n), np.sqrt(1.0 - s / n)
    alpha, beta = 2.0 * np.pi * s / _PHI, 2.0 * np.pi * s / _PSI
    quat = np.stack([inner * np.sin(alpha), inner * np.cos(alpha), outer * np.sin(beta), outer * np.cos(beta)], axis=-1)
    return pose(np.zeros(3), quat_xyzw=quat)[:, :3, :3]


def directions(n: int) -> Array:
    """(n, 3) unit vectors on a Fibonacci lattice, evenly spread over the sphere.

    Swinbank and Purser, "Fibonacci grids: A novel approach to global modelling", Quarterly Journal of the Royal
    Meteorological Society 132, 2006.
    """
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


_WORD = 8  # as many branches, a byte each, are one machine word


def sum_over_samples(kept: Mask, count: int) -> NDArray[np.uint16]:
    """(k, B) number of poses with a solution, of (k * count, B)."""
    columns = kept.shape[1]
    if columns != _WORD:
        return np.asarray(kept.reshape(-1, count, columns).sum(axis=1, dtype=np.uint16))
    # Eight branches at a time: their bytes are added as one word, and no more of them than a byte can count.
    words = kept.view(np.uint64).reshape(-1, count)
    sums = np.add.reduceat(words, np.arange(0, count, 255), axis=1).view(np.uint8)
    return np.asarray(sums.reshape(len(words), -1, columns).sum(axis=1, dtype=np.uint16))


class Counting:
    """The solutions of a chunk, fewer with every filter; joint vectors are looked at where there are any."""

    def __init__(self, arm: Arm, q: Array, valid: Mask) -> None:
        self.kept = valid
        self._arm, self._all = arm, q
        self._q: Array | None = None
        self._turning = ~arm.chain.prismatic

    @property
    def vectors(self) -> Array:
        """(k, n) the remaining solutions, pose by pose."""
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
        inside = joint_limits.has_image(self._all, self.kept, self._arm.limits, self._turning)
        self.kept, self._q = inside, None

    def keep_free(self, world: World | None, margin: float = 0.0) -> None:
        """Drop solutions in which links come within ``margin`` [m] of each other, or of the obstacles of a world."""
        model = self._arm.cell.collisions.in_world(world)
        kept = self.kept.copy()
        kept[self.kept] = ~np.asarray(model.in_collision(self.vectors, margin), dtype=np.bool_)
        self.kept, self._q = kept, None

    def clearance(self, world: World | None) -> Array:
        """(k,) m, of the remaining solutions: see ``arm.clearance``."""
        return np.asarray(self._arm.clearance(self.vectors, world), dtype=np.float64)

    def manipulability(self) -> Array:
        """(k,) of the remaining solutions; for positions that of the tip's translation."""
        return self._arm.manipulability(self.vectors, self._arm.solver.control.part)

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
