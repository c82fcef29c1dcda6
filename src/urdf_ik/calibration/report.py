"""``Calibration``, the result of a fit: the new arm, what changed, what cannot be told apart, the errors."""

from __future__ import annotations

import os
from dataclasses import dataclass, field
from functools import cached_property
from html import escape
from typing import Any

import numpy as np

from urdf_ik.arm import Arm, load
from urdf_ik.calibration import pictures
from urdf_ik.calibration.changes import DEG, MM, Change, Errors
from urdf_ik.calibration.equations import BASE, MARKER, Equations
from urdf_ik.calibration.measurements import Measurements
from urdf_ik.model.poses import pose, to_rpy
from urdf_ik.model.urdf.edits import text_of, with_numbers
from urdf_ik.support import files
from urdf_ik.support.display import html_of, short
from urdf_ik.support.text import Section, json_text, plain
from urdf_ik.typing import Array


@dataclass(frozen=True, eq=False, repr=False)
class Calibration:
    """A fit of an arm's URDF to measurements; :func:`urdf_ik.calibrate` makes it.

    Attributes:
        nominal: the arm before.
        given: the measurements.
        equations: residuals and derivatives.
        x: (k,) the fitted numbers, in the order of ``equations.parameters``.
        changes: each fitted number before and after.
        untold: groups of numbers of which only sums can be told; each is a change that no measurement shows.
        singular_values: (k,) of the residuals' derivatives, in standard deviations: how well directions are told.
        before: errors with the URDF as it was; base and marker fitted, where they were asked for.
        after: errors with the fitted numbers.
        validated: errors of measurements that a fit did not see, each fifth by the others; None for too few.
        noise: standard deviation of one coordinate: (m, rad), or (m,).
        outliers: numbers of the measurements that were left out.
        residuals_before: (m, r) m, rad.
        residuals_after: the same.
        covariance: (k, k) of the fitted numbers.
        unlooked: what the time limit left out; '' where the fit came to its end.

    Example:
        >>> import numpy as np
        >>> import urdf_ik
        >>> arm = urdf_ik.load("planar_2r")
        >>> q = np.random.default_rng(0).uniform(-1.0, 1.0, (20, 2))
        >>> found = urdf_ik.calibrate(arm, q, arm.fk(q + 0.001), fit="offsets")
        >>> [round(each.change, 6) for each in found.changes]
        [0.001, 0.001]
    """

    nominal: Arm
    given: Measurements
    equations: Equations
    x: Array
    changes: tuple[Change, ...]
    untold: tuple[tuple[str, ...], ...]
    singular_values: Array
    before: Errors
    after: Errors
    validated: Errors | None
    noise: tuple[float, ...]
    outliers: tuple[int, ...]
    residuals_before: Array = field(repr=False)
    residuals_after: Array = field(repr=False)
    covariance: Array = field(repr=False)
    unlooked: str = ""

    @cached_property
    def arm(self) -> Arm:
        """The calibrated arm, with the base, tip and held joints of the one before."""
        nominal = self.nominal
        return load(
            self.urdf().decode(),
            base=nominal.base,
            tip=nominal.tip,
            locked=dict(nominal.chain.locked) or None,
            mesh_roots=nominal.model.package_dirs,
        )

    @property
    def base_pose(self) -> Array:
        """(4, 4) m, pose of the base in the frame that was measured in."""
        return self.equations.place(BASE, self.x)

    @property
    def marker_pose(self) -> Array:
        """(4, 4) m, pose of the measured marker in the tip."""
        return self.equations.place(MARKER, self.x)

    def urdf(self) -> bytes:
        """The URDF as it was written, with the fitted numbers in place of the old ones.

        Names, meshes and comments stay. Of an arm that was not read from a URDF file (a xacro, MJCF or an open file),
        the clean URDF takes the place of the file.

        Raises:
            UrdfError: the file is no longer what it was.
        """
        return with_numbers(text_of(self.nominal.model), self._numbers())

    def write(self, path: str | os.PathLike[str]) -> None:
        """Write :meth:`urdf` to a file.

        Raises:
            ArgumentError: it cannot be written.
        """
        files.write(path, self.urdf())

    def _numbers(self) -> dict[str, dict[str, dict[str, list[float]]]]:
        """What is written into the URDF: joint -> element -> attribute -> numbers."""
        fitted = self.equations.moved(self.x)
        out: dict[str, dict[str, dict[str, list[float]]]] = {}
        chain = self.equations.chain
        for joint, start in zip(chain.joints, chain.starts, strict=True):
            names = {each.field for each in fitted if each.joint == joint.name}
            if joint.name.startswith((BASE, MARKER)) or not names:
                continue
            own = chain.values[start : start + (10 if joint.driver else 6)].copy()
            for k, parameter in enumerate(chain.parameters[start : start + len(own)]):
                own[k] = fitted.get(parameter, own[k])
            changed: dict[str, dict[str, list[float]]] = {}
            if "offset" in names and joint.driver != joint.name:
                changed["mimic"] = {"offset": [own[9]]}
            elif "offset" in names:
                # A URDF has no offset of a joint: its origin takes it.
                u = own[6:9] / np.linalg.norm(own[6:9])
                origin = pose(own[:3], rpy=own[3:6])
                shift = pose(own[9] * u) if joint.prismatic else pose(np.zeros(3), rotvec=own[9] * u)
                moved = origin @ shift
                own[:3] = moved[:3, 3]
                own[3:6] = own[3:6] if joint.prismatic else to_rpy(moved)
            if names & {"xyz", "rpy", "offset"}:
                changed["origin"] = {"xyz": own[:3].tolist(), "rpy": own[3:6].tolist()}
            if "axis" in names:
                changed["axis"] = {"xyz": own[6:9].tolist()}
            out[joint.name] = changed
        return out

    def sections(self) -> tuple[Section, ...]:
        """The report as tables."""
        errors = [("before", self.before), ("after", self.after)]
        if self.validated is not None:
            errors.append(("not seen by the fit", self.validated))
        remarks = [f"{len(self.given)} measurements ({self.given.kind})"]
        remarks.append(f"noise of one coordinate: {self._noise()}")
        remarks += [f"the fit was {self.unlooked}"] if self.unlooked else []
        if self.outliers:
            shown = ", ".join(map(str, self.outliers[:20]))
            remarks.append(f"{len(self.outliers)} outliers were left out (counted from 0): {shown}")
        rows = tuple(
            (str(each.parameter), *_numbers_of(each), "" if each.told else "only in a sum") for each in self.changes
        )
        out = [
            Section("errors", ("", "error"), tuple((name, str(each)) for name, each in errors), tuple(remarks),
                    ("", "error")),
            Section("parameters", ("parameter", "change", "+-", "unit", "told"), rows, (),
                    ("parameter", "unit", "told")),
        ]  # fmt: skip
        if self.untold:
            lines = tuple(" + ".join(group) for group in self.untold)
            out.append(Section("cannot be told apart by these measurements", remarks=lines))
        for name, T in (
            ("the base in the measuring frame", self.base_pose),
            ("the marker in the tip", self.marker_pose),
        ):
            if not np.array_equal(T, np.eye(4)):
                xyz, rpy = (" ".join(f"{x:.9g}" for x in part) for part in (T[:3, 3], to_rpy(T)))
                out.append(Section(f'{name}: xyz="{xyz}" rpy="{rpy}"'))
        return tuple(out)

    def to_dict(self) -> dict[str, Any]:
        """Plain lists, numbers and text."""
        out: dict[str, Any] = plain(
            {
                "robot": self.nominal.name,
                "kind": self.given.kind,
                "measurements": len(self.given),
                "before": vars(self.before),
                "after": vars(self.after),
                "validated": None if self.validated is None else vars(self.validated),
                "noise": list(self.noise),
                "outliers": list(self.outliers),
                "parameters": [
                    {**each.parameter._asdict(), "before": each.before, "after": each.after,
                     "deviation": each.deviation, "told": each.told}
                    for each in self.changes
                ],
                "untold": [list(group) for group in self.untold],
                "singular_values": self.singular_values.tolist(),
                "base_pose": self.base_pose.tolist(),
                "marker_pose": self.marker_pose.tolist(),
                "unlooked": self.unlooked,
            }
        )  # fmt: skip
        return out

    def to_json(self) -> str:
        """:meth:`to_dict` as strict JSON."""
        return json_text(self.to_dict())

    def to_html(self) -> str:
        """A page with the tables, and with pictures of the errors and of the changes with their standard deviations."""
        drawn = (
            pictures.residuals(self.residuals_before, self.residuals_after, self.given.kind)
            + pictures.changes(self.changes)
        )  # fmt: skip
        return (
            '<!doctype html><html lang="en"><head><meta charset="utf-8"/>'
            f"<title>Calibration of {escape(self.nominal.name)}</title><style>{pictures.STYLE}</style></head>"
            f"<body>{self._repr_html_()}{drawn}</body></html>\n"
        )

    def verdict(self) -> str:
        """The result in a line."""
        unseen = "" if self.validated is None else f"; of measurements that it did not see {self.validated}"
        ended = f"; {self.unlooked}" if self.unlooked else ""
        return f"errors fall from {self.before} to {self.after}{unseen}{ended}"

    def _noise(self) -> str:
        text = f"{self.noise[0] * MM:.4f} mm"
        return text if len(self.noise) == 1 else f"{text}, {self.noise[1] * DEG:.5f} deg"

    def _title(self) -> str:
        return f"calibration of {self.nominal.name} by {len(self.given)} measurements ({self.given.kind})"

    def __str__(self) -> str:
        return "\n".join([self._title(), *(str(section) for section in self.sections()), self.verdict()])

    def __repr__(self) -> str:
        return short(self._title(), [self.verdict()])

    def _repr_html_(self) -> str:
        return html_of(self._title(), self.verdict(), self.after.position <= self.before.position, self.sections())


def _numbers_of(each: Change) -> tuple[str, str, str]:
    """Change, standard deviation and unit, in mm and degrees."""
    if each.parameter.field == "xyz":
        return f"{each.change * MM:+.4f}", f"{each.deviation * MM:.4f}", "mm"
    if each.parameter.field == "axis":
        return f"{each.change:+.6f}", f"{each.deviation:.6f}", ""
    return f"{each.change * DEG:+.5f}", f"{each.deviation * DEG:.5f}", "deg"
