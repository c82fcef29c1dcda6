"""Which solution to take: the nearest to a reference."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def distance(q: Array, q_ref: Array, round_joints: NDArray[np.bool_] | Array, weights: Array | None = None) -> Array:
    """Weighted Euclidean distance of joint vectors, infinite for NaN rows.

    Args:
        q: (..., B, n) rad or m.
        q_ref: (..., n) rad or m.
        round_joints: (n,) joints whose difference is taken on the circle, at most pi; a number: so many turns round.
        weights: (n,) factors of the squared differences; default: 1, which adds rad^2 and m^2.

    Returns:
        (..., B): sqrt(sum of weight * difference^2).
    """
    difference = q - q_ref[..., None, :]
    half = np.pi * np.where(round_joints, round_joints, 1.0)
    on_circle = np.asarray(round_joints, dtype=np.bool_)
    difference = np.where(on_circle, np.abs(np.remainder(difference + half, 2.0 * half) - half), difference)
    squares = difference * difference if weights is None else weights * difference * difference
    total = np.sqrt(squares.sum(axis=-1))
    return np.where(np.isnan(total), np.inf, total)


def nearest_columns(distances: Array, n: int) -> NDArray[np.intp]:
    """(..., n) columns of the n smallest of distances (..., B), the nearest first, ties by column."""
    if n == 1:
        return np.asarray(np.argmin(distances, axis=-1, keepdims=True))
    return np.argsort(distances, axis=-1, kind="stable")[..., :n]
