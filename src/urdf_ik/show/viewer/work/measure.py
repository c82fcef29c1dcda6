"""What lies between two frames: a line in the scene, and distance, way and turn in words."""

from __future__ import annotations

import threading
from typing import Any

import numpy as np

from urdf_ik.arm import Arm
from urdf_ik.model.poses import to_rotvec
from urdf_ik.show.viewer.arm_panel import plain
from urdf_ik.show.viewer.state import State
from urdf_ik.typing import Array

NOTHING, TARGET = "-", "target"
"""No frame, and the frame that is dragged; all other frames are those of links."""
_COLOUR, _THICKNESS = (230, 0, 120), 3.0


class Measure:
    """Two frames to choose, a line between them, and what it measures.

    Attributes:
        ends: where the line begins, and where it ends.
        words: what lies between.
        line: in the scene; invisible until both ends are chosen.
    """

    def __init__(self, gui: Any, scene: Any, arm: Arm) -> None:
        """Add the widgets and the line."""
        self._arm = arm
        self._state: State | None = None
        # The page's callbacks run in threads side by side: what is written last must be the last choice.
        self._writing = threading.Lock()
        self.folder = gui.add_folder("Measure", expand_by_default=False, order=6e8)
        with self.folder:
            frames = (NOTHING, TARGET, *arm.model.links)
            self.ends = [gui.add_dropdown(name, frames) for name in ("From", "To")]
            self.words = gui.add_markdown("")
        self.line = scene.add_line_segments(
            "/measure", np.zeros((1, 2, 3)), np.array(_COLOUR), thickness=_THICKNESS, thickness_units="screen",
            visible=False,
        )  # fmt: skip
        for end in self.ends:
            end.on_update(lambda _: self._write())

    def show(self, state: State) -> None:
        """Measure in ``state``."""
        self._state = state
        self._write()

    def remove(self) -> None:
        """Take widgets and line away again."""
        self.folder.remove()
        self.line.remove()

    def _write(self) -> None:
        with self._writing:
            names, state = [end.value for end in self.ends], self._state
            if state is None or NOTHING in names:
                self.line.visible, self.words.content = False, ""
                return
            frames = {TARGET: state.target, **self._arm.link_poses(state.q)}
            start, end = (frames[name] for name in names)
            self.line.points = np.stack([start[:3, 3], end[:3, 3]])[None].astype(np.float32)
            self.line.visible = True
            self.words.content = between(start, end, names[0])


def between(start: Array, end: Array, name: str) -> str:
    r"""Markdown: distance, way and turn from the pose ``start`` to the pose ``end``, (4, 4) m, in the frame ``start``.

    Example:
        >>> import urdf_ik
        >>> between(urdf_ik.pose([0, 0, 1]), urdf_ik.pose([0, 0.3, 1.4], rpy=[0, 0, 0.5]), "base")
        '**0.5000 m** apart, turned by 28.65 deg\n\nin base: x 0.0000, y 0.3000, z 0.4000 m'
    """
    T = np.linalg.inv(start) @ end
    x, y, z = T[:3, 3] + 0.0
    turned = np.rad2deg(np.linalg.norm(to_rotvec(T)))
    distance = np.linalg.norm(T[:3, 3])
    return (
        f"**{distance:.4f} m** apart, turned by {turned:.2f} deg\n\nin {plain(name)}: x {x:.4f}, y {y:.4f}, z {z:.4f} m"
    )
