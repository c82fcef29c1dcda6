"""urdf-ik: every inverse-kinematics solution of a robot arm, from its URDF, in closed form.

>>> import urdf_ik
>>> arm = urdf_ik.load("zyyzyz_6r")
>>> len(arm.ik(arm.fk([0.3, -0.5, 0.8, 0.4, 0.7, -0.2])))
8
"""

from urdf_ik.arm import Arm, load
from urdf_ik.chain import Chain
from urdf_ik.errors import (
    CatalogueError,
    ChainError,
    JointVectorError,
    MissingPackage,
    PoseError,
    TaskError,
    UnsupportedArm,
    UrdfError,
    UrdfIkError,
)
from urdf_ik.poses import (
    pose,
    to_euler_zyx,
    to_quat_wxyz,
    to_quat_xyzw,
    to_rotvec,
    to_rpy,
)
from urdf_ik.solutions import IKSolutions, Singular, Solution
from urdf_ik.structure import Structure

__version__ = "0.1.0"

__all__ = [
    "Arm",
    "CatalogueError",
    "Chain",
    "ChainError",
    "IKSolutions",
    "JointVectorError",
    "MissingPackage",
    "PoseError",
    "Singular",
    "Solution",
    "Structure",
    "TaskError",
    "UnsupportedArm",
    "UrdfError",
    "UrdfIkError",
    "load",
    "pose",
    "to_euler_zyx",
    "to_quat_wxyz",
    "to_quat_xyzw",
    "to_rotvec",
    "to_rpy",
]
