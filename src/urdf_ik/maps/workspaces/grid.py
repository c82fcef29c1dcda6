"""The grid of a workspace map: its voxels, and whether the map fits in memory and on the disk."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from urdf_ik.arm import Arm
from urdf_ik.errors import ArgumentError
from urdf_ik.maps.engine import free_space
from urdf_ik.support import inputs
from urdf_ik.support.text import quoted
from urdf_ik.typing import Array

AXES = "xyz"
_MOST_VOXELS = 2**53
"""Beyond it not even their number can be written; how many fit is found out next."""
_ROUNDING = 1e-9
"""Share of a voxel by which bounds may exceed a whole number of voxels."""

_HINT = "take larger voxels, fewer orientations or narrower bounds"


@dataclass(frozen=True, eq=False)
class Grid:
    """Cubic voxels side by side; a voxel stands for its centre.

    Attributes:
        lower: (3,) m, corner of the first voxel, in the base or in the arm's plane.
        voxel: m, edge of a voxel.
        shape: number of voxels along each axis.
    """

    lower: Array
    voxel: float
    shape: tuple[int, int, int]

    @property
    def upper(self) -> Array:
        """(3,) m, corner of the last voxel."""
        return np.asarray(self.lower + self.voxel * np.array(self.shape))

    @property
    def count(self) -> int:
        """Number of voxels."""
        return math.prod(self.shape)

    def coordinates(self, axis: int) -> Array:
        """Centres (shape[axis],) m along an axis, 0 to 2.

        Example:
            >>> Grid(np.zeros(3), 0.1, (3, 1, 1)).coordinates(0).round(6).tolist()
            [0.05, 0.15, 0.25]
        """
        axis = inputs.whole(axis, "axis", high=2)
        return np.asarray(self.lower[axis] + self.voxel * (np.arange(self.shape[axis]) + 0.5))

    def centres(self, part: slice) -> Array:
        """(k, 3) m, centres of the voxels ``part`` counts, the last axis first.

        Example:
            >>> Grid(np.zeros(3), 0.1, (2, 1, 1)).centres(slice(0, 2)).round(6).tolist()
            [[0.05, 0.05, 0.05], [0.15, 0.05, 0.05]]
        """
        places = np.unravel_index(np.arange(part.start, part.stop), self.shape)
        return np.asarray(self.lower + self.voxel * (np.stack(places, axis=-1) + 0.5))

    def centres_of(self, part: tuple[slice, slice, slice]) -> Array:
        """(k, 3) m, centres of the voxels of a box, the last axis first.

        Example:
            >>> Grid(np.zeros(3), 0.1, (2, 1, 1)).centres_of((slice(1, 2), slice(0, 1), slice(0, 1))).round(6).tolist()
            [[0.15, 0.05, 0.05]]
        """
        places = np.meshgrid(*(np.arange(each.start, each.stop) for each in part), indexing="ij")
        return np.asarray(self.lower + self.voxel * (np.stack(places, axis=-1).reshape(-1, 3) + 0.5))

    def part(self, bounds: ArrayLike) -> tuple[slice, slice, slice]:
        """The voxels whose centres are inside bounds (2, 3) m.

        Raises:
            ArgumentError: the bounds make no sense, or there is no such voxel.

        Example:
            >>> Grid(np.zeros(3), 0.1, (4, 1, 1)).part([[0.1, 0, 0], [0.3, 1, 1]])[0]
            slice(1, 3, None)
        """
        lower, upper = _checked(bounds)
        first = np.ceil((lower - self.lower) / self.voxel - 0.5 - _ROUNDING).astype(int)
        last = np.floor((upper - self.lower) / self.voxel - 0.5 + _ROUNDING).astype(int)
        first, last = np.maximum(first, 0), np.minimum(last, np.array(self.shape) - 1)
        if (first > last).any():
            raise ArgumentError(
                f"no voxel has its centre inside {np.array([lower, upper]).tolist()}; the map is from "
                f"{self.lower.tolist()} to {self.upper.tolist()} m"
            )
        x, y, z = (slice(int(a), int(b) + 1) for a, b in zip(first, last, strict=True))
        return x, y, z

    def layer(self, axis: str, at: float) -> tuple[int, int]:
        """Number of an axis, and of the layer of voxels across it that holds the coordinate ``at`` [m].

        Raises:
            ArgumentError: there is no such axis, or the coordinate is outside the grid.

        Example:
            >>> Grid(np.zeros(3), 0.1, (2, 1, 1)).layer("x", 0.15)
            (0, 1)
        """
        axis = inputs.choice(axis, "axis", tuple(AXES))
        at = inputs.number(at, "at", unit="m")
        k = AXES.index(axis)
        lower, upper = float(self.lower[k]), float(self.upper[k])
        if not lower <= at <= upper:
            raise ArgumentError(f"{axis} = {at:g} m is outside the map, from {lower:g} to {upper:g} m")
        return k, min(int((at - lower) / self.voxel), self.shape[k] - 1)

    def cut(self, part: tuple[slice, slice, slice]) -> Grid:
        """The voxels of a box as a grid of their own.

        Example:
            >>> Grid(np.zeros(3), 0.5, (4, 1, 1)).cut((slice(1, 3), slice(0, 1), slice(0, 1))).lower.tolist()
            [0.5, 0.0, 0.0]
        """
        start = np.array([each.start for each in part])
        x, y, z = (each.stop - each.start for each in part)
        return Grid(np.asarray(self.lower + self.voxel * start), self.voxel, (x, y, z))

    def places(self, points: ArrayLike) -> tuple[NDArray[np.intp], NDArray[np.bool_]]:
        """The voxel (m, 3) that each of the points (m, 3) m is in, and whether it is in any (m,).

        Example:
            >>> places, inside = Grid(np.zeros(3), 0.1, (2, 1, 1)).places([[0.15, 0.0, 0.05], [9, 9, 9]])
            >>> places[0].tolist(), inside.tolist()
            ([1, 0, 0], [True, False])
        """
        with np.errstate(invalid="ignore"):
            given = inputs.real(points, "points", "points (m, 3)")
            if given.shape[-1:] != (3,):
                raise ArgumentError(f"points of shape {given.shape} given; (m, 3) is needed")
            places = np.floor((given - self.lower) / self.voxel)
            inside = np.asarray(((places >= 0) & (places < self.shape)).all(axis=-1))
        return np.where(inside[..., None], places, 0).astype(np.intp), inside

    def described(self) -> dict[str, Any]:
        """The grid as JSON can hold it.

        Example:
            >>> Grid(np.zeros(3), 0.1, (2, 1, 1)).described()
            {'lower': [0.0, 0.0, 0.0], 'voxel': 0.1, 'shape': [2, 1, 1]}
        """
        return {"lower": self.lower.tolist(), "voxel": self.voxel, "shape": list(self.shape)}

    @classmethod
    def from_described(cls, found: Any) -> Grid:
        """The grid of such a description.

        Raises:
            ArgumentError: it is invalid.

        Example:
            >>> Grid.from_described({"lower": [0.0, 0.0, 0.0], "voxel": 0.1, "shape": [2, 1, 1]}).count
            2
        """
        found = inputs.mapping(found, "grid", "a mapping with lower, voxel and shape")
        counts, lower = found.get("shape"), found.get("lower")
        if not isinstance(counts, list | tuple) or len(counts) != len(AXES):
            raise ArgumentError(f"shape={quoted(counts)} given; three whole numbers are needed")
        x, y, z = (inputs.whole(count, "shape", low=1, high=_MOST_VOXELS) for count in counts)
        corner = inputs.real(lower, "lower", "three numbers [m]")
        if corner.shape != (len(AXES),) or inputs.first_bad(corner) is not None:
            raise ArgumentError(f"lower={quoted(lower)} given; three finite numbers [m] are needed")
        return cls(corner.copy(), inputs.number(found.get("voxel"), "voxel", above=0.0), (x, y, z))


def grid_of(arm: Arm, voxel: float, bounds: ArrayLike | None) -> Grid:
    """The voxels over all that an arm could reach without limits, or over ``bounds`` (2, 3) m.

    Raises:
        ArgumentError: the edge or the bounds make no sense.
    """
    voxel = inputs.number(voxel, "voxel", above=0.0, unit="m")
    lower, upper = _reach_box(arm) if bounds is None else _checked(bounds)
    planar = arm.task.startswith("planar")
    if planar:
        lower[2], upper[2] = -0.5 * voxel, 0.5 * voxel
    with np.errstate(over="ignore"):
        steps = (upper - lower) / voxel
    if not np.isfinite(upper - lower).all():
        raise ArgumentError(f"{arm.name}: a joint slides without a limit; give bounds [[x, y, z], [x, y, z]] m")
    if not (steps < _MOST_VOXELS).all() or float(np.prod(np.maximum(steps, 1.0))) > _MOST_VOXELS:
        raise ArgumentError(
            f"voxels of {voxel:g} m over {' x '.join(f'{length:g}' for length in upper - lower)} m are too many; take "
            "larger voxels, or narrower bounds"
        )
    counts = [max(1, math.ceil(float(step) - _ROUNDING)) for step in steps]
    # Whole voxels, centred on the requested middle.
    lower = 0.5 * (lower + upper) - 0.5 * voxel * np.array(counts, dtype=np.float64)
    return Grid(lower, float(voxel), (counts[0], counts[1], counts[2]))


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


def _checked(bounds: ArrayLike) -> tuple[Array, Array]:
    box = inputs.real(bounds, "bounds", "[[x, y, z], [x, y, z]] m").copy()
    if box.shape != (2, 3) or inputs.first_bad(box) is not None or (box[0] >= box[1]).any():
        raise ArgumentError(f"bounds {quoted(bounds)} given; [[x, y, z], [x, y, z]] m are needed, lower ones first")
    return box[0], box[1]


def require_memory(grid: Grid, samples: int, needed: int) -> None:
    """Refuse a map whose ``needed`` bytes do not fit in memory, by an ArgumentError, before any work."""
    free_space.require_memory(needed, _words(grid, samples), _HINT)


def require_room(grid: Grid, samples: int, needed: int, output: Path) -> None:
    """Refuse a map whose ``needed`` bytes do not fit on the disk of ``output``, by a JobError, before any work."""
    free_space.require_disk(output, needed, _words(grid, samples), _HINT)


def _words(grid: Grid, samples: int) -> str:
    voxels = f"{' x '.join(map(str, grid.shape))} voxels of {grid.voxel:g} m"
    return f"{voxels} x {samples} orientations = {grid.count * samples:.4g} poses"
