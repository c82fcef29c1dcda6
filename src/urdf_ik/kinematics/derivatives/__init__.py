"""Derivatives of forward kinematics: by the numbers of the URDF as written, and of second order by the joints."""

from __future__ import annotations

from urdf_ik.kinematics.derivatives.swivel import Points, rates_by_geometry, second_rate, slopes
from urdf_ik.kinematics.derivatives.written import Parameter, WrittenChain, written
from urdf_ik.kinematics.velocity import curvature

__all__ = ["Parameter", "Points", "WrittenChain", "curvature", "rates_by_geometry", "second_rate", "slopes", "written"]
