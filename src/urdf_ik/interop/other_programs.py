"""Joint vectors as ROS messages.

Pinocchio's configurations are methods of the arm: ``arm.to_pinocchio(q)`` and ``arm.from_pinocchio(q_pin)``.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from urdf_ik.arm import Arm
from urdf_ik.errors import ArgumentError
from urdf_ik.typing import Array


def to_joint_state(arm: Arm, q: ArrayLike, names: Sequence[str], others: ArrayLike | None = None) -> Array:
    """Joint vectors as the positions of a ``sensor_msgs/JointState`` whose ``name`` is ``names``.

    Args:
        arm: the arm.
        q: (..., n) rad or m.
        names: joints of the message, in its order; more than the arm's, or fewer.
        others: (k,) the message's positions so far, for joints that are not the arm's; default: NaN.

    Returns:
        (..., k) rad or m.

    Raises:
        ArgumentError: q or ``others`` has another length, or ``names`` holds a name twice.

    Example:
        >>> import urdf_ik
        >>> from urdf_ik import interop
        >>> arm = urdf_ik.load("planar_2r_unit")
        >>> interop.to_joint_state(arm, [0.1, 0.2], ["gripper", "joint_2", "joint_1"], others=[0.04, 0.0, 0.0]).tolist()
        [0.04, 0.2, 0.1]
    """
    Q, place = arm.chain.check(q, padded=True), _places(names)
    kept = np.full(len(names), np.nan) if others is None else np.asarray(others, dtype=np.float64)
    if kept.shape != (len(names),):
        raise ArgumentError(f"others has the shape {kept.shape}; one position for each of {len(names)} names is needed")
    out = np.tile(kept, (*Q.shape[:-1], 1))
    for column, name in enumerate(arm.joint_names):
        if name in place:
            out[..., place[name]] = Q[..., column]
    return out


def from_joint_state(arm: Arm, names: Sequence[str], positions: ArrayLike) -> Array:
    """Joint vectors (..., n) rad or m of a ``sensor_msgs/JointState``: the inverse of :func:`to_joint_state`.

    Args:
        arm: the arm.
        names: joints of the message, in its order; all of the arm's are among them.
        positions: (..., k) rad or m.

    Raises:
        ArgumentError: a joint of the arm is missing, a name stands there twice, or the shapes do not fit.
    """
    given, place = np.asarray(positions, dtype=np.float64), _places(names)
    if given.shape[-1:] != (len(names),):
        raise ArgumentError(f"positions of shape {given.shape} for {len(names)} names; (..., {len(names)}) is needed")
    if missing := [name for name in arm.joint_names if name not in place]:
        raise ArgumentError(f"the message lacks {', '.join(missing)}; it has {', '.join(names)}")
    out: Array = given[..., [place[name] for name in arm.joint_names]]
    return arm.chain.check(out)


def _places(names: Sequence[str]) -> dict[str, int]:
    """Index of each name."""
    place = {name: k for k, name in enumerate(names)}
    if len(place) < len(names):
        twice = sorted({name for name in names if list(names).count(name) > 1})
        raise ArgumentError(f"the message names {', '.join(twice)} twice")
    return place
