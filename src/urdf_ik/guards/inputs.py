"""Numbers that are given from outside: read in one way, so that what is refused in one place is refused in all."""

from __future__ import annotations

import math
import numbers
import operator
import os
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from urdf_ik.errors import ArgumentError
from urdf_ik.text import quoted
from urdf_ik.tolerances import LARGEST

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from numpy.typing import NDArray

    from urdf_ik.errors import UrdfIkError

    Array = NDArray[np.float64]

_DEEPEST = 8
"""Levels of lists within lists that are looked at: stacks of stacks of poses have six."""
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
            arrays, lists whose parts do not fit together, and what is no number at all.

    Example:
        >>> real([[1, 2], [3, 4]], "q", "an array of numbers").tolist()
        [[1.0, 2.0], [3.0, 4.0]]
        >>> real(["1", "2"], "q", "an array of numbers")
        Traceback (most recent call last):
        urdf_ik.errors.ArgumentError: q must be an array of numbers: text is given, ['1', '2']
    """
    if type(value) is np.ndarray and value.dtype == np.float64:
        return np.require(value, np.float64, ["C", "A", "E"])
    try:
        problem = "a masked array is given" if is_masked(value) else ""
        array = np.asarray(value)
    except Exception as failure:  # whatever an object of unknown origin raises where it is asked for an array
        reason = " ".join(str(failure).split())[:200]
        raise error(f"{what} must be {needed}: {reason}, {quoted(value)}") from None
    kind = array.dtype.kind
    if kind in _NO_NUMBERS:
        problem = problem or f"{_NO_NUMBERS[kind]} is given" if kind in "SUTV" else f"{_NO_NUMBERS[kind]} are given"
    elif kind == "O" and not all(is_real(each) for each in array.flat):
        problem = problem or "there are other things than numbers in it"
    if problem:
        raise error(f"{what} must be {needed}: {problem}, {quoted(value)}")
    try:
        with np.errstate(over="ignore"):
            return np.require(array, np.float64, ["C", "A", "E"])
    except (OverflowError, TypeError, ValueError) as failure:
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
    single = value.item() if isinstance(value, np.ndarray) and not value.ndim and not is_masked(value) else value
    good = is_real(single)
    try:
        given = float(single) if good else math.nan
    except (OverflowError, TypeError, ValueError):  # TypeError: a time difference passes for a real number
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
        given = None if isinstance(value, bool | np.bool_) or is_masked(value) else operator.index(value)
    except (TypeError, RecursionError):
        given = None
    if given is None or not low <= given <= high:
        raise error(f"{what}={quoted(value)} given; a whole number from {low} to {high} is needed")
    return given


def path(value: Any, what: str, error: Callable[[str], UrdfIkError] = ArgumentError) -> Path:
    """The path of a file; whether it is there is not looked at.

    Raises:
        UrdfIkError: ``error``; it is no path, is empty, or holds a null byte.

    Example:
        >>> path(3, "output")
        Traceback (most recent call last):
        urdf_ik.errors.ArgumentError: output=3 given; the path of a file is needed
    """
    if isinstance(value, str | os.PathLike):
        written = os.fspath(value)
        if isinstance(written, str) and written.strip() and "\0" not in written:
            return Path(written)
    raise error(f"{what}={quoted(value)} given; the path of a file is needed")


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
    if isinstance(value, type) or not hasattr(value, attribute):
        raise error(f"{what}={quoted(value)} given; {needed} is needed")


def arm(value: Any, what: str = "arm", error: Callable[[str], UrdfIkError] = ArgumentError) -> None:
    """Refuse what is no arm: see :func:`kind`.

    Example:
        >>> arm(None)
        Traceback (most recent call last):
        urdf_ik.errors.ArgumentError: arm=None given; an arm, as urdf_ik.load gives it, is needed
    """
    kind(value, "chain", what, "an arm, as urdf_ik.load gives it,", error)


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


def is_masked(value: object) -> bool:
    """Whether it is a masked array, or a list that holds one, whose mask NumPy would drop in silence.

    Example:
        >>> is_masked([np.ma.masked_array([1.0], [True])]), is_masked([1.0])
        (True, False)
    """
    level: list[object] = [value]
    for _ in range(_DEEPEST):
        if any(isinstance(each, np.ma.MaskedArray) for each in level):
            return True
        inner = [each for each in level if isinstance(each, list | tuple)]
        level = [part for each in inner for part in each if isinstance(part, np.ma.MaskedArray | list | tuple)]
        if not level:
            break
    return False
