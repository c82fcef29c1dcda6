"""The interface of a cell, as inverse kinematics uses it: contact and distance of joint vectors."""

from __future__ import annotations

from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray


class Bodies(Protocol):
    """The links of an arm and the obstacles of one world."""

    @property
    def has_geometry(self) -> bool:
        """Whether there are shapes to check."""

    @property
    def unchecked(self) -> str:
        """Why contacts are not checked, '' where they are."""

    def in_collision(self, q: NDArray[np.float64], margin: float = 0.0) -> Any:
        """(k, n) rad or m to (k,): whether two bodies come within a margin [m]."""

    def motions_free(self, q0: NDArray[np.float64], q1: NDArray[np.float64], margin: float = 0.0) -> Any:
        """Whether straight motions between joint vectors (k, n) are free, as ``Motions``."""

    def nearest_pair(self, q: NDArray[np.float64]) -> Any:
        """The two bodies that come closest to each other, as ``Nearest``."""

    def distance(self, q: NDArray[np.float64]) -> Any:
        """(k, n) rad or m to (k,) m: the least distance between bodies that must not touch."""


class Contacts(Protocol):
    """The cell of an arm."""

    def in_world(self, world: Any) -> Bodies:
        """The links among the obstacles of a world; None: the links alone."""
