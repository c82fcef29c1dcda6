"""The names of the branches that most six-joint families share, and the signs of their roots."""

from __future__ import annotations

import itertools

import numpy as np

# The eight branches of shoulder, elbow and wrist: the signs of their roots (3, 8), and their names in the same order.
SIGNS = np.array(list(itertools.product((1.0, -1.0), repeat=3))).T.copy()
NAMES = tuple(
    f"shoulder {front}, elbow {up}, wrist {flip}"
    for front in ("front", "back")
    for up in ("up", "down")
    for flip in ("noflip", "flip")
)
