"""Collision checks of a path with the arm itself and a world."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from urdf_ik.cell import CollisionModel
from urdf_ik.cell.swept_motions import TOUCH
from urdf_ik.typing import Array

Mask = NDArray[np.bool_]


SLACK = 2.0 * TOUCH
"""m that a joint vector must be clear beyond the margin, so that motions from and to it can be proven clear."""


class Obstacles(NamedTuple):
    """The arm's own links and a world.

    Attributes:
        model: the arm's collision model, in its world where there is one.
        margin: m that bodies must stay apart.
    """

    model: CollisionModel
    margin: float

    def free(self, q: Array) -> Mask:
        """Whether joint vectors (k, n) are clear, (k,)."""
        if not len(q):
            return np.ones(0, dtype=np.bool_)
        return ~np.asarray(self.model.in_collision(q, self.margin + SLACK))

    def motions_free(self, q0: Array, q1: Array) -> Mask:
        """Whether straight joint motions (k, n) are clear all the way, (k,)."""
        if not len(q0):
            return np.ones(0, dtype=np.bool_)
        return np.asarray(self.model.motions_free(q0, q1, self.margin).free)

    def pair(self, q: Array) -> tuple[str, str] | None:
        """The two bodies that come nearest at a joint vector (n,)."""
        nearest = self.model.nearest_pair(q)
        return None if nearest is None else nearest.links
