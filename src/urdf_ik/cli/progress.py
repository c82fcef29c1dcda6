"""Progress of long work on standard error; short work leaves nothing there."""

from __future__ import annotations

import sys
import threading
import time
from types import TracebackType
from typing import TYPE_CHECKING

from urdf_ik.cli.options import is_terminal

if TYPE_CHECKING:
    from rich.progress import Progress as Bar
    from rich.progress import TaskID

BAR_AFTER = 0.5
WORD_AFTER = 2.0
WORD_EVERY = 5.0


class Progress:
    """A bar on a terminal, else a line every few seconds; ``tick(done, total)`` moves it."""

    def __init__(self, what: str, waiting: str) -> None:
        """``what`` heads the bar; ``waiting`` is said once when nothing has moved for two seconds."""
        self._what = what
        self._waiting = waiting
        self._start = time.monotonic()
        # The first tick counts the steps of earlier runs; the remaining time is estimated from those since.
        self._first: tuple[int, float] | None = None
        self._next_word = self._start + WORD_AFTER
        self._bar: Bar | None = None
        self._task: TaskID | None = None
        self._timer = threading.Timer(WORD_AFTER, self._say, args=(f"{waiting} ...",))
        self._timer.daemon = True

    def __enter__(self) -> Progress:
        self._timer.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._timer.cancel()
        if self._bar is not None:
            self._bar.stop()

    def tick(self, done: int, total: int) -> None:
        """Show that ``done`` of ``total`` steps are behind us."""
        self._timer.cancel()
        now = time.monotonic()
        self._first = self._first or (done, now)
        if is_terminal(sys.stderr):
            if now - self._start > BAR_AFTER:
                self._move_bar(done, total)
        elif now > self._next_word:
            self._next_word = now + WORD_EVERY
            self._say(f"{self._what}: {done} of {total}{self._left(done, total, now)}")

    def _move_bar(self, done: int, total: int) -> None:
        if self._bar is None or self._task is None:
            from rich.console import Console
            from rich.progress import Progress as Bar

            self._bar = Bar(console=Console(stderr=True), transient=True)
            self._task = self._bar.add_task(self._what, total=total)
            self._bar.start()
        self._bar.update(self._task, completed=done, total=total)

    def _left(self, done: int, total: int, now: float) -> str:
        """How long the rest will take, in words; nothing while that cannot be said."""
        assert self._first is not None
        made, began = done - self._first[0], self._first[1]
        if made <= 0:
            return ""
        seconds = round((total - done) * (now - began) / made)
        return f", {seconds // 3600}:{seconds // 60 % 60:02}:{seconds % 60:02} left"

    @staticmethod
    def _say(line: str) -> None:
        print(line, file=sys.stderr, flush=True)


class Elapsed:
    """For work that cannot say how far it is: the time that it has taken, on a terminal with a spinner."""

    def __init__(self, what: str) -> None:
        """``what`` is being done."""
        self._what = what
        self._ended = threading.Event()
        self._thread = threading.Thread(target=self._run, name="urdf-ik progress", daemon=True)
        self.start = time.monotonic()

    def __enter__(self) -> Elapsed:
        self._thread.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._ended.set()
        self._thread.join()

    @property
    def seconds(self) -> float:
        """How long ago this was made [s]."""
        return time.monotonic() - self.start

    def _run(self) -> None:
        if is_terminal(sys.stderr):
            if not self._ended.wait(BAR_AFTER):
                self._spin()
            return
        pause = WORD_AFTER
        while not self._ended.wait(pause):
            pause = WORD_EVERY
            print(f"{self._what}: {self.seconds:.0f} s so far", file=sys.stderr, flush=True)

    def _spin(self) -> None:
        from rich.console import Console
        from rich.status import Status

        with Status(self._what, console=Console(stderr=True)) as shown:
            while not self._ended.wait(BAR_AFTER):
                shown.update(f"{self._what}: {self.seconds:.0f} s")
