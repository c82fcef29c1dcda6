"""How far an ideal arm's poses can be from those of the arm as written: bounds for all joint vectors."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from urdf_ik.kinematics.chain import Chain
from urdf_ik.kinematics.dh.frames import DHFrames
from urdf_ik.typing import Array

# Rounding of one step's numbers here, about sixteen operations with an error of 2^-53 each.
_ROUNDING = 2e-15


@dataclass(frozen=True, kw_only=True, eq=False)
class Displacement:
    """Bounds on the motion between the tips of two arms at the same joint vector, by the steps that remain.

    An arm is a chain of seven constant steps with a turn between two of them: A0 turn A1 turn ... A6 for the ideal arm,
    B0 ... B6 for the arm as written, whose frames are slid along its axes and turned about them so that they are near
    the ideal ones. Replacing one step after the other by its counterpart turns the tip by the angle t_i between A_i
    and B_i, and shifts it by |a_i - b_i| + t_i times the distance from there to the tip, which is at most the sum of
    the later steps' lengths. The triangle inequality adds these up, whatever the turns are. Entry k is for steps k to
    6: entry 0 for the whole arm, entry k for what joint k moves.

    Attributes:
        turn: (7,) rad, sum of t_i.
        shift: (7,) m, sum of |a_i - b_i| + t_i (|b_i+1| + ... + |b_6|).
        length: (7,) m, sum of |b_i|.
    """

    turn: Array
    shift: Array
    length: Array


def displacement(frames: DHFrames, chain: Chain) -> Displacement:
    """Bounds for an ideal arm's frames and the chain that they replace, of six turning joints."""
    ideal = frames.steps()
    written = [np.vstack([step, [0.0, 0.0, 0.0, 1.0]]) for step in np.array(chain.motion.steps)]
    # Both arms' frames at q = 0, from frame 1's base to the solved point.
    at, other = np.eye(4), np.linalg.inv(frames.base)
    joints = [np.eye(4)]
    for k in range(6):
        at, other = at @ ideal[k], other @ written[k]
        joints.append(_beside(other, at))
    joints.append(other @ written[6] @ np.linalg.inv(frames.tool))
    steps = [np.linalg.inv(a) @ b for a, b in zip(joints, joints[1:], strict=False)]
    apart = [np.linalg.norm(a[:3, :3] - b[:3, :3]) for a, b in zip(ideal, steps, strict=True)]
    turns = 2.0 * np.arcsin(np.minimum(np.array(apart) / np.sqrt(8.0), 1.0)) + _ROUNDING
    lengths = np.array([np.linalg.norm(b[:3, 3]) for b in steps])
    offs = np.array([np.linalg.norm(a[:3, 3] - b[:3, 3]) for a, b in zip(ideal, steps, strict=True)])
    offs += _ROUNDING * (chain.size + np.abs(frames.base[:3, 3]).max())
    left = _sums(lengths)
    return Displacement(turn=_sums(turns), shift=_sums(offs + turns * (left - lengths)), length=left)


def _sums(values: Array) -> Array:
    """Each entry with all that follow it."""
    sums: Array = np.ascontiguousarray(np.cumsum(values[::-1])[::-1])
    return sums


def _beside(frame: Array, ideal: Array) -> Array:
    """A joint's frame, slid along its z axis and turned about it so that it is nearest to the ideal frame."""
    near, z = frame.copy(), frame[:3, 2]
    near[:3, 3] += (ideal[:3, 3] - frame[:3, 3]) @ z * z
    x = ideal[:3, 0] - (ideal[:3, 0] @ z) * z
    near[:3, 0] = x / np.linalg.norm(x)
    near[:3, 1] = np.cross(z, near[:3, 0])
    return near
