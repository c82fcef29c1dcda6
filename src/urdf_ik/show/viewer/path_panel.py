"""The widgets of a path: its slider, play and pause, and where each branch ends."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from urdf_ik.paths.planned_motion import Stop
from urdf_ik.show.viewer.arm_and_gizmo import colours
from urdf_ik.show.viewer.arm_panel import on_change, plain, send_again
from urdf_ik.show.viewer.playback import Track

_PLAY, _PAUSE = "Play", "Pause"
_STEP = 0.1
_LETTERS = 54


class PathPanel:
    """Widgets of a plan, above those of the arm.

    Attributes:
        status: what was found.
        slider: the place on the path, in waypoints.
        button: plays and pauses.
        ends: a button a start branch that ends.
    """

    def __init__(
        self,
        gui: Any,
        track: Track,
        on_place: Callable[[float], None],
        on_play: Callable[[], None],
        on_end: Callable[[Stop], None],
        dark: bool = False,
    ) -> None:
        """Add the widgets; the functions are called with what the reader of the page chose."""
        plan = track.plan
        names = plan.solver.structure.branches
        shades = dict(zip(names, colours(len(names), dark), strict=True))
        self._folder = gui.add_folder("Path", order=-1.0)
        with self._folder:
            self.status = gui.add_markdown(_status(track))
            self.slider = gui.add_slider("Waypoint", 0.0, float(max(track.last, _STEP)), _STEP, 0.0)
            self.button = gui.add_button(_PLAY)
            self.ends = [
                gui.add_button(_label(track, stop), color=shades.get(stop.branch), hint=str(stop))
                for stop in plan.stops
            ]
        on_change(self.slider, on_place)
        self.button.on_click(lambda _: on_play())
        for stop, button in zip(plan.stops, self.ends, strict=True):
            button.on_click(lambda _, stop=stop: on_end(stop))

    def show(self, place: float, *, again: bool = False) -> None:
        """Set the slider; ``again`` sends its value even where it has not changed."""
        self.slider.value = round(place, 1)
        if again:
            send_again(self.slider)

    def show_playing(self, playing: bool) -> None:
        """What the button does next."""
        self.button.label = _PAUSE if playing else _PLAY

    def remove(self) -> None:
        """Take the widgets out of the panel again."""
        self._folder.remove()


def _label(track: Track, stop: Stop) -> str:
    """'shoulder front, elbow up: ends before 34, limit', or with the last words of each part of the name."""
    if not track.plan.solver.structure.branches.count(stop.branch):
        return f"{stop.branch}: {stop.cause} at {stop.waypoint}"
    tail = f": ends before {stop.waypoint}, {stop.cause}"
    short = ", ".join(part.split(" ")[-1] for part in stop.branch.split(", "))
    return stop.branch + tail if len(stop.branch + tail) <= _LETTERS else short + tail


def _status(track: Track) -> str:
    """Markdown: what was found, or what stops the branch that gets farthest."""
    plan = track.plan
    if not plan.found:
        lines = [f"**No plan** along {len(plan.poses)} waypoints."]
        lines += [plain(str(stop)) for stop in plan.stops[:1]]
        return "\n\n".join(lines)
    lines = [f"{len(plan.poses)} waypoints, cost {plan.cost:.4g}: {plain(plan.branches[0])}"]
    lines += [f"before waypoint {change.waypoint}: to {plain(change.after)}" for change in plan.changes]
    return "\n\n".join(lines)
