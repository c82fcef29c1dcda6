"""The numbers that compiled solvers take: the arm as written, the nearest ideal arm, and how far it is off."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from urdf_ik.kinematics.dh.frames import denavit_hartenberg
from urdf_ik.support.tolerances import DEFAULT

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from urdf_ik._core import Solver
    from urdf_ik.kinematics.chain import Chain
    from urdf_ik.kinematics.chain.mimic import CoupledChain
    from urdf_ik.kinematics.dh.frames import DHFrames
    from urdf_ik.kinematics.structure import Structure

    Array = NDArray[np.float64]

LITTLE = 3e-3
"""Share of the arm's size: a distance up to here may be what a calibration has added, and names no branch."""

# Below this a cosine or sine of a twist is rounding of zero: eight units in the last place of 1.
_ROUNDING = 2e-15


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


def written_values(chain: Chain) -> dict[str, Any]:
    """The arm as the URDF has it, as the compiled solvers take it: the steps between frames on the joint axes."""
    return {
        "steps": chain.motion.steps,
        "slides": chain.prismatic.astype(np.float64),
        "size": chain.size,
        "tolerances": DEFAULT.for_solvers(),
    }


def driven_values(chain: CoupledChain, units: Array) -> dict[str, Any]:
    """The arm whose joints drive several axes each, as the compiled solvers take it.

    Args:
        chain: the arm.
        units: (n,) rad or m, what the solver's scaled joints count in.
    """
    written = written_values(chain.axes)
    return {
        **{name: written[name] for name in ("steps", "slides", "tolerances")},
        "size": chain.size,
        "axes": chain.axes.n,
        "gain": np.ascontiguousarray(chain.gain * units),
        "unit": units,
        "period": 2.0 * np.pi * chain.image_turns,
    }


def ideal_values(frames: DHFrames, error: float, signs: Array, size: float) -> dict[str, Any]:
    """The ideal arm, as the compiled solvers of closed forms take it."""
    base, tool = frames.base, frames.tool
    exact = error <= DEFAULT.exact_structure
    return {
        "base_rotation": np.ascontiguousarray(base[:3, :3].T),
        "base_origin": base[:3, 3].copy(),
        "tool_rotation": np.ascontiguousarray(tool[:3, :3].T),
        "tool_point": -tool[:3, :3].T @ tool[:3, 3],
        "cos_alpha": snapped(np.cos(frames.alpha)),
        "sin_alpha": snapped(np.sin(frames.alpha)),
        "a": np.array(frames.a, dtype=np.float64),
        "d": np.array(frames.d[:4], dtype=np.float64),
        "offset": np.array(frames.offset, dtype=np.float64),
        "steps": np.ascontiguousarray(np.array(frames.steps())[:, :3]),
        "size": size,
        "clamp": 100.0 * DEFAULT.fold if exact else 100.0 * DEFAULT.fold + 50.0 * error,
        "imperfection": 0.0 if exact else error,
        "signs": signs,
    }


def seen_in_frame_1(ideal: dict[str, Any], explain: Callable[[Array, Array], str]) -> Callable[[Array], str]:
    """``Plan.explain`` from one that takes the target's rotation (3, 3) and solved point (3,) in the ideal frame 1."""

    def explain_pose(T: Array) -> str:
        R, base = T[:3, :3], ideal["base_rotation"]
        point = base @ (R @ ideal["tool_point"] + T[:3, 3] - ideal["base_origin"])
        return explain(base @ R @ ideal["tool_rotation"], point)

    return explain_pose


def compared(*lengths: float) -> tuple[str, ...]:
    """Lengths in words that are compared with one another: six digits, or as many as tell them apart."""
    different = len(set(lengths))
    texts = (tuple(f"{length:.{digits}g}" for length in lengths) for digits in range(6, 18))
    return next(each for each in texts if len(set(each)) == different)


def distances_of(solver: Solver, rotation: Array, point: Array) -> Array:
    """What a pose, seen from frame 1, asks of the distance of two axes [m]: one for each way that there is."""
    seen = np.eye(4)
    seen[:3, :3], seen[:3, 3] = rotation, point
    distances: Array = np.array(solver.distances(seen))
    finite: Array = distances[np.isfinite(distances)]
    return finite


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
