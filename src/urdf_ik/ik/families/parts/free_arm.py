"""Seven joints whose self-motion holds a pose, for the compiled core."""

from __future__ import annotations

from dataclasses import dataclass

from urdf_ik.ik.families.parts.ideal import Ends
from urdf_ik.ik.families.parts.written import Written


@dataclass(frozen=True, kw_only=True, eq=False)
class FreeArm:
    """An arm of seven joints, from which ``_core.SelfMotion`` is made.

    Attributes:
        written: the arm as its URDF has it.
        given: index of the joint whose value is the redundancy parameter; -1: the swivel angle of an S-R-S arm.
        ends: the frames that the swivel angle is measured in; None: a joint is given.
    """

    written: Written
    given: int
    ends: Ends | None = None
