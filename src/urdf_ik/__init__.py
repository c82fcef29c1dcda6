"""urdf-ik: every inverse-kinematics solution of a robot arm, from its URDF, in closed form where there is one.

>>> import urdf_ik
>>> arm = urdf_ik.load("zyyzyz_6r")
>>> len(arm.ik(arm.fk([0.3, -0.5, 0.8, 0.4, 0.7, -0.2])))
8
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from urdf_ik.support import forks as _forks  # noqa: F401  a fork waits for first calls of other threads
from urdf_ik.support.lazy import attributes

if TYPE_CHECKING:
    from urdf_ik.arm import Arm, load
    from urdf_ik.calibration import Calibration, calibrate
    from urdf_ik.cell.shapes import Box, Capsule, Cylinder, HalfSpace, Mesh, Points, Sphere
    from urdf_ik.cell.world import World
    from urdf_ik.errors import (
        ArgumentError,
        ChainError,
        JobError,
        MissingPackage,
        PoseError,
        UnsupportedArm,
        UrdfError,
        UrdfIkError,
    )
    from urdf_ik.export import compile
    from urdf_ik.ik.redundancy import Interval, Intervals, Region
    from urdf_ik.ik.solutions import IKSolutions, Singular, Solution
    from urdf_ik.kinematics.chain import Chain
    from urdf_ik.kinematics.dh import DHTable
    from urdf_ik.kinematics.structure import Structure
    from urdf_ik.model.poses import pose
    from urdf_ik.paths import Plan, arc, line, polyline, read_waypoints
    from urdf_ik.verify.baselines import freeze
    from urdf_ik.verify.comparison import Comparison, compare, compare_many

__version__ = "0.1.0"

__all__ = [
    "ArgumentError",
    "Arm",
    "Box",
    "Calibration",
    "Capsule",
    "Chain",
    "ChainError",
    "Comparison",
    "Cylinder",
    "DHTable",
    "HalfSpace",
    "IKSolutions",
    "Interval",
    "Intervals",
    "JobError",
    "Mesh",
    "MissingPackage",
    "Plan",
    "Points",
    "PoseError",
    "Region",
    "Singular",
    "Solution",
    "Sphere",
    "Structure",
    "UnsupportedArm",
    "UrdfError",
    "UrdfIkError",
    "World",
    "arc",
    "calibrate",
    "compare",
    "compare_many",
    "compile",
    "freeze",
    "line",
    "load",
    "polyline",
    "pose",
    "read_waypoints",
]

# Importing the package costs nothing: a name's module is imported when the name is first used.
_MODULE = {
    "ArgumentError": "errors",
    "Arm": "arm",
    "Box": "cell.shapes",
    "Calibration": "calibration",
    "Capsule": "cell.shapes",
    "Chain": "kinematics.chain",
    "ChainError": "errors",
    "Comparison": "verify.comparison",
    "Cylinder": "cell.shapes",
    "DHTable": "kinematics.dh",
    "HalfSpace": "cell.shapes",
    "IKSolutions": "ik.solutions",
    "Interval": "ik.redundancy",
    "Intervals": "ik.redundancy",
    "JobError": "errors",
    "Mesh": "cell.shapes",
    "MissingPackage": "errors",
    "Plan": "paths",
    "Points": "cell.shapes",
    "PoseError": "errors",
    "Region": "ik.redundancy",
    "Singular": "ik.solutions",
    "Solution": "ik.solutions",
    "Sphere": "cell.shapes",
    "Structure": "kinematics.structure",
    "UnsupportedArm": "errors",
    "UrdfError": "errors",
    "UrdfIkError": "errors",
    "World": "cell.world",
    "arc": "paths",
    "calibrate": "calibration",
    "compare": "verify.comparison",
    "compare_many": "verify.comparison",
    "compile": "export",
    "freeze": "verify.baselines",
    "line": "paths",
    "load": "arm",
    "polyline": "paths",
    "pose": "model.poses",
    "read_waypoints": "paths",
}

# The differentiable functions of torch and jax, which need not be installed: urdf_ik.torch.ik, urdf_ik.jax.ik.
_AUTOGRAD = {"jax": "interop.autograd", "torch": "interop.autograd"}

__getattr__ = attributes(__name__, _MODULE | _AUTOGRAD)


def __dir__() -> list[str]:
    return sorted({*__all__, "__version__"})
