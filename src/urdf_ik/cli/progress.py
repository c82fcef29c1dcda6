"""Progress of long work on standard error; short work leaves nothing there."""

from __future__ import annotations

import sys
import time
from typing import Any

from urdf_ik.cli.options import is_terminal

BAR_AFTER, WORD_AFTER, WORD_EVERY = 0.5, 2.0, 5.0
"""Seconds before a bar, before the first line where nobody sees a bar, and between lines."""


class Progress:
    """A bar on a terminal, else a line every few seconds."""

    def __init__(self, what: str) -> None:
        """``what`` heads the bar."""
        self._what, self._start = what, time.monotonic()
        self._next_word = self._start + WORD_AFTER
        self._bar: Any = None

    def __enter__(self) -> Progress:
        return self

    def __exit__(self, *_: object) -> None:
        if self._bar is not None:
            self._bar.stop()

    @property
    def seconds(self) -> float:
        """How long ago this was made [s]."""
        return time.monotonic() - self._start

    def tick(self, done: int, total: int) -> None:
        """Show that ``done`` of ``total`` steps are behind us."""
        self._show(f"{self._what}: {done} of {total}", done, total)

    def say(self, words: str) -> None:
        """Show what is done now, of work that cannot say how far it is."""
        self._show(f"{self._what}: {words}, {self.seconds:.0f} s so far", 0, None)

    def _show(self, line: str, done: int, total: int | None) -> None:
        if not is_terminal(sys.stderr):
            if time.monotonic() > self._next_word:
                self._next_word = time.monotonic() + WORD_EVERY
                print(line, file=sys.stderr, flush=True)
        elif self.seconds > BAR_AFTER:
            if self._bar is None:
                from rich.console import Console
                from rich.progress import Progress as Bar

                self._bar = Bar(console=Console(stderr=True), transient=True)
                self._bar.add_task(self._what, total=total)
                self._bar.start()
            self._bar.update(self._bar.task_ids[0], description=line, completed=done, total=total)
