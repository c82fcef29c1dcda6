"""A workspace map in the viewer: a layer of voxels as coloured points, the boundary, and their widgets."""

from __future__ import annotations

from collections.abc import Callable, Hashable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from urdf_ik.arm import Arm
from urdf_ik.errors import ArgumentError, UrdfIkError
from urdf_ik.maps.grid import AXES
from urdf_ik.maps.workspaces import VALUES, Surface, WorkspaceMap, boundary, require_map_of
from urdf_ik.show.viewer.arm_panel import on_change, plain, slider_of, turn_to
from urdf_ik.support import palette
from urdf_ik.support.text import quoted
from urdf_ik.typing import Array

_BAR = np.linspace(0.0, 1.0, 400)
_BAR_HEIGHT = 12  # pixels
_POINT = 0.4  # a point's radius, as a share of a voxel's edge
_COLOUR, _OPACITY = (120, 120, 120), 0.25
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

    def __init__(self, found: WorkspaceMap, arm: Arm) -> None:
        require_map_of(found.about, arm)
        self.found, self.arm = found, arm
        held = found.names
        self.holds = tuple(name for name in VALUES if name in ("reach", "solutions") or name in held)
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


class MapView:
    """Widgets and points of a map; what the reader of the page changes is done in the order of ``put``.

    Attributes:
        voxels: the map.
        what: dropdown of the values, by their keys.
        axis: dropdown of the axes.
        slider: middle of the layer on that axis [m].
        outline: check box for the boundary.
        status: what the points are, in words.
        points: the points in the scene.
        boundary: the boundary in the scene; None until it is asked for.
        layer: what is shown.
    """

    def __init__(
        self,
        server: Any,
        voxels: Voxels,
        put: Callable[[Hashable, Callable[[], None]], None],
        *,
        what: str = "reach",
        axis: str | None = None,
        at: float | None = None,
    ) -> None:
        """Add everything, with the middle layer, or the one at ``at`` [m] of ``axis``.

        Raises:
            ArgumentError: the map does not hold ``what``.
        """
        voxels.values(what)
        gui, self._scene, self.voxels = server.gui, server.scene, voxels
        axis = voxels.across if axis is None else axis
        middles = voxels.coordinates(axis)
        middle = float(middles[len(middles) // 2]) if at is None else at
        self.boundary: Any = None
        self._removed = False
        self._folder = gui.add_folder("Workspace map", order=-0.5)
        with self._folder:
            self.status = gui.add_markdown("")
            bar = np.tile(palette.shades(_BAR), (_BAR_HEIGHT, 1, 1))
            self._bar = gui.add_image(bar, format="png")
            self.what = gui.add_dropdown("Value", voxels.holds, initial_value=what)
            self.axis = gui.add_dropdown("Layer across", tuple(AXES), initial_value=axis)
            self.slider = slider_of(gui, "at [m]", *self._ends())
            self.outline = gui.add_checkbox(
                "Boundary", False, hint="Faces between voxels that are reached and voxels that are not"
            )
        self.layer = self._draw(middle)
        turn_to(self.slider, self.layer.at)
        on_change(self.slider, lambda value: put((self, "layer"), lambda: self._try(lambda: self.show(value))))
        on_change(self.what, lambda _: put((self, "value"), lambda: self._try(self.show)))
        on_change(self.axis, lambda _: put((self, "axis"), lambda: self._try(self._turn)))
        on_change(self.outline, lambda _: put((self, "boundary"), lambda: self._try(self._outline)))

    def show(self, at: float | None = None) -> None:
        """Show the layer at ``at`` [m] of the axis that is chosen, without it the same layer again."""
        self.layer = self._draw(self.layer.at if at is None else at)

    def remove(self) -> None:
        """Take everything out of page and scene again."""
        self._removed = True
        self._folder.remove()
        self.points.remove()
        if self.boundary is not None:
            self.boundary.remove()

    def _try(self, step: Callable[[], None]) -> None:
        """Do what the page asks for, unless the map has gone meanwhile; a store that is damaged is said to be."""
        if self._removed:
            return
        try:
            step()
        except UrdfIkError as error:
            self.status.content = plain(str(error))

    def _ends(self) -> tuple[float, float]:
        middles = self.voxels.coordinates(self.axis.value)
        return float(middles[0]), float(middles[-1])

    def _turn(self) -> None:
        """Another axis: its middle layer."""
        low, high = self._ends()
        self.slider.min, self.slider.max = min(self.slider.min, low), max(self.slider.max, high)
        self.show(0.5 * (low + high))
        turn_to(self.slider, self.layer.at)
        self.slider.min, self.slider.max = low, max(high, low + self.slider.step)

    def _draw(self, at: float) -> Layer:
        what = self.what.value
        layer = self.voxels.layer(self.axis.value, at, what)
        self.points = self._scene.add_point_cloud(  # the same name takes the place of what was there
            "/map/layer", layer.points.astype(np.float32), layer.colours, point_shape="circle", precision="float32",
            point_size=_POINT * layer.every * self.voxels.found.grid.voxel, point_shading="flat",
        )  # fmt: skip
        thinned = f" One row in {layer.every} is shown." if layer.every > 1 else ""
        self.status.content = plain(
            f"{VALUES[what]}: 0 (dark) to {self.voxels.top(what):.3g} (light). {self.axis.value} = {layer.at:.3f} m: "
            f"{layer.reached} of {layer.voxels} voxels are reached.{thinned}"
        )
        return layer

    def _outline(self) -> None:
        if self.boundary is None and self.outline.value:
            mesh = self.voxels.boundary()
            self.boundary = self._scene.add_mesh_simple(
                "/map/boundary", mesh.vertices.astype(np.float32), mesh.faces.astype(np.uint32), color=_COLOUR,
                opacity=_OPACITY, flat_shading=True, side="double",
            )  # fmt: skip
        if self.boundary is not None:
            self.boundary.visible = self.outline.value
