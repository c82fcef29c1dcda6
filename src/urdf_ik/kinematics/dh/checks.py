"""Checks of a Denavit-Hartenberg table; errors name row, column and value."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from urdf_ik.errors import ArgumentError, PoseError, UrdfError
from urdf_ik.kinematics.dh.fields import TableFields, table_error
from urdf_ik.model.poses import check_poses
from urdf_ik.support import inputs
from urdf_ik.support.text import quoted
from urdf_ik.typing import Array

CONVENTIONS = ("standard", "modified")
COLUMNS = ("alpha", "a", "d", "theta")
JOINT_TYPES = ("revolute", "continuous", "prismatic")
LETTERS = {"R": "revolute", "C": "continuous", "P": "prismatic"}


def check(table: TableFields) -> None:
    """Check every field of the table, and freeze its arrays.

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
        raise table_error(f"{quoted(table.name)} is no name of a robot")
    for array in (*(getattr(table, column) for column in COLUMNS), table.limits, table.base, table.tool):
        array.setflags(write=False)


def numbers(values: ArrayLike, field: str) -> Array:
    """A copy of ``values`` as an array.

    Raises:
        UrdfError: they are no numbers.
    """
    return inputs.real(values, repr(field), "an array of numbers", UrdfError).copy()


def check_convention(convention: Any) -> None:
    """Refuse an unknown convention.

    Raises:
        ArgumentError: it is not one of :data:`CONVENTIONS`.
    """
    if not isinstance(convention, str) or convention not in CONVENTIONS:
        raise ArgumentError(f"unknown convention {quoted(convention)}; there are {' and '.join(CONVENTIONS)} (Craig's)")


def joint_types_of(kinds: str | Sequence[str], n: int) -> tuple[str, ...]:
    """Types of ``n`` joints from words, letters such as 'RRP', or nothing (all revolute).

    Raises:
        UrdfError: an unknown word or letter, or too many or too few of them.
    """
    if not isinstance(kinds, str | list | tuple):
        raise table_error(f"joint types {quoted(kinds)} given; letters such as 'RRP', or a list of words, are needed")
    if len(kinds) == 0:
        return ("revolute",) * n
    words = []
    for row, kind in enumerate(kinds, start=1):
        word = LETTERS.get(kind, kind) if isinstance(kind, str) else ""
        if word not in JOINT_TYPES:
            raise table_error(
                f"unknown joint type {quoted(kind)}; there are {', '.join(JOINT_TYPES)} ({', '.join(LETTERS)})",
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


def names_of(names: Any) -> tuple[str, ...]:
    """Names of joints as they are given; what they hold is checked with the table.

    Raises:
        UrdfError: they are no list.
    """
    if not isinstance(names, list | tuple):
        raise table_error(f"joint names {quoted(names)} given; a list of texts is needed")
    return tuple(names)


def _check_names(names: Sequence[str], n: int) -> None:
    if len(names) != n:
        raise table_error(f"{len(names)} joint names for {n} rows; one a row is needed")
    for row, name in enumerate(names, start=1):
        if not isinstance(name, str) or not name.strip():
            raise table_error(f"{quoted(name)} is no name of a joint", row=row, column="name")
        if name in names[: row - 1]:
            raise table_error(f"{quoted(name)} is the name of row {names.index(name) + 1}, too", row=row, column="name")


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
