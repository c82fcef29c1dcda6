"""Checks of arguments: numbers, flags, names, paths and objects; each error says the value and what is valid."""

from __future__ import annotations

import contextlib
import inspect
import math
import numbers
import operator
import os
from collections.abc import Callable, Mapping, Sequence
from itertools import islice
from pathlib import Path
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from urdf_ik.errors import ArgumentError, UrdfIkError
from urdf_ik.support import sequences
from urdf_ik.support.text import quoted
from urdf_ik.support.tolerances import LARGEST
from urdf_ik.typing import Array

Error = Callable[[str], UrdfIkError]

Threads = int | Literal["auto"]
"""How many threads share a piece of work: see :func:`threads`."""
MOST_THREADS = 1024
"""Greatest number of threads that share a piece of work."""
MOST_POSES = 10**6
"""Greatest number of random poses: all are in memory at a time."""
MOST_ITEMS = 100_000
"""Greatest number of names, paths or other items in a list."""
_NO_NUMBERS = {
    "b": "truth values",
    "c": "complex numbers",
    "M": "dates",
    "m": "durations",
    "S": "text",
    "U": "text",
    "T": "text",
    "V": "a structured array",
}


def _refusal(value: Any, what: str, needed: str, error: Error = ArgumentError) -> UrdfIkError:
    return error(f"{what}={quoted(value)} given; {needed} needed")


def real(value: Any, what: str, needed: str, error: Error = ArgumentError) -> Array:
    """``value`` as a C-contiguous float64 array of its own shape; finite or not.

    Args:
        value: an array, a number, or lists of them; returned as it is where it is such an array already.
        what: how the error calls it.
        needed: what would be valid.
        error: class of the error.

    Raises:
        UrdfIkError: ``error``; complex numbers, truth values, dates, text (numeric text, too), structured and masked
            arrays, ragged lists, lists and ranges of more than ``sequences.MOST_LISTED`` numbers, and other objects.

    Example:
        >>> real([[1, 2], [3, 4]], "q", "an array of numbers").tolist()
        [[1.0, 2.0], [3.0, 4.0]]
        >>> real(["1", "2"], "q", "an array of numbers")
        Traceback (most recent call last):
        urdf_ik.errors.ArgumentError: q must be an array of numbers: text is given, ['1', '2']
    """
    if type(value) is np.ndarray and value.dtype == np.float64 and value.flags.c_contiguous:
        return np.require(value, np.float64, ["C", "A", "E"])
    array = np.empty(0)
    try:
        problem, others = sequences.looked_through(value)
        if not problem:
            array = np.asarray(sequences.as_lists(value) if others else value)
    except Exception as failure:  # an object of unknown origin raises anything when it is converted
        problem = " ".join(str(failure).split())[:200] or type(failure).__name__
    kind = array.dtype.kind
    if not problem and kind in _NO_NUMBERS:
        problem = f"{_NO_NUMBERS[kind]} {'is' if kind in 'SUTV' else 'are'} given"
    elif not problem and kind == "O" and not all(is_real(each) for each in array.flat):
        problem = "it holds values that are not numbers"
    if not problem:
        try:
            with np.errstate(over="ignore"):
                return np.require(array, np.float64, ["C", "A", "E"])
        except (OverflowError, TypeError, ValueError, MemoryError) as failure:
            problem = str(failure)
    raise error(f"{what} must be {needed}: {problem}, {quoted(value)}")


def first_bad(array: Array, largest: float = LARGEST) -> tuple[int, ...] | None:
    """Index of the first number that is not finite, or beyond ``largest``; None where all are good.

    Example:
        >>> first_bad(np.array([[0.5, 1.0], [np.nan, 2.0]]))
        (1, 0)
    """
    good = np.abs(array) <= largest
    return None if good.all() else tuple(int(k) for k in np.argwhere(~good)[0])


def why_bad(value: float, largest: float = LARGEST) -> str:
    """The reason why :func:`first_bad` found a number.

    Example:
        >>> why_bad(float("nan")), why_bad(1e200)
        ('a finite number is needed', 'numbers of at most 1e+15 are taken')
    """
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
    """A single number, or an array without dimensions.

    Args:
        value: the number.
        what: how the error calls it.
        error: class of the error.
        low: least value.
        high: greatest value; may be infinite.
        above: bound that the value must exceed, in place of ``low``.
        unit: of the number, for the message.

    Raises:
        UrdfIkError: ``error``; not a number, or out of range.

    Example:
        >>> number("3", "margin", low=0.0, unit="m")
        Traceback (most recent call last):
        urdf_ik.errors.ArgumentError: margin='3' given; a finite number of m of at least 0 is needed
    """
    alone = isinstance(value, np.ndarray) and not value.ndim and not isinstance(value, np.ma.MaskedArray)
    single = value.item() if alone else value
    good = is_real(single)
    try:
        given = float(single) if good else math.nan
    except Exception:  # a number too large; a time difference, which passes for a real number; an odd object
        given = math.inf
    if good and low <= given <= high and (above is None or given > above):
        return given
    kind = f"a {'finite ' if high <= LARGEST else ''}number{f' of {unit}' if unit else ''}"
    if above is not None:
        kind += f" above {above:g}"
    elif low > -LARGEST:
        kind += f" of at least {low:g}"
    if high < LARGEST:
        kind += f"{' and' if above is not None or low > -LARGEST else ' of'} at most {high:g}"
    elif good and math.isfinite(given) and given > high:
        kind += f", at most {high:g},"
    raise _refusal(value, what, f"{kind} is", error)


def usable(values: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Which numbers are within a factor of LARGEST of one: their squares and inverses neither overflow nor vanish.

    Example:
        >>> usable(np.array([1.0, 0.0, 5e-324, 1e15, np.inf, np.nan])).tolist()
        [True, False, False, True, False, False]
    """
    return np.asarray((values >= 1.0 / LARGEST) & (values <= LARGEST))


USABLE = f"between {1.0 / LARGEST:g} and {LARGEST:g}"
"""The same in words."""


def whole(value: Any, what: str, error: Error = ArgumentError, *, low: int = 0, high: int = 2**31) -> int:
    """A single whole number; neither 2.0 nor True.

    Example:
        >>> whole(2.5, "threads", low=1)
        Traceback (most recent call last):
        urdf_ik.errors.ArgumentError: threads=2.5 given; a whole number from 1 to 2147483648 is needed
    """
    try:
        given = None if isinstance(value, bool | np.bool_ | np.ma.MaskedArray) else operator.index(value)
    except Exception:  # an object of unknown origin raises anything
        given = None
    if given is None or not low <= given <= high:
        raise _refusal(value, what, f"a whole number from {low} to {high} is", error)
    return given


def threads(value: Any) -> int:
    """A number of threads that share a piece of work; 'auto': one for each processor that this process may use.

    Example:
        >>> threads("auto") >= 1, threads(2)
        (True, 2)
    """
    if isinstance(value, str) and value == "auto":
        return min(processors(), MOST_THREADS)
    try:
        return whole(value, "threads", low=1, high=MOST_THREADS)
    except ArgumentError:
        raise _refusal(value, "threads", f"a whole number from 1 to {MOST_THREADS}, or 'auto', is") from None


def processors() -> int:
    """How many processors this process may use."""
    if hasattr(os, "sched_getaffinity"):  # not on macOS
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def poses(value: Any) -> int:
    """A number ``n`` of random poses."""
    return whole(value, "n", low=1, high=MOST_POSES)


def items(value: Any, what: str, needed: str, error: Error = ArgumentError, most: int = MOST_ITEMS) -> tuple[Any, ...]:
    """The items of a list or another iterable, ``most`` of them at most; not the letters of a text.

    Example:
        >>> items("joint_1", "joints", "names of joints")
        Traceback (most recent call last):
        urdf_ik.errors.ArgumentError: joints='joint_1' given; names of joints are needed
    """
    held = None
    if not isinstance(value, str | bytes | os.PathLike):
        with contextlib.suppress(Exception):  # an object of unknown origin raises anything
            held = tuple(islice(value, most + 1))
    if held is None:
        raise _refusal(value, what, f"{needed} are", error)
    if len(held) > most:
        raise error(f"{what} holds more than {most} items; {needed} are needed")
    return held


def path(value: Any, what: str, error: Error = ArgumentError) -> Path:
    """The path of a file, which need not exist.

    Raises:
        UrdfIkError: ``error``; not a path, an empty one, one with a null byte, or a relative one while the working
            directory is gone.

    Example:
        >>> path(3, "output")
        Traceback (most recent call last):
        urdf_ik.errors.ArgumentError: output=3 given; the path of a file is needed
    """
    written: object = None
    if isinstance(value, str | os.PathLike):
        with contextlib.suppress(Exception):  # the same
            written = os.fspath(value)
    if not isinstance(written, str) or not written.strip() or "\0" in written:
        raise _refusal(value, what, "the path of a file is", error)
    found = Path(written)
    try:
        if not found.is_absolute():
            os.getcwd()
    except OSError:
        raise error(f"{what}={quoted(written)} given; the working directory is gone, give an absolute path") from None
    return found


def flag(value: Any, what: str, error: Error = ArgumentError) -> bool:
    """True or False, also as 1 or 0.

    Example:
        >>> flag("no", "within_limits")
        Traceback (most recent call last):
        urdf_ik.errors.ArgumentError: within_limits='no' given; True or False is needed
    """
    if isinstance(value, bool | np.bool_) or (isinstance(value, int) and value in (0, 1)):
        return bool(value)
    raise _refusal(value, what, "True or False is", error)


def kind(value: Any, attribute: str, what: str, needed: str, error: Error = ArgumentError) -> None:
    """Refuse an object whose class lacks an attribute.

    Example:
        >>> kind("ur5", "chain", "a", "an arm, as urdf_ik.load gives it,")
        Traceback (most recent call last):
        urdf_ik.errors.ArgumentError: a='ur5' given; an arm, as urdf_ik.load gives it, is needed
    """
    missing = object()
    # A static look-up: a mock answers to any name.
    if isinstance(value, type) or inspect.getattr_static(value, attribute, missing) is missing:
        raise _refusal(value, what, f"{needed} is", error)


def arm(value: Any, what: str = "arm") -> None:
    """Refuse an object that is not an arm.

    Example:
        >>> arm(None)
        Traceback (most recent call last):
        urdf_ik.errors.ArgumentError: arm=None given; an arm, as urdf_ik.load gives it, is needed
    """
    needed = "an arm, as urdf_ik.load gives it,"
    kind(value, "chain", what, needed)
    if callable(inspect.getattr_static(value, "chain", None)):  # a DH table, which makes a chain
        raise _refusal(value, what, f"{needed} is")


def mapping(value: Any, what: str, needed: str) -> Mapping[Any, Any]:
    """Values by name.

    Example:
        >>> mapping(["joint_1"], "values", "a value for each joint by name")
        Traceback (most recent call last):
        urdf_ik.errors.ArgumentError: values=['joint_1'] given; a value for each joint by name is needed
    """
    if isinstance(value, Mapping):
        with contextlib.suppress(Exception):  # a mapping of unknown origin raises anything
            count = len(value)
            found = dict(islice(value.items(), count + 1))  # it may go on without end
            if len(found) == count:
                return found
    raise _refusal(value, what, f"{needed} is")


def callback(value: Any, what: str) -> None:
    """Refuse a value that is neither None nor a function."""
    if value is not None and not callable(value):
        raise _refusal(value, what, "a function, or None, is")


def choice(value: Any, what: str, choices: Sequence[str]) -> str:
    """One of several words.

    Example:
        >>> choice("l3", "metric", ("l2", "max"))
        Traceback (most recent call last):
        urdf_ik.errors.ArgumentError: metric='l3' given; one of 'l2', 'max' is needed
    """
    if isinstance(value, str) and value in choices:
        return value
    raise _refusal(value, what, f"one of {', '.join(map(repr, choices))} is")


def is_real(value: object) -> bool:
    """Whether a value is a single real number; neither a truth value nor a time.

    Example:
        >>> is_real(3), is_real(np.float32(0.5)), is_real("3"), is_real(True)
        (True, True, False, False)
    """
    return isinstance(value, numbers.Real | np.floating | np.integer) and not isinstance(
        value, bool | np.bool_ | np.timedelta64
    )
