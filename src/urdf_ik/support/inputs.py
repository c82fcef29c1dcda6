"""Numbers that are given from outside: read in one way, so that what is refused in one place is refused in all."""

from __future__ import annotations

import contextlib
import inspect
import math
import numbers
import operator
import os
from collections.abc import Mapping
from itertools import islice
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from urdf_ik.errors import ArgumentError, UrdfIkError
from urdf_ik.support import sequences
from urdf_ik.support.text import quoted
from urdf_ik.support.tolerances import LARGEST

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from numpy.typing import NDArray

    Array = NDArray[np.float64]

MOST_THREADS = 1024
"""Threads that share a piece of work at most."""
MOST_POSES = 10**6
"""Random poses that are drawn at most: they are all in memory at a time."""
MOST_ITEMS = 100_000
"""Names, paths or other things in a list at most."""
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


def real(value: Any, what: str, needed: str, error: Callable[[str], UrdfIkError] = ArgumentError) -> Array:
    """``value`` as a C-contiguous float64 array of its own shape; whether it is finite is not looked at.

    Args:
        value: an array, a number, or lists of them.
        what: how the error calls it.
        needed: what would be valid.
        error: what is raised.

    Returns:
        ``value`` itself where it is such an array already.

    Raises:
        UrdfIkError: ``error``; complex numbers, truth values, dates, text (numeric text, too), structured and masked
            arrays, lists whose parts do not fit together, lists and ranges of more than ``sequences.MOST_LISTED``
            numbers, and what is no number at all.

    Example:
        >>> real([[1, 2], [3, 4]], "q", "an array of numbers").tolist()
        [[1.0, 2.0], [3.0, 4.0]]
        >>> real(["1", "2"], "q", "an array of numbers")
        Traceback (most recent call last):
        urdf_ik.errors.ArgumentError: q must be an array of numbers: text is given, ['1', '2']
    """
    if type(value) is np.ndarray and value.dtype == np.float64 and value.flags.c_contiguous:
        return np.require(value, np.float64, ["C", "A", "E"])
    try:
        problem, others = sequences.looked_through(value)
        if problem:
            raise error(f"{what} must be {needed}: {problem}, {quoted(value)}")
        array = np.asarray(sequences.as_lists(value) if others else value)
    except UrdfIkError:
        raise
    except Exception as failure:  # whatever an object of unknown origin raises where it is asked for an array
        reason = " ".join(str(failure).split())[:200]
        raise error(f"{what} must be {needed}: {reason}, {quoted(value)}") from None
    kind = array.dtype.kind
    if kind in _NO_NUMBERS:
        problem = f"{_NO_NUMBERS[kind]} is given" if kind in "SUTV" else f"{_NO_NUMBERS[kind]} are given"
    elif kind == "O" and not all(is_real(each) for each in array.flat):
        problem = "there are other things than numbers in it"
    if problem:
        raise error(f"{what} must be {needed}: {problem}, {quoted(value)}")
    try:
        with np.errstate(over="ignore"):
            return np.require(array, np.float64, ["C", "A", "E"])
    except (OverflowError, TypeError, ValueError, MemoryError) as failure:
        raise error(f"{what} must be {needed}: {failure}, {quoted(value)}") from None


def first_bad(array: Array, largest: float = LARGEST) -> tuple[int, ...] | None:
    """Index of the first number that is not finite, or beyond ``largest``; None where all are good.

    Example:
        >>> first_bad(np.array([[0.5, 1.0], [np.nan, 2.0]]))
        (1, 0)
    """
    good = np.abs(array) <= largest
    return None if good.all() else tuple(int(k) for k in np.argwhere(~good)[0])


def why_bad(value: float, largest: float = LARGEST) -> str:
    """What is wrong with a number that :func:`first_bad` found.

    Example:
        >>> why_bad(float("nan")), why_bad(1e200)
        ('a finite number is needed', 'numbers of at most 1e+15 are taken')
    """
    return f"numbers of at most {largest:g} are taken" if math.isfinite(value) else "a finite number is needed"


def number(
    value: Any,
    what: str,
    error: Callable[[str], UrdfIkError] = ArgumentError,
    *,
    low: float = -LARGEST,
    high: float = LARGEST,
    above: float | None = None,
    unit: str = "",
) -> float:
    """A single number.

    Args:
        value: a number, or an array without dimensions.
        what: how the error calls it.
        error: what is raised.
        low: least value.
        high: greatest value; may be infinite.
        above: what the value must be greater than, in the place of ``low``.
        unit: of the number, for the message.

    Raises:
        UrdfIkError: ``error``; it is no number, or out of range.

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
    raise error(f"{what}={quoted(value)} given; {kind} is needed")


def usable(values: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Which numbers are within a factor of LARGEST of one: their squares and inverses neither overflow nor vanish.

    Example:
        >>> usable(np.array([1.0, 0.0, 5e-324, 1e15, np.inf, np.nan])).tolist()
        [True, False, False, True, False, False]
    """
    return np.asarray((values >= 1.0 / LARGEST) & (values <= LARGEST))


USABLE = f"between {1.0 / LARGEST:g} and {LARGEST:g}"
"""The same in words."""


def whole(
    value: Any, what: str, error: Callable[[str], UrdfIkError] = ArgumentError, *, low: int = 0, high: int = 2**31
) -> int:
    """A single whole number.

    Raises:
        UrdfIkError: ``error``; it is no whole number (2.0 and True are none), or out of range.

    Example:
        >>> whole(2.5, "threads", low=1)
        Traceback (most recent call last):
        urdf_ik.errors.ArgumentError: threads=2.5 given; a whole number from 1 to 2147483648 is needed
    """
    try:
        given = None if isinstance(value, bool | np.bool_ | np.ma.MaskedArray) else operator.index(value)
    except Exception:  # whatever an object of unknown origin raises where it is asked for a number
        given = None
    if given is None or not low <= given <= high:
        raise error(f"{what}={quoted(value)} given; a whole number from {low} to {high} is needed")
    return given


def threads(value: Any, error: Callable[[str], UrdfIkError] = ArgumentError) -> int:
    """A number of threads that share a piece of work.

    Raises:
        UrdfIkError: ``error``; it is no whole number, or out of range.

    Example:
        >>> threads(10**9)
        Traceback (most recent call last):
        urdf_ik.errors.ArgumentError: threads=1000000000 given; a whole number from 1 to 1024 is needed
    """
    return whole(value, "threads", error, low=1, high=MOST_THREADS)


def items(
    value: Any, what: str, needed: str, error: Callable[[str], UrdfIkError] = ArgumentError, most: int = MOST_ITEMS
) -> tuple[Any, ...]:
    """What a list, or another iterable of bounded length, holds; a text is none.

    Raises:
        UrdfIkError: ``error``; it cannot be gone through, or does not end after ``most`` items.

    Example:
        >>> items("joint_1", "joints", "names of joints")
        Traceback (most recent call last):
        urdf_ik.errors.ArgumentError: joints='joint_1' given; names of joints are needed
    """
    if not isinstance(value, str | bytes | os.PathLike):
        try:
            held = tuple(islice(value, most + 1))
        except Exception:  # whatever an object of unknown origin raises where it is asked for what it holds
            held = None
        if held is not None and len(held) > most:
            raise error(f"{what} holds more than {most} items; {needed} are needed")
        if held is not None:
            return held
    raise error(f"{what}={quoted(value)} given; {needed} are needed")


def poses(value: Any, error: Callable[[str], UrdfIkError] = ArgumentError) -> int:
    """A number ``n`` of random poses that are held in memory at a time.

    Raises:
        UrdfIkError: ``error``; it is no whole number, or out of range.

    Example:
        >>> poses(10**9)
        Traceback (most recent call last):
        urdf_ik.errors.ArgumentError: n=1000000000 given; a whole number from 1 to 1000000 is needed
    """
    return whole(value, "n", error, low=1, high=MOST_POSES)


def path(value: Any, what: str, error: Callable[[str], UrdfIkError] = ArgumentError) -> Path:
    """The path of a file, which need not exist.

    Raises:
        UrdfIkError: ``error``; not a path, an empty one, one with a null byte, or a relative one while the working
            directory is gone.

    Example:
        >>> path(3, "output")
        Traceback (most recent call last):
        urdf_ik.errors.ArgumentError: output=3 given; the path of a file is needed
    """
    if isinstance(value, str | os.PathLike):
        try:
            written: object = os.fspath(value)
        except Exception:  # the same where it is asked for a path
            written = None
        if isinstance(written, str) and written.strip() and "\0" not in written:
            found = Path(written)
            if not found.is_absolute() and not _in_a_folder():
                raise error(f"{what}={quoted(written)} given; the working directory is gone, give an absolute path")
            return found
    raise error(f"{what}={quoted(value)} given; the path of a file is needed")


def _in_a_folder() -> bool:
    """Whether the working directory still exists."""
    try:
        return bool(os.getcwd())
    except OSError:
        return False


def flag(value: Any, what: str, error: Callable[[str], UrdfIkError] = ArgumentError) -> bool:
    """True or false.

    Raises:
        UrdfIkError: ``error``; it is neither, nor 0 or 1.

    Example:
        >>> flag("no", "within_limits")
        Traceback (most recent call last):
        urdf_ik.errors.ArgumentError: within_limits='no' given; True or False is needed
    """
    if isinstance(value, bool | np.bool_) or (isinstance(value, int) and value in (0, 1)):
        return bool(value)
    raise error(f"{what}={quoted(value)} given; True or False is needed")


def kind(
    value: Any, attribute: str, what: str, needed: str, error: Callable[[str], UrdfIkError] = ArgumentError
) -> None:
    """Refuse an object of another kind than the one that is told by an attribute of its class.

    Raises:
        UrdfIkError: ``error``; it has no such attribute.

    Example:
        >>> kind("ur5", "chain", "a", "an arm, as urdf_ik.load gives it,")
        Traceback (most recent call last):
        urdf_ik.errors.ArgumentError: a='ur5' given; an arm, as urdf_ik.load gives it, is needed
    """
    missing = object()
    # Not what an object answers to any name, as a mock does.
    if isinstance(value, type) or inspect.getattr_static(value, attribute, missing) is missing:
        raise error(f"{what}={quoted(value)} given; {needed} is needed")


def mapping(
    value: Any, what: str, needed: str, error: Callable[[str], UrdfIkError] = ArgumentError
) -> Mapping[Any, Any]:
    """Values by name.

    Raises:
        UrdfIkError: ``error``; it is no mapping.

    Example:
        >>> mapping(["joint_1"], "values", "a value for each joint by name")
        Traceback (most recent call last):
        urdf_ik.errors.ArgumentError: values=['joint_1'] given; a value for each joint by name is needed
    """
    if isinstance(value, Mapping):
        with contextlib.suppress(Exception):  # whatever a mapping of unknown origin raises where it is read
            count = len(value)
            found = dict(islice(value.items(), count + 1))  # it may go on without end
            if len(found) == count:
                return found
    raise error(f"{what}={quoted(value)} given; {needed} is needed")


def callback(value: Any, what: str, error: Callable[[str], UrdfIkError] = ArgumentError) -> None:
    """Refuse what can neither be called nor is None.

    Raises:
        UrdfIkError: ``error``; it is no function.

    Example:
        >>> callback("bar", "progress")
        Traceback (most recent call last):
        urdf_ik.errors.ArgumentError: progress='bar' given; a function, or None, is needed
    """
    if value is not None and not callable(value):
        raise error(f"{what}={quoted(value)} given; a function, or None, is needed")


def arm(value: Any, what: str = "arm", error: Callable[[str], UrdfIkError] = ArgumentError) -> None:
    """Refuse what is no arm: see :func:`kind`.

    Example:
        >>> arm(None)
        Traceback (most recent call last):
        urdf_ik.errors.ArgumentError: arm=None given; an arm, as urdf_ik.load gives it, is needed
    """
    needed = "an arm, as urdf_ik.load gives it,"
    kind(value, "chain", what, needed, error)
    if callable(inspect.getattr_static(value, "chain", None)):  # a DH table, which makes one
        raise error(f"{what}={quoted(value)} given; {needed} is needed")


def choice(value: Any, what: str, choices: Sequence[str], error: Callable[[str], UrdfIkError] = ArgumentError) -> str:
    """One of several words.

    Raises:
        UrdfIkError: ``error``; it is none of them.

    Example:
        >>> choice("l3", "metric", ("l2", "max"))
        Traceback (most recent call last):
        urdf_ik.errors.ArgumentError: metric='l3' given; one of 'l2', 'max' is needed
    """
    if isinstance(value, str) and value in choices:
        return value
    raise error(f"{what}={quoted(value)} given; one of {', '.join(map(repr, choices))} is needed")


def is_real(value: object) -> bool:
    """Whether it is a single real number, of any kind but a truth value or a time.

    Example:
        >>> is_real(3), is_real(np.float32(0.5)), is_real("3"), is_real(True)
        (True, True, False, False)
    """
    return isinstance(value, numbers.Real | np.floating | np.integer) and not isinstance(
        value, bool | np.bool_ | np.timedelta64
    )
