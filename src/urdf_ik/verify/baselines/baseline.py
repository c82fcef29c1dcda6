"""Baseline: the contents of a lock file, and its text: one pose a line, sorted keys, numbers that read back exactly."""

from __future__ import annotations

import json
import math
import os
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

from urdf_ik.arm import Arm
from urdf_ik.errors import ArgumentError, printable
from urdf_ik.support import files
from urdf_ik.support.text import plain, quoted
from urdf_ik.support.watch import Progress
from urdf_ik.verify.baselines.records import KINDS, Answer, Planted, Pose, Recorded
from urdf_ik.verify.baselines.verification import Verification, verify
from urdf_ik.verify.description import Row, from_dict

FORMAT, VERSION = "urdf-ik lock", 1
MOST_BYTES = 2**26
"""Bytes of a lock file at most."""

@dataclass(frozen=True)
class Baseline(Recorded):
    """An arm and its answers as they were: what :func:`urdf_ik.freeze` makes and a lock file holds.

    Example:
        >>> import urdf_ik
        >>> lock = urdf_ik.freeze(urdf_ik.load("planar_2r"))
        >>> lock
        <Baseline of planar_2r, base_link to tool0: 50 poses, ... solutions>
        >>> lock.save("arm.lock.json")
        >>> Baseline.load("arm.lock.json") == lock
        True
    """


    def __repr__(self) -> str:
        found = sum(len(pose.answers) for pose in self.poses)
        contacts = f", contacts {self.contacts}" if self.contacts else ""
        left_out = f", {self.unlooked}" if self.unlooked else ""
        return (
            f"<Baseline of {printable(self.arm.title)}: {len(self.poses)} poses, {found} solutions{contacts}{left_out}>"
        )

    def verify(
        self,
        arm: Arm,
        *,
        tolerance_mm: float | None = None,
        tolerance_deg: float | None = None,
        ignore: str | Iterable[str] = (),
        time_limit: float | None = None,
        progress: Progress | None = None,
    ) -> Verification:
        """What of this holds for an arm.

        Solutions are compared as sets: a solver that orders or names them in another way is no difference; a solution
        that is lost or gained is one.

        Args:
            arm: the arm of today.
            tolerance_mm: lengths [mm] up to which a change counts as none; default: 1e-6.
            tolerance_deg: angles [deg], likewise; default: 6e-8.
            ignore: kinds of differences that do not count: 'limits', 'collisions', 'visuals', 'names'.
            time_limit: s after which no more poses are solved; what was left out did not pass.
            progress: called with (poses done, poses).

        Raises:
            ArgumentError: a tolerance is negative, or a kind cannot be ignored.
            ArgumentError: ``time_limit`` is no number of seconds, or ``progress`` no function.

        Example:
            >>> import urdf_ik
            >>> lock = urdf_ik.freeze(urdf_ik.load("planar_2r"))
            >>> print(lock.verify(urdf_ik.load("planar_2r_unit"), ignore="collisions,visuals").differences[0])
            joint_2: its origin moved by 934 mm
        """
        return verify(
            self, arm, tolerance_mm=tolerance_mm, tolerance_deg=tolerance_deg, ignore=ignore, time_limit=time_limit,
            progress=progress,
        )  # fmt: skip

    def to_text(self) -> str:
        """The text of a lock file.

        Example:
            >>> import urdf_ik
            >>> lock = urdf_ik.freeze(urdf_ik.load("planar_2r"))
            >>> Baseline.from_text(lock.to_text()) == lock
            True
        """
        described = plain(self.arm.to_dict())
        listed = {
            "arm": described,
            "contacts": self.contacts or "checked",
            "format": FORMAT,
            "made_by": dict(self.made_by),
            "planted": [plain({"T": each.T, "kind": each.kind, "q": each.q}) for each in self.planted],
            "poses": [_pose_dict(each) for each in self.poses],
            "version": VERSION,
        } | ({"unlooked": self.unlooked} if self.unlooked else {})
        return _lines(listed) + "\n"

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the lock file.

        Raises:
            ArgumentError: it cannot be written.

        Example:
            >>> import urdf_ik
            >>> urdf_ik.freeze(urdf_ik.load("planar_2r")).save("arm.lock.json")
        """
        files.write(path, self.to_text().encode())

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> Baseline:
        """Read a lock file.

        Raises:
            ArgumentError: it cannot be read, is no lock file, or one of a version that this release does not know.

        Example:
            >>> import urdf_ik
            >>> urdf_ik.freeze(urdf_ik.load("planar_2r")).save("arm.lock.json")
            >>> Baseline.load("arm.lock.json").arm.joint_names
            ('joint_1', 'joint_2')
        """
        return cls.from_text(files.read(path).decode("utf-8", "replace"), files.name_of(path))

    @classmethod
    def from_text(cls, text: str, name: str = "the text") -> Baseline:
        """The baseline of a lock file's text.

        Raises:
            ArgumentError: it is not the text of a lock file; the message calls it ``name``.

        Example:
            >>> Baseline.from_text("{}")
            Traceback (most recent call last):
            urdf_ik.errors.ArgumentError: the text is no lock file: it has no "format": "urdf-ik lock"...
        """
        hint = "; urdf-ik freeze writes one"
        try:
            data = json.loads(text)
        except (ValueError, RecursionError) as error:
            raise ArgumentError(f"{name} is no lock file: {printable(error, 200)}{hint}") from None
        if not isinstance(data, dict) or data.get("format") != FORMAT:
            raise ArgumentError(f'{name} is no lock file: it has no "format": "{FORMAT}"{hint}')
        if data.get("version") != VERSION:
            raise ArgumentError(
                f"{name} is a lock file of version {quoted(data.get('version'))}; "
                f"this release reads {VERSION}{hint} anew"
            )
        try:
            return _read(data)
        except (KeyError, TypeError, ValueError, AttributeError, OverflowError) as error:
            reason = f"{type(error).__name__} {error}"
            raise ArgumentError(f"{name} is a damaged lock file: {printable(reason, 200)}{hint} anew") from None


def _pose_dict(pose: Pose) -> dict[str, Any]:
    return {
        "T": list(pose.T),
        "kind": pose.kind,
        "redundancy": list(pose.redundancy),
        "solutions": [
            {
                "branch": answer.branch,
                "contact": answer.contact,
                "q": list(answer.q),
                "singular": answer.singular,
                "within_limits": answer.within_limits,
            }
            for answer in pose.answers
        ],
    }


def _read(data: dict[str, Any]) -> Baseline:
    arm = from_dict(data["arm"])
    poses = []
    for each in data["poses"]:
        answers = tuple(
            Answer(
                _row(one["q"], arm.dof),
                str(one["branch"]),
                bool(one["within_limits"]),
                bool(one["singular"]),
                None if one["contact"] is None else bool(one["contact"]),
            )
            for one in each["solutions"]
        )
        redundancy = _row(each["redundancy"], len(each["redundancy"]))
        poses.append(Pose(_kind(each["kind"]), _row(each["T"], 12), redundancy, answers))
    planted = tuple(
        Planted(_kind(each["kind"]), _row(each["q"], arm.dof), _row(each["T"], 12)) for each in data["planted"]
    )
    contacts = "" if data["contacts"] == "checked" else str(data["contacts"])
    made_by = tuple(sorted((str(name), str(value)) for name, value in data["made_by"].items()))
    return Baseline(arm, planted, tuple(poses), contacts, made_by, str(data.get("unlooked", "")))


def _row(values: Any, width: int) -> Row:
    row = tuple(float(each) for each in values)
    if len(row) != width or not all(map(math.isfinite, row)):
        raise ValueError(f"{len(row)} numbers, or one that is not finite, where {width} are needed")
    return row


def _kind(value: Any) -> str:
    if value not in KINDS:
        raise ValueError(f"no kind of pose: {quoted(value)}")
    return str(value)


def _lines(value: Any, indent: str = "\n") -> str:
    """JSON with sorted keys: a line for each entry of the upper levels, and for each element of a list of entries."""
    inner = indent + " "
    if isinstance(value, dict):
        parts = [f"{json.dumps(key)}: {_lines(value[key], inner)}" for key in sorted(value)]
        return "{" + inner + ("," + inner).join(parts) + indent + "}" if parts else "{}"
    if isinstance(value, list) and any(isinstance(each, dict | list) for each in value):
        parts = [json.dumps(each, sort_keys=True, allow_nan=False) for each in value]
        return "[" + inner + ("," + inner).join(parts) + indent + "]"
    return json.dumps(value, allow_nan=False)
