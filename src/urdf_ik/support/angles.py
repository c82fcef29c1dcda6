"""Angles modulo a turn, and the unit in which messages show them."""

from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

TURN = 2.0 * np.pi
"""rad: one turn."""


def wrapped(angles: Array) -> Array:
    """``angles`` [rad] in (-pi, pi]; those that are there already keep their digits."""
    return np.where(np.abs(angles) < np.pi, angles, np.pi - np.remainder(np.pi - angles, TURN))


def shortest(steps: Array) -> Array:
    """Differences of angles [rad] taken the short way round: in [-pi, pi)."""
    turned: Array = (steps + np.pi) % TURN - np.pi
    return turned


def difference(q: Array, other: Array, sliding: NDArray[np.bool_]) -> Array:
    """``q`` less ``other`` (..., n) [rad or m], angles taken the short way round."""
    return np.where(sliding, q - other, shortest(q - other))


def largest_apart(a: Array, b: Array) -> Array:
    """Largest difference (...) [rad] between the angles of joint vectors (..., n)."""
    largest: Array = np.abs(shortest(a - b)).max(axis=-1, initial=0.0)
    return largest


_IN_DEGREES = ContextVar("in_degrees", default=False)


@contextmanager
def shown_in_degrees(wanted: bool = True) -> Iterator[None]:
    """Messages that are made inside show angles in degrees."""
    token = _IN_DEGREES.set(wanted)
    try:
        yield
    finally:
        _IN_DEGREES.reset(token)


def shown(value: Any, unit: str = "rad") -> Any:
    """A value in the unit that :func:`unit_of` gives."""
    return np.rad2deg(value) if unit == "rad" and _IN_DEGREES.get() else value


def unit_of(unit: str = "rad") -> str:
    """The unit in which messages show a value of ``unit``: 'deg' for 'rad' inside :func:`shown_in_degrees`."""
    return "deg" if unit == "rad" and _IN_DEGREES.get() else unit


def amount(value: Any, unit: str = "rad", form: str = ".4g") -> str:
    """A value with its unit, as messages show it."""
    return f"{shown(value, unit) + 0.0:{form}} {unit_of(unit)}"
