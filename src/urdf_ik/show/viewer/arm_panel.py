"""The viewer's panel: status, branches, redundancy and joints of one arm; it mirrors a State and decides nothing."""

from __future__ import annotations

import math
import threading
from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np

from urdf_ik.arm import Arm
from urdf_ik.ik.solutions import limits
from urdf_ik.show.viewer import interval_strip
from urdf_ik.show.viewer.arm_and_gizmo import colours
from urdf_ik.show.viewer.state import State

READING = threading.Lock()
"""Held from the reading of what a page moved until it is asked for: viser's calls run in threads side by side, and one
that was held up would ask for an older value after a newer one."""
_STEP, _DIGITS = 0.001, 3
_ROUNDING = 1e-6  # steps that an end may be off for rounding
_LETTERS = 54
"""As many fit on a button of a wide window."""
STYLE = """<style>
.mantine-Button-root { height: auto !important; min-height: 2em; padding-top: 0.2em; padding-bottom: 0.2em; }
.mantine-Button-label { white-space: normal; line-height: 1.2; overflow: visible; }
@media (max-width: 36em) {
  .mantine-Paper-root[style*="bottom: 0px"] { width: 100% !important; max-height: 50% !important; }
  .mantine-Paper-root[style*="bottom: 0px"] div[style*="width: 20em"] { width: 100% !important; }
}
</style>"""
"""A label that is too long for its button goes on in another line; the panel of a narrow window is as wide as that."""


class Panel:
    """Widgets of an arm in the panel of a viser server.

    Attributes:
        status: text above the branches.
        branches: one button a branch.
        sliders: one a joint.
        redundancies: sliders of the redundancy parameters.
        strip: under that of a single parameter, its intervals by branch; None without one.
    """

    def __init__(
        self,
        gui: Any,
        arm: Arm,
        on_branch: Callable[[int], None],
        on_joint: Callable[[int, float], None],
        on_redundancy: Callable[[int, float], None],
        dark: bool = False,
    ) -> None:
        """Add the widgets; the functions are called with what the reader of the page chose."""
        self._arm = arm
        self.status = gui.add_markdown("")
        self._folders = [gui.add_folder("Branches")]
        with self._folders[-1]:
            self.branches = [
                gui.add_button(name, color=colour, visible=False)
                for name, colour in zip(arm.structure.branches, colours(len(arm.structure.branches), dark), strict=True)
            ]
        for column, button in enumerate(self.branches):
            button.on_click(_calling(partial(on_branch, column)))
        self.redundancies, self.strip = [], None
        if arm.solver.parameters:
            self._folders.append(gui.add_folder("Redundancy"))
            with self._folders[-1]:
                self.redundancies = [slider_of(gui, f"{p.label} [{p.unit}]", *p.range) for p in arm.solver.parameters]
                self.strip = gui.add_html("", visible=False)
        for which, slider in enumerate(self.redundancies):
            on_change(slider, partial(on_redundancy, which))
        self._folders.append(gui.add_folder("Joints"))
        with self._folders[-1]:
            self.sliders = [
                slider_of(gui, f"{name} [{'m' if slides else 'rad'}]", float(low), float(high))
                for name, (low, high), slides in zip(
                    arm.joint_names, limits.drawn(arm.limits, ~arm.chain.prismatic), arm.chain.prismatic, strict=True
                )
            ]
        for index, slider in enumerate(self.sliders):
            on_change(slider, partial(on_joint, index))

    def show(self, state: State, *, keep: object = None) -> None:
        """Set every widget to what ``state`` says, except for ``keep``, which is being moved."""
        self.status.content = _status(state)
        chosen, by_column = state.chosen, {ghost.column: k for k, ghost in enumerate(state.ghosts)}
        pinned = {ghost.column for ghost in state.pinned}
        for column, button in enumerate(self.branches):
            k = by_column.get(column)
            button.visible = k is not None
            if k is not None:
                ghost = state.ghosts[k]
                seen = ["hidden"] * (column in state.hidden) + ["pinned"] * (column in pinned)
                button.label = _label(ghost.branch, (*ghost.marks, *seen), k == chosen)
        for slider, value in zip(self.sliders, state.q, strict=True):
            if slider is not keep:
                turn_to(slider, float(value))
        if self.strip is not None:
            content = interval_strip.drawn(state)
            self.strip.visible = bool(content)
            self.strip.content = content
        if state.redundancy is not None:
            for slider, value in zip(self.redundancies, np.atleast_1d(state.redundancy), strict=True):
                if slider is not keep:
                    turn_to(slider, float(value))

    def send_again(self) -> None:
        """Send every page the values of the sliders, also those that have not changed since they were sent."""
        for slider in (*self.sliders, *self.redundancies):
            send_again(slider)

    def remove(self) -> None:
        """Take the widgets out of the panel again."""
        self.status.remove()
        for folder in self._folders:
            folder.remove()


def _label(branch: str, marks: tuple[str, ...], chosen: bool) -> str:
    """A branch and its marks on one button; where that is too long, 'shoulder front, elbow up' becomes 'front, up'."""
    dot, tail = "● " * chosen, f" ({'; '.join(marks)})" if marks else ""
    for name in (branch, ", ".join(part.split(" ")[-1] for part in branch.split(", "))):
        text = dot + name + tail
        if len(text) <= _LETTERS:
            break
    return text


def _status(state: State) -> str:
    """Markdown: the arm, how many solutions, why there is no solution."""
    arm, count = state.arm, len(state.ghosts)
    inside = sum(not ghost.outside for ghost in state.ghosts)
    solutions = f"{count} solution{'s' if count != 1 else ''}, {inside} inside the limits"
    lines = [f"**{plain(arm.name)}**, {plain(arm.structure.family or f'{arm.dof} joints')}"]
    lines.append(f"**No solution{' inside the limits' if count else ''}:** {plain(state.reason)}" if state.reason
                 else solutions)  # fmt: skip
    return "\n\n".join([*lines, *[plain(state.note)] * bool(state.note)])


def plain(text: str) -> str:
    """``text`` without meaning to Markdown: names come from files of unknown origin."""
    return "".join(f"\\{c}" if c in "\\`*_{}[]<>#|!~$&" else c for c in text)


def slider_of(gui: Any, name: str, low: float, high: float) -> Any:
    """A slider from ``low`` to ``high`` [rad or m] in steps of a thousandth."""
    # Whole steps, since the page writes as many digits as the ends have; at least one, or there is no slider.
    low, high = math.ceil(low / _STEP - _ROUNDING) * _STEP, math.floor(high / _STEP + _ROUNDING) * _STEP
    low, high = round(low, _DIGITS), round(max(high, low + _STEP), _DIGITS)
    return gui.add_slider(name, low, high, _STEP, low)


def turn_to(slider: Any, value: float) -> None:
    """Move a slider; one end gives way to a value beyond it, as a solution outside the limits has."""
    shown = round(value, _DIGITS)
    if shown < slider.min:
        slider.min = shown
    if shown > slider.max:
        slider.max = shown
    slider.value = shown


def send_again(widget: Any) -> None:
    """Send every page the value of a widget; viser itself sends changes alone."""
    widget._queue_update("value", widget.value)


def on_change(widget: Any, call: Callable[[Any], None]) -> None:
    """Call ``call`` with the widget's value where the reader of the page changes it."""

    def changed(event: Any) -> None:
        if event.client_id is not None:  # not what this program set itself
            with READING:
                call(widget.value)

    widget.on_update(changed)


def _calling(call: Callable[[], None]) -> Callable[[Any], None]:
    return lambda _: call()
