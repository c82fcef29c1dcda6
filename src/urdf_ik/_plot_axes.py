"""What the pictures are made of: axes in space, stick figures, shapes, frames and planar regions."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib import colormaps
from matplotlib.patches import PathPatch
from matplotlib.path import Path
from mpl_toolkits.mplot3d.art3d import Poly3DCollection

from urdf_ik import _plot_shapes

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from numpy.typing import ArrayLike, NDArray

    from urdf_ik.arm import Arm
    from urdf_ik.workspace import PlanarWorkspace, Region

    Array = NDArray[np.float64]

_FRAME = ("tab:red", "tab:green", "tab:blue")
REGION_COLOURS = {"elbow left": "tab:blue", "elbow right": "tab:orange"}


def posture(arm: Arm, q: ArrayLike | None) -> Array:
    """``q`` as a joint vector (n,); where it is None, the one nearest to zero within the limits."""
    if q is not None:
        return arm.chain.check(np.asarray(q)).reshape(arm.dof)
    lower, upper = arm.limits.T
    return np.clip(np.zeros(arm.dof), lower, upper)


def colours(branches: Sequence[str]) -> dict[str, Any]:
    """A colour for each branch, the same one in every picture."""
    palette = colormaps["tab10" if len(branches) <= 10 else "tab20"]
    return {name: palette(k % palette.N) for k, name in enumerate(branches)}


def box(arm: Arm, vectors: Iterable[Array]) -> tuple[Array, float]:
    """Middle (3,) and half the edge [m] of a cube that holds the arm's stick figures, and the base."""
    points = np.concatenate([_plot_shapes.stick(arm, q) for q in vectors])
    low, high = points.min(axis=0), points.max(axis=0)
    return 0.5 * (low + high), 0.55 * float((high - low).max()) or arm.chain.size


def space(axes: Any, around: tuple[Array, float], *, small: bool = False) -> Any:
    """Axes in space over a cube, all three to the same scale."""
    middle, half = around
    axes.set(xlim=(middle[0] - half, middle[0] + half), ylim=(middle[1] - half, middle[1] + half))
    axes.set(zlim=(middle[2] - half, middle[2] + half), box_aspect=(1, 1, 1))
    axes.locator_params(nbins=3 if small else 5)
    axes.tick_params(labelsize=5 if small else 7, pad=-2 if small else 1)
    if not small:
        axes.set(xlabel="x [m]", ylabel="y [m]", zlabel="z [m]")
    return axes


def stick(axes: Any, arm: Arm, q: Array, colour: Any, label: str | None = None) -> Any:
    """The links of the chain as lines from frame to frame; gives the line."""
    (line,) = axes.plot(*_plot_shapes.stick(arm, q).T, "-o", color=colour, linewidth=2, markersize=3, label=label)
    return line


def shapes(axes: Any, arm: Arm, q: Array, colour: Any = "tab:gray") -> list[Any]:
    """The boxes, cylinders and spheres of the links; gives the collections, one a shape."""
    drawn = []
    for _, polygons in _plot_shapes.faces(arm, q):
        drawn.append(Poly3DCollection(polygons, facecolors=colour, alpha=0.35, shade=True))
        axes.add_collection3d(drawn[-1])
    return drawn


def frame(axes: Any, T: Array, size: float) -> None:
    """The axes of a pose (4, 4), x, y and z in red, green and blue."""
    for column, colour in enumerate(_FRAME):
        axes.plot(*np.stack([T[:3, 3], T[:3, 3] + size * T[:3, column]], axis=-1), color=colour, linewidth=1)


def regions(axes: Any, region: PlanarWorkspace) -> None:
    """Both elbows' regions, their overlap hatched, and the outer boundary."""
    for name, part in region.regions.items():
        _fill(axes, part, facecolor=REGION_COLOURS[name], alpha=0.35, edgecolor="none", label=name)
    _fill(axes, region.overlap, facecolor="none", edgecolor="0.3", hatch="////", linewidth=0.0, label="both elbows")
    _fill(axes, region.boundary, facecolor="none", edgecolor="0.1", linewidth=1.2, label="boundary")
    reach = 1.08 * float(region.lengths.sum())
    x, y = region.centre
    axes.set(xlim=(x - reach, x + reach), ylim=(y - reach, y + reach), aspect="equal")
    names = ["xyz"[int(np.argmax(np.abs(axis)))] for axis in region.plane.axes]
    axes.set(xlabel=f"{names[0]} [m]", ylabel=f"{names[1]} [m]")


def two_links(axes: Any, region: PlanarWorkspace, q: Array) -> Any:
    """The two links at ``q`` (2,) rad; gives the line."""
    (line,) = axes.plot(*links(region, q), "-o", color="0.1", linewidth=3, markersize=6, label="arm")
    return line


def links(region: PlanarWorkspace, q: Array) -> tuple[Array, Array]:
    """X and y (3,) m of the first axis, the second one and the tip."""
    points = np.stack([region.centre, region.elbow(q), region.tip(q)])
    return points[:, 0], points[:, 1]


def _fill(axes: Any, part: Region, **style: Any) -> None:
    """One patch of a region with its holes: their outlines run the other way round."""
    loops = part.loops()
    if not loops:
        return
    outline = Path.make_compound_path(*[Path(np.vstack([loop, loop[:1]]), closed=True) for loop in loops])
    axes.add_patch(PathPatch(outline, **style))
