"""WorkspaceMap: the solution counts of the poses of a grid, in memory or in a store, with slices and sums."""

import json
import os
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from urdf_ik.arm import Arm
from urdf_ik.errors import ArgumentError
from urdf_ik.maps import cluster, store
from urdf_ik.maps.grid import AXES, Blocks, Grid, Part
from urdf_ik.maps.store import STORE_KEYS, VARIABLES, BlockStore, Coordinate, digest
from urdf_ik.support import files
from urdf_ik.typing import Array

VALUES = {
    "reach": "share of the orientations that are reached",
    "solutions": "mean number of solutions",
    "manipulability": "greatest manipulability",
    "margin": "greatest limit margin",
    "clearance": "greatest clearance [m]",
}
"""Values of a voxel, by name, with their descriptions."""
FORMAT, VERSION = "urdf-ik workspace map", 2
HINT = "take larger voxels, fewer orientations or narrower bounds"


class MapSlice(NamedTuple):
    """Values in one layer of voxels.

    Attributes:
        values: (a, b), NaN where nothing is reached.
        axes: names of the two axes.
        extent: lower and upper edge along the first axis, then along the second one [m].
        across: name of the axis that the layer lies across.
        at: m, the layer's middle on it.
        what: what the values are.
    """

    values: Array
    axes: tuple[str, str]
    extent: tuple[float, float, float, float]
    across: str
    at: float
    what: str


@dataclass(frozen=True, eq=False)
class WorkspaceMap:
    """Positions x orientations of an arm's tip, with their numbers of solutions.

    A map in a store is read block by block, and only as far as a question needs it. Any Zarr reader reads the store,
    such as ``xarray.open_zarr(path)``.

    Attributes:
        about: the arm and the question as in JSON, such as 'robot', 'base', 'tip', 'task', 'branches' and 'counted':
            which of 'solutions', 'within' and 'free' count for reach, branches, manipulability and margin.
        grid: the voxels (X, Y, Z).
        samples: (S, ...) orientations at each position: rotation matrices, directions or angles.
        arrays: the arrays by name; None for a map in a store.
        store: the store; None for a map in memory.
        solutions: (X, Y, Z, S) number of solutions; like each name of ``VARIABLES``, None where it was not computed.
        within: of these, within the limits.
        free: of these, free of collision.
        manipulability: (X, Y, Z, S) greatest one of the solutions that count, NaN where nothing is reached.
        margin: the same of the limit margin: the least distance of any joint to a limit as a share of half its range.
        clearance: the same of the clearance [m].
        branch_poses: (X, Y, Z, B) number of orientations in which a branch has a solution that counts.

    Example:
        >>> import urdf_ik
        >>> found = urdf_ik.maps.workspace(urdf_ik.load("planar_2r"), voxel=0.05, orientations=4)
        >>> found
        <WorkspaceMap of planar_2r: 8 x 8 x 1 voxels of 0.05 m x 1, 24 poses reached>
        >>> found.about["robot"], found.solutions.shape
        ('planar_2r', (8, 8, 1, 1))
    """

    about: dict[str, Any]
    grid: Grid
    samples: Array = field(repr=False)
    arrays: Mapping[str, NDArray[Any]] | None = field(repr=False, default=None)
    store: BlockStore | None = field(repr=False, default=None)

    def __repr__(self) -> str:
        shape = " x ".join(map(str, self.grid.shape))
        state = f"in {self.path}" if self.complete else f"in {self.path}, not complete"
        if self.store is None:
            state = f"{int((self.counts > 0).sum())} poses reached"
        voxels = f"{shape} voxels of {self.grid.voxel:g} m x {len(self.samples)}"
        return f"<WorkspaceMap of {self.about['robot']}: {voxels}, {state}>"

    @property
    def path(self) -> Path | None:
        """The store's folder; None for a map in memory."""
        return None if self.store is None else self.store.path

    @property
    def complete(self) -> bool:
        """Whether all blocks are there; if not, ``stored_workspace`` with the same store continues it."""
        return self.store is None or not self.store.pending()

    @property
    def blocks(self) -> Blocks:
        """The division of the grid; one block for a map in memory."""
        return Blocks(self.grid.shape, self.grid.shape) if self.store is None else self.store.blocks

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the arrays that the map contains."""
        return tuple(self.arrays or ()) if self.store is None else self.store.names

    def array(self, name: str, part: Part | None = None) -> NDArray[Any]:
        """One array (X, Y, Z, S) or (X, Y, Z, B), or a box of it.

        Raises:
            ArgumentError: the map does not contain this, or it does not fit in memory.
            JobError: a block is missing or damaged.
        """
        if name not in self.names:
            raise ArgumentError(f"the map contains no {name!r}; it contains {', '.join(self.names)}")
        if self.store is None:
            whole = (self.arrays or {})[name]
            return whole if part is None else whole[part]
        part = self.grid.whole if part is None else part
        count = self.grid.cut(part).count * len(self.samples)
        require_memory(self.grid, len(self.samples), count * np.dtype(VARIABLES[name].kind).itemsize)
        return self.store.array(name, part)

    def __getattr__(self, name: str) -> Any:
        if name not in VARIABLES:
            raise AttributeError(f"{type(self).__name__} has no attribute {name!r}")
        return self.array(name) if name in self.names else None

    @property
    def counts(self) -> NDArray[np.uint8]:
        """(X, Y, Z, S) number of the solutions that count, see ``about['counted']``."""
        return self.array(self.about["counted"])

    @property
    def reached(self) -> NDArray[np.bool_]:
        """(X, Y, Z) whether a voxel's centre is reached in any orientation."""
        return ~np.isnan(self.values())

    @property
    def cell(self) -> float:
        """Volume [m^3] of a voxel; area [m^2] for a planar arm."""
        return float(self.grid.voxel ** (2 if self.about["task"].startswith("planar") else 3))

    def read(self, bounds: ArrayLike | None = None) -> "WorkspaceMap":
        """The map in memory, or its voxels whose centres are inside bounds (2, 3) m.

        Raises:
            ArgumentError: invalid bounds, or the map does not fit in memory.
            JobError: a block is missing or damaged.
        """
        part = self.grid.whole if bounds is None else self.grid.part(bounds)
        return WorkspaceMap(
            self.about, self.grid.cut(part), self.samples, {name: self.array(name, part) for name in self.names}
        )

    def values(self, what: str = "reach") -> Array:
        """One number a voxel (X, Y, Z), NaN where nothing is reached; ``what`` is a key of ``VALUES``.

        'reach' is the reachability index of Zacharias, Borst and Hirzinger ("Capturing robot workspace structure",
        IROS 2007) with orientations in place of directions.

        Raises:
            ArgumentError: there is no such value, or it was not computed.

        Example:
            >>> import urdf_ik
            >>> found = urdf_ik.maps.workspace(urdf_ik.load("planar_2r"), voxel=0.05, orientations=4)
            >>> float(np.nanmax(found.values("reach")))
            1.0
        """
        found = np.empty(self.grid.shape)
        for part in self.blocks.parts():
            found[part] = self._values(what, part)
        return found

    def _values(self, what: str, part: Part) -> Array:
        if what not in VALUES:
            raise ArgumentError(f"no value is called {what!r}; there are {', '.join(VALUES)}")
        counts = self.array(self.about["counted"], part)
        if what == "reach":
            values = (counts > 0).mean(axis=-1, dtype=np.float64)
        elif what == "solutions":
            values = counts.mean(axis=-1, dtype=np.float64)
        elif what in self.names:
            measured = self.array(what, part)
            values = np.where(np.isnan(measured), -np.inf, measured).max(axis=-1).astype(np.float64)
        else:
            raise ArgumentError(f"the map contains no {what}; compute it with {what}=True")
        return np.where(counts.any(axis=-1), values, np.nan)

    def slice(self, axis: str = "z", at: float = 0.0, what: str = "reach") -> MapSlice:
        """The layer of voxels across an axis that contains the coordinate ``at`` [m]; only its blocks are read.

        Raises:
            ArgumentError: there is no such axis or value, or the coordinate is outside the grid.
        """
        k, layer = self.grid.layer(axis, at)
        one, two = (i for i in range(3) if i != k)
        part = tuple(slice(layer, layer + 1) if i == k else side for i, side in enumerate(self.grid.whole))
        edges = [float(edge[i]) for i in (one, two) for edge in (self.grid.lower, self.grid.upper)]
        return MapSlice(
            np.take(self._values(what, part), 0, axis=k),
            (AXES[one], AXES[two]),
            (edges[0], edges[1], edges[2], edges[3]),
            axis,
            float(self.grid.coordinates(k)[layer]),
            what,
        )

    def totals(self) -> dict[str, Any]:
        """Sums over the whole map.

        Returns:
            'poses' and 'voxels': the numbers of 'all' and of 'reached' ones, a voxel in any orientation;
            'dexterous_voxels': those reached in every orientation; 'solutions': the sum of each count that the map
            contains; 'branches': the shares of the reached 'voxels' and 'poses' that each branch covers.
        """
        counted: dict[str, int] = {name: 0 for name in ("solutions", "within", "free") if name in self.names}
        branches = np.zeros((2, len(self.about["branches"])), dtype=np.int64)
        reached = np.zeros(3, dtype=np.int64)
        for part in self.blocks.parts():
            hit = self.array(self.about["counted"], part) > 0
            reached += [hit.sum(), hit.any(axis=-1).sum(), hit.all(axis=-1).sum()]
            for name in counted:
                counted[name] += int(self.array(name, part).sum(dtype=np.int64))
            poses = self.array("branch_poses", part).reshape(-1, branches.shape[1])
            branches += [(poses > 0).sum(axis=0), poses.sum(axis=0, dtype=np.int64)]
        poses_hit, voxels_hit, dexterous = (int(count) for count in reached)
        shares = (branches / np.maximum(1, [[voxels_hit], [poses_hit]])).T.tolist()
        return {
            "poses": {"all": self.grid.count * len(self.samples), "reached": poses_hit},
            "voxels": {"all": self.grid.count, "reached": voxels_hit},
            "dexterous_voxels": dexterous,
            "solutions": counted,
            "branches": {
                name: dict(zip(("voxels", "poses"), share, strict=True))
                for name, share in zip(self.about["branches"], shares, strict=True)
            },
        }

    def to_xarray(self) -> Any:
        """An ``xarray.Dataset`` with the dimensions x, y, z, orientation and branch; that of a store is lazy.

        Raises:
            MissingPackage: xarray is not installed.
        """
        xarray = cluster.package("xarray")
        if self.store is not None:
            return xarray.open_zarr(self.store.path)
        arrays: dict[str, Any] = {
            name: ((*AXES, VARIABLES[name].last), self.array(name), VARIABLES[name].attributes) for name in self.names
        }
        arrays |= {name: (name, self.grid.coordinates(k), {"units": "m"}) for k, name in enumerate(AXES)}
        return xarray.Dataset({**arrays, **sample_coordinates(self.about, self.samples)}, attrs=self.about)

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write a compressed ``.npz`` file, which :func:`read` reads.

        Its array ``header`` is JSON: format, version, and ``about`` with the grid. The other arrays have the
        names of ``VARIABLES``.

        Raises:
            ArgumentError: the file cannot be written.
        """
        about = {"format": FORMAT, "version": VERSION, **self.about, "grid": self.grid.described()}
        arrays: dict[str, Any] = {name: self.array(name) for name in self.names}
        arrays |= {"header": np.array(json.dumps(about)), "samples": self.samples}
        files.write(path, lambda file: np.savez_compressed(file, allow_pickle=False, **arrays))


def opened(path: str | os.PathLike[str]) -> WorkspaceMap:
    """A map in a store, or in a file that :meth:`WorkspaceMap.save` wrote.

    Raises:
        JobError: the folder is no store of a map.
        ArgumentError: the file cannot be read, or is no map; the message says why.

    Example:
        >>> import urdf_ik
        >>> _ = urdf_ik.maps.stored_workspace(urdf_ik.load("planar_2r"), "map.zarr", 0.05, 4)
        >>> opened("map.zarr").complete
        True
    """
    if os.path.isdir(path):
        store = BlockStore(path)
        return WorkspaceMap(store.about, store.grid, np.asarray(store.group["samples"][...]), store=store)
    try:
        with open(path, "rb") as raw, np.load(raw, allow_pickle=False) as file:
            arrays = {name: file[name] for name in file.files}
        header = json.loads(str(arrays.pop("header")))
        if (header["format"], header["version"]) != (FORMAT, VERSION):
            raise ValueError(f"it is {header['format']!r}, version {header['version']}; {VERSION} is read")
        about = {name: value for name, value in header.items() if name not in STORE_KEYS}
        grid, samples = Grid.from_described(about["grid"]), arrays.pop("samples")
        last = {"orientation": len(samples), "branch": len(about["branches"])}
        for name in {"solutions", "branch_poses", about["counted"], *arrays}:
            shape, kind = (*grid.shape, last[VARIABLES[name].last]), np.dtype(VARIABLES[name].kind)
            if (arrays[name].shape, arrays[name].dtype) != (shape, kind):
                raise ValueError(f"{name} is of shape {arrays[name].shape} and type {arrays[name].dtype}")
            arrays[name].setflags(write=False)
    except OSError as error:
        raise ArgumentError(f"cannot read {path}: {error.strerror or error}") from None
    except Exception as error:  # zip, zlib, NumPy and JSON each have their own errors for damaged bytes
        raise ArgumentError(f"{path} is no workspace map, or a damaged one: {type(error).__name__} {error}") from None
    return WorkspaceMap(about, grid, samples, {name: arrays[name] for name in VARIABLES if name in arrays})


def sample_coordinates(about: Mapping[str, Any], samples: Array) -> dict[str, Coordinate]:
    """The coordinates of the dimension 'orientation'."""
    words = {"long_name": about["sampled"], "units": "rad" if samples.shape[1:] == (1,) else "1"}
    return {
        "orientation": (("orientation",), np.arange(len(samples)), {}),
        "samples": (("orientation", *("row", "column")[: samples.ndim - 1]), samples, words),
    }


def require_memory(grid: Grid, samples: int, needed: int) -> None:
    """Refuse a map of ``needed`` bytes that does not fit in memory, by an ArgumentError, before any work."""
    voxels = f"{' x '.join(map(str, grid.shape))} voxels of {grid.voxel:g} m"
    poses = f"{voxels} x {samples} orientations = {grid.count * samples:.4g} poses"
    store.require_memory(needed, poses, HINT)


def require_map_of(about: Mapping[str, Any], arm: Arm) -> None:
    """Refuse the map of another arm.

    Raises:
        ArgumentError: it was computed for another URDF, other frames, or other values of the locked joints.
    """
    if (about["base"], about["tip"]) != (arm.base, arm.tip):
        raise ArgumentError(
            f"the map is one of {about['robot']!r} from {about['base']} to {about['tip']}, and the arm is one from "
            f"{arm.base} to {arm.tip}; give the same base and tip"
        )
    if about["urdf_sha256"] != digest(arm.model.xml) or about["locked"] != dict(arm.chain.locked):
        raise ArgumentError(
            f"the map is one of another URDF of {about['robot']!r}, or with other locked joints, than the arm "
            f"{arm.name!r}; compute it anew: urdf-ik workspace"
        )
