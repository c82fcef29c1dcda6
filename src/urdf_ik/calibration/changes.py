"""What a fit changed, and how large the errors are."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from urdf_ik.kinematics.derivatives import Parameter

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
        deviation: standard deviation of the fitted value, along what the measurements tell apart.
        told: whether the measurements determine it alone; where not, see :attr:`Calibration.untold`.
    """

    parameter: Parameter
    before: float
    after: float
    deviation: float
    told: bool

    @property
    def change(self) -> float:
        """After less before."""
        return self.after - self.before

    @property
    def unit(self) -> str:
        """'m', 'rad', or '' for an axis."""
        return {"xyz": "m", "rpy": "rad", "offset": "rad or m"}.get(self.parameter.field, "")
