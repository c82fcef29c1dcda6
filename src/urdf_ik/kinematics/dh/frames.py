"""Denavit-Hartenberg frames of a chain of lines, in Craig's order, and the table of a chain."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from urdf_ik.errors import UrdfError
from urdf_ik.kinematics.chain import Chain
from urdf_ik.kinematics.structure import closest_points, cross
from urdf_ik.support import inputs
from urdf_ik.support.angles import wrapped
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
    """A vector across ``u``, of any length."""
    return cross(u, np.eye(3)[np.argmin(np.abs(u))])


# Shares of the arm's size, or rad: what rounding leaves of zero in one number, and in a product of four matrices.
_ROUNDING, _ROUNDING_OF_STEP = 2e-15, 1e-14


MOST_SNAP = 0.5
"""Greatest ``snap`` [rad, share of the arm's size]: axes farther apart are neither parallel nor meet."""


def frames_of(chain: Chain, snap: float | None) -> DHFrames:
    """Craig's frames on the axes of the chain."""
    near_angle, near_distance = float(np.sqrt(np.finfo(np.float64).eps)), _ROUNDING_OF_STEP
    if snap is not None:
        near_angle = near_distance = inputs.number(snap, "snap", UrdfError, low=0.0, high=MOST_SNAP)
    # Measured from the first axis: how far from its base the arm is mounted has no part in its table.
    mount = chain.P[0]
    points = chain.points - mount
    parallel, meet = [], []
    for u, v, p, r in zip(chain.H[:-1], chain.H[1:], points[:-1], points[1:], strict=True):
        parallel.append(bool(np.linalg.norm(np.cross(u, v)) <= near_angle))
        gap = np.cross(r - p, u) if parallel[-1] else np.subtract(*closest_points(p, u, r, v))
        meet.append(bool(np.linalg.norm(gap) <= near_distance * chain.size))
    home = np.eye(4)
    home[:3, :3], home[:3, 3] = chain.R_tip, chain.P[1:].sum(axis=0)
    frames = denavit_hartenberg(chain.H, points, home, parallel, meet)
    frames.base[:3, 3] += mount
    return frames


def fields_of(frames: DHFrames, chain: Chain, modified: bool) -> dict[str, Any]:
    """The table that says the most by its rows: base and tool absorbed where they fit, angles small, no rounding."""
    n = chain.n
    theta, d = frames.offset.copy(), np.append(0.0, frames.d)
    alpha, a = np.append(frames.alpha, 0.0), np.append(frames.a, 0.0)  # behind joint i; the last: before the tool
    base, tool, first = frames.base, frames.tool, (0.0, 0.0)
    # Standard tables begin, and modified ones end, with a step about z alone.
    step = _as_step(base, chain.size)
    if step is not None and (modified or step[:2] == (0.0, 0.0)):
        first, base = step[:2], np.eye(4)
        theta[0] += step[2]
        d[0] += step[3]
    for i in range(n - 1):
        # x may point either way along its normal, with a and alpha of the other sign; where two axes are one, anywhere.
        if a[i] == 0.0 and alpha[i] in (0.0, np.pi):
            theta[i + 1] += np.cos(alpha[i]) * theta[i]
            theta[i] = 0.0
        elif np.abs(wrapped(theta[i])) > 0.5 * np.pi + 1e-9:
            alpha[i], a[i] = -alpha[i], -a[i]
            theta[i : i + 2] += np.pi, -np.pi
    step = _as_step(np.linalg.inv(tool).astype(np.float64), chain.size)
    if step is not None and (not modified or step[:2] == (0.0, 0.0)):
        alpha[-1], a[-1], tool = -step[0], -step[1], np.eye(4)
        theta[-1] -= step[2]
        d[-1] -= step[3]
    if modified:
        alpha, a = np.append(first[0], alpha[:-1]), np.append(first[1], a[:-1])
    return {
        "alpha": wrapped(_rounded(wrapped(alpha), 1.0)),
        "a": _rounded(a, chain.size),
        "d": _rounded(d, chain.size),
        "theta": wrapped(_rounded(wrapped(theta), 1.0)),
        "base": base,
        "tool": tool,
    }


def _as_step(T: Array, size: float) -> tuple[float, float, float, float] | None:
    """(alpha, a, theta, d) with Rx(alpha) Tx(a) Rz(theta) Tz(d) = T (4, 4); None where T is no such step."""
    R, p = T[:3, :3], T[:3, 3]
    alpha, theta = np.arctan2(-R[1, 2], R[2, 2]), np.arctan2(-R[0, 1], R[0, 0])
    d = (p - [p[0], 0.0, 0.0]) @ R[:, 2]
    alpha, theta = _rounded(np.array([alpha, theta]), 1.0)
    a, d = _rounded(np.array([p[0], d]), size)
    apart = step_x(a, alpha) @ rotation_z(theta) @ slide_z(d) - T
    apart[:3, 3] /= size
    return (float(alpha), float(a), float(theta), float(d)) if np.abs(apart).max() < _ROUNDING_OF_STEP else None


def _rounded(values: Array, scale: float) -> Array:
    """Values with the rounding of zero, of multiples of pi / 12 and of short decimals taken away."""
    values = np.where(np.abs(values) < _ROUNDING * scale, 0.0, values)
    for candidates in (np.round(values * 12.0 / np.pi) * (np.pi / 12.0), np.round(values, 12)):
        values = np.where(np.abs(values - candidates) < _ROUNDING * scale, candidates, values)
    return np.asarray(values + 0.0)
