"""Surveys: checks of many arms in one run, a folder of URDFs in, one table out.

>>> from pathlib import Path
>>> from urdf_ik.model import catalogue
>>> from urdf_ik.verify import surveys
>>> files = [catalogue.resolve(name).path for name in ("planar_2r", "puma_560")]
>>> found = surveys.survey(files, n=5)
>>> found.passed, [each.result for each in found.arms]
(True, ['passed', 'passed'])

The checks are those of :mod:`urdf_ik.verify.crosscheck`, or with ``complete=True`` of
:mod:`urdf_ik.verify.completeness`.
"""

from __future__ import annotations

from urdf_ik.verify.surveys.report import FAILED, NOT_AN_ARM, NOT_CHECKED, NOT_ENDED, PASSED, REFUSED, Checked, Survey
from urdf_ik.verify.surveys.survey import survey, urdf_files

__all__ = [
    "Checked",
    "FAILED",
    "NOT_AN_ARM",
    "NOT_CHECKED",
    "NOT_ENDED",
    "PASSED",
    "REFUSED",
    "Survey",
    "survey",
    "urdf_files",
]
