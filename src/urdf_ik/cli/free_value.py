"""Options ``--lock`` and ``--redundancy``: joints that are held, and what is free in an arm with seven joints."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from urdf_ik.cli import console
from urdf_ik.support.text import quoted

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from urdf_ik.arm import Arm
    from urdf_ik.cli.console import Angles


def locked(typed: Sequence[str], option: str) -> dict[str, float]:
    """Joint names and values [rad or m] of ``NAME=VALUE``; a value with ``deg`` behind it is in degrees.

    Raises:
        typer.BadParameter: one is not of this form.
    """
    out = {}
    for text in typed:
        name, _, value = text.rpartition("=")
        number = value.strip().removesuffix("deg")
        try:
            out[name.strip()] = math.radians(float(number)) if number != value.strip() else float(number)
        except ValueError:
            name = ""
        if not name:
            raise console.usage(f"{quoted(text)} is no NAME=VALUE, such as joint_7=0.5 or joint_7=30deg", option)
    return out


def own_values(arm: Arm, q: NDArray[np.float64]) -> NDArray[np.float64] | None:
    """What the redundancy parameter is at joint vectors (N, n); None for an arm without one."""
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
