"""The elements of a batch that a NumPy index names."""

from __future__ import annotations

import math
import operator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from urdf_ik.errors import ArgumentError
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
        return np.asarray(np.arange(math.prod(shape)).reshape(shape)[index])
    except (IndexError, TypeError, ValueError) as failure:
        problem = str(failure)
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
