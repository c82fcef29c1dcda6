"""Kinematics of a chain: screw axes, forward kinematics, Jacobian, structure of the axes, DH tables, velocities."""

from urdf_ik.support.lazy import attributes

__getattr__ = attributes(__name__)
