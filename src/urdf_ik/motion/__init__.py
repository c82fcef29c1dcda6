"""Motion of an arm: poses followed as they come, and paths planned as a whole."""

from urdf_ik._core import Step
from urdf_ik.motion.tracker import Tracker

__all__ = ["Step", "Tracker"]
