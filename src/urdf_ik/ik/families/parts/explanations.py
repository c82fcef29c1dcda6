"""What explanations of unreachable poses share: lengths in words."""

from __future__ import annotations

import numpy as np

from urdf_ik._core import Solver
from urdf_ik.typing import Array


def compared(*lengths: float) -> tuple[str, ...]:
    """Lengths in words, with six digits or as many as show that they differ."""
    different = len(set(lengths))
    texts = (tuple(f"{length:.{digits}g}" for length in lengths) for digits in range(6, 18))
    return next(each for each in texts if len(set(each)) == different)


def too_far(actual: float, least: float, most: float) -> str:
    """How far a length is outside a range, in words to stand behind both.

    Example:
        >>> too_far(2.8, 0.1, 2.1)
        ': 0.7 m too far'
        >>> too_far(0.04, 0.1, 2.1)
        ': 0.06 m too near'
    """
    return f": {actual - most:.3g} m too far" if actual > most else f": {least - actual:.3g} m too near"


def beyond_links(what: str, far: float, size: float) -> str:
    """The text for what is further from axis 1 than the links reach, stretched out."""
    return f"{what} is {far:.6g} m from axis 1, and all links together measure {size:.6g} m{too_far(far, 0.0, size)}"


def distances_of(solver: Solver, rotation: Array, point: Array) -> Array:
    """The distances between two axes [m] that a pose, seen from frame 1, requires: one for each way to reach it."""
    seen = np.eye(4)
    seen[:3, :3], seen[:3, 3] = rotation, point
    distances: Array = np.array(solver.distances(seen))
    finite: Array = distances[np.isfinite(distances)]
    return finite
