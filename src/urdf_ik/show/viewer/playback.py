"""Playback of a plan: the viewer's state at each place of its path."""

import threading
import time
import traceback
from collections.abc import Callable, Hashable

import numpy as np

from urdf_ik.paths.planned_motion import Plan
from urdf_ik.show.viewer import state as states
from urdf_ik.show.viewer.state import State

FRAME = 0.05
"""s between two frames of a plan that is played."""
_RATE, _SHORTEST, _LONGEST = 10.0, 4.0, 40.0
"""Waypoints a second, and s that playing the whole plan takes at least and at most."""


def last(plan: Plan) -> int:
    """Number of the last waypoint."""
    return len(plan.poses) - 1


def at(plan: Plan, state: State, place: float) -> State:
    """The state at a place of a path; 2.5 is half way from waypoint 2 to waypoint 3.

    With a plan the arm stands where the plan puts it. Without one the target goes along the waypoints, and the arm
    follows to the nearest solution, as it does when somebody drags the target.
    """
    place = float(np.clip(place, 0.0, last(plan)))
    if not plan.found:
        return states.with_target(state, plan.poses[round(place)])
    q = np.array([np.interp(place, plan.place, column) for column in plan.motion.T])
    return states.with_joints(state, q)


class Player:
    """Moves on along a path, frame by frame, until its end or until it is stopped."""

    def __init__(self, go: Callable[[float], None], ended: Callable[[], None]) -> None:
        """``go`` is called with each place, ``ended`` when the end is reached; both from another thread."""
        self._go, self._ended = go, ended
        self._thread: threading.Thread | None = None
        self._stop = threading.Event()
        self._going = threading.Lock()

    @property
    def playing(self) -> bool:
        """Whether it moves."""
        return self._thread is not None and self._thread.is_alive() and not self._stop.is_set()

    def start(self, end: int, place: float) -> None:
        """Move on from ``place`` to ``end``; from the beginning where that is the end."""
        self.stop()
        first = 0.0 if place >= end else place
        self._stop = threading.Event()
        self._thread = threading.Thread(
            target=self._run, args=(end, first, self._stop), name="urdf-ik player", daemon=True
        )
        self._thread.start()

    def stop(self) -> None:
        """Stay where it is: ``go`` is not called after this."""
        with self._going:
            self._stop.set()

    def _run(self, end: int, first: float, stop: threading.Event) -> None:
        begun, rate = time.monotonic(), end / float(np.clip((end + 1) / _RATE, _SHORTEST, _LONGEST))
        place = first
        while place < end and not stop.wait(FRAME):
            place = min(first + (time.monotonic() - begun) * rate, float(end))
            with self._going:
                if stop.is_set():
                    return
                self._go(place)
        if not stop.is_set():
            stop.set()
            self._ended()


class Latest:
    """Requests of many threads, done one after the other.

    A drag sends requests faster than a page is drawn; only the last position of the pointer matters.
    """

    def __init__(self, afterwards: Callable[[], None], pause: float = 0.25) -> None:
        """Have ``afterwards()`` called when no request came for ``pause`` [s] after the last one."""
        self._afterwards, self._pause, self._due = afterwards, pause, False
        self._waiting: dict[Hashable, Callable[[], None]] = {}
        self._changed = threading.Condition()
        self._busy = self._ended = False
        self._thread = threading.Thread(target=self._run, name="urdf-ik viewer", daemon=True)
        self._thread.start()

    def put(self, key: Hashable, do: Callable[[], None]) -> None:
        """Have ``do()`` called, instead of what was put under ``key`` and has not begun."""
        with self._changed:
            self._waiting[key] = do
            self._changed.notify_all()

    def settle(self, timeout: float | None = None) -> bool:
        """Wait until nothing is left to do; false if that takes longer than ``timeout`` [s]."""
        with self._changed:
            return self._changed.wait_for(lambda: self._ended or not (self._waiting or self._busy), timeout)

    def close(self) -> None:
        """Drop what waits and end the thread."""
        with self._changed:
            self._ended = True
            self._changed.notify_all()
        self._thread.join(timeout=5.0)

    def _run(self) -> None:
        while True:
            with self._changed:
                self._busy = False
                self._changed.notify_all()
                self._changed.wait_for(lambda: self._ended or self._waiting, self._pause if self._due else None)
                if self._ended:
                    return
                self._due = bool(self._waiting)
                do = self._waiting.pop(next(iter(self._waiting))) if self._due else self._afterwards
                self._busy = self._due
            try:
                do()
            except Exception:  # a defect in one answer must not end the viewer
                traceback.print_exc()
