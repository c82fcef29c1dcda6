"""Values of the redundancy parameters, as they are typed, shown and named."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from urdf_ik.arm import Arm
from urdf_ik.cli.console import Angles


def own_values(arm: Arm, q: NDArray[np.float64]) -> NDArray[np.float64] | None:
    """Redundancy parameters of joint vectors (N, n); None for an arm without one."""
    return None if arm.redundancy is None else arm.redundancy_of(q)


def shown(arm: Arm, value: Any, angles: Angles) -> Any:
    """Values of the parameters, (...) of one and (..., k) of k, in the units that the user reads."""
    turns = np.array([parameter.unit == "rad" for parameter in arm.solver.parameters])
    return np.where(turns if len(turns) > 1 else turns[0], angles.angle(value), value)


def units(arm: Arm, angles: Angles) -> list[str]:
    """The units that the user reads the parameters in."""
    return [angles.unit if parameter.unit == "rad" else "m" for parameter in arm.solver.parameters]


def line(arm: Arm, value: Any, angles: Angles) -> str:
    """One value of each parameter in words."""
    values = np.atleast_1d(shown(arm, value, angles)) + 0.0
    parts = zip(arm.solver.parameters, values, units(arm, angles), strict=True)
    return ", ".join(f"{parameter.label} {float(x):.4f} {unit}" for parameter, x, unit in parts)


def headings(arm: Arm) -> list[str]:
    """Names of the columns that hold the values."""
    count = len(arm.solver.parameters)
    return ["redundancy"] * count if count < 2 else [f"redundancy_{k}" for k in range(1, count + 1)]
