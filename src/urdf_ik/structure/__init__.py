"""How the joint axes of a chain lie to each other, with the measured imperfection of each relation."""

from __future__ import annotations

from urdf_ik.structure.axes import (
    AxisPair,
    AxisTriple,
    Structure,
    analyse,
    closest_points,
    cross,
    meeting_point,
)

__all__ = [
    "AxisPair",
    "AxisTriple",
    "Structure",
    "analyse",
    "closest_points",
    "cross",
    "meeting_point",
]
