"""Ideal arms whose number of solutions a theorem gives, and the arms as written beside them.

Where three consecutive axes meet in a point or are parallel, six turning joints have at most eight isolated complex
solutions (D. L. Pieper, "The kinematics of manipulators under computer control", 1968; C. Mavroidis and B. Roth,
J. Mech. Des. 116, 1994). An arm as written misses this by rounding, or by the decimals of its file. Its real joint
vectors q in the pose G solve the ideal arm at the target ``e1' ... e6'(q)``, which differs from G = ``e1 ... e6(q)`` by
a known amount. So where all eight roots of the ideal arm are enclosed for every target so close to G, the real
solutions of the arm as written lie in these eight boxes.
"""

import numpy as np
from flint import acb, acb_mat, arb

from urdf_ik.verify.proof.loop import Axes, Loop, twist

EIGHT = 8
_NEAR = 0.05  # a structure further off than this share of the arm, or this many rad, is not tried


def ideal(loop: Loop) -> tuple[Loop, float] | None:
    """The loop of the nearest arm with three axes that meet or are parallel, for every target that is needed; or None.

    Args:
        loop: the arm as written at a pose.

    Returns:
        The loop of the ideal arm, and how far its targets reach. Its ``G`` is a ball that holds the ideal arm's target
        for every real solution of the arm as written.
    """
    written = loop.axes
    choices = []
    for first in range(4):
        for straighten in (_meeting, _parallel):
            axes = straighten(written, first)
            if axes is not None:
                turn, move = _difference(written, axes)
                choices.append((float(turn + move), axes, turn, move))
    if not choices:
        return None
    _, axes, turn, move = min(choices, key=lambda choice: choice[0])
    side = [acb(arb(0, turn))] * 3 + [acb(arb(0, move))]
    target = acb_mat([[loop.G[i, k] + (side[k] if i < 3 else 0) for k in range(4)] for i in range(4)])
    return Loop(axes, target), float(turn + move)


def _meeting(axes: Axes, first: int) -> Axes | None:
    """The axes with three consecutive ones moved through one point, that nearest to them."""
    h = np.array([[float(x) for x in axes[first + k][0]] for k in range(3)])
    p = np.array([[float(x) for x in axes[first + k][1]] for k in range(3)])
    across = np.eye(3) - h[:, :, None] * h[:, None, :]
    M = across.sum(0)
    if np.linalg.cond(M) > 1e6:
        return None
    point = np.linalg.solve(M, np.einsum("kij,kj->i", across, p))
    if np.linalg.norm(np.einsum("kij,kj->ki", across, point - p), axis=1).max() > _NEAR:
        return None
    common = [arb(float(x)) for x in point]
    return tuple((axis, common if first <= k < first + 3 else at) for k, (axis, at) in enumerate(axes))


def _parallel(axes: Axes, first: int) -> Axes | None:
    """The axes with three consecutive ones turned into the direction of the middle one, about their points."""
    middle = axes[first + 1][0]
    out = list(axes)
    for k in (first, first + 2):
        axis, at = axes[k]
        cosine = sum((a * b for a, b in zip(axis, middle, strict=True)), arb(0))
        across = [a - b * cosine.mid() for a, b in zip(axis, middle, strict=True)]
        sine = sum((x * x for x in across), arb(0))  # x ** 2 has no value where a ball holds zero
        if not (sine < _NEAR**2 and abs(cosine) > 0.5):
            return None
        out[k] = (middle if cosine > 0 else [-x for x in middle], at)
    return tuple(out)


def _difference(written: Axes, changed: Axes) -> tuple[arb, arb]:
    """Bounds on the entries of ``e1' ... e6' - e1 ... e6`` over all real joint vectors: rotation, translation.

    ``R' - R = sin(q) (S' - S) + (1 - cos q) (S'^2 - S^2)`` of each joint, and
    ``t' - t = (R - R') p' + (1 - R) (p' - p)``, where the last is at most twice the distance of p' from the axis. A
    rotation keeps lengths, so the differences of the rotations add up, and each moves what stands behind it by at most
    its length.
    """
    turn, move, behind = arb(0), arb(0), arb(0)
    for (h, p), (g, r) in reversed(list(zip(written, changed, strict=True))):
        S, Z = twist(h, [arb(0)] * 3), twist(g, [arb(0)] * 3)
        rotated = (_frobenius(Z - S) + 2 * _frobenius(Z * Z - S * S)).upper()
        d = [a - b for a, b in zip(r, p, strict=True)]
        shift = _length([h[1] * d[2] - h[2] * d[1], h[2] * d[0] - h[0] * d[2], h[0] * d[1] - h[1] * d[0]])
        turn += rotated
        move += rotated * (_length(r) + behind) + 2 * shift
        behind += 2 * _length(p).max(_length(r))
    return turn.upper(), move.upper()


def _length(v: list[arb]) -> arb:
    return sum((x.abs_upper() ** 2 for x in v), arb(0)).sqrt().upper()


def _frobenius(M: acb_mat) -> arb:
    return sum((M[i, k].abs_upper() ** 2 for i in range(4) for k in range(4)), arb(0)).sqrt()
