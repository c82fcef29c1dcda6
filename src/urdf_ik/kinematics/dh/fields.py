"""The fields of a Denavit-Hartenberg table."""

from __future__ import annotations

from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from urdf_ik.errors import UrdfError
from urdf_ik.typing import Array


class TableFields(Protocol):
    """The fields of :class:`urdf_ik.DHTable`, which says what they mean."""

    @property
    def convention(self) -> str:
        """'standard' or 'modified'."""

    @property
    def alpha(self) -> Array:
        """(n,) rad."""

    @property
    def a(self) -> Array:
        """(n,) m."""

    @property
    def d(self) -> Array:
        """(n,) m."""

    @property
    def theta(self) -> Array:
        """(n,) rad."""

    @property
    def joint_types(self) -> tuple[str, ...]:
        """(n,) types."""

    @property
    def joint_names(self) -> tuple[str, ...]:
        """(n,) names."""

    @property
    def limits(self) -> Array:
        """(n, 2) rad or m."""

    @property
    def base(self) -> Array:
        """(4, 4) where the table begins."""

    @property
    def tool(self) -> Array:
        """(4, 4) tip in the last frame."""

    @property
    def name(self) -> str:
        """The robot's name."""

    @property
    def n(self) -> int:
        """Number of joints."""

    @property
    def prismatic(self) -> NDArray[np.bool_]:
        """(n,) true for prismatic joints."""

    def origins(self) -> Array:
        """(n + 1, 4, 4) joint frames at q = 0, each in the one before."""


def table_error(problem: str, *, row: int | None = None, column: str | None = None) -> UrdfError:
    """The error for a table that makes no arm; rows count from 1.

    Example:
        >>> str(table_error("nan is not finite", row=2, column="a"))
        "row 2, column 'a': nan is not finite"
    """
    where = [f"row {row}"] * (row is not None) + [f"column {column!r}"] * (column is not None)
    return UrdfError(problem, element=", ".join(where) or None)
