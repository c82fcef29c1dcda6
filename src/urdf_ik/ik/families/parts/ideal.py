"""The names of the branches that most six-joint families share, and the signs of their roots."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from urdf_ik.ik.families.parts.written import Ends, Written
from urdf_ik.kinematics.chain import Chain
from urdf_ik.kinematics.dh.frames import DHFrames, denavit_hartenberg
from urdf_ik.kinematics.structure import Structure
from urdf_ik.support.tolerances import DEFAULT
from urdf_ik.typing import Array

# The eight branches of shoulder, elbow and wrist: the signs of their roots (3, 8), and their names in the same order.
SIGNS = np.array(list(itertools.product((1.0, -1.0), repeat=3))).T.copy()
NAMES = tuple(
    f"shoulder {front}, elbow {up}, wrist {flip}"
    for front in ("front", "back")
    for up in ("up", "down")
    for flip in ("noflip", "flip")
)


# Rounding of one step's numbers here, about sixteen operations with an error of 2^-53 each.
_STEP_ROUNDING = 2e-15


@dataclass(frozen=True, kw_only=True, eq=False)
class _Displacement:
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


def displacement(frames: DHFrames, chain: Chain) -> _Displacement:
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
    turns = 2.0 * np.arcsin(np.minimum(np.array(apart) / np.sqrt(8.0), 1.0)) + _STEP_ROUNDING
    lengths = np.array([np.linalg.norm(b[:3, 3]) for b in steps])
    offs = np.array([np.linalg.norm(a[:3, 3] - b[:3, 3]) for a, b in zip(ideal, steps, strict=True)])
    offs += _STEP_ROUNDING * (chain.size + np.abs(frames.base[:3, 3]).max())
    left = _sums(lengths)
    return _Displacement(turn=_sums(turns), shift=_sums(offs + turns * (left - lengths)), length=left)


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


LITTLE = 3e-3
"""Share of the arm's size: a distance up to here may be what a calibration has added, and names no branch."""

# Below this a cosine or sine of a twist is rounding of zero: eight units in the last place of 1.
_ROUNDING = 2e-15


@dataclass(frozen=True, kw_only=True, eq=False)
class IdealFrames(Ends):
    """The nearest arm that has its family's structure exactly, by Craig's Denavit-Hartenberg parameters.

    T = base Rz(t1) Tx(a1) Rx(alpha1) Tz(d2) Rz(t2) ... Rz(t6) tool, with t = q + offset.

    Attributes:
        cos_alpha: (5,) of the twists.
        sin_alpha: (5,) of the twists.
        a: (5,) m, lengths of the links.
        d: (4,) m, offsets along axes 2 to 5.
        offset: (6,) rad, added to the joint values.
        steps: (7, 3, 4) the motions between the frames with every t at zero, base and tool included [m].
        size: m, the length that tolerances are shares of.
        clamp: how far below zero a margin may fall before its branch is given up.
        imperfection: how far its poses are from those of the arm as written [rad, share of size]; 0: exact.
        signs: (3, 8) of the roots of shoulder, elbow and wrist, by branch.
        displacement: bounds on the motion between its tip and that of the arm as written.
    """

    cos_alpha: Array
    sin_alpha: Array
    a: Array
    d: Array
    offset: Array
    steps: Array
    size: float
    clamp: float
    imperfection: float
    signs: Array
    displacement: _Displacement


@dataclass(frozen=True, kw_only=True, eq=False)
class ClosedFormArm:
    """An arm of six turning joints for the closed form of its family.

    Attributes:
        variant: which of the family's solvers it is for; each family says which there are.
        ideal: the nearest arm with the family's structure.
        written: the arm as its URDF has it.
    """

    variant: str
    ideal: IdealFrames
    written: Written


def ideal_frames(
    chain: Chain,
    directions: Array,
    points: Array,
    parallel: Sequence[bool],
    meet: Sequence[bool],
) -> tuple[DHFrames, float]:
    """DH frames of the ideal arm, and how far its poses are from those of the arm as written."""
    # Measured from the first axis: how far from its base the arm is mounted has no part in its structure.
    mount = chain.P[0]
    local = replace(chain, P=np.vstack([np.zeros(3), chain.P[1:]]))
    home = np.eye(4)
    home[:3, :3], home[:3, 3] = local.R_tip, local.P.sum(axis=0)
    frames = denavit_hartenberg(directions, points - mount, home, parallel, meet, LITTLE * chain.size)
    Q = np.random.default_rng(0).uniform(-np.pi, np.pi, (12, chain.n))
    apart = frames.fk(Q) - local.fk(Q)
    apart[:, :3, 3] /= chain.size
    frames.base[:3, 3] += mount
    return frames, float(np.abs(apart).max())


def ideal_arm(frames: DHFrames, error: float, chain: Chain) -> IdealFrames:
    """The ideal arm for its family's solver.

    Args:
        frames: its DH frames.
        error: how far its poses are from those of the arm as written [rad, share of size].
        chain: the arm as written.
    """
    base, tool = frames.base, frames.tool
    exact = error <= DEFAULT.exact_structure
    return IdealFrames(
        base_rotation=np.ascontiguousarray(base[:3, :3].T),
        base_origin=base[:3, 3].copy(),
        tool_rotation=np.ascontiguousarray(tool[:3, :3].T),
        tool_point=-tool[:3, :3].T @ tool[:3, 3],
        cos_alpha=snapped(np.cos(frames.alpha)),
        sin_alpha=snapped(np.sin(frames.alpha)),
        a=np.array(frames.a, dtype=np.float64),
        d=np.array(frames.d[:4], dtype=np.float64),
        offset=np.array(frames.offset, dtype=np.float64),
        steps=np.ascontiguousarray(np.array(frames.steps())[:, :3]),
        size=chain.size,
        clamp=100.0 * DEFAULT.fold if exact else 100.0 * DEFAULT.fold + 50.0 * error,
        imperfection=0.0 if exact else error,
        signs=SIGNS,
        displacement=displacement(frames, chain),
    )


def snapped(values: Array) -> Array:
    """Values with the rounding of 0 and +-1 taken away."""
    nearest = np.round(values)
    return np.where(np.abs(values - nearest) < _ROUNDING, nearest, values)


def imperfection(structure: Structure, parallel: Sequence[int], meet: Sequence[int]) -> tuple[float, float]:
    """Greatest angle [rad] and distance [m] by which these pairs, named by their first axis, are off."""
    angles = [structure.pairs[i - 1].off_angle for i in parallel]
    distances = [structure.pairs[i - 1].off_distance for i in meet]
    return max(angles, default=0.0), max(distances, default=0.0)


def mean_direction(directions: Array) -> Array:
    """Directions (k, 3) replaced by their common one, each with its own sign."""
    signs = np.where(directions @ directions[0] < 0.0, -1.0, 1.0)
    mean = (signs[:, None] * directions).sum(axis=0)
    common: Array = signs[:, None] * (mean / np.linalg.norm(mean))
    return common


def straightened(structure: Structure, directions: Array) -> tuple[Array, list[bool]]:
    """Directions (n, 3) with neighbours that are parallel, or nearly, made exactly so; and which those are."""
    parallel = [structure.is_parallel(i) for i in range(1, len(directions))]
    straight = directions.copy()
    start = 0
    for end in range(1, len(directions) + 1):
        if end == len(directions) or not parallel[end - 1]:
            straight[start:end] = mean_direction(directions[start:end])
            start = end
    return straight, parallel
