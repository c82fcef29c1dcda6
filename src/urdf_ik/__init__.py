"""urdf-ik: every inverse-kinematics solution of a robot arm, from its URDF, in closed form where there is one.

>>> import urdf_ik
>>> arm = urdf_ik.load("zyyzyz_6r")
>>> len(arm.ik(arm.fk([0.3, -0.5, 0.8, 0.4, 0.7, -0.2])))
8
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

from urdf_ik.guards import forks as _forks  # noqa: F401  a fork waits for first calls of other threads

if TYPE_CHECKING:
    from urdf_ik.arm import Arm, load
    from urdf_ik.chain import Chain
    from urdf_ik.collision.shapes import Box, Capsule, Cylinder, HalfSpace, Mesh, Points, Sphere
    from urdf_ik.collision.world import World
    from urdf_ik.comparison import Comparison, compare
    from urdf_ik.datasets import dataset
    from urdf_ik.dh import DHTable
    from urdf_ik.errors import (
        ArgumentError,
        BatchError,
        CatalogueError,
        ChainError,
        ClusterError,
        DHError,
        JointVectorError,
        MissingPackage,
        PathError,
        PlaceError,
        PlotError,
        PoseError,
        StoreError,
        TaskError,
        UnsupportedArm,
        UrdfError,
        UrdfIkError,
        VelocityError,
        WorkspaceError,
        WorldError,
    )
    from urdf_ik.motion import Plan, arc, line, polyline, read_waypoints
    from urdf_ik.placements import placement
    from urdf_ik.poses import (
        pose,
        to_euler_zyx,
        to_quat_wxyz,
        to_quat_xyzw,
        to_rotvec,
        to_rpy,
    )
    from urdf_ik.redundancy import Interval, Intervals, Redundancy, Region, Sweep
    from urdf_ik.solutions import IKSolutions, Singular, Solution
    from urdf_ik.structure import Structure

__version__ = "0.1.0"

__all__ = [
    "ArgumentError",
    "Arm",
    "BatchError",
    "Box",
    "Capsule",
    "CatalogueError",
    "Chain",
    "ChainError",
    "ClusterError",
    "Comparison",
    "Cylinder",
    "DHError",
    "DHTable",
    "HalfSpace",
    "IKSolutions",
    "Interval",
    "Intervals",
    "JointVectorError",
    "Mesh",
    "MissingPackage",
    "PathError",
    "PlaceError",
    "Plan",
    "PlotError",
    "Points",
    "PoseError",
    "Redundancy",
    "Region",
    "Singular",
    "Solution",
    "Sphere",
    "StoreError",
    "Structure",
    "Sweep",
    "TaskError",
    "UnsupportedArm",
    "UrdfError",
    "UrdfIkError",
    "VelocityError",
    "WorkspaceError",
    "World",
    "WorldError",
    "arc",
    "compare",
    "dataset",
    "line",
    "load",
    "placement",
    "polyline",
    "pose",
    "read_waypoints",
    "to_euler_zyx",
    "to_quat_wxyz",
    "to_quat_xyzw",
    "to_rotvec",
    "to_rpy",
]

# Importing the package costs nothing: a name's module is imported when the name is first used.
_NAMES = {
    "arm": (
        "Arm",
        "load",
    ),
    "chain": ("Chain",),
    "collision.shapes": ("Box", "Capsule", "Cylinder", "HalfSpace", "Mesh", "Points", "Sphere"),
    "collision.world": ("World",),
    "comparison": (
        "Comparison",
        "compare",
    ),
    "datasets": ("dataset",),
    "dh": ("DHTable",),
    "errors": (
        "ArgumentError",
        "BatchError",
        "CatalogueError",
        "ChainError",
        "ClusterError",
        "DHError",
        "JointVectorError",
        "MissingPackage",
        "PathError",
        "PlaceError",
        "PlotError",
        "PoseError",
        "StoreError",
        "TaskError",
        "UnsupportedArm",
        "UrdfError",
        "UrdfIkError",
        "VelocityError",
        "WorkspaceError",
        "WorldError",
    ),
    "motion": (
        "Plan",
        "arc",
        "line",
        "polyline",
        "read_waypoints",
    ),
    "placements": ("placement",),
    "poses": (
        "pose",
        "to_euler_zyx",
        "to_quat_wxyz",
        "to_quat_xyzw",
        "to_rotvec",
        "to_rpy",
    ),
    "redundancy": ("Interval", "Intervals", "Redundancy", "Region", "Sweep"),
    "solutions": (
        "IKSolutions",
        "Singular",
        "Solution",
    ),
    "structure": ("Structure",),
}
_MODULE = {name: module for module, names in _NAMES.items() for name in names}


def __getattr__(name: str) -> Any:
    """A public name, or a module of the package."""
    if name in _MODULE:
        value = getattr(import_module(f"{__name__}.{_MODULE[name]}"), name)
        globals()[name] = value
        return value
    if not name.startswith("_"):
        try:
            return import_module(f"{__name__}.{name}")
        except ModuleNotFoundError as error:
            if error.name != f"{__name__}.{name}":
                raise
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
