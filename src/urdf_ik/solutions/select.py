"""Which solution to take: the nearest to a reference."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from urdf_ik.errors import JointVectorError

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


def reference(q_ref: ArrayLike, names: Sequence[str], batch: tuple[int, ...]) -> Array:
    """``q_ref`` as (n,) or (..., n) finite float64, for poses of the shape ``batch``.

    Raises:
        JointVectorError: it does not fit the joints ``names`` or the poses, or is not finite.
    """
    array = _joint_vector(q_ref, "q_ref", names)
    try:
        np.broadcast_to(array, (*batch, array.shape[-1]))
    except ValueError:
        raise JointVectorError(
            f"q_ref has the shape {array.shape} and the poses {batch}: one joint vector, or one a pose"
        ) from None
    return array


def factors(weights: ArrayLike, names: Sequence[str]) -> Array:
    """``weights`` as (n,) finite float64.

    Raises:
        JointVectorError: they do not fit the joints ``names``, or one is negative or not finite.
    """
    array = _joint_vector(weights, "weights", names)
    if array.ndim != 1 or (array < 0.0).any():
        raise JointVectorError(f"weights are {weights!r}; one number a joint is needed, zero or positive")
    return array


def _joint_vector(value: ArrayLike, what: str, names: Sequence[str]) -> Array:
    """``value`` as (..., n) finite float64."""
    try:
        array = np.asarray(value, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise JointVectorError(f"{what} must be an array of numbers (..., {len(names)}): {error}") from None
    if array.shape[-1:] != (len(names),):
        raise JointVectorError(
            f"{what} has the shape {array.shape}; the arm has {len(names)} joints: {', '.join(names)}"
        )
    if not np.isfinite(array).all():
        raise JointVectorError(f"{what} is {value!r}; finite numbers are needed")
    return array
