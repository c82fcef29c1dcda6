"""Rows of NaN among joint vectors: places of a batch without a joint vector, as solutions hold them."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from urdf_ik.typing import Array


def filled(q: Array) -> tuple[Array, NDArray[np.bool_]]:
    """Joint vectors (..., n) with zeros in the rows that are NaN, and which rows (...) these are.

    Example:
        >>> q, gone = filled(np.array([[0.5, 1.0], [np.nan, np.nan]]))
        >>> q.tolist(), gone.tolist()
        ([[0.5, 1.0], [0.0, 0.0]], [False, True])
    """
    gone = np.asarray(np.isnan(q).any(axis=-1))
    return (np.where(gone[..., None], 0.0, q) if gone.any() else q), gone


def over_gaps(q: Array, compute: Callable[[Array], Array]) -> Array:
    """``compute`` of joint vectors (..., n), an array (..., ...) of floats, with NaN where a row is NaN."""
    whole, gone = filled(q)
    if whole is q:
        return compute(q)
    out = np.array(compute(whole), dtype=np.float64)
    out[gone] = np.nan
    return out
