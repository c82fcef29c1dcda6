"""Forward kinematics by a URDF's numbers and steps of Newton's method, in torch's and jax's own functions.

The steps change nothing in answers of ``ik``, and carry derivatives through them.

Both libraries call these functions alike, so that ``xp`` is either; ``constant`` makes one of its arrays of numbers.
"""

from collections.abc import Callable
from typing import Any

import numpy as np

from urdf_ik.interop.differentiable import Answers, Differentiable
from urdf_ik.kinematics.chain.free_axis import turning
from urdf_ik.kinematics.derivatives import WrittenChain

_UNITS = np.eye(3)


def residual(xp: Any, tip: tuple[Any, Any], target: tuple[Any, Any]) -> Any:
    """How far tips are from targets (...): (..., B, 6), zero at a solution.

    The rotation counts by the skew part of R R_T^T. It is zero at the rotation nearest to R_T, so that entries of a
    target may change one by one.
    """
    M = tip[0] @ target[0][..., None, :, :].swapaxes(-1, -2)
    turn = [
        0.5 * (M[..., 2, 1] - M[..., 1, 2]),
        0.5 * (M[..., 0, 2] - M[..., 2, 0]),
        0.5 * (M[..., 1, 0] - M[..., 0, 1]),
    ]
    off = tip[1] - target[1][..., None, :]
    return xp.stack([off[..., 0], off[..., 1], off[..., 2], *turn], -1)


def fk(xp: Any, constant: Callable[[Any], Any], geometry: WrittenChain, q: Any, values: Any) -> tuple[Any, Any]:
    """Rotations (..., 3, 3) and positions (..., 3) of the tip at joint vectors (..., n), by numbers (p,) of a URDF.

    Args:
        xp: the library.
        constant: makes one of its arrays of numbers.
        geometry: the chain.
        q: joint vectors.
        values: the numbers.
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
                turn = turn @ along + c * (turn @ (eye - along)) - s * (turn @ (cross @ axis))
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


def step(
    xp: Any,
    constant: Callable[[Any], Any],
    still: Callable[[Any], Any],
    function: Differentiable,
    answers: Answers,
    T: Any,
    numbers: Any,
    values: Any,
) -> Any:
    """Joint vectors (..., B, n) after two steps of Newton's method from answers, whose inverses it takes.

    The steps change nothing, and carry the derivatives by T, numbers and values, exact up to the second order.

    Args:
        xp: the library.
        constant: makes one of its arrays of numbers.
        still: makes of an array one without derivatives.
        function: the arm.
        answers: its answers, as arrays of the library, without derivatives.
        T: (..., 4, 4) poses.
        numbers: (p,) of the URDF.
        values: (..., k) of the redundancy parameters.
    """
    target = R, p = T[..., :3, :3], T[..., :3, 3]
    if function.free_axis is not None:
        line = np.array(function.free_axis.direction), np.array(function.free_axis.at)
        fixed, cosine, sine = (constant(part) for part in turning(*line))
        v = values[..., 0, None, None]
        turn = fixed + xp.cos(v) * cosine + xp.sin(v) * sine
        target = R @ turn[..., :3], (R @ turn[..., 3:])[..., 0] + p
    own = values[..., values.shape[-1] - len(function.held) :]
    q = answers.q
    for _ in range(2):
        parts = [residual(xp, fk(xp, constant, function.geometry, q, numbers), target)]
        if function.held:
            moved = xp.stack([q[..., k] - answers.q[..., k] for k in function.held], -1)
            parts.append(moved - (own - still(own))[..., None, :])
        off = xp.concatenate([xp.broadcast_to(each, (*q.shape[:-1], each.shape[-1])) for each in parts], -1)
        q = q - (answers.inverse @ off[..., None])[..., 0]
    return q
