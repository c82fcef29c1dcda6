"""Steps between joint vectors: images 2 pi apart, and the shortest step between two vectors."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from urdf_ik import _core
from urdf_ik.ik.solutions.limits import LIMIT_TOLERANCE
from urdf_ik.kinematics.chain import Chain
from urdf_ik.support.angles import TURN
from urdf_ik.typing import Array

Ints = NDArray[np.int64]

MOST_IMAGES = 5
"""A joint with more images inside its limits than these turns without end, as far as a path is concerned."""
MOST_STATES = 1024
"""Images of a node that are kept apart: the joints with the most images turn without end until there are no more."""


@dataclass(frozen=True)
class Joints:
    """How the joints of an arm turn, for its graphs.

    Attributes:
        chain: the arm's joints.
        turn: (n,) rad between images, 0 for one that slides.
        counted: (n,) uint8, whether images inside the limits are states of their own.
        digits: (states, n) uint8, the number of each joint's image in each state.
        strides: (n,) what one image more adds to a state's number.
        core: the compiled functions.
    """

    chain: Chain
    turn: Array
    counted: NDArray[np.uint8]
    digits: NDArray[np.uint8]
    strides: Ints
    core: _core.PathGraph

    @classmethod
    def of(cls, chain: Chain) -> Joints:
        """Those of a chain."""
        low, high = (np.ascontiguousarray(side) for side in chain.limits.T)
        turn = TURN * np.asarray(chain.image_turns, dtype=np.float64)
        with np.errstate(divide="ignore", invalid="ignore"):
            images = np.where(turn > 0.0, np.floor((high - low + 2.0 * LIMIT_TOLERANCE) / turn) + 1.0, 1.0)
        counted = (turn > 0.0) & (images <= MOST_IMAGES)
        while np.prod(images, where=counted) > MOST_STATES:
            counted[np.argmax(np.where(counted, images, 0.0))] = False
        radix = np.where(counted, images, 1.0).astype(np.int64)
        strides = np.concatenate([np.cumprod(radix[::-1])[::-1][1:], [1]]).astype(np.int64)
        digits = np.indices(tuple(radix)).reshape(len(radix), -1).T.astype(np.uint8)
        flags = counted.astype(np.uint8)
        core = _core.PathGraph(low - LIMIT_TOLERANCE, high + LIMIT_TOLERANCE, turn, flags)
        return cls(chain, turn, flags, np.ascontiguousarray(digits), strides, core)

    def choose(
        self, q: Array, flags: NDArray[np.uint8], centres: Array | None = None, near: float = 0.0, outside: bool = False
    ) -> tuple[Ints, Array, NDArray[np.uint8]]:
        """Joint vectors that are wanted: their indices (k,), lowest images (k, n) and how many images there are (k, n).

        Args:
            q: (m, n) rad or m.
            flags: (m,) bit 0: a solution.
            centres: (c, n) rad or m, of m / c joint vectors each: only those near to them are wanted.
            near: rad that a joint that turns may be off its centre.
            outside: those outside the limits, too; their images count zero.
        """
        kept, lowest, counts = np.empty(len(q), np.int64), np.empty(q.shape), np.empty(q.shape, np.uint8)
        count = self.core.choose(
            np.ascontiguousarray(q), np.ascontiguousarray(flags), centres, near, outside, kept, lowest, counts
        )
        return kept[:count], lowest[:count], counts[:count]

    def step(self, a: Array, b: Array) -> Array:
        """The shortest way (..., n) from joint vectors to others: for joints that turn, on the circle."""
        turn = np.where(self.turn > 0.0, self.turn, 1.0)
        apart: Array = b - a
        return apart - np.where(self.turn > 0.0, np.round(apart / turn) * turn, 0.0)
