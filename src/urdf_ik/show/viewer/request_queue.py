"""Latest: a thread that serves the requests of pages; a newer request replaces an older one of the same kind."""

import threading
import traceback
from collections.abc import Callable, Hashable


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
