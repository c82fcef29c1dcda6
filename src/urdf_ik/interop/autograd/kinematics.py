"""Forward kinematics by a URDF's numbers, residuals and swivel angles, in torch's and jax's own functions.

Both libraries call these functions alike, so that ``xp`` is either; ``constant`` makes one of its arrays of numbers.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    from urdf_ik.ik.families.parts.ideal import Ends
    from urdf_ik.kinematics.derivatives import WrittenChain

    Array = NDArray[np.float64]

_UNITS = np.eye(3)
_FOURTH = 3  # index of the joint whose axis a swivel angle is measured to


def swivel_row(geometry: WrittenChain, ends: Ends, q: Array) -> Array:
    """(..., 7) the derivative of an arm's swivel angle by the joints, by complex steps.

    Source: Squire and Trapp, "Using complex variables to estimate derivatives of real functions", SIAM Review 40(1),
    1998: no difference is taken, so that a step of 1e-30 loses nothing.

    Example:
        >>> import urdf_ik
        >>> from urdf_ik.kinematics.derivatives import written
        >>> arm = urdf_ik.load("srs_7r")
        >>> ends = arm.solver.redundant_member.swivel
        >>> row = swivel_row(written(arm.chain), ends, np.array([[0.3, 0.5, -0.4, 0.9, 0.2, -0.6, 0.1]]))
        >>> row.shape, bool((abs(row[0, 4:]) < 1e-12).all())
        ((1, 7), True)
    """
    moved = q[..., None, :] + 1e-30j * np.eye(7)
    c, s = swivel(np, np.asarray, ends, *fk(np, np.asarray, geometry, moved, geometry.values))
    return np.asarray((s.imag * c.real - c.imag * s.real) / 1e-30)


def residual(xp: Any, tip: tuple[Any, Any, Any], target: tuple[Any, Any]) -> Any:
    """How far tips are from targets (...): (..., B, 6), zero at a solution.

    The rotation counts by the skew part of R R_T^T. It is zero at the rotation nearest to R_T, so that entries of a
    target may change one by one.

    Example:
        >>> import urdf_ik
        >>> from urdf_ik.kinematics.derivatives import written
        >>> arm = urdf_ik.load("planar_2r")
        >>> geometry, q = written(arm.chain), np.array([[0.1, 0.2]])
        >>> T = arm.fk(q[0])
        >>> tip = fk(np, np.asarray, geometry, q, geometry.values)
        >>> bool(abs(residual(np, tip, (T[:3, :3], T[:3, 3]))).max() < 1e-12)
        True
    """
    M = tip[0] @ target[0][..., None, :, :].swapaxes(-1, -2)
    turn = [
        0.5 * (M[..., 2, 1] - M[..., 1, 2]),
        0.5 * (M[..., 0, 2] - M[..., 2, 0]),
        0.5 * (M[..., 1, 0] - M[..., 0, 1]),
    ]
    off = tip[1] - target[1][..., None, :]
    return xp.stack([off[..., 0], off[..., 1], off[..., 2], *turn], -1)


def swivel(xp: Any, constant: Callable[[Any], Any], ends: Ends, R: Any, p: Any, axis: Any) -> tuple[Any, Any]:
    """Cosine and sine (..., B) of the swivel angle, as the core measures it (swivel.hpp), of tips and axes 4.

    Example:
        >>> import urdf_ik
        >>> from urdf_ik.kinematics.derivatives import written
        >>> arm, q = urdf_ik.load("srs_7r"), np.array([0.3, 0.5, -0.4, 0.9, 0.2, -0.6, 0.1])
        >>> geometry, ends = written(arm.chain), arm.solver.redundant_member.swivel
        >>> c, s = swivel(np, np.asarray, ends, *fk(np, np.asarray, geometry, q, geometry.values))
        >>> bool(abs(np.arctan2(s, c) - arm.redundancy_of(q)) < 1e-12)
        True
    """
    W = p + (R @ constant(ends.tool_point)[:, None])[..., 0] - constant(ends.base_origin)
    normal = _cross(xp, constant(ends.base_rotation[2]), W)
    across = _cross(xp, W / xp.sqrt((W * W).sum(-1))[..., None], normal)
    c, s = (axis * normal).sum(-1), (axis * across).sum(-1)
    length = xp.sqrt(c * c + s * s)
    return c / length, s / length


def _cross(xp: Any, a: Any, b: Any) -> Any:
    pairs = ((1, 2), (2, 0), (0, 1))
    return xp.stack([a[..., i] * b[..., j] - a[..., j] * b[..., i] for i, j in pairs], -1)


def fk(xp: Any, constant: Callable[[Any], Any], geometry: WrittenChain, q: Any, values: Any) -> tuple[Any, Any, Any]:
    """Rotations (..., 3, 3) and positions (..., 3) of the tip at joint vectors (..., n), by numbers (p,) of a URDF.

    Returns:
        The rotations, the positions, and the direction (..., 3) of joint 4's axis; zeros where there is none.

    Example:
        >>> import urdf_ik
        >>> from urdf_ik.kinematics.derivatives import written
        >>> geometry = written(urdf_ik.load("planar_2r").chain)
        >>> fk(np, np.asarray, geometry, np.zeros(2), geometry.values)[1].round(6).tolist()
        [0.196, 0.0, 0.0]
    """
    one, zero = constant(1.0), constant(0.0)
    eye, cross = constant(_UNITS), constant(np.cross(np.eye(3)[:, None], np.eye(3)[None]).transpose(2, 0, 1))
    R, p, fourth = eye, constant(np.zeros(3)), constant(np.zeros(3))
    for joint, up, start in zip(geometry.joints, geometry.upwards, geometry.starts, strict=True):
        own = [values[start + k] for k in range(10 if joint.driver else 6)]
        turn = _about(xp, own[5], 2, one, zero) @ _about(xp, own[4], 1, one, zero) @ _about(xp, own[3], 0, one, zero)
        origin, shift, axis = turn, xp.stack(own[:3], -1), None
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
        before = R
        if up:
            R = before = R @ turn.swapaxes(-1, -2)
            p = p - (R @ shift[..., None])[..., 0]
        else:
            p = p + (R @ shift[..., None])[..., 0]
            R = R @ turn
        if joint.column == _FOURTH:
            fourth = (-joint.multiplier if up else joint.multiplier) * (before @ (origin @ axis)[..., None])[..., 0]
    return R, p, fourth


def _about(xp: Any, angle: Any, axis: int, one: Any, zero: Any) -> Any:
    """Rotation (3, 3) by an angle about x, y or z."""
    s, c = xp.sin(angle), xp.cos(angle)
    rows = [[one, zero, zero], [zero, c, -s], [zero, s, c]]
    order = [(k - axis) % 3 for k in range(3)]
    return xp.stack([xp.stack([rows[i][j] for j in order], -1) for i in order], -2)
