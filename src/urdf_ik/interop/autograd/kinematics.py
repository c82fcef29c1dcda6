"""Forward kinematics by a URDF's numbers, and the distance of a pose from a target, in torch's and jax's own functions.

Both libraries call these functions alike, so that ``xp`` is either; ``constant`` makes one of its arrays of numbers.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Callable

    from urdf_ik.kinematics.derivatives import WrittenChain

_UNITS = np.eye(3)


def residual(xp: Any, constant: Callable[[Any], Any], geometry: WrittenChain, q: Any, values: Any, T: Any) -> Any:
    """How far the tip at ``q`` (..., B, n) is from targets (..., 4, 4): (..., B, 6), zero at a solution.

    The rotation counts by the skew part of R R_T^T. It is zero at the rotation nearest to R_T, so that entries of a
    target may change one by one.

    Example:
        >>> import urdf_ik
        >>> from urdf_ik.kinematics.derivatives import written
        >>> arm = urdf_ik.load("planar_2r")
        >>> geometry, q = written(arm.chain), np.array([[0.1, 0.2]])
        >>> bool(abs(residual(np, np.asarray, geometry, q, geometry.values, arm.fk(q[0]))).max() < 1e-12)
        True
    """
    R, p = fk(xp, constant, geometry, q, values)
    target = T[..., None, :3, :3]
    M = R @ target.swapaxes(-1, -2)
    turn = [
        0.5 * (M[..., 2, 1] - M[..., 1, 2]),
        0.5 * (M[..., 0, 2] - M[..., 2, 0]),
        0.5 * (M[..., 1, 0] - M[..., 0, 1]),
    ]
    off = p - T[..., None, :3, 3]
    return xp.stack([off[..., 0], off[..., 1], off[..., 2], *turn], -1)


def fk(xp: Any, constant: Callable[[Any], Any], geometry: WrittenChain, q: Any, values: Any) -> tuple[Any, Any]:
    """Rotations (..., 3, 3) and positions (..., 3) of the tip at joint vectors (..., n), by numbers (p,) of a URDF.

    Example:
        >>> import urdf_ik
        >>> from urdf_ik.kinematics.derivatives import written
        >>> geometry = written(urdf_ik.load("planar_2r").chain)
        >>> fk(np, np.asarray, geometry, np.zeros(2), geometry.values)[1].round(6).tolist()
        [0.196, 0.0, 0.0]
    """
    one, zero = constant(1.0), constant(0.0)
    eye, cross = constant(_UNITS), constant(np.cross(np.eye(3)[:, None], np.eye(3)[None]).transpose(2, 0, 1))
    R, p = eye, constant(np.zeros(3))
    for joint, up, start in zip(geometry.joints, geometry.upwards, geometry.starts, strict=True):
        own = [values[start + k] for k in range(10 if joint.driver else 6)]
        turn = _about(xp, own[5], 2, one, zero) @ _about(xp, own[4], 1, one, zero) @ _about(xp, own[3], 0, one, zero)
        shift = xp.stack(own[:3], -1)
        if joint.driver:
            axis = xp.stack(own[6:9], -1)
            axis = axis / xp.sqrt((axis * axis).sum())
            value = own[9] if joint.column is None else joint.multiplier * q[..., joint.column] + own[9]
            if joint.prismatic:
                shift = shift + value[..., None] * (turn @ axis)
            else:
                s, c = xp.sin(value)[..., None, None], xp.cos(value)[..., None, None]
                along = axis[:, None] * axis[None, :]
                turn = turn @ (c * eye + (1.0 - c) * along - s * (cross @ axis))
        if up:
            R = R @ turn.swapaxes(-1, -2)
            p = p - (R @ shift[..., None])[..., 0]
        else:
            p = p + (R @ shift[..., None])[..., 0]
            R = R @ turn
    return R, p


def _about(xp: Any, angle: Any, axis: int, one: Any, zero: Any) -> Any:
    """Rotation (3, 3) by an angle about x, y or z."""
    s, c = xp.sin(angle), xp.cos(angle)
    rows = [[one, zero, zero], [zero, c, -s], [zero, s, c]]
    order = [(k - axis) % 3 for k in range(3)]
    return xp.stack([xp.stack([rows[i][j] for j in order], -1) for i in order], -2)
