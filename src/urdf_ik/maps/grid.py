"""Grid: the voxels of a map. Blocks: the division of a grid into the chunks of a store."""

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from urdf_ik.errors import ArgumentError
from urdf_ik.support import inputs
from urdf_ik.typing import Array

AXES = ("x", "y", "z")
_ROUNDING = 1e-9
"""Share of a voxel by which bounds may exceed a whole number of voxels."""

Shape = tuple[int, ...]
"""Three numbers."""
Part = tuple[slice, ...]
"""A box of voxels: three slices."""


@dataclass(frozen=True, eq=False)
class Grid:
    """Cubic voxels side by side; a voxel is represented by its centre.

    Attributes:
        lower: (3,) m, corner of the first voxel, in the base or in the arm's plane.
        voxel: m, edge of a voxel.
        shape: number of voxels along each axis.
    """

    lower: Array
    voxel: float
    shape: Shape

    @property
    def upper(self) -> Array:
        """(3,) m, corner of the last voxel."""
        return np.asarray(self.lower + self.voxel * np.array(self.shape))

    @property
    def count(self) -> int:
        """Number of voxels."""
        return math.prod(self.shape)

    @property
    def whole(self) -> Part:
        """The box of all voxels."""
        return tuple(slice(0, count) for count in self.shape)

    def coordinates(self, axis: int) -> Array:
        """Centres (shape[axis],) m along an axis, 0 to 2."""
        return np.asarray(self.lower[axis] + self.voxel * (np.arange(self.shape[axis]) + 0.5))

    def centres_in(self, part: Part) -> Array:
        """(k, 3) m, centres of the voxels of a box, the last axis first."""
        places = np.meshgrid(*(np.arange(side.start, side.stop) for side in part), indexing="ij")
        return np.asarray(self.lower + self.voxel * (np.stack(places, axis=-1).reshape(-1, 3) + 0.5))

    def part(self, bounds: ArrayLike) -> Part:
        """The voxels whose centres are inside bounds (2, 3) m."""
        lower, upper = checked_bounds(bounds)
        first = np.ceil((lower - self.lower) / self.voxel - 0.5 - _ROUNDING).astype(int)
        last = np.floor((upper - self.lower) / self.voxel - 0.5 + _ROUNDING).astype(int)
        first, last = np.maximum(first, 0), np.minimum(last, np.array(self.shape) - 1)
        if (first > last).any():
            raise ArgumentError(
                f"no voxel has its centre inside {np.array([lower, upper]).tolist()}; the map is from "
                f"{self.lower.tolist()} to {self.upper.tolist()} m"
            )
        return tuple(slice(int(a), int(b) + 1) for a, b in zip(first, last, strict=True))

    def layer(self, axis: str, at: float) -> tuple[int, int]:
        """Number of an axis, and of the layer of voxels across it that contains the coordinate ``at`` [m]."""
        k = AXES.index(inputs.choice(axis, "axis", AXES))
        lower, upper = float(self.lower[k]), float(self.upper[k])
        if not lower <= at <= upper:
            raise ArgumentError(f"{axis} = {at:g} m is outside the map, from {lower:g} to {upper:g} m")
        return k, min(int((at - lower) / self.voxel), self.shape[k] - 1)

    def cut(self, part: Part) -> "Grid":
        """The grid of a box of voxels."""
        start = np.array([side.start for side in part])
        shape = tuple(side.stop - side.start for side in part)
        return Grid(np.asarray(self.lower + self.voxel * start), self.voxel, shape)

    def described(self) -> dict[str, Any]:
        """The grid in JSON."""
        return {"lower": self.lower.tolist(), "voxel": self.voxel, "shape": list(self.shape)}

    @classmethod
    def from_described(cls, described: Mapping[str, Any]) -> "Grid":
        """The inverse of :meth:`described`."""
        x, y, z = described["shape"]
        return cls(np.array(described["lower"], dtype=np.float64), float(described["voxel"]), (x, y, z))


@dataclass(frozen=True)
class Blocks:
    """Boxes of voxels side by side; those at the end may contain fewer.

    Attributes:
        grid: number of voxels along each axis.
        shape: number of voxels of a block along each axis.
    """

    grid: Shape
    shape: Shape

    @classmethod
    def cut(cls, grid: Shape, most: int) -> "Blocks":
        """Blocks of at most ``most`` voxels, and about as long as they are wide."""
        shape = [1, 1, 1]
        while True:
            longer = [(side, k) for k, side in enumerate(shape) if side < grid[k]]
            for _, k in sorted(longer):
                wider = [*shape]
                wider[k] = min(2 * shape[k], grid[k])
                if math.prod(wider) <= most:
                    shape = wider
                    break
            else:
                return cls(grid, tuple(shape))

    @property
    def along(self) -> Shape:
        """Number of blocks along each axis."""
        return tuple(-(-count // side) for count, side in zip(self.grid, self.shape, strict=True))

    @property
    def count(self) -> int:
        """Number of blocks."""
        return math.prod(self.along)

    def place(self, block: int) -> Shape:
        """Number of a block along each axis; the last axis counts first."""
        return tuple(int(k) for k in np.unravel_index(block, self.along))

    def part(self, block: int) -> Part:
        """The voxels of a block."""
        sides = zip(self.place(block), self.shape, self.grid, strict=True)
        return tuple(slice(k * side, min((k + 1) * side, end)) for k, side, end in sides)

    def parts(self) -> Iterator[Part]:
        """The voxels of all blocks, in their order."""
        return (self.part(block) for block in range(self.count))

    def overlapping(self, part: Part) -> list[int]:
        """Numbers of the blocks that contain voxels of a box."""
        spans = (range(box.start // side, -(-box.stop // side)) for box, side in zip(part, self.shape, strict=True))
        places = np.meshgrid(*spans, indexing="ij")
        return [int(k) for k in np.ravel_multi_index(tuple(places), self.along).ravel()]


def checked_bounds(bounds: ArrayLike, *, flat: bool = False) -> tuple[Array, Array]:
    """Lower and upper corner (3,) m; ``flat``: they may be equal along an axis."""
    box = np.array(bounds, dtype=np.float64)
    if box.shape == (2, 3) and np.isfinite(box).all():
        lower, upper = box
        if (lower < upper).all() or (flat and (lower <= upper).all()):
            return lower, upper
    raise ArgumentError(f"bounds={box.tolist()} given; [[x, y, z], [x, y, z]] m are needed, lower ones first")
