"""How long a search may take, what it looks at, and the best that it has found."""

from __future__ import annotations

from time import monotonic
from typing import TYPE_CHECKING, Any

from urdf_ik.support import inputs

if TYPE_CHECKING:
    from collections.abc import Callable


class TimeIsUp(Exception):
    """The time limit of a search has passed. The function that began the search catches it."""


class Watch:
    """The time limit and the progress of one search.

    Attributes:
        limit: s, infinite without a limit.
        doing: what is being looked at, in words.
        best: the best that was found so far, or None.
    """

    def __init__(self, limit: Any, progress: Callable[[str], object] | None) -> None:
        """Begin now.

        Raises:
            ArgumentError: ``limit`` is neither None nor a number of seconds, or ``progress`` is no function.
        """
        inputs.callback(progress, "progress")
        self.limit = float("inf") if limit is None else inputs.number(limit, "time_limit", low=0.0, unit="s")
        self.doing = "reading the settings"
        self.best: Any = None
        self._end = monotonic() + self.limit
        self._progress = progress

    def begin(self, doing: str) -> None:
        """Report what is looked at next.

        Raises:
            TimeIsUp: the time limit has passed.
        """
        self.check()
        self.doing = doing
        if self._progress is not None:
            self._progress(doing)

    def check(self) -> None:
        """Go on, or not.

        Raises:
            TimeIsUp: the time limit has passed.
        """
        if monotonic() >= self._end:
            raise TimeIsUp

    def close(self) -> None:
        """The search has ended: what is looked for later, when it is asked for, has no limit."""
        self._end, self._progress = float("inf"), None
