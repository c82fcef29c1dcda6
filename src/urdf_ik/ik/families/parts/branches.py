"""Names of branches by geometry: where shoulder and elbow are."""

from __future__ import annotations

from typing import Any

import numpy as np

from urdf_ik.ik.families.parts.ideal import LITTLE, NAMES
from urdf_ik.kinematics.chain import Chain
from urdf_ik.typing import Array

_SAMPLES = 8
"""Number of random poses whose solutions show what the signs of the roots mean on an arm."""
_CLEAR = 0.02
"""Share of the arm's size: a wrist that is nearer to the shoulder's axis is neither in front nor behind."""


def geometric(branches: tuple[str, ...], solver: Any, chain: Chain, wrist: tuple[int, int]) -> tuple[str, ...]:
    """The names of an arm's columns, shoulder and elbow by geometry; ``branches`` where a column has no clear side.

    The forward side of link 1 is where the shoulder's offset puts axis 2; without an offset, where the wrist is at
    q = 0; if that is above the shoulder, along the base's x or y. *Front*: the wrist is on that
    side of axis 1. *Up*: the elbow (axis 3) is above the line from the shoulder (axis 2) to the wrist, as long as the
    wrist is on the side of the shoulder that its name says. Above is along axis 1, upwards in the base.

    Args:
        branches: the names by the signs of the roots, the first eight ``NAMES``.
        solver: the compiled solver.
        chain: six turning joints, axes 2 and 3 parallel.
        wrist: the two axes, counted from 0, that meet in the point that joint 1 puts in place: (3, 4), or
            (4, 5) where axis 4 is parallel to axes 2 and 3.
    """
    up = chain.H[0] * (1.0 if chain.H[0][2] > -0.1 else -1.0)
    across = np.cross(chain.H[1], up)
    home = _axes(chain, np.zeros(6))
    sides = (
        (chain.points[1] - chain.points[0]) @ across / chain.size,
        (_meeting(*home, *wrist) - chain.points[0]) @ across / chain.size,
        0.01 * across[0],
        0.01 * across[1],
    )
    side = next((np.sign(side) for side in sides if abs(side) > LITTLE), 1.0)
    T = chain.fk(np.random.default_rng(0).uniform(-np.pi, np.pi, (_SAMPLES, 6)))
    q = np.full((_SAMPLES, len(branches), 6), np.nan)
    solver.solve(T, None, q, np.zeros(q.shape[:2], np.uint8), None, 1)
    H, points = _axes(chain, q[:, :8])
    ahead = side * np.cross(H[..., 1, :], up)
    far = ((_meeting(H, points, *wrist) - points[..., 0, :]) * ahead).sum(-1)
    end = points[..., 3, :] if wrist == (4, 5) else _meeting(H, points, *wrist)
    to_wrist, to_elbow = end - points[..., 1, :], points[..., 2, :] - points[..., 1, :]
    x = (to_wrist * ahead).sum(-1)
    above = x * (x * (to_elbow @ up) - (to_wrist @ up) * (to_elbow * ahead).sum(-1))
    above[~((np.abs(x) > _CLEAR * chain.size) & (x * far > 0.0))] = 0.0
    is_front, is_up = np.nansum(np.sign(far), axis=0) > 0.0, np.nansum(np.sign(above), axis=0) > 0.0
    named = tuple(
        f"shoulder {'front' if front else 'back'}, elbow {'up' if raised else 'down'}, {name.rpartition(', ')[2]}"
        for front, raised, name in zip(is_front, is_up, branches[:8], strict=True)
    )
    return (*named, *branches[8:]) if sorted(named) == sorted(NAMES) else branches


def _axes(chain: Chain, q: Array) -> tuple[Array, Array]:
    """Directions (..., 6, 3) of the axes at joint vectors (..., 6), and their points (..., 6, 3) next to the tip."""
    J = np.moveaxis(chain.jacobian(q), -1, -2)
    H = J[..., 3:]
    return H, chain.fk(q)[..., None, :3, 3] + np.cross(H, J[..., :3])


def _meeting(H: Array, points: Array, i: int, j: int) -> Array:
    """The point (..., 3) of axis i that is nearest to axis j."""
    normal = np.cross(H[..., j, :], np.cross(H[..., i, :], H[..., j, :]))
    along = ((points[..., j, :] - points[..., i, :]) * normal).sum(-1) / (H[..., i, :] * normal).sum(-1)
    return np.asarray(points[..., i, :] + H[..., i, :] * along[..., None])
