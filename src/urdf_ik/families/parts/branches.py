"""The names of the branches that most six-joint families share, and the signs of their roots."""

from __future__ import annotations

import numpy as np

# The eight branches of shoulder, elbow and wrist: the signs of their roots, and their names in the same order.
SIGNS = np.array([[front, up, flip] for front in (1, -1) for up in (1, -1) for flip in (1, -1)], dtype=np.float64)
NAMES = tuple(
    f"shoulder {front}, elbow {up}, wrist {flip}"
    for front in ("front", "back")
    for up in ("up", "down")
    for flip in ("noflip", "flip")
)
