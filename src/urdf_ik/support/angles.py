"""Angles modulo a turn."""

from __future__ import annotations

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


def largest_apart(a: Array, b: Array) -> Array:
    """Largest difference (...) [rad] between the angles of joint vectors (..., n)."""
    largest: Array = np.abs(shortest(a - b)).max(axis=-1, initial=0.0)
    return largest
