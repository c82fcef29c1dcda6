"""Judgements of any solver on an arm: its wrong, missed and duplicate solutions, each with the pose to replay.

>>> import urdf_ik
>>> from urdf_ik.verify import judge
>>> arm = urdf_ik.load("puma_560")
>>> judge(arm, lambda T: arm.ik(T).to_array(), n=3).passed
True
"""

from __future__ import annotations

from urdf_ik.verify.judging.c_library import CLibrary
from urdf_ik.verify.judging.judge import judge, replay
from urdf_ik.verify.judging.report import Fault, Judgement, Kind
from urdf_ik.verify.judging.solvers import IKFastLibrary, SolverProcess, solver_of

__all__ = ["CLibrary", "Fault", "IKFastLibrary", "Judgement", "Kind", "SolverProcess", "judge", "replay", "solver_of"]
