"""The Denavit-Hartenberg table of a chain, with base and tool as far as its rows can hold them."""

from __future__ import annotations

from typing import Any

import numpy as np

from urdf_ik.errors import UrdfError
from urdf_ik.kinematics.chain import Chain
from urdf_ik.kinematics.dh.frames import DHFrames, denavit_hartenberg, rotation_z, slide_z, step_x
from urdf_ik.kinematics.structure import closest_points
from urdf_ik.support import inputs
from urdf_ik.support.angles import wrapped
from urdf_ik.typing import Array

# Shares of the arm's size, or rad: what rounding leaves of zero in one number, and in a product of four matrices.
_ROUNDING, _ROUNDING_OF_STEP = 2e-15, 1e-14


MOST_SNAP = 0.5
"""Greatest ``snap`` [rad, share of the arm's size]: axes farther apart are neither parallel nor meet."""


def _as_written(snap: float | None) -> tuple[float, float]:
    """Angle [rad] and distance [share of size] below which axes are parallel or meet.

    Feet of a common normal lie 1 / angle away, where rounding weighs 1e-16 / angle: below the root of that, taking
    the axes for parallel costs less.
    """
    return (np.sqrt(np.finfo(np.float64).eps), _ROUNDING_OF_STEP) if snap is None else (snap, snap)


def frames_of(chain: Chain, snap: float | None) -> DHFrames:
    """Craig's frames on the axes of the chain."""
    snap = None if snap is None else inputs.number(snap, "snap", UrdfError, low=0.0, high=MOST_SNAP)
    near_angle, near_distance = _as_written(snap)
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
