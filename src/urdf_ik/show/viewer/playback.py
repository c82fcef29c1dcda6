"""Playback of a plan: the viewer's state at each place of its path, and where branches end."""

import threading
import time
import traceback
from collections.abc import Callable, Hashable
from dataclasses import dataclass

import numpy as np

from urdf_ik.paths.planned_motion import Plan, Stop
from urdf_ik.show.viewer import state as states
from urdf_ik.show.viewer.state import State
from urdf_ik.typing import Array

FRAME = 0.05
"""s between two frames of a plan that is played."""
_RATE, _SHORTEST, _LONGEST = 10.0, 4.0, 40.0
"""Waypoints a second, and s that playing the whole plan takes at least and at most."""


@dataclass(frozen=True, eq=False)
class Track:
    """A plan in the viewer.

    Attributes:
        plan: found or not.
        points: (m, 3) m, the tip at the waypoints.
        reached: last waypoint that some branch reaches.
        ends: by waypoint, what ends there: see :func:`place_of`.
    """

    plan: Plan
    points: Array
    reached: int
    ends: dict[int, tuple[Stop, ...]]

    @property
    def last(self) -> int:
        """Number of the last waypoint."""
        return len(self.points) - 1

    @property
    def duration(self) -> float:
        """S: how long playing it takes."""
        return float(np.clip(len(self.points) / _RATE, _SHORTEST, _LONGEST))


def track(plan: Plan) -> Track:
    """A plan made ready."""
    ends: dict[int, tuple[Stop, ...]] = {}
    reached = len(plan.poses) - 1 if plan.found else -1
    for stop in plan.stops:
        place = place_of(plan, stop)
        ends[place] = (*ends.get(place, ()), stop)
        if stop.branch in plan.solver.structure.branches:
            reached = max(reached, stop.waypoint - 1)
    return Track(plan, plan.poses[:, :3, 3], reached, ends)


def place_of(plan: Plan, stop: Stop) -> int:
    """The last waypoint that a branch reaches; of what no branch gets past, the waypoint itself."""
    return max(stop.waypoint - 1, 0) if stop.branch in plan.solver.structure.branches else stop.waypoint


def at(track: Track, state: State, place: float) -> State:
    """The state at a place of the path; 2.5 is half way from waypoint 2 to waypoint 3.

    With a plan the arm stands where the plan puts it. Without one the target goes along the waypoints, and the arm
    follows to the nearest solution, as it does when somebody drags the target.
    """
    plan = track.plan
    place = float(np.clip(place, 0.0, track.last))
    if not plan.found:
        return states.with_target(state, plan.poses[round(place)])
    q = np.array([np.interp(place, plan.place, column) for column in plan.motion.T])
    return states.with_joints(state, q)


def first_of(track: Track, state: State, stop: Stop) -> State:
    """The state where the ways of a branch end: the target there, the arm at that branch's solution if it has one."""
    here = at(track, state, place_of(track.plan, stop))
    names = here.arm.structure.branches
    return states.with_branch(here, names.index(stop.branch)) if stop.branch in names else here


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

    def start(self, track: Track, place: float) -> None:
        """Move on from ``place``; from the beginning where that is the end."""
        self.stop()
        first = 0.0 if place >= track.last else place
        self._stop = threading.Event()
        self._thread = threading.Thread(
            target=self._run, args=(track, first, self._stop), name="urdf-ik player", daemon=True
        )
        self._thread.start()

    def stop(self) -> None:
        """Stay where it is: ``go`` is not called after this."""
        with self._going:
            self._stop.set()

    def _run(self, track: Track, first: float, stop: threading.Event) -> None:
        begun, rate = time.monotonic(), track.last / track.duration
        place = first
        while place < track.last and not stop.wait(FRAME):
            place = min(first + (time.monotonic() - begun) * rate, float(track.last))
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
