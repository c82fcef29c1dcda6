"""The limits of position, velocity and acceleration that a tracker keeps."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from urdf_ik.errors import ArgumentError
from urdf_ik.ik.solver import Solver
from urdf_ik.support import inputs
from urdf_ik.support.text import quoted
from urdf_ik.typing import Array


def positive(name: str, value: float, unit: str, *, zero: bool = False) -> float:
    """A finite number above zero, or from zero on."""
    return inputs.number(value, name, low=0.0, above=None if zero else 0.0, unit=unit)


def limits_of(solver: Solver, name: str, value: ArrayLike) -> Array:
    """(n,) numbers above zero, infinite for no limit, from one number or one a joint."""
    given = inputs.real(value, name, f"one number, or one a joint ({solver.dof},)")
    if given.shape not in ((), (1,), (solver.dof,)):
        raise ArgumentError(f"{name}: one number, or one a joint ({solver.dof},), is needed: {quoted(value)} given")
    array = np.array(np.broadcast_to(given, (solver.dof,)))
    bad = np.flatnonzero(~(array > 0.0))
    if len(bad):
        raise ArgumentError(
            f"{name}: {array[bad[0]]} for joint {quoted(solver.joint_names[bad[0]])}; a number above 0 is needed (inf: "
            "no limit)"
        )
    return array
