"""Options ``--lock`` and ``--redundancy``: joints that are held, and what is free in an arm with seven joints."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from urdf_ik import _cli_io

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from urdf_ik._cli_io import Angles
    from urdf_ik._cli_targets import Target
    from urdf_ik.arm import Arm


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
            raise _cli_io.usage(f"{text!r} is no NAME=VALUE, such as joint_7=0.5 or joint_7=30deg", option)
    return out


def spread(arm: Arm, target: Target, typed: str | None, angles: Angles) -> Target:
    """``target`` with the values of the redundancy parameter: each pose at every value typed, else as it is.

    Raises:
        typer.BadParameter: values that are none, or an arm without such a parameter.
    """
    if typed is None:
        return target
    parameter = arm.redundancy
    if parameter is None:
        raise _cli_io.usage(f"this arm's {arm.dof} joints leave nothing free in a pose", "--redundancy")
    values = _cli_io.numbers(typed, "--redundancy", ["value"] * len(typed.replace(",", " ").split()))
    if not len(values):
        raise _cli_io.usage(f"a value is needed, of the {parameter}", "--redundancy")
    values = np.deg2rad(values) if angles.degrees and parameter.unit == "rad" else values
    poses = np.repeat(target.poses, len(values), axis=0)
    return replace(target, poses=poses, redundancy=np.tile(values, len(target.poses)))


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
    name = "swivel angle" if arm.redundancy is None or arm.redundancy.kind == "swivel" else arm.redundancy.joint
    return f"{name} {float(shown(arm, value, angles)) + 0.0:.4f} {unit(arm, angles)}"
