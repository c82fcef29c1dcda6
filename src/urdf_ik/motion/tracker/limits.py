"""The limits that a tracker keeps to, checked."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from urdf_ik.errors import ArgumentError, VelocityError

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

    from urdf_ik.arm import Arm

    Array = NDArray[np.float64]


def positive(name: str, value: float, unit: str, *, zero: bool = False) -> float:
    """A finite number above zero, or from zero on."""
    try:
        number = float(value)
    except (TypeError, ValueError):
        number = math.nan
    if not math.isfinite(number) or number < 0.0 or (number == 0.0 and not zero):
        raise ArgumentError(
            f"{name}={value!r} given; a finite number {'from' if zero else 'above'} 0 is needed [{unit}]"
        )
    return number


def limits_of(arm: Arm, name: str, value: ArrayLike) -> Array:
    """(n,) numbers above zero, infinite for no limit, from one number or one a joint."""
    try:
        array = np.array(np.broadcast_to(np.asarray(value, dtype=np.float64), (arm.dof,)))
    except (TypeError, ValueError):
        raise VelocityError(f"{name}: one number, or one a joint ({arm.dof},), is needed: {value!r} given") from None
    bad = np.flatnonzero(~(array > 0.0))
    if len(bad):
        raise VelocityError(
            f"{name}: {array[bad[0]]} for joint {arm.joint_names[bad[0]]!r}; a number above 0 is needed (inf: no limit)"
        )
    return array
