"""urdf-ik: every inverse-kinematics solution of a robot arm, from its URDF, in closed form where there is one.

>>> import urdf_ik
>>> arm = urdf_ik.load("zyyzyz_6r")
>>> len(arm.ik(arm.fk([0.3, -0.5, 0.8, 0.4, 0.7, -0.2])))
8
"""

from urdf_ik.support import forks as _forks  # noqa: F401  a fork waits for first calls of other threads
from urdf_ik.support.lazy import attributes
from urdf_ik.version import __version__  # noqa: F401

# A module is imported when one of its names is first used. The types of these names are in __init__.pyi.
_PUBLIC = {
    "arm": ("Arm", "load", "load_compiled"),
    "calibration": ("Calibration", "calibrate"),
    "cell.shapes": ("Box", "Capsule", "Cylinder", "HalfSpace", "Mesh", "Points", "Sphere"),
    "cell.world": ("World",),
    "errors": (
        "ArgumentError",
        "ChainError",
        "JobError",
        "MissingPackage",
        "PoseError",
        "UnsupportedArm",
        "UrdfError",
        "UrdfIkError",
    ),
    "export": ("compile",),
    "ik.configurations": ("OPW",),
    "ik.redundancy": ("Interval", "Intervals", "Region"),
    "ik.task": ("Task",),
    "ik.solutions": ("IKSolutions", "Singular", "Solution"),
    "ik.solutions.distances": ("Wish",),
    "kinematics.chain": ("Chain",),
    "kinematics.dh": ("DHTable",),
    "kinematics.structure": ("Structure",),
    "model.poses": ("pose",),
    "paths": ("Plan", "arc", "line", "polyline", "read_waypoints"),
    "verify.baselines": ("Lock", "freeze"),
    "verify.comparison": ("Comparison", "compare"),
    "verify.many_arms": ("compare_many",),
}

__all__ = sorted(name for names in _PUBLIC.values() for name in names)

# The differentiable functions of torch and jax, which need not be installed: urdf_ik.torch.ik, urdf_ik.jax.ik.
_AUTOGRAD = {"jax": "interop", "torch": "interop"}

__getattr__ = attributes(__name__, {name: module for module, names in _PUBLIC.items() for name in names} | _AUTOGRAD)


def __dir__() -> list[str]:
    rooms = ("calibration", "interop", "jax", "maps", "show", "torch", "verify")
    return [*__all__, *rooms, "__version__"]
