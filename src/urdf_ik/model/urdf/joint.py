"""Joint: one joint of a URDF."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from urdf_ik.support.read_only import Frozen


@dataclass(frozen=True, eq=False)
class Joint(Frozen):
    """One joint of a URDF.

    Attributes:
        name: unique among the joints.
        type: 'revolute', 'continuous', 'prismatic', 'fixed', 'floating' or 'planar'.
        parent: link that carries the joint.
        child: link that the joint carries.
        origin: (4, 4) pose of the joint, and of the child link at zero, in the parent link [m], read-only.
        axis: (3,) unit direction in the joint's frame, read-only; (1, 0, 0) where the type has none.
        lower: lower bound [rad or m]; -inf where the type has none.
        upper: upper bound [rad or m]; inf where the type has none.
        velocity: greatest speed [rad/s or m/s], or None where none is given.
        effort: greatest torque or force [N m or N], or None where none is given.
        mimic: (joint followed, multiplier, offset [rad or m]), or None.
        line: line of its tag in the source.
        rpy: (3,) rad, roll, pitch and yaw of the origin as written; zeros where none are.
        axis_length: length of the axis as written, which ``axis`` is divided by.
    """

    name: str
    type: str
    parent: str
    child: str
    origin: NDArray[np.float64]
    axis: NDArray[np.float64]
    lower: float
    upper: float
    velocity: float | None
    effort: float | None
    mimic: tuple[str, float, float] | None
    line: int
    rpy: tuple[float, float, float] = (0.0, 0.0, 0.0)
    axis_length: float = 1.0
