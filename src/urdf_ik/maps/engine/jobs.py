"""What makes the chunks of a store."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Protocol


class Job(Protocol):
    """What makes the files of a chunk: the same bytes whoever makes them, and when. It is pickled for workers."""

    def __call__(self, chunk: int, /) -> Mapping[str, bytes]:
        """The files of a chunk, by their paths in the store."""
