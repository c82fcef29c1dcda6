"""Arms with seven joints: the redundancy parameter, and solutions along it."""

from __future__ import annotations

from urdf_ik.chain.redundancy import Redundancy
from urdf_ik.redundancy.found import End
from urdf_ik.redundancy.interval import Interval, Intervals
from urdf_ik.redundancy.region import Region
from urdf_ik.redundancy.sweep import Sweep

__all__ = ["End", "Interval", "Intervals", "Redundancy", "Region", "Sweep"]
