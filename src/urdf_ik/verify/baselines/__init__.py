"""Baselines: an arm's answers in a lock file, and the check of a later arm against them.

>>> import urdf_ik
>>> lock = urdf_ik.freeze(urdf_ik.load("planar_2r"))
>>> lock.verify(urdf_ik.load("planar_2r")).passed
True
"""

from __future__ import annotations

from urdf_ik.verify.baselines.baseline import Baseline
from urdf_ik.verify.baselines.freezing import freeze
from urdf_ik.verify.baselines.records import Planted, Pose
from urdf_ik.verify.baselines.verification import Verification

__all__ = ["Baseline", "Planted", "Pose", "Verification", "freeze"]
