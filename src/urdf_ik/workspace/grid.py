"""The grid of a workspace map: its voxels, and whether its answers fit into memory and on the disk."""

from __future__ import annotations

import contextlib
import math
import shutil
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from urdf_ik import inputs
from urdf_ik.errors import WorkspaceError
from urdf_ik.text import quoted

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

    from urdf_ik.arm import Arm

    Array = NDArray[np.float64]

AXES = "xyz"
_MOST_VOXELS = 2**53
"""Beyond it not even their number can be written; how many fit is found out next."""
_ROUNDING = 1e-9
"""Share of a voxel by which bounds may exceed a whole number of voxels."""


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
        """Centres (shape[axis],) m along an axis.

        Example:
            >>> Grid(np.zeros(3), 0.1, (3, 1, 1)).coordinates(0).round(6).tolist()
            [0.05, 0.15, 0.25]
        """
        return np.asarray(self.lower[axis] + self.voxel * (np.arange(self.shape[axis]) + 0.5))

    def centres(self, part: slice) -> Array:
        """(k, 3) m, centres of the voxels ``part`` counts, the last axis first.

        Example:
            >>> Grid(np.zeros(3), 0.1, (2, 1, 1)).centres(slice(0, 2)).round(6).tolist()
            [[0.05, 0.05, 0.05], [0.15, 0.05, 0.05]]
        """
        places = np.unravel_index(np.arange(part.start, part.stop), self.shape)
        return np.asarray(self.lower + self.voxel * (np.stack(places, axis=-1) + 0.5))


def grid_of(arm: Arm, voxel: float, bounds: ArrayLike | None) -> Grid:
    """The voxels over all that an arm could reach without limits, or over ``bounds`` (2, 3) m.

    Raises:
        WorkspaceError: the edge or the bounds make no sense.
    """
    voxel = inputs.number(voxel, "voxel", WorkspaceError, above=0.0, unit="m")
    lower, upper = _reach_box(arm) if bounds is None else _checked(bounds)
    planar = arm.task.startswith("planar")
    if planar:
        lower[2], upper[2] = -0.5 * voxel, 0.5 * voxel
    with np.errstate(over="ignore"):
        steps = (upper - lower) / voxel
    if not np.isfinite(upper - lower).all():
        raise WorkspaceError(f"{arm.name}: a joint slides without a limit; give bounds [[x, y, z], [x, y, z]] m")
    if not (steps < _MOST_VOXELS).all() or float(np.prod(np.maximum(steps, 1.0))) > _MOST_VOXELS:
        raise WorkspaceError(
            f"voxels of {voxel:g} m over {' x '.join(f'{length:g}' for length in upper - lower)} m are too many; take "
            "larger voxels, or narrower bounds"
        )
    counts = [max(1, math.ceil(float(step) - _ROUNDING)) for step in steps]
    # Whole voxels, with the middle where it was asked for.
    lower = 0.5 * (lower + upper) - 0.5 * voxel * np.array(counts, dtype=np.float64)
    return Grid(lower, float(voxel), (counts[0], counts[1], counts[2]))


def _reach_box(arm: Arm) -> tuple[Array, Array]:
    """A box (3,), (3,) m that holds all positions of the tip: no further off than the links and slides are long."""
    chain = arm.chain
    middle, first = chain.P[0].copy(), chain.P[1].copy()
    if not chain.prismatic[0]:
        # Any point of the first axis will do; the one across from the second joint is nearest.
        middle += (first @ chain.H[0]) * chain.H[0]
        first -= (first @ chain.H[0]) * chain.H[0]
    reach = float(np.linalg.norm(first) + np.linalg.norm(chain.P[2:], axis=1).sum())
    reach += float(np.abs(chain.limits[chain.prismatic]).max(axis=1, initial=0.0).sum())
    plane = arm.plane
    if plane is not None:
        middle = np.append(plane.axes @ middle, 0.0)
    return middle - reach, middle + reach


def _checked(bounds: ArrayLike) -> tuple[Array, Array]:
    box = inputs.real(bounds, "bounds", "[[x, y, z], [x, y, z]] m", WorkspaceError).copy()
    if box.shape != (2, 3) or inputs.first_bad(box) is not None or (box[0] >= box[1]).any():
        raise WorkspaceError(f"bounds {quoted(bounds)} given; [[x, y, z], [x, y, z]] m are needed, lower ones first")
    return box[0], box[1]


def require_room(grid: Grid, samples: int, results: int, scratch: int, output: Path | None) -> None:
    """Refuse a map that does not fit, before any work.

    Args:
        grid: the voxels.
        samples: orientations at each of them.
        results: bytes of all answers.
        scratch: bytes that a chunk takes.
        output: the file that the answers go to, uncompressed at most as large as ``results``; None: no file.

    Raises:
        WorkspaceError: with the numbers.
    """
    what = f"{' x '.join(map(str, grid.shape))} voxels of {grid.voxel:g} m x {samples} orientations"
    hint = "take larger voxels, fewer orientations or narrower bounds"
    free = available_memory()
    if results + scratch > free:
        raise WorkspaceError(
            f"{what} = {grid.count * samples:.4g} poses take {_size(results + scratch)} of memory, and "
            f"{_size(free)} are free; {hint}"
        )
    if output is not None:
        folder = output.resolve().parent
        if not folder.is_dir():
            raise WorkspaceError(f"{output}: there is no folder {folder}")
        free = shutil.disk_usage(folder).free
        if results > free:
            raise WorkspaceError(
                f"{what} = {grid.count * samples:.4g} poses take up to {_size(results)} on the disk, and {folder} has "
                f"{_size(free)} free; {hint}"
            )


def available_memory() -> int:
    """Bytes of memory that can be had without swapping."""
    import psutil  # only maps need it

    found = [int(psutil.virtual_memory().available)]
    group = Path("/sys/fs/cgroup")
    with contextlib.suppress(OSError, ValueError):  # a container's own limit, where there is one
        found.append(int((group / "memory.max").read_text()) - int((group / "memory.current").read_text()))
    return max(0, min(found))


def _size(count: int) -> str:
    return f"{count / 2**30:.3g} GiB" if count >= 2**29 else f"{count / 2**20:.3g} MiB"
