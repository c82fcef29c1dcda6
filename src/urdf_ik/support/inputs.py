"""The checks of arguments, made once, where a public function is entered: each error says what would be valid."""

import math
import numbers
import operator
import os
from collections.abc import Callable, Sequence
from types import EllipsisType
from typing import Any

import numpy as np

from urdf_ik.errors import ArgumentError, UrdfIkError
from urdf_ik.support.text import quoted
from urdf_ik.support.tolerances import LARGEST
from urdf_ik.typing import Array

Error = Callable[[str], UrdfIkError]

MOST_THREADS = 1024
"""Greatest number of threads that share a piece of work."""
MOST_POSES = 10**6
"""Greatest number of random poses: all are in memory at a time."""


def _refusal(value: Any, what: str, needed: str, error: Error = ArgumentError) -> UrdfIkError:
    return error(f"{what}={quoted(value)} given; {needed} needed")


def real(value: Any, what: str, needed: str, error: Error = ArgumentError) -> Array:
    """Numbers as a C-contiguous float64 array of their own shape, finite or not; such an array is returned as it is.

    ``what`` is how the error calls it, ``needed`` what would be valid.
    """
    if type(value) is np.ndarray and value.dtype == np.float64 and value.flags.c_contiguous:
        return np.require(value, np.float64, ["C", "A", "E"])
    try:
        array = np.asarray(value)
        if array.dtype.kind in "fiu":
            return np.require(array, np.float64, ["C", "A", "E"])
        problem = f"it holds values of the type {array.dtype}"
    except (TypeError, ValueError, OverflowError) as failure:
        problem = str(failure)
    raise error(f"{what} must be {needed}: {problem}, {quoted(value)}")


def array(
    value: Any,
    what: str,
    shape: Sequence[int | EllipsisType | None],
    error: Error = ArgumentError,
    *,
    unit: str = "",
) -> Array:
    """``value`` as a C-contiguous float64 array of finite numbers.

    ``shape``: (4, 4) for one pose, (..., 6) for any number of twists, (None, 3) for a list of points.
    """
    wanted = (
        f"({', '.join('...' if n is ... else 'm' if n is None else str(n) for n in shape)}{',' * (len(shape) == 1)})"
    )
    needed = f"finite numbers {wanted}{f' [{unit}]' if unit else ''}"
    out = real(value, what, needed, error)
    batch = bool(shape) and shape[0] is ...
    tail = list(shape[1:] if batch else shape)
    there = out.shape[out.ndim - len(tail) :] if batch and out.ndim >= len(tail) else out.shape
    if len(there) != len(tail) or any(n not in (None, m) for n, m in zip(tail, there, strict=True)):
        raise error(f"{what} of shape {out.shape} given; {needed} are needed")
    if (bad := first_bad(out)) is not None:
        raise error(f"{what}{list(bad) if bad else ''} is {out[bad]}; {why_bad(out[bad])}")
    return out


def first_bad(array: Array, largest: float = LARGEST) -> tuple[int, ...] | None:
    """Index of the first number that is not finite, or beyond ``largest``; None where all are good."""
    good = np.abs(array) <= largest
    return None if good.all() else tuple(int(k) for k in np.argwhere(~good)[0])


def why_bad(value: float, largest: float = LARGEST) -> str:
    """The reason why :func:`first_bad` refuses a number."""
    return f"numbers of at most {largest:g} are taken" if math.isfinite(value) else "a finite number is needed"


def number(
    value: Any,
    what: str,
    error: Error = ArgumentError,
    *,
    low: float = -LARGEST,
    high: float = LARGEST,
    above: float | None = None,
    unit: str = "",
) -> float:
    """A single number from ``low`` to ``high``, or greater than ``above``."""
    valid = is_real(value) or (isinstance(value, np.ndarray) and not value.ndim and value.dtype.kind in "fiu")
    if valid and low <= float(value) <= high and (above is None or value > above):
        return float(value)
    kind = f"a {'finite ' if high <= LARGEST else ''}number{f' of {unit}' if unit else ''}"
    if above is not None:
        kind += f" above {above:g}"
    elif low > -LARGEST:
        kind += f" of at least {low:g}"
    if high < LARGEST or (valid and math.isfinite(value) and value > high):
        kind += f"{' and' if above is not None or low > -LARGEST else ' of'} at most {high:g}"
    raise _refusal(value, what, f"{kind} is", error)


def whole(value: Any, what: str, error: Error = ArgumentError, *, low: int = 0, high: int = 2**31) -> int:
    """A single whole number from ``low`` to ``high``; not 2.0."""
    try:
        if low <= (count := operator.index(value)) <= high:
            return count
    except TypeError:
        pass
    raise _refusal(value, what, f"a whole number from {low} to {high} is", error)


def threads(value: Any) -> int:
    """A number of threads that share a piece of work; 'auto': one for each processor that this process may use."""
    if isinstance(value, str):
        if value != "auto":
            raise _refusal(value, "threads", f"a whole number from 1 to {MOST_THREADS}, or 'auto', is")
        has_affinity = hasattr(os, "sched_getaffinity")  # not on macOS
        return min(len(os.sched_getaffinity(0)) if has_affinity else os.cpu_count() or 1, MOST_THREADS)
    return whole(value, "threads", low=1, high=MOST_THREADS)


def poses(value: Any) -> int:
    """A number ``n`` of random poses."""
    return whole(value, "n", low=1, high=MOST_POSES)


def choice(value: Any, what: str, choices: Sequence[str]) -> str:
    """One of several words."""
    if isinstance(value, str) and value in choices:
        return value
    raise _refusal(value, what, f"one of {', '.join(map(repr, choices))} is")


def is_real(value: object) -> bool:
    """Whether a value is a single real number; not a truth value."""
    return isinstance(value, numbers.Real | np.floating | np.integer) and not isinstance(value, bool | np.bool_)
