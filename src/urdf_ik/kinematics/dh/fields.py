"""The fields of a Denavit-Hartenberg table, and their checks; errors name row, column and value."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from urdf_ik.errors import ArgumentError, PoseError, UrdfError
from urdf_ik.kinematics.dh.frames import rotation_z, slide_z, step_x
from urdf_ik.model.poses import check_poses
from urdf_ik.support import inputs
from urdf_ik.support.read_only import Frozen, frozen
from urdf_ik.typing import Array

CONVENTIONS = ("standard", "modified")
COLUMNS = ("alpha", "a", "d", "theta")
JOINT_TYPES = ("revolute", "continuous", "prismatic")
LETTERS = {"R": "revolute", "C": "continuous", "P": "prismatic"}


@dataclass(frozen=True, eq=False)
class TableFields(Frozen):
    """The fields of :class:`urdf_ik.DHTable`, which says what they mean."""

    convention: str
    alpha: Array
    a: Array
    d: Array
    theta: Array
    joint_types: tuple[str, ...]
    joint_names: tuple[str, ...]
    limits: Array
    base: Array
    tool: Array
    name: str = "arm"

    def __post_init__(self) -> None:
        for field in (*COLUMNS, "limits", "base", "tool"):
            values = inputs.real(getattr(self, field), repr(field), "an array of numbers", UrdfError)
            object.__setattr__(self, field, frozen(values.copy()))
        _check(self)

    @property
    def n(self) -> int:
        """Number of joints."""
        return len(self.alpha)

    @property
    def prismatic(self) -> NDArray[np.bool_]:
        """(n,) true for prismatic joints."""
        return np.array([kind == "prismatic" for kind in self.joint_types], dtype=np.bool_)

    def origins(self) -> Array:
        """(n + 1, 4, 4) joint frames at q = 0, each in the one before, then the tip; every axis is z of its frame."""
        about_x = [step_x(a, alpha) for a, alpha in zip(self.a, self.alpha, strict=True)]
        about_z = [rotation_z(theta) @ slide_z(d) for theta, d in zip(self.theta, self.d, strict=True)]
        if self.convention == "modified":
            steps = [x @ z for x, z in zip(about_x, about_z, strict=True)]
            return np.array([self.base @ steps[0], *steps[1:], self.tool])
        steps = [z @ x for z, x in zip(about_z, about_x, strict=True)]
        return np.array([self.base, *steps[:-1], steps[-1] @ self.tool])


def table_error(problem: str, *, row: int | None = None, column: str | None = None) -> UrdfError:
    """The error for a table that makes no arm; rows count from 1."""
    where = [f"row {row}"] * (row is not None) + [f"column {column!r}"] * (column is not None)
    return UrdfError(problem, element=", ".join(where) or None)


def _check(table: TableFields) -> None:
    """Check every field of the table.

    Raises:
        UrdfError: something is missing, of the wrong shape, not finite or senseless.
    """
    check_convention(table.convention)
    n = table.alpha.size
    if n == 0:
        raise table_error("the table has no rows; one row a joint is needed")
    for column in COLUMNS:
        values = getattr(table, column)
        if values.shape != (n,):
            raise table_error(f"column {column!r} has the shape {values.shape}, {n} numbers are needed")
        if (bad := inputs.first_bad(values)) is not None:
            problem = "is no finite number" if not np.isfinite(values[bad]) else f"given; {inputs.why_bad(values[bad])}"
            raise table_error(f"{values[bad]} {problem}", row=bad[0] + 1, column=column)
    joint_types_of(table.joint_types, n)
    _check_names(table.joint_names, n)
    _check_limits(table)
    for name in ("base", "tool"):
        transform(getattr(table, name), name)
    if not isinstance(table.name, str) or not table.name.strip():
        raise table_error(f"{table.name!r} is no name of a robot")


def check_convention(convention: Any) -> None:
    """Refuse an unknown convention.

    Raises:
        ArgumentError: it is not one of :data:`CONVENTIONS`.
    """
    if not isinstance(convention, str) or convention not in CONVENTIONS:
        raise ArgumentError(f"unknown convention {convention!r}; there are {' and '.join(CONVENTIONS)} (Craig's)")


def joint_types_of(kinds: str | Sequence[str], n: int) -> tuple[str, ...]:
    """Types of ``n`` joints from words, letters such as 'RRP', or nothing (all revolute).

    Raises:
        UrdfError: an unknown word or letter, or too many or too few of them.
    """
    if len(kinds) == 0:
        return ("revolute",) * n
    words = []
    for row, kind in enumerate(kinds, start=1):
        word = LETTERS.get(kind, kind) if isinstance(kind, str) else ""
        if word not in JOINT_TYPES:
            raise table_error(
                f"unknown joint type {kind!r}; there are {', '.join(JOINT_TYPES)} ({', '.join(LETTERS)})",
                row=row,
                column="type",
            )
        words.append(word)
    if len(words) != n:
        raise table_error(f"{len(words)} joint types for {n} rows; one a row is needed")
    return tuple(words)


def table_array(rows: Any, columns: Sequence[str] = COLUMNS) -> Array:
    """A writable array (n, number of columns) of numbers.

    Raises:
        UrdfError: a row has more or fewer columns, or an entry is no number.
    """
    out = np.empty((len(rows), len(columns)))
    for i, row in enumerate(rows):
        values = np.atleast_1d(np.asarray(row))
        if values.shape != (len(columns),):
            needed = f"{len(columns)} are needed: {', '.join(columns)}"
            raise table_error(f"{values.size} columns given, {needed}", row=i + 1)
        for k, value in enumerate(row):
            if not inputs.is_real(value):
                raise table_error(f"{value!r} is no number", row=i + 1, column=columns[k])
            out[i, k] = value
    return out


def transform(value: ArrayLike | None, name: str) -> Array:
    """One pose (4, 4) of its own; the identity for None.

    Raises:
        UrdfError: it is not a pose.
    """
    try:
        T = np.eye(4) if value is None else check_poses(value).copy()
    except PoseError as error:
        raise table_error(f"{name} transform: {error}") from None
    if T.shape != (4, 4):
        raise table_error(f"{name} transform of shape {T.shape} given; one pose (4, 4) is needed")
    return T


def _check_names(names: Sequence[str], n: int) -> None:
    if len(names) != n:
        raise table_error(f"{len(names)} joint names for {n} rows; one a row is needed")
    for row, name in enumerate(names, start=1):
        if not str(name).strip():
            raise table_error(f"{name!r} is no name of a joint", row=row, column="name")
        if name in names[: row - 1]:
            raise table_error(f"{name!r} is the name of row {names.index(name) + 1}, too", row=row, column="name")


def _check_limits(table: TableFields) -> None:
    if table.limits.shape != (len(table.alpha), 2):
        raise table_error(f"limits of shape {table.limits.shape} given; ({len(table.alpha)}, 2) is needed")
    for row, (kind, (lower, upper)) in enumerate(zip(table.joint_types, table.limits, strict=True), start=1):
        for column, value in (("lower", lower), ("upper", upper)):
            if kind != "continuous" and not np.isfinite(value):
                needs = "give both" if kind == "prismatic" else "give both, or neither for a continuous joint"
                raise table_error(f"a {kind} joint needs a finite limit, not {value}; {needs}", row=row, column=column)
        if lower > upper:
            raise table_error(f"lower limit {lower} is above the upper one, {upper}", row=row, column="lower")
