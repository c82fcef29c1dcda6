"""The arm with one joint given, for the compiled solver of the others."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

from urdf_ik.typing import Array


@dataclass(frozen=True, kw_only=True, eq=False)
class OneGiven:
    """An arm with one joint given; its value moves the target: ``GivenJoint`` of the core.

    Attributes:
        motion: (3, 3, 4) the joint's motion back is their sum times (1, cos, sin) of its value; where it slides, the
            first one plus the value times the second one.
        turns: whether the joint turns.
        last: whether it is the last joint.
        value: its value where no other is given [rad, m].
        solver: the arm of the other joints: the dataclass of its solver.
        before: index of the joint if it shares its axis with the next one, which then takes its value back; -1: it is
            an end joint.
        opposite: whether the next joint turns the other way.
    """

    kind: ClassVar = "one joint given"
    motion: Array
    turns: bool
    last: bool
    value: float
    solver: Any
    before: int = -1
    opposite: bool = False
