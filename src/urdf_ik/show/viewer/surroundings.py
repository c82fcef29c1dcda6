"""The arm's surroundings in viser's scene: the obstacles of a world, and the path of a plan."""

from typing import Any

import numpy as np

from urdf_ik.cell import World
from urdf_ik.cell.shapes import HalfSpace, Points, Shape
from urdf_ik.errors import ArgumentError
from urdf_ik.model.poses import to_quat_wxyz
from urdf_ik.paths.planned_motion import Plan
from urdf_ik.show.shapes import half_extents, triangles
from urdf_ik.typing import Array

_COLOUR, _OPACITY = (150, 140, 125), 0.75
_PLANE_OPACITY = 0.35
_FOUND, _MISSED = (30, 30, 30), (214, 39, 40)


_FAR = 3.0
"""Obstacles, and corners of them, within so many sizes of the arm are looked at."""
_CORNERS = np.array([[x, y, z] for x in (-1.0, 1.0) for y in (-1.0, 1.0) for z in (-1.0, 1.0)])


def points_beside(plan: Plan | None, world: World | None, size: float) -> Array | None:
    """Points (k, 3) [m] that a camera is to see besides the arm: waypoints, and the corners of near obstacles.

    None without any; ``size`` is the arm's [m].
    """
    points = [] if plan is None else [plan.poses[:, :3, 3]]
    for each in world or ():
        if not isinstance(each.shape, HalfSpace) and np.linalg.norm(each.pose[:3, 3]) < _FAR * size:
            corners = each.pose[:3, 3] + (_CORNERS * half_extents(each.shape)) @ each.pose[:3, :3].T
            points.append(corners[np.linalg.norm(corners, axis=1) < _FAR * size])
    return np.concatenate(points) if points else None


class Obstacles:
    """A world in the scene; what is moved, added or removed there is shown with the next :meth:`update`.

    Attributes:
        handles: by the obstacle's name.
        missing: a sentence for each mesh that cannot be read.
    """

    def __init__(self, scene: Any, world: World | None, size: float) -> None:
        """Show ``world``; ``size`` is the arm's [m], which a half-space is drawn around."""
        self._scene, self._world, self._size = scene, world, size
        self._shapes: dict[str, Shape] = {}
        self._version: int | None = None
        self.handles: dict[str, Any] = {}
        self.missing: dict[str, str] = {}
        self.update()

    def update(self) -> None:
        """Show the world as it is now."""
        if self._world is None or self._world.version == self._version:
            return
        self._version = self._world.version
        there = {each.name: each for each in self._world}
        for name in [name for name in self._shapes if name not in there or there[name].shape is not self._shapes[name]]:
            self._remove(name)
        for each in there.values():
            if each.name not in self._shapes:
                self._shapes[each.name] = each.shape
                try:
                    self.handles[each.name] = self._add(f"/world/{len(self._shapes)}_{self._version}", each.shape)
                except ArgumentError as error:
                    self.missing[each.name] = str(error)
            if each.name in self.handles:
                handle, T = self.handles[each.name], each.pose
                handle.position, handle.wxyz = T[:3, 3], to_quat_wxyz(T)

    def remove(self) -> None:
        """Take everything out of the scene again."""
        for name in list(self._shapes):
            self._remove(name)

    def _remove(self, name: str) -> None:
        del self._shapes[name]
        self.missing.pop(name, None)
        if name in self.handles:
            self.handles.pop(name).remove()

    def _add(self, path: str, shape: Shape) -> Any:
        if isinstance(shape, Points):
            return self._scene.add_point_cloud(
                path, shape.points.astype(np.float32), _COLOUR, point_size=2.0 * shape.radius, point_shape="circle",
                precision="float32",
            )  # fmt: skip
        mesh = triangles(shape, self._size)
        plane = isinstance(shape, HalfSpace)
        return self._scene.add_mesh_simple(
            path, np.asarray(mesh.vertices, dtype=np.float32), np.asarray(mesh.faces, dtype=np.uint32), color=_COLOUR,
            opacity=_PLANE_OPACITY if plane else _OPACITY, flat_shading=True, side="double",
        )  # fmt: skip


def add_path(scene: Any, plan: Plan) -> Any:
    """The way of the tip from waypoint to waypoint; red without a plan."""
    points = plan.poses[:, :3, 3]
    pieces = np.stack([points[:-1], points[1:]], axis=1) if len(points) > 1 else np.repeat(points[None], 2, axis=1)
    shades = np.broadcast_to(np.array(_FOUND if plan.found else _MISSED, dtype=np.uint8), pieces.shape)
    return scene.add_line_segments("/path", pieces.astype(np.float32), shades, thickness=4.0, thickness_units="screen")
