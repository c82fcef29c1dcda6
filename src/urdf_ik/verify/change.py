"""Difference: one difference between two descriptions of an arm; and the tolerances below which values are the same."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np

from urdf_ik.errors import ArgumentError
from urdf_ik.support import inputs
from urdf_ik.support.text import quoted
from urdf_ik.typing import Array

KINDS = ("kinematics", "limits", "names", "collisions", "visuals")
"""Kinds of differences; each but the first can be ignored."""

_MOST_LENGTH = 1e6
_MOST_PLACES, _MOST_SHAPES = 6, 3


@dataclass(frozen=True)
class Tolerance:
    """Tolerances up to which values count as the same.

    Attributes:
        distance: [m].
        angle: [rad].
        limit: of a joint limit [rad or m], relative to the limit if it is beyond 1 rad or 1 m.
    """

    distance: float = 1e-9
    angle: float = 1e-9
    limit: float = 1e-9

    @classmethod
    def read(cls, mm: object = None, deg: object = None) -> Tolerance:
        """From millimetres and degrees; None: the default.

        Raises:
            ArgumentError: a value is not a number, or is negative.

        Example:
            >>> Tolerance.read(0.5).distance
            0.0005
        """
        out = cls()
        if mm is not None:
            out = replace(out, distance=inputs.number(mm, "tolerance_mm", low=0.0, high=_MOST_LENGTH, unit="mm") / 1e3)
        if deg is not None:
            angle = math.radians(inputs.number(deg, "tolerance_deg", low=0.0, high=180.0, unit="deg"))
            out = replace(out, angle=angle, limit=max(cls.limit, angle))
        return out


DEFAULT = Tolerance()


@dataclass(frozen=True)
class Difference:
    """One thing that is not the same.

    Attributes:
        kind: one of ``KINDS``, or 'solutions'.
        name: the joint or link that it is about; '' where it is about the whole arm.
        words: what is different.
        distance: how far [m], 0 where that says nothing.
        angle: how far [rad].
        replay: Python that shows it, '' where the words say it all.
    """

    kind: str
    name: str
    words: str
    distance: float = 0.0
    angle: float = 0.0
    replay: str = ""

    def __str__(self) -> str:
        return f"{self.name}: {self.words}" if self.name else self.words


def ignored(given: str | Iterable[str]) -> frozenset[str]:
    """Kinds of differences that do not count, as a list or as text with commas.

    Raises:
        ArgumentError: a kind that there is not, or kinematics, which cannot be ignored.

    Example:
        >>> sorted(ignored("limits,names"))
        ['limits', 'names']
    """
    parts = given.replace(",", " ").split() if isinstance(given, str) else list(inputs.items(given, "ignore", "kinds"))
    for part in parts:
        if part not in KINDS[1:]:
            raise ArgumentError(f"{quoted(part)} cannot be ignored; what can: {', '.join(KINDS[1:])}")
    return frozenset(parts)


def summed(found: tuple[Difference, ...]) -> tuple[str, ...]:
    """Differences, a line each; those of many shapes in one line.

    Example:
        >>> summed((Difference("limits", "elbow", "its upper limit was 180 deg, and is 179 deg"),))
        ('elbow: its upper limit was 180 deg, and is 179 deg',)
    """
    out, said = [], set()
    for each in found:
        if each.kind not in ("collisions", "visuals"):
            out.append(str(each))
            continue
        alike = [other for other in found if other.kind == each.kind and other.name]
        if len(alike) <= _MOST_SHAPES or not each.name:
            out.append(str(each))
        elif each.kind not in said:
            said.add(each.kind)
            links = list(dict.fromkeys(other.name for other in alike))
            shown = ", ".join(links[:_MOST_PLACES]) + (", ..." if len(links) > _MOST_PLACES else "")
            out.append(f"{shown}: {len(alike)} {each.kind[:-1]} shapes differ; the first: {alike[0].words}")
    return tuple(out)


def within(change: tuple[float, float], tolerance: Tolerance) -> bool:
    """Whether a change [m, rad] is tolerated.

    Example:
        >>> within((0.0, 1e-10), DEFAULT)
        True
    """
    return change[0] <= tolerance.distance and change[1] <= tolerance.angle


def same_limit(a: float, b: float, tolerance: Tolerance = DEFAULT) -> bool:
    """Whether two limits [rad or m] are the same to rounding.

    Example:
        >>> same_limit(6.283185307, 6.2831853071795862), same_limit(3.14, 3.15)
        (True, False)
    """
    return a == b or abs(a - b) <= tolerance.limit * max(1.0, abs(a), abs(b))


def moved(distance: float, angle: float) -> str:
    """How far something moved, in words.

    Example:
        >>> moved(0.0001, 0.0)
        'moved by 0.1 mm'
    """
    parts = [f"moved by {length(distance)}"] if distance > DEFAULT.distance or angle <= DEFAULT.angle else []
    parts += [f"turned by {math.degrees(angle):.4g} deg"] if angle > DEFAULT.angle else []
    return " and ".join(parts)


def length(distance: float) -> str:
    """A length in mm.

    Example:
        >>> length(0.0215)
        '21.5 mm'
    """
    return f"{distance * 1e3:.4g} mm"


def apart(one: Array, other: Array) -> tuple[float, float]:
    """Distance [m] and angle [rad] between two poses (4, 4)."""
    from urdf_ik.cell.pinocchio_reference import pose_errors

    position, rotation = pose_errors(one, other)
    return float(position), float(rotation)


def angle_between(u: Array, v: Array) -> float:
    """Angle [rad] between two directions (3,)."""
    return float(np.arctan2(np.linalg.norm(np.cross(u, v)), u @ v))
