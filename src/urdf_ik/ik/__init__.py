"""Inverse kinematics: families and their solvers, solutions, redundancy parameters, tasks."""

from __future__ import annotations

from urdf_ik.support.lazy import attributes

__getattr__ = attributes(__name__)
