"""Redundancy parameters: their values, the intervals with solutions, and the choice along them."""

from urdf_ik.ik.redundancy.curves import End
from urdf_ik.ik.redundancy.intervals import Interval, Intervals
from urdf_ik.ik.redundancy.region import Region
from urdf_ik.kinematics.chain.redundancy import Redundancy

__all__ = ["End", "Interval", "Intervals", "Redundancy", "Region"]
