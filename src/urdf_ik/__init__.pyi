"""The types of the names that ``__init__.py`` imports at their first use."""

from typing import Any

from urdf_ik.arm import Arm as Arm
from urdf_ik.arm import load as load
from urdf_ik.arm import load_compiled as load_compiled
from urdf_ik.calibration.fit import calibrate as calibrate
from urdf_ik.calibration.report import Calibration as Calibration
from urdf_ik.cell.shapes import Box as Box
from urdf_ik.cell.shapes import Capsule as Capsule
from urdf_ik.cell.shapes import Cylinder as Cylinder
from urdf_ik.cell.shapes import HalfSpace as HalfSpace
from urdf_ik.cell.shapes import Mesh as Mesh
from urdf_ik.cell.shapes import Points as Points
from urdf_ik.cell.shapes import Sphere as Sphere
from urdf_ik.cell.world import World as World
from urdf_ik.errors import ArgumentError as ArgumentError
from urdf_ik.errors import ChainError as ChainError
from urdf_ik.errors import JobError as JobError
from urdf_ik.errors import MissingPackage as MissingPackage
from urdf_ik.errors import PoseError as PoseError
from urdf_ik.errors import UnsupportedArm as UnsupportedArm
from urdf_ik.errors import UrdfError as UrdfError
from urdf_ik.errors import UrdfIkError as UrdfIkError
from urdf_ik.export import compile as compile
from urdf_ik.ik.configurations import OPW as OPW
from urdf_ik.ik.redundancy import Interval as Interval
from urdf_ik.ik.redundancy import Intervals as Intervals
from urdf_ik.ik.redundancy import Region as Region
from urdf_ik.ik.solutions import IKSolutions as IKSolutions
from urdf_ik.ik.solutions import Singular as Singular
from urdf_ik.ik.solutions import Solution as Solution
from urdf_ik.ik.solutions.distances import Wish as Wish
from urdf_ik.ik.task import Task as Task
from urdf_ik.kinematics.chain import Chain as Chain
from urdf_ik.kinematics.dh import DHTable as DHTable
from urdf_ik.kinematics.structure import Structure as Structure
from urdf_ik.model.poses import pose as pose
from urdf_ik.paths import Plan as Plan
from urdf_ik.paths import arc as arc
from urdf_ik.paths import line as line
from urdf_ik.paths import polyline as polyline
from urdf_ik.paths import read_waypoints as read_waypoints
from urdf_ik.verify.baselines import Lock as Lock
from urdf_ik.verify.baselines import freeze as freeze
from urdf_ik.verify.comparison import Comparison as Comparison
from urdf_ik.verify.comparison import compare as compare
from urdf_ik.verify.many_arms import compare_many as compare_many
from urdf_ik.version import __version__ as __version__

def __getattr__(name: str) -> Any: ...
