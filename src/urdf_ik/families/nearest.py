"""Why an arm with few joints does not reach a target: how far the nearest pose that a search finds is off."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from urdf_ik._kernels import few_joints as kernels
from urdf_ik._kernels.refine import damped_step

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from urdf_ik.chain import Chain

    Array = NDArray[np.float64]

_STARTS, _ROUNDS = 32, 40
_AXES = "xyz"
# Below this [rad, share of size] a part of an error is not worth a word beside a greater one.
_SILENT = 1e-6


def off_by(chain: Chain, arm: Array, rotation: Array, point: Array) -> str:
    """What is off, and by how much, at the pose nearest to the target that a search finds.

    Args:
        chain: the arm.
        arm: its numbers, whose kind says what is asked for.
        rotation: (3, 3) of the target in the base.
        point: (3,) m of the target in the base.
    """
    far = float(np.linalg.norm(point - chain.points[0]))
    if far > chain.size and not chain.prismatic.any():
        return f"the tip is {far:.6g} m from axis 1, and all links together measure {chain.size:.6g} m"
    target = np.eye(4)
    target[:3, :3], target[:3, 3] = rotation, point
    e = _least(chain, arm, target)
    worst = np.abs(e).max()
    parts = [
        f"{abs(part[k]) * unit:.3g} {name} the base's {_AXES[k]}"
        for part, unit, name in ((e[:3], chain.size, "m along"), (e[3:], 1.0, "rad about"))
        if abs(part[k := int(np.argmax(np.abs(part)))]) > min(_SILENT, 0.5 * worst)
    ]
    joints = f"{chain.n} joint{'s' if chain.n > 1 else ''}"
    return f"{joints} cannot bring the tip there: the nearest that was found is off by {' and '.join(parts)}"


def _least(chain: Chain, arm: Array, target: Array) -> Array:
    """The error (6,) of least squares, lengths as shares of the size, that is smallest of those from many starts."""
    rng = np.random.default_rng(0)
    n = chain.n
    e, step, T, J = np.empty(6), np.empty(n), np.empty((4, 4)), np.empty((6, n))
    axes, points = np.empty((n, 3)), np.empty((n, 3))
    best, least = np.zeros(6), np.inf
    for _ in range(_STARTS):
        q = rng.uniform(-np.pi, np.pi, n)
        q = np.where(chain.prismatic, q * chain.size / np.pi, q)
        for _ in range(_ROUNDS):
            kernels.place_few(arm, q, T, axes, points)
            kernels.task_error(arm, target, T, e)
            kernels.task_jacobian(arm, axes, points, T, J)
            # The skew part of a rotation falls again beyond a quarter turn: its angle leads on.
            if arm[kernels.KIND] == kernels.POSE:
                sine = float(np.linalg.norm(e[3:]))
                cosine = 0.5 * (np.trace(target[:3, :3] @ T[:3, :3].T) - 1.0)
                e[3:] *= np.arctan2(sine, cosine) / max(sine, 1e-12)
            if e @ e < least:
                least, best = float(e @ e), e.copy()
            damped_step(J, e, 0.03 * min(1.0, float(np.linalg.norm(e))) + 1e-9, step)
            kernels.advance(arm, q, step, min(1.0, 0.5 / (float(np.abs(step).max()) + 1e-12)))
    return best
