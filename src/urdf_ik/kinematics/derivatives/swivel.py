"""Derivatives of the swivel angle of an S-R-S arm: by the joints, of second order too, and by its URDF's numbers."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from urdf_ik.kinematics.chain import Chain
from urdf_ik.kinematics.derivatives.written import written
from urdf_ik.kinematics.velocity import curvature
from urdf_ik.typing import Array

SHOULDER, ELBOW, WRIST = slice(0, 3), 3, slice(4, 7)
_STEP = 1e-30  # of a complex step, whose error is its square


class Points(NamedTuple):
    """What a swivel angle is measured from.

    Attributes:
        wrist: (3,) m in the tip, where axes 5, 6 and 7 meet.
        shoulder: (3,) m in the base, where axes 1, 2 and 3 meet.
        up: (3,) direction of axis 1 in the base.
    """

    wrist: Array
    shoulder: Array
    up: Array


class Seen(NamedTuple):
    """The vectors that a swivel angle is a function of, or their rates.

    Attributes:
        line: (..., 3) m from shoulder to wrist.
        axis: (..., 3) direction of axis 4.
        up: (..., 3) direction of axis 1.
    """

    line: Any
    axis: Any
    up: Any


def rate(at: Seen, by: Seen) -> Any:
    """The rate of the swivel angle (...) when its vectors have rates; of complex numbers too.

    It is the angle about the line, from the normal of the plane of line and axis 1 to axis 4; see swivel.hpp.
    """
    length = np.sqrt((at.line * at.line).sum(-1))[..., None]
    w = at.line / length
    w_rate = (by.line - w * (w * by.line).sum(-1)[..., None]) / length
    normal = np.cross(at.up, w)
    normal_rate = np.cross(by.up, w) + np.cross(at.up, w_rate)
    across = np.cross(w, normal)
    across_rate = np.cross(w_rate, normal) + np.cross(w, normal_rate)
    c, s = (at.axis * normal).sum(-1), (at.axis * across).sum(-1)
    c_rate = (by.axis * normal + at.axis * normal_rate).sum(-1)
    s_rate = (by.axis * across + at.axis * across_rate).sum(-1)
    return (c * s_rate - s * c_rate) / (c * c + s * s)


def slopes(chain: Chain, points: Points, q: Array) -> Array:
    """The derivatives (..., 7) of the swivel angle by the joints (..., 7)."""
    T, J = chain.fk(q), chain.jacobian(q)
    arm = (T[..., :3, :3] @ points.wrist[:, None])[..., 0]
    z = np.swapaxes(J[..., 3:, :], -1, -2)
    axis = z[..., ELBOW, :]
    lines = np.swapaxes(J[..., :3, :], -1, -2) + np.cross(z, arm[..., None, :])
    # Axis 4 is turned by the joints before it.
    axes = np.where(np.arange(chain.n)[:, None] < ELBOW, np.cross(z, axis[..., None, :]), 0.0)
    at = Seen((T[..., :3, 3] + arm - points.shoulder)[..., None, :], axis[..., None, :], points.up)
    return np.asarray(rate(at, Seen(lines, axes, np.zeros(3))))


def second_rate(chain: Chain, points: Points, q: Array, along: Array, moving: Array) -> Array:
    """The rate of the swivel angle's rate along joint velocities, when the joints move with others.

    Args:
        chain: the arm of seven joints.
        points: what the angle is measured from.
        q: (..., 7) rad, finite.
        along: (..., 7) rad/s.
        moving: (..., 7) rad/s.

    Returns:
        (...) rad/s^2, symmetric in the two velocities.
    """
    T, J, bent = chain.fk(q), chain.jacobian(q), curvature(chain, q, along, moving)
    arm = (T[..., :3, :3] @ points.wrist[:, None])[..., 0]
    z = J[..., 3:, :]
    twists = [(J @ each[..., None])[..., 0] for each in (along, moving)]
    lines = [each[..., :3] + np.cross(each[..., 3:], arm) for each in twists]
    bent_line = (
        bent[..., :3] + np.cross(bent[..., 3:], arm) + np.cross(twists[0][..., 3:], np.cross(twists[1][..., 3:], arm))
    )
    turns = [(z[..., :ELBOW] @ each[..., :ELBOW, None])[..., 0] for each in (along, moving)]
    axis, still = z[..., ELBOW], np.zeros((*q.shape[:-1], 3))
    axes = [np.cross(each, axis) for each in turns]
    passed = np.cumsum(z[..., :ELBOW] * moving[..., None, :ELBOW], axis=-1) - z[..., :ELBOW] * moving[..., None, :ELBOW]
    bent_turn = np.cross(passed, z[..., :ELBOW] * along[..., None, :ELBOW], axis=-2).sum(axis=-1)
    bent_axis = np.cross(bent_turn, axis) + np.cross(turns[0], axes[1])
    at = Seen(T[..., :3, 3] + arm - points.shoulder, axis, np.broadcast_to(points.up, still.shape))
    moved = Seen(at.line + 1j * _STEP * lines[1], at.axis + 1j * _STEP * axes[1], at.up)
    by = Seen(lines[0] + 1j * _STEP * bent_line, axes[0] + 1j * _STEP * bent_axis, still)
    return np.asarray(rate(moved, by).imag / _STEP)


def rates_by_geometry(chain: Chain, points: Points, q: Array, parameters: Sequence[Any] | None = None) -> Array:
    """Rates (..., k) of the swivel angle by numbers of the URDF, the joints held still.

    Shoulder and wrist are the points with the least squared distances from their three axes where all joints are zero,
    as the solver takes them: they follow every change of the numbers, also one after which the axes meet no more.
    """
    geometry, zero = written(chain), np.zeros(chain.n)
    T0, twists0 = chain.fk(zero), geometry.twists(zero, parameters=parameters)
    shoulder_rate = _meeting_rates(*(geometry.axis(k, zero, parameters) for k in range(chain.n)[SHOULDER]))
    wrist_rate = _meeting_rates(*(geometry.axis(k, zero, parameters) for k in range(chain.n)[WRIST]))
    up_rate = geometry.axis(0, zero, parameters)[2][3:]
    arm0 = (T0[:3, :3] @ points.wrist)[:, None]
    own = wrist_rate - twists0[:3] - np.cross(twists0[3:], arm0, axis=0)  # of the wrist against the tip, in the base

    T, twists = chain.fk(q), geometry.twists(q, parameters=parameters)
    R = T[..., :3, :3]
    arm = R @ points.wrist[:, None]
    _, axis, axis_rates = geometry.axis(ELBOW, q, parameters)
    line_rates = (
        twists[..., :3, :] + np.cross(twists[..., 3:, :], arm, axis=-2) + R @ (T0[:3, :3].T @ own) - shoulder_rate
    )
    line = T[..., :3, 3] + arm[..., 0] - points.shoulder
    at = Seen(line[..., None, :], axis[..., None, :], points.up)
    by = Seen(*(np.swapaxes(each, -1, -2) for each in (line_rates, axis_rates[..., 3:, :], up_rate)))
    return np.asarray(rate(at, by))


def _meeting_rates(*axes: tuple[Array, Array, Array]) -> Array:
    """Rates (3, k) of the point with the least sum of squared distances from lines.

    The point x solves sum P (x - p) = 0 with P = 1 - h h^T; its rate follows from that equation's.
    """
    points, directions = (np.array([each[k] for each in axes]) for k in (0, 1))
    across = np.eye(3) - directions[:, :, None] * directions[:, None, :]
    total = across.sum(axis=0)
    off = np.linalg.solve(total, np.einsum("aij,aj->i", across, points - points[0])) - (points - points[0])
    right = np.zeros_like(axes[0][2][:3])
    for (_, h, rates), P, x in zip(axes, across, off, strict=True):
        turned = rates[3:]
        right += P @ rates[:3] + np.outer(h, x @ turned) + (h @ x) * turned
    return np.asarray(np.linalg.solve(total, right))
