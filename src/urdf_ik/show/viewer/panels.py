"""The widgets of the viewer's page: arm, path, text, another arm; they mirror a State."""

import math
import re
import threading
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from urdf_ik.arm import Arm
from urdf_ik.errors import ArgumentError, MissingPackage, UrdfIkError
from urdf_ik.ik.solutions import limits
from urdf_ik.ik.solutions.branch_names import short
from urdf_ik.model import catalogue
from urdf_ik.model.poses import check_poses, pose
from urdf_ik.paths.planned_motion import Plan
from urdf_ik.show.viewer import state as states
from urdf_ik.show.viewer.arm_and_gizmo import colours
from urdf_ik.show.viewer.playback import last
from urdf_ik.show.viewer.state import State
from urdf_ik.typing import Array

READING = threading.Lock()
"""Held while a page's value is read and requested: viser calls in several threads, and a slow one would request an
older value after a newer one."""
_STEP, _DIGITS = 0.001, 3  # rad or m
_PLACE_STEP = 0.1  # waypoints
_NO_CHOICE = "catalogue ..."
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
"""Long labels of buttons wrap; in a narrow window the panel is as wide as the window."""


class Panel:
    """Widgets of an arm in the panel of a viser server.

    Attributes:
        status: text above the branches.
        branches: one button a branch.
        sliders: one a joint.
        redundancies: sliders of the redundancy parameters.
        strip: picture of the intervals of a single parameter by branch; None without a parameter.
    """

    def __init__(
        self,
        gui: Any,
        arm: Arm,
        on_branch: Callable[[int], None],
        on_joint: Callable[[int, float], None],
        on_redundancy: Callable[[int, float], None],
    ) -> None:
        """Add the widgets; the functions are called with what the reader of the page chose."""
        self._arm = arm
        self.status = gui.add_markdown("")
        self._folders = [gui.add_folder("Branches")]
        with self._folders[-1]:
            self.branches = [
                gui.add_button(name, color=colour, visible=False)
                for name, colour in zip(arm.structure.branches, colours(len(arm.structure.branches)), strict=True)
            ]
        for column, button in enumerate(self.branches):
            button.on_click(lambda _, column=column: on_branch(column))
        self.redundancies, self.strip = [], None
        if arm.solver.parameters:
            self._folders.append(gui.add_folder("Redundancy"))
            with self._folders[-1]:
                self.redundancies = [slider_of(gui, f"{p.label} [{p.unit}]", *p.range) for p in arm.solver.parameters]
                self.strip = gui.add_image(np.zeros((1, 1, 3), np.uint8), visible=False)
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
        for column, button in enumerate(self.branches):
            k = by_column.get(column)
            button.visible = k is not None
            if k is not None:
                ghost = state.ghosts[k]
                button.label = branch_label(ghost.branch, ghost.marks, k == chosen)
        for slider, value in zip(self.sliders, state.q, strict=True):
            if slider is not keep:
                turn_to(slider, float(value))
        if state.redundancy is not None:
            for slider, value in zip(self.redundancies, np.atleast_1d(state.redundancy), strict=True):
                if slider is not keep:
                    turn_to(slider, float(value))

    def show_intervals(self, state: State) -> None:
        """Draw the intervals; this takes a tenth of a second, and nothing is shown without matplotlib."""
        if self.strip is not None:
            picture = intervals_picture(state)
            if picture is not None:
                self.strip.image = picture
            self.strip.visible = picture is not None

    def remove(self) -> None:
        """Take the widgets out of the panel again."""
        self.status.remove()
        for folder in self._folders:
            folder.remove()


def branch_label(branch: str, marks: tuple[str, ...], chosen: bool) -> str:
    """A branch and its marks on one button; where that is too long, 'shoulder front, elbow up' becomes 'front, up'."""
    dot, tail = "● " * chosen, f" ({'; '.join(marks)})" if marks else ""
    for name in (branch, short(branch)):
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
    low, high = math.ceil(low / _STEP - 1e-6) * _STEP, math.floor(high / _STEP + 1e-6) * _STEP
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


def intervals_picture(state: State) -> NDArray[np.uint8] | None:
    """Pixels (h, w, 3) of the intervals of the redundancy parameter with its present value; None if not available."""
    if state.intervals is None or not len(state.intervals) or state.redundancy is None:
        return None
    try:
        from urdf_ik.show import plot
    except MissingPackage:
        return None
    from matplotlib.backends.backend_agg import FigureCanvasAgg

    figure = plot.intervals(state.intervals, degrees=False)
    figure.axes[0].axvline(float(np.atleast_1d(state.redundancy)[0]), color="#d55e00", linestyle="--")
    canvas: Any = FigureCanvasAgg(figure)
    canvas.draw()
    return np.asarray(canvas.buffer_rgba(), dtype=np.uint8)[..., :3].copy()


def on_change(widget: Any, call: Callable[[Any], None]) -> None:
    """Call ``call`` with the widget's value where the reader of the page changes it."""

    def changed(event: Any) -> None:
        if event.client_id is not None:  # not what this program set itself
            with READING:
                call(widget.value)

    widget.on_update(changed)


class PathPanel:
    """Widgets of a plan, above those of the arm.

    Attributes:
        status: what was found.
        slider: the place on the path, in waypoints.
        button: plays and pauses.
    """

    def __init__(self, gui: Any, plan: Plan, on_place: Callable[[float], None], on_play: Callable[[], None]) -> None:
        """Add the widgets; the functions are called with what the reader of the page chose."""
        self._folder = gui.add_folder("Path", order=-1.0)
        with self._folder:
            self.status = gui.add_markdown(_plan_status(plan))
            self.slider = gui.add_slider("Waypoint", 0.0, float(max(last(plan), _PLACE_STEP)), _PLACE_STEP, 0.0)
            self.button = gui.add_button("Play")
        on_change(self.slider, on_place)
        self.button.on_click(lambda _: on_play())

    def show(self, place: float) -> None:
        """Set the slider."""
        self.slider.value = round(place, 1)

    def show_playing(self, playing: bool) -> None:
        """What the button does next."""
        self.button.label = "Pause" if playing else "Play"

    def remove(self) -> None:
        """Take the widgets out of the panel again."""
        self._folder.remove()


def _plan_status(plan: Plan) -> str:
    """Markdown: what was found, or where each branch ends."""
    if not plan.found:
        return "\n\n".join(
            [f"**No plan** along {len(plan.poses)} waypoints.", *(plain(str(each)) for each in plan.stops)]
        )
    lines = [f"{len(plan.poses)} waypoints, cost {plan.cost:.4g}: {plain(plan.branches[0])}"]
    lines += [f"before waypoint {change.waypoint}: to {plain(change.after)}" for change in plan.changes]
    return "\n\n".join(lines)


class WorkPanel:
    """A pose or joint vector to paste or copy, and keys.

    Attributes:
        text: where a pose or a joint vector is pasted.
        copied: the joint vector and the target as Python, to be selected and copied.
    """

    def __init__(
        self, gui: Any, arm: Arm, change: Callable[[Callable[[State], State]], None], say: Callable[[str], None]
    ) -> None:
        """Add the widgets; ``change`` is called with what makes the next state, ``say`` with what is wrong."""
        self._arm, self._change, self._say = arm, change, say
        self._folder = gui.add_folder("Paste, copy", expand_by_default=False, order=5e8)
        with self._folder:
            hint = "q = [...], 16 numbers of a matrix, or x y z and a quaternion"
            self.text = gui.add_text("Pose or q", "", hint=hint)
            self.copied = gui.add_markdown("")
        self._keys = [gui.add_command("Next solution", hotkey="N"), gui.add_command("Previous solution", hotkey="P")]
        on_change(self.text, self._typed)
        for key, step in zip(self._keys, (1, -1), strict=True):
            key.on_trigger(lambda _, step=step: change(lambda state: states.with_next(state, step)))

    def show(self, state: State) -> None:
        """Write the joint vector and the target of ``state``."""
        self.copied.content = f"```\n{written(state.q, state.target)}\n```"

    def remove(self) -> None:
        """Take the widgets out of the panel again."""
        for part in (self._folder, *self._keys):
            part.remove()

    def _typed(self, text: str) -> None:
        if not text.strip():
            return
        try:
            kind, value = read(text, self._arm)
        except UrdfIkError as error:
            self._say(str(error))
            return
        self._say("")
        step = states.with_joints if kind == "q" else states.with_target
        self._change(lambda state: step(state, value))


def add_sources(gui: Any, choose: Callable[[str], None], name: Callable[[], str], page: Callable[[], str]) -> None:
    """Add the widgets that stay whatever arm is shown: the catalogue, and a button that saves the scene.

    A page chooses among names only: it cannot have files of this machine read.

    Args:
        gui: of the viser server.
        choose: called with a catalogue name.
        name: the name of the arm that is shown.
        page: the scene as HTML.
    """
    with gui.add_folder("Another arm", expand_by_default=False, order=1e9):
        names = gui.add_dropdown("Catalogue", (_NO_CHOICE, *catalogue.names()))
    save = gui.add_button("Save the scene as HTML", order=1e9 + 1.0)

    def saved(event: Any) -> None:
        if event.client is not None:
            event.client.send_file_download(f"{Path(name()).name}.html", page().encode(), save_immediately=True)

    on_change(names, lambda chosen: choose(chosen) if chosen in catalogue.names() else None)
    save.on_click(saved)


_NUMBER = re.compile(r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?")
_BESIDE = re.compile(r"[\s,;()\[\]]|np\.|array|tensor")
_SHOWN_DIGITS = 9


def read(text: str, arm: Arm) -> tuple[str, Array]:
    """What a text says: ('q', (n,) rad or m) or ('pose', (4, 4) m).

    Numbers in brackets or without: as many as the arm has joints are a joint vector, 16 a matrix, 7 a position and a
    quaternion (x, y, z, w), 6 a position and roll, pitch, yaw [rad]. Where that leaves a doubt, a word says what they
    are: ``q=...``, ``pose=...``.

    Example:
        >>> import urdf_ik
        >>> arm = urdf_ik.load("zyyzyz_6r")
        >>> read("q = [0, 0.5, 0, 0, 0, 0]", arm)[0], read("1.2 0.4 0.9 0 0 0 1", arm)[1][:3, 3].tolist()
        ('q', [1.2, 0.4, 0.9])
    """
    kind, values = _parsed(text)
    n = arm.dof
    if kind == "q" or (not kind and len(values) == n):
        if len(values) != n:
            raise ArgumentError(f"{len(values)} numbers given; {arm.name} has {n} joints: {', '.join(arm.joint_names)}")
        return "q", arm.chain.check(values)
    if len(values) == 16:
        return "pose", check_poses(values.reshape(4, 4))
    if len(values) == 7:
        return "pose", pose(values[:3], quat_xyzw=values[3:])
    if len(values) == 6:
        return "pose", pose(values[:3], rpy=values[3:])
    raise ArgumentError(
        f"{len(values)} numbers given; {n} are a joint vector, 16 a matrix, 7 x,y,z and a quaternion x,y,z,w, 6 x,y,z "
        "and roll,pitch,yaw"
    )


def written(q: Array, target: Array) -> str:
    """A joint vector and the target's pose as lines of Python, each of which :func:`read` takes."""
    joints, matrix = ((np.round(each, _SHOWN_DIGITS) + 0.0).tolist() for each in (q, target))
    return f"q = {joints}\npose = {matrix}"


def _parsed(text: str) -> tuple[str, Array]:
    """The word that says what the numbers are, 'q', 'pose' or '', and the numbers."""
    word, sign, rest = text.partition("=")
    if sign and word.strip() in ("q", "pose", "T"):
        return "q" if word.strip() == "q" else "pose", _numbers(rest)
    return "", _numbers(text)


def _numbers(text: str) -> Array:
    left = _BESIDE.sub("", _NUMBER.sub(" ", text)).strip()
    if left:
        raise ArgumentError(f"{left!r} is no number; paste numbers, such as 0.5, 0.1, 0.3, 0, 0, 0, 1")
    return np.array([float(each) for each in _NUMBER.findall(text)])
