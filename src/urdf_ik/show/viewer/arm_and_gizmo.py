"""The arm, its ghosts and the target in viser's scene; :class:`Drawing` mirrors a State and decides nothing."""

from typing import Any

import numpy as np
import trimesh
from numpy.typing import NDArray

from urdf_ik.arm import Arm
from urdf_ik.model import link_shapes
from urdf_ik.model.poses import to_quat_wxyz
from urdf_ik.show.viewer.state import State
from urdf_ik.support import palette
from urdf_ik.typing import Array

_OPACITY = 0.4
# rad, and share of the arm's size, by which links of two solutions differ that are not in the same place.
_SAME = 1e-6
# Where the camera stands, as seen from the arm; how far the arm is left of the middle, where the panel is not; and what
# is around the frames of the links [share of the arm's size], which is the links themselves.
_FROM, _ASIDE, _AROUND = np.array([0.6, -0.75, 0.35]), 0.22, 0.12
# Faces that a ghost's link has at most: there may be sixteen of them.
_MOST_FACES = 4000
_ABOVE = 0.45
"""Share of a narrow window's height that the panel below leaves for the arm."""
_LINE = (40, 40, 40)
_NAMED = 2
"""Greatest number of shapes that could not be read which the page names one by one."""


def colours(count: int) -> tuple[tuple[int, int, int], ...]:
    """``count`` colours, red, green, blue from 0 to 255: those of every picture, see :mod:`urdf_ik.support.palette`."""
    return tuple((round(255 * r), round(255 * g), round(255 * b)) for r, g, b in palette.colours(count))


class Drawing:
    """An arm in the scene of a viser server.

    Attributes:
        root: the frame that holds arm and ghosts.
        target: the handles that are dragged.
        bodies: link and handle of each of the arm's own shapes.
        ghosts: link and handle of the shapes of all ghosts: an instance for each branch.
        lines: handles of the lines along the links, the arm's own first; empty where all shapes are drawn.
        missing: a sentence for each shape that could not be read.
        has_shapes: whether any link has a shape; where it has not, or lacks some, there are frames and lines.
    """

    def __init__(self, scene: Any, arm: Arm) -> None:
        """Add everything, at the arm's zero configuration."""
        self._arm, self._scene, count = arm, scene, len(arm.structure.branches)
        self._capacity = max(count, 1)
        self._colours = np.array(colours(self._capacity), dtype=np.uint8)
        shapes, self.missing = link_shapes.read(arm.model)
        self.has_shapes = bool(shapes)
        self.root = scene.add_frame("/robot", show_axes=False)
        self._size = arm.chain.size
        self.lines: list[Any] = []
        self.bodies: list[tuple[str, Any]] = []
        self._forms: dict[str, trimesh.Trimesh] = {}
        self._edges = [
            (joint.parent, joint.child) for joint in arm.model.joints if np.linalg.norm(joint.origin[:3, 3]) > 0.0
        ]
        for k, (link, mesh) in enumerate(shapes):
            self.bodies.append((link, scene.add_mesh_trimesh(f"/robot/body_{k}", mesh)))
        moving = self._moving()
        for link in dict.fromkeys(link for link, _ in shapes if link in moving):
            whole = link_shapes.joined([mesh for carrier, mesh in shapes if carrier == link])
            self._forms[link] = link_shapes.simplified(whole, _MOST_FACES)
        self.ghosts = self._add_ghosts()
        self._axes: Any = None
        if self.missing or not self.has_shapes:
            self._add_lines()
        scene.add_frame("/robot/base", axes_length=0.15 * self._size, axes_radius=0.004 * self._size)
        self._tip = scene.add_frame("/robot/tip", axes_length=0.12 * self._size, axes_radius=0.004 * self._size)
        self.target = scene.add_transform_controls("/target", scale=0.3 * self._size, depth_test=False)

    def show(self, state: State, *, keep_target: bool = False) -> None:
        """Move everything to where ``state`` says.

        Args:
            state: what to show.
            keep_target: leave the handles alone, as they are being dragged.
        """
        drawn = state.drawn
        poses = self._arm.link_poses(np.stack([state.q, *(ghost.q for ghost in drawn)]))
        for link, handle in self.bodies:
            _place(handle, poses[link][0])
        _place(self._tip, poses[self._arm.tip][0])
        columns = [ghost.column for ghost in drawn]
        for link, handle in self.ghosts:
            # Two bodies in the same place would flicker: the arm goes before its ghosts, and the first of them.
            new = np.flatnonzero(_first_of_their_kind(poses[link], _SAME * self._size)[1:])
            self._place_ghosts(handle, [columns[k] for k in new], poses[link][1 + new])
        if self.lines:
            self._place_lines(self.lines, [0, *(1 + column for column in columns)], poses)
            here = np.stack([poses[link][0] for link in self._arm.model.links])
            self._axes.batched_positions = here[:, :3, 3].astype(np.float32)
            self._axes.batched_wxyzs = to_quat_wxyz(here).astype(np.float32)
        if not keep_target:
            _place(self.target, state.target)

    @property
    def unseen(self) -> list[str]:
        """That there are frames and lines for want of shapes, and why some cannot be read; of many the first ones."""
        lines: list[str] = []
        if not self.has_shapes:
            lines.append("No link has a shape that can be shown: the arm is drawn as frames and lines.")
        elif self.missing:
            lines.append("Not all shapes can be shown: frames and lines are drawn, too.")
        lines += self.missing[:_NAMED]
        return [*lines, f"and {len(self.missing) - _NAMED} more"] if len(self.missing) > _NAMED else lines

    def camera(
        self, state: State, fov: float, aspect: float | None = None, beside: Array | None = None
    ) -> tuple[Array, Array]:
        """Where a camera stands, and what it looks at, to see the arm and its ghosts beside the panel.

        Args:
            state: what is shown.
            fov: angle of view from bottom to top [rad].
            aspect: width of the window as a share of its height; a narrow one has the panel below. Default: a wide one.
            beside: (k, 3) m, what else is to be seen: waypoints, and obstacles.
        """
        poses = self._arm.link_poses(np.stack([state.q, *(ghost.q for ghost in state.ghosts)]))
        points = np.concatenate([poses[link].reshape(-1, 4, 4)[:, :3, 3] for link in self._arm.model.links])
        if beside is not None:
            points = np.concatenate([points, beside])
        middle = 0.5 * (points.min(axis=0) + points.max(axis=0))
        radius = float(np.linalg.norm(points - middle, axis=1).max()) + _AROUND * self._size
        towards = -_FROM / np.linalg.norm(_FROM)
        aside = np.cross(towards, [0.0, 0.0, 1.0])
        aside /= np.linalg.norm(aside)
        if aspect is None or aspect >= 1.0:
            distance = radius / np.sin(0.5 * fov)
            middle = middle + _ASIDE * distance * aside
        else:
            half = np.tan(0.5 * fov)
            distance = radius / np.sin(np.arctan(half * min(aspect, _ABOVE)))
            middle = middle - (1.0 - _ABOVE) * half * distance * np.cross(aside, towards)
        return middle - distance * towards, middle

    def remove(self) -> None:
        """Take everything out of the scene again."""
        self.root.remove()
        self.target.remove()

    def _moving(self) -> set[str]:
        """Links that the joints move: the others stand where the arm's own do."""
        poses = self._arm.link_poses(np.stack([np.zeros(self._arm.dof), np.ones(self._arm.dof)]))
        return {link for link, (first, second) in poses.items() if not np.array_equal(first, second)}

    def _add_ghosts(self) -> list[tuple[str, Any]]:
        """Each moving link as many times as there are branches, in their colours and of no size yet."""
        return [
            (
                link,
                self._scene.add_batched_meshes_simple(
                    f"/robot/ghosts_{k}",
                    one.vertices,
                    one.faces,
                    np.tile([1.0, 0.0, 0.0, 0.0], (self._capacity, 1)),
                    np.zeros((self._capacity, 3)),
                    batched_scales=np.zeros(self._capacity),
                    batched_colors=self._colours,
                    opacity=_OPACITY,
                    lod="off",
                    cast_shadow=False,
                    receive_shadow=False,
                ),
            )
            for k, (link, one) in enumerate(self._forms.items())
        ]

    def _place_ghosts(self, handle: Any, columns: list[int], poses: Array) -> None:
        # Columns without a ghost are scaled to nothing: another number of instances would build them all anew.
        places, turns = np.zeros((self._capacity, 3)), np.tile([1.0, 0.0, 0.0, 0.0], (self._capacity, 1))
        sizes = np.zeros(self._capacity)
        if columns:
            places[columns], turns[columns], sizes[columns] = poses[:, :3, 3], to_quat_wxyz(poses), 1.0
        handle.batched_positions, handle.batched_wxyzs, handle.batched_scales = (
            places.astype(np.float32), turns.astype(np.float32), sizes.astype(np.float32)
        )  # fmt: skip

    def _add_lines(self) -> None:
        """Add an object of lines along the links for the arm, thick, and for each branch, and the links' frames."""
        shape = (max(len(self._edges), 1), 2, 3)
        self.lines = [
            self._scene.add_line_segments(
                f"/robot/line_{k}",
                np.zeros(shape),
                np.broadcast_to(shade, shape),
                thickness=3.0 if k else 6.0,
                thickness_units="screen",
            )
            for k, shade in enumerate([np.array(_LINE, dtype=np.uint8), *self._colours])
        ]
        count = len(self._arm.model.links)
        self._axes = self._scene.add_batched_axes(
            "/robot/axes",
            np.tile([1.0, 0.0, 0.0, 0.0], (count, 1)),
            np.zeros((count, 3)),
            axes_length=0.08 * self._size,
            axes_radius=0.003 * self._size,
        )

    def _place_lines(self, lines: list[Any], at: list[int], poses: dict[str, Array]) -> None:
        """Put the lines of these numbers along the links, and the others nowhere."""
        points = np.zeros((len(lines), max(len(self._edges), 1), 2, 3), dtype=np.float32)
        for k, ends in enumerate(self._edges):
            for end, link in enumerate(ends):
                points[at, k, end] = poses[link][:, :3, 3]
        for handle, each in zip(lines, points, strict=True):
            handle.points = each


def _first_of_their_kind(poses: Array, distance: float) -> NDArray[np.bool_]:
    """(k,) whether no earlier one of the poses (k, 4, 4) is the same."""
    gaps = np.abs(poses[:, None] - poses[None])
    same = (gaps[..., :3, :3].max(axis=(-1, -2)) < _SAME) & (gaps[..., :3, 3].max(axis=-1) < distance)
    return np.asarray(~np.tril(same, -1).any(axis=1))


def _place(handle: Any, T: Array) -> None:
    handle.position, handle.wxyz = T[:3, 3], to_quat_wxyz(T)
