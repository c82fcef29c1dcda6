"""survey(): checks many arms."""

from __future__ import annotations

import hashlib
import os
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from urdf_ik.arm import Arm, load
from urdf_ik.arm.loading import read
from urdf_ik.errors import ArgumentError, ChainError, UnsupportedArm, UrdfError, UrdfIkError
from urdf_ik.maps.cluster import versions
from urdf_ik.support import files as files_guard
from urdf_ik.support import inputs
from urdf_ik.support.watch import Watch
from urdf_ik.verify.completeness import Completeness, compare
from urdf_ik.verify.crosscheck import Report, check
from urdf_ik.verify.surveys.report import (
    FAILED,
    NOT_AN_ARM,
    NOT_CHECKED,
    NOT_ENDED,
    PASSED,
    REFUSED,
    Checked,
    Survey,
)

FORMAT, VERSION = "urdf-ik survey", 1
ENDINGS = (".urdf", ".urdf.gz")
"""Endings of the files that are taken from a folder."""


Files = str | os.PathLike[str] | Sequence[str | os.PathLike[str]]


def urdf_files(folder: str | os.PathLike[str]) -> tuple[Path, ...]:
    """The URDFs of a folder and of those in it, by name.

    Raises:
        UrdfError: there is none.

    Example:
        >>> from urdf_ik.model import catalogue
        >>> folder = Path(catalogue.resolve("planar_2r").path).parent
        >>> "planar_2r.urdf" in [path.name for path in urdf_files(folder)]
        True
    """
    where = inputs.path(folder, "folder")
    try:
        found = sorted(path for path in where.rglob("*") if path.name.endswith(ENDINGS) and path.is_file())
    except OSError as error:
        reason = f"cannot read the folder: {error.strerror}"
        raise UrdfError(reason, source=str(folder), hint="check its rights") from None
    if not found:
        raise UrdfError(
            f"the folder holds no file that ends in {' or '.join(ENDINGS)}", source=str(folder),
            hint="name a folder of URDFs, or a single file",
        )  # fmt: skip
    return tuple(found)


def survey(
    files: Files,
    *,
    n: int = 200,
    seed: int = 0,
    complete: bool = False,
    collision: bool | None = None,
    base: str | None = None,
    tip: str | None = None,
    mesh_roots: Sequence[str | os.PathLike[str]] = (),
    time_limit: float | None = None,
    progress: Callable[[int, int], object] | None = None,
) -> Survey:
    """Check every arm of a folder, or of a list of files, against Pinocchio, or for solutions that its solver lacks.

    A file that cannot be read, one without an arm, or an arm that no check is for, is a row of the table and ends
    nothing.

    Args:
        files: a folder, whose URDFs are taken with those of the folders in it; or paths.
        n: number of random poses of each arm; see :func:`urdf_ik.verify.crosscheck.check`.
        seed: the same seed gives the same survey.
        complete: look for missed solutions instead; see :func:`urdf_ik.verify.completeness.compare`.
        collision: compare collision, too; default: where the URDF has collision shapes that can be read.
        base: base link of all; default: chosen for each, as ``urdf_ik.load`` does.
        tip: tip link of all; likewise.
        mesh_roots: folders in which meshes and ROS packages are looked for.
        time_limit: s after which no more is checked; what was left out did not pass.
        progress: called with the number of arms behind us, and of all.

    Raises:
        ArgumentError: a number that makes no sense.
        UrdfError: the folder holds no URDF.

    Example:
        >>> from urdf_ik.model import catalogue
        >>> found = survey([catalogue.resolve("puma_560").path], n=1, complete=True)
        >>> print(found.verdict())
        PASSED: 1 file: 1 passed
    """
    if isinstance(files, str | os.PathLike):
        where = inputs.path(files, "files")
        root = where if os.path.isdir(where) else None
        paths: tuple[Path, ...] = (where,) if root is None else urdf_files(root)
    else:
        held = inputs.items(files, "files", "a folder, or paths of files,")
        paths, root = tuple(inputs.path(each, "a path of files") for each in held), None
    complete = inputs.flag(complete, "complete")
    collision = None if collision is None else inputs.flag(collision, "collision")
    watch = Watch(time_limit, progress)
    folders = [mesh_roots] if isinstance(mesh_roots, str | os.PathLike) else mesh_roots
    folders = [
        inputs.path(each, "a folder of mesh_roots") for each in inputs.items(folders, "mesh_roots", "paths of folders")
    ]
    n = inputs.poses(n)
    inputs.whole(seed, "seed", high=2**64)
    if complete and collision is not None:
        raise ArgumentError("complete=True compares solutions and nothing else; leave collision out")
    if not paths:
        raise ArgumentError("no file given; one or more are needed")
    names = tuple(str(path if root is None else path.relative_to(root)) for path in paths)
    job = Checking(
        tuple(map(os.path.abspath, paths)), names, n, seed, complete, collision, base, tip,
        tuple(map(os.path.abspath, folders)),
    )  # fmt: skip
    question = job.described()
    arms: list[Checked] = []
    while len(arms) < len(paths) and not watch.is_over:
        arms.append(job.checked(len(arms), watch.left))
        watch.step(len(arms), len(paths))
    return Survey(question, tuple(arms), _left_out(len(arms), len(paths), watch))


@dataclass(frozen=True)
class Checking:
    """Checks the arm of a file; it is pickled for workers.

    Attributes:
        paths: the files.
        names: what the table calls them.
        n: number of random poses.
        seed: of the joint vectors.
        complete: whether to look for missed solutions instead.
        collision: whether to compare collision; None: where there are shapes.
        base: base link of all, or None.
        tip: tip link of all, or None.
        mesh_roots: folders in which meshes are looked for.
    """

    paths: tuple[str, ...]
    names: tuple[str, ...]
    n: int
    seed: int
    complete: bool
    collision: bool | None
    base: str | None
    tip: str | None
    mesh_roots: tuple[str, ...]

    def described(self) -> dict[str, Any]:
        """All that the reports depend on, but for the meshes."""
        asked = {name: value for name, value in asdict(self).items() if name not in ("paths", "names", "mesh_roots")}
        return {
            "format": FORMAT,
            "version": VERSION,
            **asked,
            "files": [[name, _digest(path)] for name, path in zip(self.names, self.paths, strict=True)],
            "made_by": versions()["urdf-ik"],
            "instructions": versions()["instructions"],
        }

    def checked(self, chunk: int, time_limit: float | None = None) -> Checked:
        """The row of a file, checked for so many seconds."""
        name = self.names[chunk]
        try:
            arm = load(self.paths[chunk], self.base, self.tip, mesh_roots=self.mesh_roots)
        except UrdfIkError as error:
            without = isinstance(error, ChainError) and self._has_no_chain(chunk)
            return Checked(name, NOT_AN_ARM if without else REFUSED, words=str(error))
        try:
            done = self._complete(arm, time_limit) if self.complete else self._check(arm, time_limit)
        except UrdfIkError as error:
            result = NOT_CHECKED if isinstance(error, UnsupportedArm) else REFUSED
            done = {"result": result, "words": str(error)}
        family = arm.structure.family or ""
        return Checked(name, robot=arm.name, base=arm.base, tip=arm.tip, joints=arm.dof, family=family, **done)

    def _has_no_chain(self, chunk: int) -> bool:
        """Whether no joint of a URDF moves an arm, so that there is nothing to be solved, whatever is asked."""
        try:
            return not read(self.paths[chunk], mesh_roots=self.mesh_roots)[0].chains()
        except UrdfIkError:
            return False

    def _check(self, arm: Arm, time_limit: float | None) -> dict[str, Any]:
        found = check(arm, n=self.n, seed=self.seed, collision=self.collision, time_limit=time_limit)
        wrong = "; ".join(f"{row.name}: {row.place() or 'nowhere in particular'}" for row in found.failed)
        return {
            "result": _result(found, bool(found.failed)),
            "found": _worst(found),
            "words": "; ".join(part for part in (wrong, found.unlooked) if part),
            "report": found.to_dict(),
        }

    def _complete(self, arm: Arm, time_limit: float | None) -> dict[str, Any]:
        found: Completeness = compare(arm, n=self.n, seed=self.seed, time_limit=time_limit)
        return {
            "result": _result(found, any(difference.counts for difference in found.differences)),
            "found": f"{sum(group.solver for group in found.groups)} solutions",
            "words": "" if not found.differences and not found.unlooked else found.verdict(),
            "report": found.to_dict(),
        }


def _result(found: Report | Completeness, wrong: bool) -> str:
    return PASSED if found.passed else FAILED if wrong else NOT_ENDED


def _left_out(done: int, total: int, watch: Watch) -> str:
    return "" if done == total else watch.ended(f"with {done} of {total} files: the others were")


def _worst(found: Report) -> str:
    """The worst error of a solution's position."""
    for row in found.rows:
        if row.name == "solutions, position":
            return f"{row.worst:.1e} {row.unit}"
    return ""


def _digest(path: str) -> str | None:
    """SHA-256 of a file; None where it cannot be read, which the check says then."""
    try:
        return hashlib.sha256(files_guard.read(path)).hexdigest()
    except ArgumentError:
        return None
