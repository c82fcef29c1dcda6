"""What the pictures are made of: axes in space, stick figures, shapes, frames and planar regions."""

import io
from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from matplotlib.patches import PathPatch
from matplotlib.path import Path
from mpl_toolkits.mplot3d.art3d import Poly3DCollection
from numpy.typing import ArrayLike

from urdf_ik.arm import Arm
from urdf_ik.cell import World
from urdf_ik.cell.shapes import Points
from urdf_ik.errors import ArgumentError
from urdf_ik.maps.workspaces import PlanarWorkspace, Region
from urdf_ik.show import shapes as looks
from urdf_ik.support import palette
from urdf_ik.typing import Array

_FRAME = ("tab:red", "tab:green", "tab:blue")
_BLUE, _, OVERLAP_COLOUR, _, _ORANGE = palette.colours(5)
REGION_COLOURS = {"elbow left": _BLUE, "elbow right": _ORANGE}


class Picture(Figure):
    """A figure that a notebook shows by itself, whether or not anything there has imported pyplot."""

    def _repr_png_(self) -> bytes:
        buffer = io.BytesIO()
        self.savefig(buffer, format="png")
        return buffer.getvalue()


def words(text: str) -> str:
    """``text`` as it is: a dollar sign, which names in files of unknown origin may hold, would begin a formula."""
    return text.replace("$", r"\$")


def posture(arm: Arm, q: ArrayLike | None) -> Array:
    """``q`` as a joint vector (n,); where it is None, the one nearest to zero within the limits."""
    if q is not None:
        vector = arm.chain.check(q)
        if vector.shape != (arm.dof,):
            raise ArgumentError(f"joint vectors of shape {vector.shape} given; one ({arm.dof},) is drawn")
        return vector
    lower, upper = arm.limits.T
    return np.clip(np.zeros(arm.dof), lower, upper)


def colours(branches: Sequence[str]) -> dict[str, Any]:
    """A colour for each branch, the same one in every picture."""
    return dict(zip(branches, palette.colours(len(branches)), strict=True))


def box(points: Array) -> tuple[Array, float]:
    """Middle (3,) and half the edge [m] of a cube that holds points (..., 3) m."""
    flat = points.reshape(-1, 3)
    low, high = flat.min(axis=0), flat.max(axis=0)
    return 0.5 * (low + high), 0.55 * float((high - low).max()) or 1.0


def space(axes: Any, around: tuple[Array, float], *, small: bool = False) -> Any:
    """Axes in space over a cube, all three to the same scale."""
    middle, half = around
    axes.set(xlim=(middle[0] - half, middle[0] + half), ylim=(middle[1] - half, middle[1] + half))
    axes.set(zlim=(middle[2] - half, middle[2] + half))
    # Constrained layout leaves no room for what stands beside the cube.
    axes.set_box_aspect((1, 1, 1), zoom=1.0 if small else 0.88)
    axes.locator_params(nbins=3 if small else 5)
    axes.tick_params(labelsize=6 if small else 7, pad=-3 if small else 0)
    for name in "xyz":
        getattr(axes, f"set_{name}label")(f"{name} [m]", fontsize=6 if small else 9, labelpad=-9 if small else 2)
    return axes


def stick(axes: Any, arm: Arm, q: Array, colour: Any, label: str | None = None) -> Any:
    """The links of the chain as lines from frame to frame; gives the line."""
    points = looks.stick(arm.chain, q).T
    (line,) = axes.plot(*points, "-o", color=colour, linewidth=2.0, markersize=3.5, label=label)
    return line


def shapes(axes: Any, triangles: Iterable[Array], colour: Any = "tab:gray", alpha: float = 0.35) -> None:
    """The bodies of the links, by their triangles (k, 3, 3) m."""
    for body in triangles:
        axes.add_collection3d(Poly3DCollection(body, facecolors=colour, alpha=alpha, shade=True))


def obstacles(axes: Any, world: World | None, half: float) -> None:
    """The obstacles of a world, in axes over a cube of half the edge ``half`` [m]."""
    for each in world or ():
        if isinstance(each.shape, Points):
            axes.scatter(*(each.pose[:3, :3] @ each.shape.points.T + each.pose[:3, 3:]), color="0.5", s=2)
        else:
            corners = np.asarray(looks.triangles(each.shape, 0.5 * half).triangles)
            shapes(axes, [corners @ each.pose[:3, :3].T + each.pose[:3, 3]], "0.6", 0.3)


def frame(axes: Any, T: Array, size: float) -> None:
    """The axes of a pose (4, 4), x, y and z in red, green and blue."""
    for column, colour in enumerate(_FRAME):
        axes.plot(*np.stack([T[:3, 3], T[:3, 3] + size * T[:3, column]], axis=-1), color=colour, linewidth=1)


def is_two_links(arm: Arm) -> bool:
    """Whether the exact workspace of two turning joints can be drawn."""
    return arm.solver.control.plane is not None and arm.dof == 2 and not arm.chain.prismatic.any()


def regions(axes: Any, region: PlanarWorkspace) -> None:
    """Both elbows' regions, their overlap, and the outer boundary."""
    for name, part in region.regions.items():
        _fill(axes, part, facecolor=REGION_COLOURS[name], alpha=0.4, edgecolor="none", label=name)
    _fill(axes, region.overlap, facecolor=OVERLAP_COLOUR, edgecolor="none", label="both elbows")
    _fill(axes, region.boundary, facecolor="none", edgecolor="0.1", linewidth=1.2, label="boundary")
    reach = 1.08 * float(region.lengths.sum())
    x, y = region.centre
    axes.set(xlim=(x - reach, x + reach), ylim=(y - reach, y + reach), aspect="equal")
    names = ["xyz"[int(np.argmax(np.abs(axis)))] for axis in region.plane.axes]
    axes.set(xlabel=f"{names[0]} [m]", ylabel=f"{names[1]} [m]")
    axes.locator_params(nbins=6)


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
