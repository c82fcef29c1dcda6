"""How long a piece of work may take, what it looks at, and the best that it has found."""

from collections.abc import Callable, Iterator
from time import monotonic
from typing import Any

from urdf_ik.support import inputs

Progress = Callable[[int, int], object]
"""Called with how many things of all are behind the work."""


class TimeIsUp(Exception):
    """The time limit of a search has passed. The function that began the search catches it."""


class Watch:
    """The time limit and the progress of one piece of work.

    A search says in words what it looks at (``begin``); work on many things of a kind says how many are behind it
    (``step``).

    Attributes:
        limit: s, infinite without a limit.
        doing: what is being looked at, in words.
        best: the best that was found so far, or None.
        unlooked: what :meth:`parts` left out, in words; '' where nothing was.
    """

    def __init__(self, limit: Any, progress: Callable[..., object] | None) -> None:
        """Begin now; an ArgumentError unless ``limit`` is None or a number of seconds."""
        self.limit = float("inf") if limit is None else inputs.number(limit, "time_limit", low=0.0, unit="s")
        self.doing = "reading the settings"
        self.best: Any = None
        self.unlooked = ""
        self._end = monotonic() + self.limit
        self._progress = progress

    @property
    def is_over(self) -> bool:
        """Whether the time limit has passed."""
        return monotonic() >= self._end

    def begin(self, doing: str) -> None:
        """Report what is looked at next; TimeIsUp where the time limit has passed."""
        self.check()
        self.doing = doing
        if self._progress is not None:
            self._progress(doing)

    def step(self, done: int, total: int) -> None:
        """Report how many things of all are behind the work."""
        if self._progress is not None:
            self._progress(done, total)

    def parts(self, total: int, size: int = 1, what: str = "poses") -> Iterator[range]:
        """The numbers from 0 to ``total`` in ranges of ``size``, until the time limit has passed."""
        for start in range(0, total, size):
            if self.is_over:
                self.unlooked = self.ended(f"with {start} of {total} {what}: the others were")
                return
            part = range(start, min(start + size, total))
            yield part
            self.step(part.stop, total)

    def check(self) -> None:
        """TimeIsUp where the time limit has passed."""
        if self.is_over:
            raise TimeIsUp

    def ended(self, what: str) -> str:
        """How the work ended, in words; ``what`` was not looked at, its verb included."""
        return f"ended by the time limit of {self.limit:g} s {what} not looked at"

    def close(self) -> None:
        """The search has ended: what is looked for later, when it is asked for, has no limit."""
        self._end, self._progress = float("inf"), None
