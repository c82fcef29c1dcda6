"""Steps of Newton's method in torch's and jax's own functions: they carry derivatives through answers of ``ik``."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from urdf_ik.interop.autograd.kinematics import fk, residual, swivel, swivel_points
from urdf_ik.interop.autograd.solving import Answers, Differentiable
from urdf_ik.kinematics.chain.free_axis import turning
from urdf_ik.kinematics.derivatives.swivel import ELBOW


class Given(NamedTuple):
    """What the answers depend on.

    Attributes:
        T: (..., 4, 4) poses.
        numbers: (p,) of the URDF.
        values: (..., k) of the redundancy parameters.
        still: makes of an array one without derivatives.

    Example:
        >>> Given(T=np.eye(4), numbers=np.zeros(26), values=np.zeros(0), still=np.copy).values.shape
        (0,)
    """

    T: Any
    numbers: Any
    values: Any
    still: Callable[[Any], Any]


def step(xp: Any, constant: Callable[[Any], Any], of: Differentiable, at: Answers, given: Given) -> Any:
    """Joint vectors (..., B, n) after two steps of Newton's method from answers, whose inverses it takes.

    The steps change nothing, and carry the derivatives by what is given, exact up to the second order.

    Args:
        xp: the library.
        constant: makes one of its arrays of numbers.
        of: the arm.
        at: the answers, as arrays of the library, without derivatives.
        given: what the derivatives are by.

    Example:
        >>> import urdf_ik
        >>> arm = urdf_ik.load("zyyzyz_6r")
        >>> function, T = Differentiable(arm, "raise"), arm.fk([0.3, -0.5, 0.8, 0.4, 0.7, -0.2])
        >>> at, given = function.answers(T), Given(T, function.geometry.values, np.zeros(0), np.copy)
        >>> bool(abs(step(np, np.asarray, function, at, given) - arm.ik(T).q).max() < 1e-12)
        True
    """
    target = T, p = given.T[..., :3, :3], given.T[..., :3, 3]
    if of.free_axis is not None:
        line = np.array(of.free_axis.direction), np.array(of.free_axis.at)
        fixed, cosine, sine = (constant(part) for part in turning(*line))
        v = given.values[..., 0, None, None]
        turn = fixed + xp.cos(v) * cosine + xp.sin(v) * sine
        target = T @ turn[..., :3], (T @ turn[..., 3:])[..., 0] + p
    own = given.values[..., given.values.shape[-1] - of.rows :]
    q, lines = at.q, (ELBOW,) if of.swivelling else ()
    if of.swivelling:
        points = swivel_points(xp, constant, of.geometry, given.numbers)
        start = [
            given.still(each) for each in swivel(xp, points, *fk(xp, constant, of.geometry, q, given.numbers, lines))
        ]
    for _ in range(2):
        tip = fk(xp, constant, of.geometry, q, given.numbers, lines)
        parts = [residual(xp, tip, target)]
        if of.held:
            moved = xp.stack([q[..., k] - at.q[..., k] for k in of.held], -1)
            parts.append(moved - (own - given.still(own))[..., None, :])
        elif of.swivelling:
            (c, s), (c_start, s_start) = swivel(xp, points, *tip), start
            change = (own - given.still(own))[..., 0, None]
            parts.append((s * c_start - c * s_start - change)[..., None])
        off = xp.concatenate([xp.broadcast_to(each, (*q.shape[:-1], each.shape[-1])) for each in parts], -1)
        q = q - (at.inverse @ off[..., None])[..., 0]
    return q
