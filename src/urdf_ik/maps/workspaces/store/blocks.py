"""Blocks: the division of a grid's voxels into the chunks of a store."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from urdf_ik.errors import ArgumentError
from urdf_ik.maps.workspaces.grid import Grid
from urdf_ik.support import inputs
from urdf_ik.support.text import quoted

Shape = tuple[int, int, int]
Part = tuple[slice, slice, slice]


@dataclass(frozen=True)
class Blocks:
    """Boxes of voxels side by side; those at the end may hold fewer.

    Attributes:
        grid: number of voxels along each axis.
        shape: number of voxels of a block along each axis.
    """

    grid: Shape
    shape: Shape

    @classmethod
    def of(cls, grid: Grid, most: int) -> Blocks:
        """Blocks of at most so many voxels, and about as long as they are wide.

        Example:
            >>> from urdf_ik.maps.workspaces import Grid
            >>> Blocks.of(Grid(np.zeros(3), 0.1, (40, 40, 3)), 300).shape
            (8, 8, 3)
        """
        shape = [1, 1, 1]
        while True:
            longer = [(side, k) for k, side in enumerate(shape) if side < grid.shape[k]]
            for _, k in sorted(longer):
                wider = [*shape]
                wider[k] = min(2 * shape[k], grid.shape[k])
                if math.prod(wider) <= most:
                    shape = wider
                    break
            else:
                return cls(grid.shape, (shape[0], shape[1], shape[2]))

    @classmethod
    def from_described(cls, grid: Shape, shape: Any) -> Blocks:
        """Blocks of this many voxels along each axis, as a store's question says.

        Raises:
            ArgumentError: there are no such blocks.
        """
        if not isinstance(shape, list) or len(shape) != len(grid):
            raise ArgumentError(f"block={quoted(shape)} given; three whole numbers are needed")
        sides = zip(shape, grid, strict=True)
        x, y, z = (inputs.whole(each, "block", low=1, high=most) for each, most in sides)
        return cls(grid, (x, y, z))

    @property
    def along(self) -> Shape:
        """Number of blocks along each axis."""
        x, y, z = (-(-all_of // side) for all_of, side in zip(self.grid, self.shape, strict=True))
        return x, y, z

    @property
    def count(self) -> int:
        """Number of blocks."""
        return math.prod(self.along)

    @property
    def most(self) -> int:
        """Voxels of a whole block."""
        return math.prod(self.shape)

    def place(self, block: int) -> Shape:
        """Number of a block along each axis; the last axis counts first.

        Example:
            >>> Blocks((4, 4, 4), (2, 2, 2)).place(5)
            (1, 0, 1)
        """
        x, y, z = (int(k) for k in np.unravel_index(block, self.along))
        return x, y, z

    def part(self, block: int) -> Part:
        """The voxels of a block.

        Example:
            >>> Blocks((3, 1, 1), (2, 1, 1)).part(1)[0]
            slice(2, 3, None)
        """
        x, y, z = (
            slice(k * side, min((k + 1) * side, end))
            for k, side, end in zip(self.place(block), self.shape, self.grid, strict=True)
        )
        return x, y, z

    def parts(self) -> Iterator[Part]:
        """The voxels of all blocks, in their order.

        Example:
            >>> len(list(Blocks((3, 1, 1), (2, 1, 1)).parts()))
            2
        """
        return (self.part(block) for block in range(self.count))
