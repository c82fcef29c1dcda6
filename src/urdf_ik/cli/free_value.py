"""Options ``--lock`` and ``--redundancy``: joints that are held, and what is free in an arm with seven joints."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from urdf_ik.cli import console

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
            raise console.usage(f"{text!r} is no NAME=VALUE, such as joint_7=0.5 or joint_7=30deg", option)
    return out


def own_values(arm: Arm, q: NDArray[np.float64]) -> NDArray[np.float64] | None:
    """What the redundancy parameter is at joint vectors (N, n); None for an arm without one."""
    return None if arm.redundancy is None else arm.redundancy_of(q)


def shown(arm: Arm, value: Any, angles: Angles) -> Any:
    """A value of the parameter in the units that the user reads."""
    return angles.angle(value) if unit(arm, angles) != "m" else value


def unit(arm: Arm, angles: Angles) -> str:
    """The unit that the user reads the parameter in."""
    return angles.unit if arm.redundancy is not None and arm.redundancy.unit == "rad" else "m"


def line(arm: Arm, value: float, angles: Angles) -> str:
    """A value in words."""
    name = "" if arm.redundancy is None else arm.redundancy.label
    return f"{name} {float(shown(arm, value, angles)) + 0.0:.4f} {unit(arm, angles)}"
