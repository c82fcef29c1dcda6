"""Denavit-Hartenberg frames of a chain of lines, in Craig's order."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from urdf_ik.kinematics.structure import closest_points, cross
from urdf_ik.typing import Array


@dataclass(frozen=True)
class DHFrames:
    """T(q) = base Rz(t1) Tx(a1) Rx(alpha1) Tz(d2) Rz(t2) ... Rz(tn) tool, with t = q + offset.

    Attributes:
        base: (4, 4) frame 1 at t1 = 0, in the base link.
        alpha: (n - 1,) rad, from axis i to axis i + 1 about x_i.
        a: (n - 1,) m, along x_i.
        d: (n - 1,) m, of joints 2 to n, along their axes.
        offset: (n,) rad.
        tool: (4, 4) tip in frame n.
    """

    base: Array
    alpha: Array
    a: Array
    d: Array
    offset: Array
    tool: Array

    def steps(self) -> list[Array]:
        """The n + 1 constant motions between the joints' turns, from frame 1 to frame n, offsets included."""
        steps = [rotation_z(self.offset[0])]
        for a, alpha, d, offset in zip(self.a, self.alpha, self.d, self.offset[1:], strict=True):
            steps.append(step_x(a, alpha) @ slide_z(d) @ rotation_z(offset))
        return [*steps, np.eye(4)]

    def fk(self, q: Array) -> Array:
        """Pose (..., 4, 4) of the tip for joint vectors (..., n) of revolute joints."""
        steps = self.steps()
        T = np.broadcast_to(self.base @ steps[0], (*q.shape[:-1], 4, 4))
        turn = np.zeros_like(T)
        turn[..., 2, 2] = turn[..., 3, 3] = 1.0
        for i, step in enumerate(steps[1:]):
            c, s = np.cos(q[..., i]), np.sin(q[..., i])
            turn[..., 0, 0], turn[..., 0, 1], turn[..., 1, 0], turn[..., 1, 1] = c, -s, s, c
            T = T @ turn @ step
        return T @ self.tool


def rotation_z(angle: float) -> Array:
    """(4, 4) rotation about z."""
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, -s, 0, 0], [s, c, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1.0]])


def step_x(a: float, alpha: float) -> Array:
    """(4, 4) translation along x, then rotation about it."""
    c, s = np.cos(alpha), np.sin(alpha)
    return np.array([[1, 0, 0, a], [0, c, -s, 0], [0, s, c, 0], [0, 0, 0, 1.0]])


def slide_z(d: float) -> Array:
    """(4, 4) translation along z."""
    T = np.eye(4)
    T[2, 3] = d
    return T


def denavit_hartenberg(
    directions: Array,
    points: Array,
    home: Array,
    parallel: Sequence[bool],
    meet: Sequence[bool],
    little: float = 0.0,
) -> DHFrames:
    """Frames of axes through ``points`` (n, 3) m along unit ``directions`` (n, 3) at q = 0.

    A prismatic joint's axis has a direction only: the frames lie on the line that its point gives it.

    Args:
        directions: of the axes, in base axes.
        points: one on each axis.
        home: (4, 4) pose of the tip at q = 0.
        parallel: (n - 1,) neighbours that are exactly parallel; their frame has d = 0.
        meet: (n - 1,) neighbours that meet; their frame has a = 0.
        little: m; of neighbours that all but meet, x points as if they met, and ``a`` may be below zero by so much.
            What a calibration adds to an arm then turns no frame round.
    """
    n = len(directions)
    feet, origins, xs = [points[0]], [], []
    a, alpha = np.zeros(n - 1), np.zeros(n - 1)
    for i in range(n - 1):
        u, v = directions[i], directions[i + 1]
        if parallel[i]:
            origin = feet[i] if i else points[0] + (points[1] - points[0]) @ u * u
            gap = points[i + 1] - origin
            gap = gap - (gap @ u) * u
            other = origin + gap
            alpha[i] = 0.0 if u @ v > 0.0 else np.pi
            a[i] = 0.0 if meet[i] else np.linalg.norm(gap)
            x = gap if a[i] > 0.0 else any_normal(u)
        else:
            origin, other = closest_points(points[i], u, points[i + 1], v)
            gap = other - origin
            x = cross(u, v)
            if not meet[i] and gap @ x < -little * np.linalg.norm(x):
                x = -x
            alpha[i] = np.arctan2(cross(u, v) @ x / np.linalg.norm(x), u @ v)
            a[i] = 0.0 if meet[i] else np.copysign(np.linalg.norm(gap), gap @ x)
        origins.append(origin)
        feet.append(other)
        xs.append(x / np.linalg.norm(x))
    origins.append(feet[-1])
    before = xs[-1] if xs else any_normal(directions[-1])
    xs.append(before - (before @ directions[-1]) * directions[-1])
    d = np.array([(origins[i] - feet[i]) @ directions[i] for i in range(1, n)])
    offset = np.zeros(n)
    for i in range(1, n - 1):
        offset[i] = np.arctan2(cross(xs[i - 1], xs[i]) @ directions[i], xs[i - 1] @ xs[i])
    base = frame(directions[0], xs[0], origins[0])
    last = frame(directions[-1], xs[-1], origins[-1])
    return DHFrames(base, alpha, a, d, offset, np.linalg.inv(last) @ home)


def frame(z: Array, x: Array, origin: Array) -> Array:
    """(4, 4) frame at ``origin`` with the given z axis, and x as near as can be."""
    T = np.eye(4)
    x = x - (x @ z) * z
    x = x / np.linalg.norm(x)
    T[:3, 0], T[:3, 1], T[:3, 2], T[:3, 3] = x, cross(z, x), z, origin
    return T


def any_normal(u: Array) -> Array:
    """A unit vector across ``u``."""
    return cross(u, np.eye(3)[np.argmin(np.abs(u))])
