"""The length check of sequences that are converted to arrays; it runs before they are expanded."""

from __future__ import annotations

from array import array as packed
from collections.abc import Mapping
from itertools import islice
from typing import Any

import numpy as np

MOST_LISTED = 2**24
"""Greatest count of numbers in lists, ranges and other sequences, which take ten times the memory of an array."""
MOST_REPEATED = 2**27
"""Greatest count of numbers in an array that repeats its memory, such as ``np.broadcast_to`` returns: 1 GiB."""
_DEEPEST = 8
"""Greatest depth of nested lists: stacks of stacks of poses have six levels."""
_MASKED = "a masked array is given"
_LEAVES = frozenset((float, int, bool, complex, str, bytes, type(None), np.float64, np.float32, np.int64, np.str_))
_AS_ARRAY = ("__array__", "__array_interface__", "__array_struct__", "__buffer__")


def too_long(value: Any) -> str:
    """The reason why a sequence is not converted to an array (too long, too deep or masked), '' without one.

    Example:
        >>> too_long(range(10**9))
        'more than 16777216 numbers in lists or ranges are given; give a NumPy array'
    """
    return looked_through(value)[0]


def looked_through(value: Any) -> tuple[str, bool]:
    """The reason as in :func:`too_long`, and whether the value contains sequences other than lists.

    Only lengths are read: a range of any length costs nothing.

    Example:
        >>> looked_through([0.5, range(3)])
        ('', True)
    """
    if isinstance(value, np.ndarray):
        if isinstance(value, np.ma.MaskedArray):
            return _MASKED, False
        repeated = value.size > MOST_REPEATED and 0 in value.strides
        return f"a view that stands for more than {MOST_REPEATED} numbers is given" if repeated else "", False
    level, others = [value], False
    for _ in range(_DEEPEST):
        count = 0
        inner: list[Any] = []
        for each in level:
            if isinstance(each, list | tuple):
                count += len(each)
                inner.append(each)
            elif isinstance(each, np.ndarray):
                if isinstance(each, np.ma.MaskedArray):
                    return _MASKED, others
                count += each.size
            elif _is_sequence(each):
                count += _length(each)
                others = True
            if count > MOST_LISTED:
                return f"more than {MOST_LISTED} numbers in lists or ranges are given; give a NumPy array", others
        level = [part for each in inner for part in each if type(part) not in _LEAVES]
        if not level:
            return "", others
    deeper = any(isinstance(each, list | tuple) or _is_sequence(each) for each in level)
    return f"lists within lists are given, more than {_DEEPEST} deep" if deeper else "", others


def _is_sequence(value: Any) -> bool:
    """Whether NumPy would go through it element by element; an enumeration has a length, its members have none."""
    kind = type(value)
    own = {name for base in kind.__mro__ for name in ("__len__", "__getitem__") if name in vars(base)}
    return (
        len(own) == 2
        and not isinstance(value, str | bytes | bytearray | memoryview | packed | Mapping)
        and not any(hasattr(kind, name) for name in _AS_ARRAY)
    )


def _length(value: Any) -> int:
    try:
        return len(value)
    except OverflowError:  # beyond what fits in a machine's word
        return MOST_LISTED + 1


def as_lists(value: Any) -> Any:
    """The same with other sequences than lists as lists: one may go on without end, whatever it says of its length.

    Raises:
        ValueError: one is not as long as it says.

    Example:
        >>> as_lists([range(3)])
        [[0, 1, 2]]
    """
    if isinstance(value, list | tuple):
        return [as_lists(each) for each in value]
    if not _is_sequence(value):
        return value
    count = _length(value)
    listed = list(islice(value, count + 1))
    if len(listed) != count:
        raise ValueError(f"a {type(value).__name__} that is not as long as it says")
    return as_lists(listed)
