"""``Tracker``: one target a control cycle, within the joint limits, on one branch."""

from urdf_ik._core import Step
from urdf_ik.paths.tracker.tracker import Tracker

__all__ = ["Step", "Tracker"]
