"""Progress of long work on standard error; short work leaves nothing there."""

import sys
import time
from typing import Self

from urdf_ik.cli.options import is_terminal

WORD_AFTER, WORD_EVERY, WORD_EVERY_ON_TERMINAL = 2.0, 5.0, 0.2
"""Seconds before the first line, and between lines; on a terminal one line is written again and again."""


class Progress:
    """A line now and then."""

    def __init__(self, what: str) -> None:
        """``what`` heads the line."""
        self._what, self._start, self._on_terminal = what, time.monotonic(), is_terminal(sys.stderr)
        self._next, self._is_shown = self._start + WORD_AFTER, False

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        if self._is_shown and self._on_terminal:
            print("\r\x1b[K", end="", file=sys.stderr, flush=True)

    @property
    def seconds(self) -> float:
        """How long ago this was made [s]."""
        return time.monotonic() - self._start

    def tick(self, done: int, total: int) -> None:
        """Show that ``done`` of ``total`` steps are behind us."""
        self.say(f"{done} of {total}")

    def say(self, words: str) -> None:
        """Show what is done now."""
        if time.monotonic() <= self._next:
            return
        self._next, self._is_shown = time.monotonic() + WORD_EVERY, True
        line = f"{self._what}: {words}, {self.seconds:.0f} s so far"
        if self._on_terminal:
            self._next = time.monotonic() + WORD_EVERY_ON_TERMINAL
            line = f"\r\x1b[K{line[:78]}"
        print(line, end="" if self._on_terminal else "\n", file=sys.stderr, flush=True)
