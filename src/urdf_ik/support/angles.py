"""Angles modulo a turn."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

TURN = 2.0 * np.pi
"""rad: one turn."""


def wrapped(angles: Array) -> Array:
    """``angles`` [rad] in (-pi, pi]; those that are there already keep their digits.

    >>> wrapped(np.array([0.5, np.pi + 0.5, -np.pi])).round(4).tolist()
    [0.5, -2.6416, 3.1416]
    """
    return np.where(np.abs(angles) < np.pi, angles, np.pi - np.remainder(np.pi - angles, TURN))


def shortest(steps: Array) -> Array:
    """Differences of angles [rad] taken the short way round: in [-pi, pi).

    >>> shortest(np.array([0.25, np.pi + 0.25, -6.0])).round(4).tolist()
    [0.25, -2.8916, 0.2832]
    """
    turned: Array = (steps + np.pi) % TURN - np.pi
    return turned


def largest_apart(a: Array, b: Array) -> Array:
    """Largest difference (...) [rad] between the angles of joint vectors (..., n).

    Example:
        >>> round(float(largest_apart(np.array([0.1, 3.1]), np.array([0.2, -3.1]))), 4)
        0.1
    """
    largest: Array = np.abs(shortest(a - b)).max(axis=-1, initial=0.0)
    return largest
