"""Inverse kinematics: families and their solvers, solutions, redundancy parameters, tasks."""

from urdf_ik.support.lazy import attributes

__getattr__ = attributes(__name__)
