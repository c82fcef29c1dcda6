"""Denavit-Hartenberg tables, standard or modified, to URDF and back from any chain.

One step from frame to frame is, with theta + q for a revolute joint and d + q for a prismatic one::

    standard   Rz(theta) Tz(d) Tx(a) Rx(alpha)      (Paul 1981; Spong, Hutchinson and Vidyasagar, chapter 3)
    modified   Rx(alpha) Tx(a) Rz(theta) Tz(d)      (Craig, Introduction to Robotics, chapter 3)
"""

from urdf_ik.kinematics.dh.files import CONVENTIONS
from urdf_ik.kinematics.dh.table import DHTable

__all__ = [
    "CONVENTIONS",
    "DHTable",
]
