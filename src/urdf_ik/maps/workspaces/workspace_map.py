"""WorkspaceMap: the solution counts of the poses of a grid, with slices, shares and look-ups."""

from __future__ import annotations

import itertools
import os
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from urdf_ik.errors import ArgumentError
from urdf_ik.maps.workspaces import map_files
from urdf_ik.maps.workspaces.cells import cells
from urdf_ik.maps.workspaces.grid import AXES, Grid
from urdf_ik.maps.workspaces.totals import BranchShare, Totals
from urdf_ik.support import inputs
from urdf_ik.support.read_only import Frozen
from urdf_ik.support.text import quoted
from urdf_ik.typing import Array

Counts = NDArray[np.uint8]

# Arrays of a file: those of every map, the requested ones, and the types other than uint8.
_ALWAYS = ("samples", "solutions", "branch_poses")
_PERHAPS = ("within", "free", "manipulability", "margin", "clearance")
_MEASURED = ("manipulability", "margin", "clearance")
_TYPES = {"samples": np.float64, "branch_poses": np.uint16} | dict.fromkeys(_MEASURED, np.float32)
_TEXTS = ("robot", "urdf_sha256", "base", "tip", "task", "sampled", "counted", "made_by")
_COUNTED = ("solutions", "within", "free")
VALUES = {
    "reach": "share of the orientations that are reached",
    "solutions": "mean number of solutions",
    "manipulability": "greatest manipulability",
    "margin": "greatest limit margin",
    "clearance": "greatest clearance [m]",
}
"""Values of a voxel, by name, with their descriptions."""


@dataclass(frozen=True)
class About:
    """The arm, task and settings of a map.

    Attributes:
        robot: the URDF's name.
        urdf_sha256: of the URDF's links and joints, as they were read.
        base: link in which positions are given.
        tip: link whose positions they are.
        joints: names, base to tip.
        limits: (lower, upper) of each joint [rad or m], None where there is no limit.
        locked: joints that are held, with their values [rad or m].
        task: what the arm controls, see ``arm.task``.
        sampled: the kind of samples at each position, in words.
        branches: names of the family's branches.
        counted: 'solutions', 'within' or 'free': which solutions count for reach, branches, manipulability and margin.
        redundancy: value of the redundancy parameter [rad or m], None for an arm without one.
        world: digest of the obstacles that counted, see ``World.digest``; None for a map without.
        made_by: version of this package.
    """

    robot: str
    urdf_sha256: str
    base: str
    tip: str
    joints: tuple[str, ...]
    limits: tuple[tuple[float | None, float | None], ...]
    locked: dict[str, float]
    task: str
    sampled: str
    branches: tuple[str, ...]
    counted: str
    redundancy: float | None
    world: str | None
    made_by: str

    def cell(self, voxel: float) -> float:
        """Volume [m^3] of a voxel; area [m^2] for a planar arm.

        Example:
            >>> import urdf_ik
            >>> found = urdf_ik.maps.workspace(urdf_ik.load("planar_2r"), voxel=0.05, orientations=4)
            >>> round(found.about.cell(0.05), 6)
            0.0025
        """
        return float(voxel ** (2 if self.task.startswith("planar") else 3))

    @classmethod
    def read(cls, header: Mapping[str, Any]) -> About:
        """From the fields as JSON holds them.

        Raises:
            ArgumentError: a field is missing or invalid.

        Example:
            >>> from dataclasses import asdict
            >>> import urdf_ik
            >>> found = urdf_ik.maps.workspace(urdf_ik.load("planar_2r"), voxel=0.05, orientations=4)
            >>> About.read(asdict(found.about)) == found.about
            True
        """
        inputs.mapping(header, "header", "the fields of a map")
        if missing := [name for name in cls.__dataclass_fields__ if name not in header]:
            raise ArgumentError(f"there is no {quoted(missing[0])} in it")
        named = {name: header[name] for name in cls.__dataclass_fields__}
        for name in ("joints", "branches"):
            named[name] = inputs.items(named[name], name, "names")
        named["limits"] = tuple(
            inputs.items(pair, "limits", "pairs of numbers")
            for pair in inputs.items(named["limits"], "limits", "pairs of numbers")
        )
        texts = [*named["joints"], *named["branches"], *(named[name] for name in _TEXTS)]
        numbers = [*itertools.chain(*named["limits"]), named["redundancy"]]
        locked = inputs.mapping(named["locked"], "locked", "values by joint")
        if (
            any(len(pair) != 2 for pair in named["limits"])
            or not all(isinstance(each, str) for each in (*texts, *locked, named["world"] or ""))
            or not all(inputs.is_real(each) for each in (*(x for x in numbers if x is not None), *locked.values()))
            or named["counted"] not in _COUNTED
        ):
            raise ArgumentError("its fields are of other kinds than names and numbers")
        return cls(**named)


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
class WorkspaceMap(Frozen):
    """Positions x orientations of an arm's tip, with what they have as solutions.

    Attributes:
        about: the arm and the question.
        grid: the voxels (X, Y, Z).
        samples: (S, ...) what was sampled at each position: rotation matrices, directions or angles.
        solutions: (X, Y, Z, S) number of solutions.
        branch_poses: (X, Y, Z, B) number of orientations in which a branch has a solution that counts.
        within: (X, Y, Z, S) number within the limits, or None.
        free: (X, Y, Z, S) number within the limits that are free of collision, or None.
        manipulability: (X, Y, Z, S) greatest one of the solutions that count, NaN where nothing is reached; or None.
        margin: (X, Y, Z, S) greatest limit margin: the least of all joints' distances to their limits, as shares of
            half their ranges, 0 at a limit and 1 in the middle of all; NaN where nothing is reached; or None.
        clearance: (X, Y, Z, S) m, greatest one of the solutions that count; NaN where nothing is reached; or None.

    Example:
        >>> import urdf_ik
        >>> found = urdf_ik.maps.workspace(urdf_ik.load("planar_2r"), voxel=0.05, orientations=4)
        >>> found
        <WorkspaceMap of planar_2r: 8 x 8 x 1 voxels of 0.05 m x 1, 24 poses reached>
        >>> found.about.robot, found.solutions.shape
        ('planar_2r', (8, 8, 1, 1))
    """

    about: About
    grid: Grid
    samples: Array = field(repr=False)
    solutions: Counts = field(repr=False)
    branch_poses: NDArray[np.uint16] = field(repr=False)
    within: Counts | None = field(repr=False, default=None)
    free: Counts | None = field(repr=False, default=None)
    manipulability: NDArray[np.float32] | None = field(repr=False, default=None)
    margin: NDArray[np.float32] | None = field(repr=False, default=None)
    clearance: NDArray[np.float32] | None = field(repr=False, default=None)

    def __repr__(self) -> str:
        shape = " x ".join(map(str, self.grid.shape))
        voxels = f"{shape} voxels of {self.grid.voxel:g} m x {len(self.samples)}"
        return f"<WorkspaceMap of {self.about.robot}: {voxels}, {int((self.counts > 0).sum())} poses reached>"

    @property
    def counts(self) -> Counts:
        """(X, Y, Z, S) number of the solutions that count, see ``about.counted``."""
        return {"solutions": self.solutions, "within": self.within, "free": self.free}[self.about.counted]  # type: ignore[return-value]

    @property
    def reached(self) -> NDArray[np.bool_]:
        """(X, Y, Z) whether a voxel's centre is reached in any orientation."""
        return np.asarray(self.counts.any(axis=-1))

    @property
    def volume(self) -> float:
        """Volume [m^3] of the voxels that are reached; area [m^2] for a planar arm."""
        return float(self.reached.sum()) * self.about.cell(self.grid.voxel)

    @property
    def dexterous_volume(self) -> float:
        """The same of the voxels that are reached in every orientation that was sampled."""
        return float((self.counts > 0).all(axis=-1).sum()) * self.about.cell(self.grid.voxel)

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
        if not isinstance(what, str) or what not in VALUES:
            raise ArgumentError(f"no value is called {quoted(what)}; there are {', '.join(VALUES)}")
        if what in ("reach", "solutions"):
            counts = self.counts if what == "solutions" else self.counts > 0
            values = counts.mean(axis=-1, dtype=np.float64)
        else:
            stored: NDArray[np.float32] | None = getattr(self, what)
            if stored is None:
                raise ArgumentError(f"the map holds no {what}; compute it with {what}=True")
            values = np.where(np.isnan(stored), -np.inf, stored).max(axis=-1).astype(np.float64)
        return np.where(self.reached, values, np.nan)

    def slice(self, axis: str = "z", at: float = 0.0, what: str = "reach") -> MapSlice:
        """The layer of voxels across an axis that holds the coordinate ``at`` [m].

        Raises:
            ArgumentError: there is no such axis or value, or the coordinate is outside the grid.

        Example:
            >>> import urdf_ik
            >>> found = urdf_ik.maps.workspace(urdf_ik.load("planar_2r"), voxel=0.05, orientations=4)
            >>> found.slice().axes, found.slice().values.shape
            (('x', 'y'), (8, 8))
        """
        k, layer = self.grid.layer(axis, at)
        one, two = (i for i in range(3) if i != k)
        edges = [float(edge[i]) for i in (one, two) for edge in (self.grid.lower, self.grid.upper)]
        return MapSlice(
            np.take(self.values(what), layer, axis=k),
            (AXES[one], AXES[two]),
            (edges[0], edges[1], edges[2], edges[3]),
            axis,
            float(self.grid.coordinates(k)[layer]),
            what,
        )

    def reach(self, direction: ArrayLike, origin: ArrayLike = (0.0, 0.0, 0.0)) -> Array:
        """Where a ray runs through voxels that are reached.

        Args:
            direction: (3,), of any length.
            origin: (3,) m.

        Returns:
            (k, 2) m from the origin, each stretch's beginning and end; the last number is how far the arm reaches.

        Raises:
            ArgumentError: the direction or the origin is invalid.

        Example:
            >>> import urdf_ik
            >>> found = urdf_ik.maps.workspace(urdf_ik.load("planar_2r"), voxel=0.05, orientations=4)
            >>> found.reach([1, 0, 0]).round(3).tolist()
            [[0.1, 0.2]]
        """
        ray, start = (
            inputs.real(value, name, "three numbers")
            for name, value in (("direction", direction), ("origin", origin))
        )
        good = start.shape == ray.shape == (3,) and inputs.first_bad(start) is inputs.first_bad(ray) is None
        length = float(np.linalg.norm(ray)) if good else 0.0
        if length == 0.0:
            raise ArgumentError(
                f"direction {quoted(direction)} from {quoted(origin)}: three numbers each, not all zero, are needed"
            )
        ray = ray / length
        edges = [self.grid.lower[i] + self.grid.voxel * np.arange(self.grid.shape[i] + 1) for i in range(3)]
        crossings = [(edges[i] - start[i]) / ray[i] for i in range(3) if ray[i] != 0.0]
        cuts = np.unique(np.concatenate([[0.0], *crossings]))
        cuts = cuts[cuts >= 0.0]
        middles = start + 0.5 * (cuts[:-1] + cuts[1:])[:, None] * ray
        places = np.floor((middles - self.grid.lower) / self.grid.voxel).astype(int)
        inside = ((places >= 0) & (places < self.grid.shape)).all(axis=1)
        hit = np.zeros(len(places) + 2, dtype=np.int8)
        hit[1:-1][inside] = self.reached[tuple(places[inside].T)]
        change = np.diff(hit)
        return np.stack([cuts[change[: len(cuts)] > 0], cuts[change[: len(cuts)] < 0]], axis=-1)

    def look_up(self, targets: Any, what: str | None = None) -> NDArray[Any]:
        """Values of an array in the cells of targets: nearest voxel and nearest orientation.

        Args:
            targets: (m, ...) of the map's task, ``about.task``, as ``arm.ik`` takes them.
            what: name of the array; default: the number of solutions that count.

        Returns:
            (m,); zero, or NaN for what is measured, outside the grid.

        Raises:
            ArgumentError: the targets are of another shape, or the map does not hold this.

        Example:
            >>> import urdf_ik
            >>> found = urdf_ik.maps.workspace(urdf_ik.load("planar_2r"), voxel=0.05, orientations=4)
            >>> found.look_up([[0.15, 0.05], [9.0, 9.0]]).tolist()
            [1, 0]
        """
        name = self.about.counted if what is None else what
        values = getattr(self, name) if isinstance(name, str) and name in _PERHAPS + ("solutions",) else None
        if values is None:
            raise ArgumentError(f"the map holds no {quoted(name)} for each pose")
        at = cells(self.grid, self.samples, self.about.task, targets)
        found = values[(*at.voxels.T, at.samples)]
        found[~at.inside] = np.nan if found.dtype.kind == "f" else 0
        return np.asarray(found)

    def branch_shares(self) -> dict[str, BranchShare]:
        """How much of what is reached each branch covers, by name; zeros where nothing is reached.

        Example:
            >>> import urdf_ik
            >>> found = urdf_ik.maps.workspace(urdf_ik.load("planar_2r"), voxel=0.05, orientations=4)
            >>> sorted(found.branch_shares())
            ['elbow left', 'elbow right']
        """
        return self.totals().branch_shares

    def totals(self) -> Totals:
        """Sums over the whole map.

        Example:
            >>> import urdf_ik
            >>> found = urdf_ik.maps.workspace(urdf_ik.load("planar_2r"), voxel=0.05, orientations=4)
            >>> found.totals().reached_voxels == int(found.reached.sum())
            True
        """
        reached, branches = self.counts > 0, self.about.branches
        flat = self.branch_poses.reshape(-1, len(branches))
        counted = {name: getattr(self, name) for name in ("solutions", "within", "free")}
        return Totals(
            reached.size,
            int(reached.sum()),
            self.grid.count,
            int(reached.any(axis=-1).sum()),
            int(reached.all(axis=-1).sum()),
            {name: int(stored.sum(dtype=np.int64)) for name, stored in counted.items() if stored is not None},
            dict(zip(branches, (flat > 0).sum(axis=0).tolist(), strict=True)),
            dict(zip(branches, flat.sum(axis=0, dtype=np.int64).tolist(), strict=True)),
        )

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write a compressed ``.npz`` file, which :func:`read` reads: see :mod:`urdf_ik.maps.workspaces.map_files`.

        Raises:
            ArgumentError: the file cannot be written.

        Example:
            >>> import urdf_ik
            >>> found = urdf_ik.maps.workspace(urdf_ik.load("planar_2r"), voxel=0.05, orientations=4)
            >>> found.save("map.npz")
            >>> urdf_ik.maps.workspaces.read("map.npz").about.robot
            'planar_2r'
        """
        arrays = {name: getattr(self, name) for name in _ALWAYS + _PERHAPS if getattr(self, name) is not None}
        map_files.write(path, {**asdict(self.about), "grid": self.grid.described()}, arrays)


def read(path: str | os.PathLike[str], *, most: int = map_files.MAX_BYTES) -> WorkspaceMap:
    """Read a map that :meth:`WorkspaceMap.save` wrote.

    Args:
        path: the file.
        most: bytes that it may unpack to: a file of a few MiB may hold a thousand times as much.

    Raises:
        ArgumentError: the file cannot be read, or is no such map; the message says why.

    Example:
        >>> import urdf_ik
        >>> urdf_ik.maps.workspace(urdf_ik.load("planar_2r"), voxel=0.05, orientations=4).save("map.npz")
        >>> urdf_ik.maps.workspaces.read("map.npz").grid.shape
        (8, 8, 1)
    """
    return map_files.read(path, _built, inputs.whole(most, "most", high=2**63))


def _built(header: dict[str, Any], arrays: dict[str, NDArray[Any]]) -> WorkspaceMap:
    about, voxels = About.read(header), Grid.from_described(header["grid"])
    for name in _ALWAYS:
        if name not in arrays:
            raise ValueError(f"the array {quoted(name)} is missing")
    if about.counted != "solutions" and about.counted not in arrays:
        raise ValueError(f"the array {quoted(about.counted)} is missing")
    arrays = {name: array for name, array in arrays.items() if name in _ALWAYS + _PERHAPS}
    for name, array in arrays.items():
        last = len(about.branches) if name == "branch_poses" else len(arrays["samples"])
        shape = array.shape if name == "samples" else (*voxels.shape, last)
        kind = _TYPES.get(name, np.uint8)
        if array.shape != shape or array.dtype != kind:
            raise ValueError(
                f"{name} is of shape {array.shape} and type {array.dtype}, not {shape} and {kind.__name__}"
            )
        array.setflags(write=False)
    return WorkspaceMap(about, voxels, **arrays)
