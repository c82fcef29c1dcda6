"""Velocity limits of a URDF's joints."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from urdf_ik.kinematics.chain.serial import Chain
from urdf_ik.model.urdf import MOVABLE, UrdfModel
from urdf_ik.support.tolerances import LARGEST


def velocity_limits(model: UrdfModel, chain: Chain) -> NDArray[np.float64]:
    """(n,) rad/s or m/s, greatest speed of each joint of a chain of the URDF; infinite where the URDF gives no speed.

    A speed of zero counts as not given: files have it where nobody filled it in, and the joint could not move. So do
    one below 1e-15, which is zero by rounding, and one beyond 1e15, which programs write for none. A joint of the chain
    that mimics another narrows its speed as it does its limits.

    Example:
        >>> import urdf_ik
        >>> arm = urdf_ik.load("scara_rrpr")
        >>> velocity_limits(arm.model, arm.chain).tolist()
        [3.0, 3.0, 1.0, 3.0]
    """
    speeds = dict.fromkeys(chain.joint_names, np.inf)
    followers = {follower.name for follower in chain.followers}
    for joint in model.joints:
        driver, multiplier, _ = model.driver(joint)
        speed = joint.velocity if joint.name == driver.name or joint.name in followers else None
        if speed is None or not 1.0 / LARGEST <= speed <= LARGEST:
            continue
        if multiplier and joint.type in MOVABLE and driver.name in speeds:
            speeds[driver.name] = min(speeds[driver.name], speed / abs(multiplier))
    limits = np.array([speeds[name] for name in chain.joint_names], dtype=np.float64)
    limits.setflags(write=False)
    return limits
