"""Second derivatives of the tip's pose by the joints."""

from __future__ import annotations

import numpy as np

from urdf_ik.kinematics.chain import Chain
from urdf_ik.typing import Array


def curvature(chain: Chain, q: Array, along: Array, moving: Array) -> Array:
    """The rate of the twist ``J(q) along`` when the joints move with the velocities ``moving``: (dJ/dq moving) along.

    With joint i before joint k on the way to the tip, column k of the Jacobian is (v_k, z_k), and
    dv_k/dq_i = z_i x v_k, dv_i/dq_k = z_i x v_k, dz_k/dq_i = z_i x z_k, dz_i/dq_k = 0 (Hourtash, "The kinematic Hessian
    and higher derivatives", IEEE CIRA 2005). With ``along`` = ``moving`` it is the term that joint velocities add to
    the tip's acceleration.

    Args:
        chain: the arm.
        q: (..., n) rad or m, finite.
        along: (..., n) rad/s or m/s.
        moving: (..., n) rad/s or m/s; the leading dimensions broadcast.

    Returns:
        (..., 6) m/s^2 and rad/s^2 at the tip, in base axes.

    Example:
        >>> import numpy as np
        >>> import urdf_ik
        >>> chain = urdf_ik.load("planar_2r").chain
        >>> turning = np.array([1.0, 0.0])  # rad/s: the centripetal acceleration is the tip's distance from axis 1
        >>> (curvature(chain, np.zeros(2), turning, turning)[:3].round(6) + 0.0).tolist()
        [-0.196, 0.0, 0.0]
    """
    axes = chain.axes
    if axes is not chain:
        gain: Array = chain.gain  # type: ignore[attr-defined]  # where axes differ from joints, the chain is coupled
        q, along, moving = (each @ gain.T for each in (q, along, moving))
    J = axes.jacobian(q)
    v, z = J[..., :3, :], np.where(axes.prismatic, 0.0, J[..., 3:, :])
    a, b = along[..., None, :], moving[..., None, :]
    # Sums over the joints before each one.
    before_a, before_b = (np.cumsum(z * each, axis=-1) - z * each for each in (a, b))
    linear = np.cross(before_a, v * b, axis=-2) + np.cross(before_b, v * a, axis=-2) + np.cross(z * a, v * b, axis=-2)
    angular = np.cross(before_b, z * a, axis=-2)
    return np.concatenate([linear.sum(axis=-1), angular.sum(axis=-1)], axis=-1)
