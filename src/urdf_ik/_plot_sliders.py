"""Sliders for the joints, in a window of matplotlib or, with ipywidgets, in a notebook."""

from __future__ import annotations

import os
import sys
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.figure import Figure

from urdf_ik import _plot_axes as draw
from urdf_ik import _plot_shapes
from urdf_ik.errors import MissingPackage, PlotError

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

    from urdf_ik.arm import Arm

    Array = NDArray[np.float64]

_HALF_TURN = np.pi


class Sliders:
    """The arm with a slider for each joint; of two turning joints in a plane, the workspace with the arm in it.

    Attributes:
        figure: the picture; on a window's canvas where one was asked for.
        sliders: one a joint, in degrees for joints that turn, else in m. Keep this object as long as they are used.
    """

    def __init__(self, arm: Arm, figure: Figure, q: ArrayLike | None = None) -> None:
        """Draw the arm and its sliders into ``figure``."""
        from matplotlib.widgets import Slider

        self._arm, self.figure = arm, figure
        self.q: Array = draw.posture(arm, q).copy()
        self._scale = np.where(arm.chain.prismatic, 1.0, 180.0 / np.pi)
        share = min(0.6, 0.06 * arm.dof + 0.06)
        self._draw(figure, (0.1, share + 0.08, 0.86, 0.84 - share))
        self.sliders = []
        for i, name in enumerate(arm.joint_names):
            lower, upper = slider_range(arm, i)
            place = figure.add_axes((0.2, share - 0.06 * i - 0.05, 0.62, 0.035))
            unit = "m" if arm.chain.prismatic[i] else "°"
            slider = Slider(
                place, name, self._scale[i] * lower, self._scale[i] * upper, valinit=self._scale[i] * self.q[i],
                valfmt=f"%.3g {unit}",
            )  # fmt: skip
            slider.on_changed(self._changed)
            self.sliders.append(slider)

    def _draw(self, figure: Figure, place: tuple[float, float, float, float]) -> None:
        from urdf_ik import workspace

        arm = self._arm
        if is_two_links(arm):
            self._region = workspace.planar(arm)
            axes = figure.add_axes(place)
            draw.regions(axes, self._region)
            self._line = draw.two_links(axes, self._region, self.q)
            axes.legend(loc="upper left", fontsize=7)
            self._set = self._set_planar
        else:
            middle, half = arm.chain.points[0], arm.chain.size
            axes = draw.space(figure.add_axes(place, projection="3d"), (middle, half))
            self._line = draw.stick(axes, arm, self.q, "tab:blue")
            self._set = self._set_spatial
        axes.set_title(arm.name)

    def _changed(self, _: float) -> None:
        self.q = np.array([slider.val for slider in self.sliders]) / self._scale
        self._set()
        self.figure.canvas.draw_idle()

    def _set_planar(self) -> None:
        self._line.set_data(*draw.links(self._region, self.q))

    def _set_spatial(self) -> None:
        self._line.set_data_3d(*_plot_shapes.stick(self._arm, self.q).T)


def sliders(arm: Arm, q: ArrayLike | None = None, *, window: bool = True) -> Sliders:
    """The arm with a slider for each joint, in a window that stays open until ``matplotlib.pyplot.show`` returns.

    Args:
        arm: the arm.
        q: (n,) rad or m, where the sliders begin; default: zero, or the nearest to it within the limits.
        window: open one; else a figure to be saved.

    Raises:
        PlotError: there is no display to open a window on.
    """
    size = (6.4, 6.0 + 0.25 * arm.dof)
    if not window:
        return Sliders(arm, Figure(figsize=size), q)
    require_display()
    from matplotlib import pyplot

    return Sliders(arm, pyplot.figure(figsize=size), q)


def show(figure: Figure) -> None:
    """Show a figure in a window, and wait until it is closed.

    Raises:
        PlotError: there is no display.
    """
    require_display()
    import matplotlib
    from matplotlib import pyplot
    from matplotlib.backends.registry import backend_registry

    if figure.canvas.manager is not None:
        pyplot.show()
        return
    canvas = backend_registry.load_backend_module(matplotlib.get_backend()).FigureCanvas  # type: ignore[no-untyped-call]
    manager = canvas.new_manager(figure, 1)
    manager.show()
    manager.start_main_loop()


def interact(arm: Arm, q: ArrayLike | None = None) -> Any:
    """Sliders in a notebook: the picture drawn anew at every move.

    Raises:
        MissingPackage: ipywidgets is not installed.
    """
    try:
        import ipywidgets
    except ImportError:
        raise MissingPackage("sliders in a notebook need ipywidgets: pip install ipywidgets") from None
    from urdf_ik import plot, workspace

    start = draw.posture(arm, q)
    region = workspace.planar(arm) if is_two_links(arm) else None

    def picture(**values: float) -> Figure:
        at = np.array(list(values.values()))
        return plot.arm(arm, at, shapes=False) if region is None else plot.planar_workspace(region, at)

    ranges = [slider_range(arm, i) for i in range(arm.dof)]
    controls = {
        name: ipywidgets.FloatSlider(value=start[i], min=ranges[i][0], max=ranges[i][1], step=0.01, description=name)
        for i, name in enumerate(arm.joint_names)
    }
    return ipywidgets.interactive(picture, **controls)


def slider_range(arm: Arm, joint: int) -> tuple[float, float]:
    """Limits of a joint, half a turn or a metre where there is none."""
    far = 1.0 if arm.chain.prismatic[joint] else _HALF_TURN
    lower, upper = arm.limits[joint]
    return (float(lower) if np.isfinite(lower) else -far), (float(upper) if np.isfinite(upper) else far)


def is_two_links(arm: Arm) -> bool:
    """Whether the exact workspace of two turning joints can be drawn."""
    return arm.plane is not None and arm.dof == 2 and not arm.chain.prismatic.any()


def require_display() -> None:
    """Refuse a window where none can be opened.

    Raises:
        PlotError: there is no display, or matplotlib was told to draw without one.
    """
    import matplotlib
    from matplotlib.backends.registry import BackendFilter, backend_registry

    if sys.platform.startswith("linux") and not (os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY")):
        raise PlotError("there is no display to open a window on; write a file instead, with --output or plot.save")
    backend = matplotlib.get_backend().lower()
    if backend not in backend_registry.list_builtin(BackendFilter.INTERACTIVE):  # type: ignore[no-untyped-call]
        raise PlotError(
            f"matplotlib draws with {backend!r}, which opens no windows; install a toolkit such as PyQt6, or write a "
            "file instead, with --output or plot.save"
        )
