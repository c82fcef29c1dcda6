"""Pictures of an arm, its branches, limits, workspace and paths, by matplotlib.

>>> import urdf_ik
>>> from urdf_ik.show import plot
>>> arm = urdf_ik.load("zyyzyz_6r")
>>> figure = plot.branches(arm.ik(arm.fk([0.3, -0.5, 0.8, 0.4, 0.7, -0.2])))
>>> plot.save(figure, "all_branches.png")

``plot.path(arm.follow(T))`` draws a path, found or not. Every function returns a ``matplotlib.figure.Figure`` that no
window knows of: it is drawn without a display, and a notebook shows it. ``interact`` has sliders in a notebook.
"""

from urdf_ik.errors import ArgumentError
from urdf_ik.support import extras

try:
    import matplotlib as _  # noqa: F401
except ImportError:
    raise extras.missing("pictures need matplotlib", "plot") from None
except ValueError as error:  # the environment names a backend that there is not
    raise ArgumentError(f"matplotlib does not start: {error}") from None

from urdf_ik.show.plot.pictures import (
    SUFFIXES,
    arm,
    branches,
    interact,
    intervals,
    limits,
    placements,
    planar_workspace,
    save,
    workspace_slice,
)
from urdf_ik.show.plot.waypoints import path

__all__ = [
    "SUFFIXES",
    "arm",
    "branches",
    "interact",
    "intervals",
    "limits",
    "path",
    "placements",
    "planar_workspace",
    "save",
    "workspace_slice",
]
