"""What the viewer shows of a workspace map, without the viewer: a layer as coloured points, and the boundary."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from urdf_ik.errors import ArgumentError
from urdf_ik.maps.workspaces import VALUES, boundary
from urdf_ik.maps.workspaces.grid import AXES
from urdf_ik.maps.workspaces.question import require_map_of
from urdf_ik.support import palette
from urdf_ik.support.text import quoted

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from urdf_ik.arm import Arm
    from urdf_ik.maps.workspaces import StoredMap, Surface, WorkspaceMap

    Array = NDArray[np.float64]

MOST_POINTS = 100_000
"""Points that a page draws smoothly; of a layer with more of them one row in two, in three, ... is shown."""


@dataclass(frozen=True, eq=False)
class Layer:
    """The voxels of one layer that are reached, as points.

    Attributes:
        points: (k, 3) m, their centres in the base.
        colours: (k, 3) red, green and blue, 0 to 255; from dark blue at zero to yellow at ``Voxels.top``.
        at: m, the layer's middle on its axis.
        reached: number of its voxels that are reached.
        voxels: number of its voxels.
        every: 2 where one row in two is shown, and so on; 1 where all are.
    """

    points: Array
    colours: NDArray[np.uint8]
    at: float
    reached: int
    voxels: int
    every: int


class Voxels:
    """A map of an arm, read value by value.

    Attributes:
        found: the map.
        arm: whose map it is.
        holds: the values that can be shown, keys of ``VALUES``.
        across: name of the axis with fewest layers, which are the largest; where there are several, z before y.

    Raises:
        ArgumentError: the map is of another arm.
        JobError: the map is in a store that is not complete, or damaged.
    """

    def __init__(self, found: WorkspaceMap | StoredMap, arm: Arm) -> None:
        require_map_of(found.about, arm)
        self.found, self.arm = found, arm
        held = getattr(found, "holds", None)
        self.holds = tuple(
            name
            for name in VALUES
            if name in ("reach", "solutions")
            or (name in held if held is not None else getattr(found, name) is not None)
        )
        self.across = min(reversed(AXES), key=lambda name: found.grid.shape[AXES.index(name)])
        self._values: dict[str, NDArray[np.float32]] = {}
        plane = arm.solver.control.plane
        # A planar arm's map is in the plane's coordinates.
        self._origin = np.zeros(3) if plane is None else plane.origin
        self._axes = np.eye(3) if plane is None else np.vstack([plane.axes, plane.normal])
        self.values(self.holds[0])

    def values(self, what: str) -> NDArray[np.float32]:
        """(X, Y, Z) one number a voxel, NaN where nothing is reached; the map is read once.

        Raises:
            ArgumentError: the map does not hold this.
        """
        if what not in self.holds:
            raise ArgumentError(f"the map holds no {quoted(what)}; it holds {', '.join(self.holds)}")
        if what not in self._values:
            self._values[what] = self.found.values(what).astype(np.float32)
        return self._values[what]

    def top(self, what: str) -> float:
        """The greatest value of the whole map, which the last colour stands for; 0 where nothing is reached."""
        return float(np.nanmax(self.values(what), initial=0.0))

    def coordinates(self, axis: str) -> Array:
        """Middles of the layers across an axis [m]."""
        return self.found.grid.coordinates(AXES.index(axis))

    def layer(self, axis: str, at: float, what: str) -> Layer:
        """The layer of voxels across ``axis`` that is nearest to the coordinate ``at`` [m].

        Raises:
            ArgumentError: the map does not hold ``what``.
        """
        k, middles = AXES.index(axis), self.coordinates(axis)
        number = int(np.argmin(np.abs(middles - at)))
        values = np.take(self.values(what), [number], axis=k)
        reached = int(np.isfinite(values).sum())
        every = int(np.ceil(np.sqrt(reached / MOST_POINTS))) or 1
        shown = np.zeros(values.shape, dtype=np.bool_)
        shown[tuple(slice(None, None, 1 if axis == name else every) for name in AXES)] = True
        shown &= np.isfinite(values)
        places = np.argwhere(shown)
        places[:, k] += number
        centres = self.found.grid.lower + self.found.grid.voxel * (places + 0.5)
        colours = palette.shades(values[shown] / (self.top(what) or 1.0))
        return Layer(self._in_base(centres), colours, float(middles[number]), reached, values.size, every)

    def boundary(self) -> Surface:
        """The boundary of what is reached, in the base."""
        mesh = boundary(self.found)
        return mesh._replace(vertices=self._in_base(mesh.vertices))

    def _in_base(self, points: Array) -> Array:
        return np.asarray(self._origin + points @ self._axes)
