"""Windows of pictures, and sliders for the joints in a notebook."""

from __future__ import annotations

import os
import signal
import sys
import threading
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from urdf_ik.arm import Arm
from urdf_ik.errors import ArgumentError
from urdf_ik.ik.solutions import limits
from urdf_ik.show import shapes as looks
from urdf_ik.show.plot import axes as draw
from urdf_ik.support import extras
from urdf_ik.typing import Array

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_WIDE, _HIGH = 6.4, 5.6
"""The picture [inches]."""
_INSTEAD = "write a file instead, with --output or plot.save"
_LEAST = 1e-3
"""Range [deg or m] of a slider whose joint has none."""


class _Stage:
    """The arm in a figure, to be moved; two turning joints in a plane stand in their workspace.

    Attributes:
        axes: what it is drawn in.
    """

    def __init__(self, arm: Arm, figure: Figure, place: tuple[float, float, float, float], q: Array) -> None:
        """Draw the arm at ``q`` (n,) rad or m, in the part ``place`` of the figure."""
        from urdf_ik.maps import workspaces

        self._arm = arm
        self._region = workspaces.planar(arm) if is_two_links(arm) else None
        if self._region is not None:
            self.axes = figure.add_axes(place)
            draw.regions(self.axes, self._region)
            self._line = draw.two_links(self.axes, self._region, q)
            self.axes.legend(loc="upper left", fontsize=7)
        else:
            around = draw.box(looks.surroundings(arm, limits.drawn(arm.limits, ~arm.chain.prismatic)))
            self.axes = draw.space(figure.add_axes(place, projection="3d"), around)
            self._line = draw.stick(self.axes, arm, q, "tab:blue")
        self.axes.set_title(draw.words(arm.name))

    def move(self, q: Array) -> None:
        """Move the arm to ``q`` (n,) rad or m."""
        if self._region is not None:
            self._line.set_data(*draw.links(self._region, q))
        else:
            self._line.set_data_3d(*looks.stick(self._arm.chain, q).T)


def show(figure: Figure) -> None:
    """Show a figure in a window, and wait until it is closed.

    Raises:
        ArgumentError: there is no display.
    """
    if figure.canvas.manager is None:
        titles = [figure.get_suptitle(), *(axes.get_title() for axes in figure.axes)]
        _open(figure, next(filter(None, titles), "").replace(r"\$", "$"))
    from matplotlib import pyplot

    interrupted = []

    def interrupt(*_: object) -> None:
        interrupted.append(True)
        pyplot.close(figure)

    # Tk hears of Ctrl-C when its window is touched, and prints what is raised there: the timer wakes it, and the
    # interrupt is raised when the window is gone.
    timer = figure.canvas.new_timer(interval=200)
    timer.add_callback(lambda: None)
    timer.start()
    here = threading.current_thread() is threading.main_thread()
    before = signal.signal(signal.SIGINT, interrupt) if here else None
    try:
        pyplot.show(block=True)
    finally:
        timer.stop()
        if here:
            signal.signal(signal.SIGINT, before)
    if interrupted:
        raise KeyboardInterrupt


def _open(figure: Figure, title: str) -> None:
    """Put a figure into a window that ``pyplot.show`` shows."""
    canvas = require_display()
    from matplotlib import pyplot
    from matplotlib._pylab_helpers import Gcf

    try:
        manager = canvas.new_manager(figure, max(pyplot.get_fignums(), default=0) + 1)
    except Exception as error:  # each toolkit has its own way of saying that the display does not answer
        raise ArgumentError(f"no window can be opened: {error}; {_INSTEAD}") from None
    manager.set_window_title(f"urdf-ik: {title}")
    # A toolkit's main loop ends at once where pyplot knows of no window.
    Gcf.set_active(manager)


def interact(arm: Arm, q: ArrayLike | None = None) -> Any:
    """Sliders in a notebook: the picture drawn anew at every move.

    Args:
        arm: the arm.
        q: (n,) rad or m within the limits, where the sliders begin; default: zero, or the nearest to it.

    Raises:
        ArgumentError: ``q`` does not fit the arm, or is outside the limits.
        MissingPackage: ipywidgets is not installed.
    """
    try:
        import ipywidgets
    except ImportError:
        raise extras.missing("sliders in a notebook need ipywidgets", "notebooks") from None
    first, scale = start(arm, q), scales(arm)
    figure = draw.Picture(figsize=(_WIDE, _HIGH))
    stage = _Stage(arm, figure, (0.12, 0.1, 0.84, 0.84), first)

    def picture(**values: float) -> Figure:
        stage.move(np.array(list(values.values())) / scale)
        return figure

    controls = {
        name: ipywidgets.FloatSlider(
            value=scale[i] * first[i],
            min=lower,
            max=upper,
            step=0.001 if arm.chain.prismatic[i] else 0.5,
            description=f"{name} [{unit(arm, i)}]",
            style={"description_width": "initial"},
        )
        for i, (name, (lower, upper)) in enumerate(zip(arm.joint_names, ranges(arm, first), strict=True))
    }
    return ipywidgets.interactive(picture, **controls)


def scales(arm: Arm) -> Array:
    """(n,) what joint values in rad or m are multiplied by to be shown: degrees and m."""
    return np.where(arm.chain.prismatic, 1.0, 180.0 / np.pi)


def unit(arm: Arm, joint: int) -> str:
    """Unit in which a joint is shown."""
    return "m" if arm.chain.prismatic[joint] else "°"


def start(arm: Arm, q: ArrayLike | None) -> Array:
    """Where the sliders begin, (n,) rad or m: a slider cannot stand outside its joint's limits.

    Raises:
        ArgumentError: ``q`` does not fit the arm, or is outside the limits.
    """
    first = draw.posture(arm, q)
    limits.check_inside(first, arm.limits, arm.joint_names, "sliders begin inside them")
    return first


def ranges(arm: Arm, q: Array) -> list[tuple[float, float]]:
    """The ends of each joint's slider, degrees or m; where a limit is missing, ``q`` (n,) rad or m is within them."""
    low, high = limits.drawn(arm.limits, ~arm.chain.prismatic).T
    ends = scales(arm)[:, None] * np.stack([np.minimum(low, q), np.maximum(high, q)], axis=-1)
    return [(float(lower), float(max(upper, lower + _LEAST))) for lower, upper in ends]


def is_two_links(arm: Arm) -> bool:
    """Whether the exact workspace of two turning joints can be drawn."""
    return arm.solver.control.plane is not None and arm.dof == 2 and not arm.chain.prismatic.any()


def require_display() -> Any:
    """The class of the canvas that a window has.

    Raises:
        ArgumentError: there is no display, or matplotlib is set to draw without one, or it lacks its toolkit.
    """
    import matplotlib
    from matplotlib.backends.registry import BackendFilter, backend_registry

    display = os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY")
    if sys.platform.startswith("linux") and not display:
        raise ArgumentError(f"there is no display to open a window on; {_INSTEAD}")
    backend = matplotlib.get_backend().lower()
    if backend not in backend_registry.list_builtin(BackendFilter.INTERACTIVE):  # type: ignore[no-untyped-call]
        raise ArgumentError(
            f"matplotlib draws with {backend!r}, which opens no windows: it is set to, no toolkit such as PyQt6 is "
            f"installed, or the display {display or ''} does not answer; {_INSTEAD}"
        )
    try:
        return backend_registry.load_backend_module(backend).FigureCanvas  # type: ignore[no-untyped-call]
    except ImportError as error:
        raise ArgumentError(f"matplotlib cannot open windows with {backend!r}: {error}; {_INSTEAD}") from None
