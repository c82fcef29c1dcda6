"""Motion of an arm: poses followed as they come, and paths planned as a whole."""

from urdf_ik.motion.tracker import Step, Tracker

__all__ = ["Step", "Tracker"]
