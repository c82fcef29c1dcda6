"""Checks of every URDF in a folder: one row an arm."""

import os
import re
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from urdf_ik.arm import load
from urdf_ik.arm.loading import read
from urdf_ik.errors import ChainError, UnsupportedArm, UrdfError, UrdfIkError
from urdf_ik.support import inputs
from urdf_ik.support.report import Report
from urdf_ik.support.text import Section
from urdf_ik.support.watch import Progress, Watch
from urdf_ik.verify import completeness, crosscheck

RESULTS = ("passed", "FAILED", "REFUSED", "not ended", "not checked", "not an arm")
PASSED, FAILED, REFUSED, NOT_ENDED, NOT_CHECKED, NOT_AN_ARM = RESULTS
"""Results of a file. No arm can be read from a refused one; no check is for an arm that was not checked; what is not an
arm has no chain of joints, as a URDF of obstacles; the time limit passed before a check ended, without a fault so far.
"""


@dataclass(frozen=True)
class _CheckedFile:
    """One file, checked.

    Attributes:
        file: its name in the folder.
        result: passed, FAILED, REFUSED, not ended, not checked or not an arm.
        robot: the robot's name; '' for a file that cannot be read, as are base, tip and family.
        base: base link.
        tip: tip link.
        joints: number of joints from base to tip.
        family: the family that solves the arm.
        words: what was found, or why the arm was not checked.
        report: the whole report as plain values, or None.
    """

    file: str
    result: str
    robot: str = ""
    base: str = ""
    tip: str = ""
    joints: int = 0
    family: str = ""
    words: str = ""
    report: dict[str, Any] | None = field(default=None, repr=False)


@dataclass(frozen=True, repr=False)
class FolderCheck(Report):
    """The arms of a folder, checked in the same way.

    Attributes:
        question: what was asked of each.
        arms: one a file, by name.
        unlooked: what the time limit left out; '' where every file was looked at.
    """

    question: dict[str, Any]
    arms: tuple[_CheckedFile, ...]
    unlooked: str = ""

    @property
    def faulty(self) -> bool:
        """Whether a file failed or was refused; one that no check is for, and one without an arm, do not count."""
        return any(checked.result in (FAILED, REFUSED) for checked in self.arms)

    @property
    def passed(self) -> bool:
        """Whether nothing failed, was refused or left out."""
        return super().passed and not any(checked.result == NOT_ENDED for checked in self.arms)

    def title(self) -> str:
        """The number of files."""
        return "1 file" if len(self.arms) == 1 else f"{len(self.arms)} files"

    def sections(self) -> tuple[Section, ...]:
        """A table with a row a file; the family's name without its details."""
        header = ("file", "joints", "family", "result")
        rows = tuple((c.file, str(c.joints or ""), re.split("[,:]", c.family)[0], c.result) for c in self.arms)
        return (Section("", header, rows, left=("file", "family", "result")),)

    def lines(self) -> tuple[str, ...]:
        """What was found, or why an arm was not checked."""
        return tuple(f"{each.result} {each.file}: {each.words}" for each in self.arms if each.words)

    def summary(self) -> str:
        """How many files have which result."""
        results = [checked.result for checked in self.arms]
        counts = [f"{results.count(result)} {result.lower()}" for result in RESULTS if result in results]
        return f"{self.title()}: {', '.join(counts)}"


def check_folder(
    folder: str | os.PathLike[str],
    *,
    n: int = 200,
    seed: int = 0,
    complete: bool = False,
    collision: bool | None = None,
    base: str | None = None,
    tip: str | None = None,
    mesh_roots: Sequence[str | os.PathLike[str]] = (),
    time_limit: float | None = None,
    progress: Progress | None = None,
) -> FolderCheck:
    """Check every URDF of a folder, and of the folders in it, as ``urdf-ik check`` checks one.

    Args:
        folder: the folder.
        n: number of random poses of each arm.
        seed: the same seed gives the same report.
        complete: look for missed solutions instead; see :func:`urdf_ik.verify.completeness.compare`.
        collision: compare collision, too; default: where the URDF has collision shapes that can be read.
        base: base link of all; default: chosen for each, as ``urdf_ik.load`` does.
        tip: tip link of all; likewise.
        mesh_roots: folders in which meshes and ROS packages are looked for.
        time_limit: s after which no more is checked; what was left out did not pass.
        progress: called with (files done, files).

    Returns:
        The report. Files that cannot be read or checked are rows with the reason.

    Raises:
        UrdfError: the folder holds no URDF.
        ArgumentError: n is below 1, or ``time_limit`` is no number of seconds.
    """
    inputs.poses(n)
    watch = Watch(time_limit, progress)
    paths = sorted(path for path in Path(folder).rglob("*.urdf") if path.is_file())
    if not paths:
        problem = "the folder holds no file that ends in .urdf"
        raise UrdfError(problem, source=str(folder), hint="name a folder of URDFs, or a single file")
    arms: list[_CheckedFile] = []
    for (k,) in watch.parts(len(paths), 1, "files"):
        file, about = str(paths[k].relative_to(folder)), dict[str, Any]()
        try:
            arm = load(paths[k], base, tip, mesh_roots=mesh_roots)
            about = {"robot": arm.name, "base": arm.base, "tip": arm.tip, "joints": arm.dof}
            about["family"] = arm.structure.family or ""
            report: Report
            if complete:
                report = completeness.compare(arm, n=n, seed=seed, time_limit=watch.left)
            else:
                report = crosscheck.check(arm, n, seed, collision, time_limit=watch.left)
            result = PASSED if report.passed else FAILED if report.faulty else NOT_ENDED
            failed = [line for line in report.lines() if line.startswith("FAILED")]
            words = "; ".join([*failed, report.summary(), *filter(None, [report.unlooked])])
            checked: dict[str, Any] = {"result": result, "words": words, "report": report.to_dict()}
        except UrdfIkError as error:
            without = isinstance(error, ChainError) and not read(paths[k], mesh_roots=mesh_roots)[0].chains()
            result = NOT_AN_ARM if without else NOT_CHECKED if isinstance(error, UnsupportedArm) else REFUSED
            checked = {"result": result, "words": str(error)}
        arms.append(_CheckedFile(file, **about, **checked))
    question = {"n": n, "seed": seed, "complete": complete, "collision": collision, "base": base, "tip": tip}
    return FolderCheck(question, tuple(arms), watch.unlooked)
