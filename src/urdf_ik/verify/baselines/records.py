"""The data of a lock file: planted joint vectors, poses, and their solutions."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from urdf_ik.typing import Array
from urdf_ik.verify.description import Description, Row, flat, matrix

KINDS = ("random", "round", "at limits", "near limits", "near singularity", "own")
"""Kinds of poses; 'own' are the user's."""


@dataclass(frozen=True)
class Planted:
    """Where Pinocchio has the tip at a joint vector.

    Attributes:
        kind: one of ``KINDS``.
        q: (n,) rad or m.
        T: 12 numbers, the upper three rows of the pose [m].
    """

    kind: str
    q: Row
    T: Row


@dataclass(frozen=True)
class Answer:
    """One solution of a pose.

    Attributes:
        q: (n,) rad or m.
        branch: its branch.
        within_limits: whether it, or an image a turn away, lies inside the joint limits.
        singular: whether the Jacobian loses rank there.
        contact: whether something touches that must not; None: not checked, or too near to tell.
    """

    q: Row
    branch: str
    within_limits: bool
    singular: bool
    contact: bool | None


@dataclass(frozen=True)
class Pose:
    """A pose and every solution of it.

    Attributes:
        kind: one of ``KINDS``.
        T: 12 numbers, the upper three rows of the pose [m].
        redundancy: values of the redundancy parameters at which it was solved, or () for an arm without.
        answers: the solutions.
    """

    kind: str
    T: Row
    redundancy: Row
    answers: tuple[Answer, ...]

    @property
    def matrix(self) -> Array:
        """The pose (4, 4) [m]."""
        return matrix(self.T)

    @property
    def q(self) -> Array:
        """(k, n) rad or m, the solutions."""
        return np.array([answer.q for answer in self.answers], dtype=np.float64)


@dataclass(frozen=True)
class Recorded:
    """An arm and its answers as they were.

    Attributes:
        arm: the arm.
        planted: joint vectors with Pinocchio's pose for each.
        poses: poses with every solution; () where no solver takes the arm.
        contacts: '' where contacts were checked, else why not.
        made_by: versions of the packages that computed it.
        unlooked: what a time limit left out when it was made; '' where nothing was.
    """

    arm: Description
    planted: tuple[Planted, ...]
    poses: tuple[Pose, ...]
    contacts: str = ""
    made_by: tuple[tuple[str, str], ...] = ()
    unlooked: str = ""


def answer_rows(q: Array) -> tuple[Row, ...]:
    """Joint vectors (k, n) rounded to 1e-12, so that a file differs only where an answer does."""
    return tuple(tuple(float(each) + 0.0 for each in row) for row in np.round(q, 12))


def pose_row(T: Array) -> Row:
    """The 12 numbers of a pose (4, 4)."""
    return flat(T)
