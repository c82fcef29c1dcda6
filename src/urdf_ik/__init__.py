"""urdf-ik: every inverse-kinematics solution of a robot arm, from its URDF, in closed form.

>>> import urdf_ik
>>> arm = urdf_ik.load("zyyzyz_6r")
>>> len(arm.ik(arm.fk([0.3, -0.5, 0.8, 0.4, 0.7, -0.2])))
8
"""

from urdf_ik.arm import Arm, load
from urdf_ik.chain import Chain
from urdf_ik.comparison import Comparison, compare
from urdf_ik.dh import DHTable
from urdf_ik.errors import (
    CatalogueError,
    ChainError,
    DHError,
    JointVectorError,
    MissingPackage,
    PlotError,
    PoseError,
    TaskError,
    UnsupportedArm,
    UrdfError,
    UrdfIkError,
    VelocityError,
    WorkspaceError,
)
from urdf_ik.poses import (
    pose,
    to_euler_zyx,
    to_quat_wxyz,
    to_quat_xyzw,
    to_rotvec,
    to_rpy,
)
from urdf_ik.redundancy import Redundancy
from urdf_ik.self_motion import Sweep
from urdf_ik.solutions import IKSolutions, Singular, Solution
from urdf_ik.structure import Structure

__version__ = "0.1.0"

__all__ = [
    "Arm",
    "CatalogueError",
    "Chain",
    "ChainError",
    "Comparison",
    "DHError",
    "DHTable",
    "IKSolutions",
    "JointVectorError",
    "MissingPackage",
    "PlotError",
    "PoseError",
    "Redundancy",
    "Singular",
    "Solution",
    "Structure",
    "Sweep",
    "TaskError",
    "UnsupportedArm",
    "UrdfError",
    "UrdfIkError",
    "VelocityError",
    "WorkspaceError",
    "compare",
    "load",
    "pose",
    "to_euler_zyx",
    "to_quat_wxyz",
    "to_quat_xyzw",
    "to_rotvec",
    "to_rpy",
]
