"""The elements of a batch that a NumPy index names."""

from __future__ import annotations

import math
import operator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from urdf_ik.errors import ArgumentError
from urdf_ik.support import sequences
from urdf_ik.support.text import quoted


def picked(shape: tuple[int, ...], index: Any) -> NDArray[np.intp]:
    """Numbers of those poses of a batch that an index picks, whatever NumPy takes for one.

    Args:
        shape: of the batch.
        index: a number, a slice, numbers or truth values, or a tuple of these.

    Raises:
        ArgumentError: it is no index, or leads out of the batch.

    Example:
        >>> picked((2, 3), (slice(None), 1)).tolist()
        [1, 4]
        >>> picked((2, 3), 7)
        Traceback (most recent call last):
        urdf_ik.errors.ArgumentError: index 7 into a batch of shape (2, 3): index 7 is out of bounds ...
    """
    try:
        parts = index if isinstance(index, tuple) else (index,)
        looked = [sequences.looked_through(part) for part in parts]
        problem = next((problem for problem, _ in looked if problem), "")
        if not problem:
            # What is no list may go on without end, whatever it says of its length.
            known = (
                sequences.as_lists(part) if others else part for part, (_, others) in zip(parts, looked, strict=True)
            )
            return np.asarray(np.arange(math.prod(shape)).reshape(shape)[tuple(known)])
    except Exception as failure:  # whatever an object of unknown origin raises where it is asked for an index
        problem = " ".join(str(failure).split())[:200]
    raise ArgumentError(f"index {quoted(index)} into a batch of shape {shape}: {problem}")


def place(count: int, index: Any, what: str) -> int:
    """The place in a sequence that an index names, from its end where it is negative.

    Raises:
        ArgumentError: it is no whole number, or leads out of the sequence.

    Example:
        >>> place(3, -1, "solutions")
        2
        >>> place(3, 3, "solutions")
        Traceback (most recent call last):
        urdf_ik.errors.ArgumentError: index 3 given; there are 3 solutions
    """
    try:
        return range(count)[operator.index(index)]
    except Exception:  # the same
        raise ArgumentError(f"index {quoted(index)} given; there are {count} {what}") from None
