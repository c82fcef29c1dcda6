"""Why an arm with few joints does not reach a target: how far the nearest pose found is off, coordinate by coordinate."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from urdf_ik._kernels import few_joints as kernels

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from urdf_ik.chain import Chain

    Array = NDArray[np.float64]

_STARTS, _ROUNDS = 48, 60
_AXES = "xyz"


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
    parts = [_largest(e[:3] * chain.size, "m", "along")]
    if arm[kernels.KIND] not in (kernels.POSITION, kernels.PLANAR_POSITION):
        parts.append(_largest(e[3:], "rad", "about"))
    words = " and ".join(part for part in parts if part) or "by rounding only"
    joints = f"{chain.n} joint{'s' if chain.n > 1 else ''}"
    return f"{joints} cannot bring the tip there: the nearest that was found is off {words}"


def _largest(e: Array, unit: str, word: str) -> str:
    """The coordinate that is most off."""
    k = int(np.argmax(np.abs(e)))
    return f"{abs(e[k]):.3g} {unit} {word} the base's {_AXES[k]}" if abs(e[k]) > 1e-11 else ""


def _least(chain: Chain, arm: Array, target: Array) -> Array:
    """The error (6,), lengths as shares of the size, that is smallest in its greatest entry."""
    rng = np.random.default_rng(0)
    e, T = np.empty(6), np.empty((4, 4))
    axes, points = np.empty((chain.n, 3)), np.empty((chain.n, 3))
    best, least = np.zeros(6), np.inf
    for _ in range(_STARTS):
        q = rng.uniform(-np.pi, np.pi, chain.n)
        q = np.where(chain.prismatic, q * chain.size / np.pi, q)
        error = kernels.polish(arm, target, q, _ROUNDS)
        if error < least:
            kernels.place_few(arm, q, T, axes, points)
            kernels.task_error(arm, target, T, e)
            least, best = error, e.copy()
    return best
