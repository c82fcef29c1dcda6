"""The part of the page for work: paste or copy a pose or joint vector, postures by name; keys, ghosts, a measure."""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import Any

from urdf_ik.arm import Arm
from urdf_ik.errors import UrdfIkError
from urdf_ik.show.viewer import state as states
from urdf_ik.show.viewer.state import State
from urdf_ik.show.viewer.work import typed_text
from urdf_ik.show.viewer.work.ghost_choice import GhostChoice
from urdf_ik.show.viewer.work.measure import Measure

Change = Callable[[Callable[[State], State]], None]

_NO_POSTURE = "posture ..."
NEXT, BEFORE = "N", "P"
"""Keys that move the arm to the next solution, and to the one before."""


class WorkPanel:
    """Widgets that mirror a State, and keys.

    Attributes:
        text: where a pose or a joint vector is pasted.
        postures: names of postures.
        form: how the joint vector and the target are written.
        copied: these two, to be selected and copied.
        ghosts: which ghosts are drawn.
        measure: what lies between two frames.
    """

    def __init__(self, gui: Any, scene: Any, arm: Arm, change: Change, say: Callable[[str], None]) -> None:
        """Add the widgets.

        Args:
            gui: of the viser server.
            scene: of the viser server.
            arm: the arm that is shown.
            change: called with what makes the next state.
            say: called with what is wrong with a text.
        """
        self._arm, self._change, self._say = arm, change, say
        self._postures = states.postures(arm)
        self._state: State | None = None
        self._writing = threading.Lock()  # the page's callbacks run in threads side by side
        self.folder = gui.add_folder("Paste, copy, postures", expand_by_default=False, order=5e8)
        with self.folder:
            self.text = gui.add_text(
                "Pose or q", "", hint="q = [...], 16 numbers of a matrix, or x y z and a quaternion"
            )
            self.postures = gui.add_dropdown("Posture", (_NO_POSTURE, *self._postures))
            self.form = gui.add_dropdown("Copy as", typed_text.FORMS)
            self.copied = gui.add_markdown("")
        self.ghosts, self.measure = GhostChoice(gui, arm, change), Measure(gui, scene, arm)
        self._keys = [
            gui.add_command("Next solution", hotkey=NEXT),
            gui.add_command("Solution before", hotkey=BEFORE),
        ]
        self.text.on_update(self._typed)
        self.postures.on_update(self._posed)
        self.form.on_update(lambda _: self._write())
        for key, step in zip(self._keys, (1, -1), strict=True):
            key.on_trigger(lambda _, step=step: change(lambda state: states.with_next(state, step)))

    def show(self, state: State) -> None:
        """Write the joint vector and the target of ``state``, and measure in it."""
        self._state = state
        self._write()
        self.measure.show(state)

    def remove(self) -> None:
        """Take the widgets out of the panel again."""
        for part in (self.folder, self.ghosts, self.measure):
            part.remove()
        for key in self._keys:
            key.remove()

    def _write(self) -> None:
        with self._writing:
            if (state := self._state) is not None:
                text = typed_text.written(state.q, state.target, self.form.value)
                self.copied.content = f"```\n{text}\n```"

    def _typed(self, event: Any) -> None:
        if event.client_id is None or not self.text.value.strip():
            return
        try:
            kind, value = typed_text.read(self.text.value, self._arm)
        except UrdfIkError as error:
            self._say(str(error))
            return
        self._say("")
        step = states.with_joints if kind == "q" else states.with_target
        self._change(lambda state: step(state, value))

    def _posed(self, event: Any) -> None:
        q = self._postures.get(self.postures.value)
        if event.client_id is not None and q is not None:
            self._change(lambda state: states.with_joints(state, q))
