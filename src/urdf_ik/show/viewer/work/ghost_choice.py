"""Which ghosts are drawn: all of a kind, and single branches hidden, or pinned where they are."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from urdf_ik.arm import Arm
from urdf_ik.show.viewer import state as states
from urdf_ik.show.viewer.state import State

Change = Callable[[Callable[[State], State]], None]

EVERY = "every branch"
"""What the actions are done to where no branch is named."""
ACTIONS = ("Hide", "Show", "Pin", "Unpin")
"""What can be done to a ghost; a pinned one stays where it is while the target moves on."""


class GhostChoice:
    """Widgets of a folder of their own.

    Attributes:
        shown: which kind of ghosts is drawn.
        branch: the branch that the actions are done to.
        actions: hide, show, pin, unpin.
    """

    def __init__(self, gui: Any, arm: Arm, change: Change) -> None:
        """Add the widgets; ``change`` is called with what makes the next state."""
        self._change, self._names = change, list(arm.structure.branches)
        self.folder = gui.add_folder("Ghosts", expand_by_default=False, order=4e8)
        with self.folder:
            self.shown = gui.add_dropdown("Drawn", states.SHOWN)
            self.branch = gui.add_dropdown("Branch", (EVERY, *self._names))
            self.actions = gui.add_button_group("Do", ACTIONS, hint="A pinned ghost stays where it is")
        self.shown.on_update(self._chosen)
        self.actions.on_click(self._acted)

    def remove(self) -> None:
        """Take the widgets out of the panel again."""
        self.folder.remove()

    def _chosen(self, event: Any) -> None:
        what = self.shown.value
        if event.client_id is not None:
            self._change(lambda state: states.with_shown(state, what))

    def _acted(self, event: Any) -> None:
        if event.client_id is None:
            return
        what, name = self.actions.value, self.branch.value
        columns = frozenset(k for k, each in enumerate(self._names) if name in (EVERY, each))
        step = states.with_hidden if what in ("Hide", "Show") else states.with_pinned
        self._change(lambda state: step(state, columns, what in ("Hide", "Pin")))
