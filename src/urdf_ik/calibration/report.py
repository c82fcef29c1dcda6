"""``Calibration``, the result of a fit: the new arm, the changes, the unobservable parameters, the errors."""

import os
from dataclasses import dataclass, field
from functools import cached_property
from html import escape
from typing import Any, ClassVar

import numpy as np

from urdf_ik.arm import Arm, load
from urdf_ik.calibration.equations import BASE, MARKER, Equations
from urdf_ik.calibration.measurements import Measurements
from urdf_ik.kinematics.derivatives import Parameter
from urdf_ik.model.poses import pose, to_rpy
from urdf_ik.model.urdf.edits import text_of, with_numbers
from urdf_ik.support import files
from urdf_ik.support.report import Report
from urdf_ik.support.text import Section, plain
from urdf_ik.typing import Array

MM, DEG = 1e3, 180.0 / np.pi
"""Millimetres a metre, degrees a radian."""


@dataclass(frozen=True)
class Errors:
    """Errors of measurements: root mean square and greatest, of positions or lengths [m] and of rotations [rad].

    ``rotation`` and ``worst_rotation`` are NaN where none was measured.
    """

    position: float
    worst_position: float
    rotation: float
    worst_rotation: float

    def __str__(self) -> str:
        text = f"{self.position * MM:.4f} mm (worst {self.worst_position * MM:.4f})"
        if np.isnan(self.rotation):
            return text
        return f"{text}, {self.rotation * DEG:.4f} deg (worst {self.worst_rotation * DEG:.4f})"


@dataclass(frozen=True)
class Change:
    """A fitted number.

    Attributes:
        parameter: which.
        before: its first value [m or rad].
        after: its fitted value.
        deviation: standard deviation of the fitted value, along the observable directions.
        observable: whether the measurements determine it alone; where not, see :attr:`Calibration.unobservable`.
    """

    parameter: Parameter
    before: float
    after: float
    deviation: float
    observable: bool

    @property
    def change(self) -> float:
        """After less before."""
        return self.after - self.before

    @property
    def unit(self) -> str:
        """'m', 'rad', or '' for an axis."""
        return {"xyz": "m", "rpy": "rad", "offset": "rad or m"}.get(self.parameter.field, "")

    def cells(self) -> tuple[str, ...]:
        """A row of a table: parameter, change, standard deviation, unit, whether it is observable."""
        scale, digits, unit = {"xyz": (MM, 4, "mm"), "axis": (1.0, 6, "")}.get(self.parameter.field, (DEG, 5, "deg"))
        numbers = f"{self.change * scale:+.{digits}f}", f"{self.deviation * scale:.{digits}f}"
        return str(self.parameter), *numbers, unit, "" if self.observable else "only combined"


@dataclass(frozen=True, eq=False, repr=False)
class Calibration(Report):
    """A fit of an arm's URDF to measurements; :func:`urdf_ik.calibrate` makes it.

    Attributes:
        nominal: the arm before.
        given: the measurements.
        equations: residuals and derivatives.
        x: (k,) the fitted numbers, in the order of ``equations.parameters``.
        changes: each fitted number before and after.
        unobservable: groups of parameters of which the measurements determine only combinations.
        singular_values: (k,) of the residuals' derivatives, in standard deviations: how observable each direction is.
        before: errors with the URDF as it was; base and marker fitted, where they were asked for.
        after: errors with the fitted numbers.
        validated: errors of held-out measurements by five-fold cross-validation; None for too few measurements.
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

    JUDGES: ClassVar[bool] = False

    nominal: Arm
    given: Measurements
    equations: Equations
    x: Array
    changes: tuple[Change, ...]
    unobservable: tuple[tuple[str, ...], ...]
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

    @property
    def faulty(self) -> bool:
        """Whether the fit has made the errors larger."""
        return self.after.position > self.before.position

    def title(self) -> str:
        """The arm and the measurements."""
        return f"calibration of {self.nominal.name} by {len(self.given)} measurements ({self.given.kind})"

    def sections(self) -> tuple[Section, ...]:
        """The errors, the fitted numbers, and what is unobservable."""
        noise = f"{self.noise[0] * MM:.4f} mm" + (f", {self.noise[1] * DEG:.5f} deg" if len(self.noise) > 1 else "")
        remarks = [f"noise of one coordinate: {noise}"]
        if self.outliers:
            shown = ", ".join(map(str, self.outliers[:20]))
            remarks.append(f"{len(self.outliers)} outliers were left out (counted from 0): {shown}")
        errors = (("before", self.before), ("after", self.after), ("not seen by the fit", self.validated))
        rows = tuple((name, str(error)) for name, error in errors if error is not None)
        header = ("parameter", "change", "+-", "unit", "observable")
        out = [
            Section("errors", ("", "error"), rows, tuple(remarks), ("", "error")),
            Section(
                "parameters", header, tuple(change.cells() for change in self.changes), (), (header[0], *header[3:])
            ),
        ]
        if self.unobservable:
            lines = tuple(" + ".join(group) for group in self.unobservable)
            out.append(Section("unobservable: the measurements determine only combinations of these", remarks=lines))
        return tuple(out)

    def lines(self) -> tuple[str, ...]:
        """Where the base and the marker are, as far as they were fitted."""
        places = (("the base in the measuring frame", self.base_pose), ("the marker in the tip", self.marker_pose))
        out = []
        for name, T in places:
            if not np.array_equal(T, np.eye(4)):
                xyz, rpy = (" ".join(f"{x:.9g}" for x in part) for part in (T[:3, 3], to_rpy(T)))
                out.append(f'{name}: xyz="{xyz}" rpy="{rpy}"')
        return tuple(out)

    def summary(self) -> str:
        """The errors before and after."""
        unseen = "" if self.validated is None else f"; of measurements that it did not see {self.validated}"
        return f"errors fall from {self.before} to {self.after}{unseen}"

    def to_dict(self) -> dict[str, Any]:
        """Plain lists, numbers and text."""
        parameters = [
            {
                **change.parameter._asdict(),
                "before": change.before,
                "after": change.after,
                "deviation": change.deviation,
                "told": change.observable,
            }
            for change in self.changes
        ]
        out: dict[str, Any] = plain(
            {
                "robot": self.nominal.name,
                "kind": self.given.kind,
                "measurements": len(self.given),
                "before": vars(self.before),
                "after": vars(self.after),
                "validated": None if self.validated is None else vars(self.validated),
                "noise": self.noise,
                "outliers": self.outliers,
                "parameters": parameters,
                "untold": self.unobservable,
                "singular_values": self.singular_values,
                "base_pose": self.base_pose,
                "marker_pose": self.marker_pose,
                "unlooked": self.unlooked,
            }
        )
        return out

    def to_html(self) -> str:
        """A page with the tables."""
        title = f"Calibration of {escape(self.nominal.name)}"
        head = f'<head><meta charset="utf-8"/><title>{title}</title></head>'
        return f'<!doctype html><html lang="en">{head}<body>{self._repr_html_()}</body></html>\n'
