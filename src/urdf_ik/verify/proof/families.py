"""Ideal arms whose number of solutions a theorem gives, and the arms as written beside them.

Where three consecutive axes meet in a point or are parallel, six turning joints have at most eight isolated complex
solutions (D. L. Pieper, "The kinematics of manipulators under computer control", 1968; C. Mavroidis and B. Roth,
J. Mech. Des. 116, 1994). An arm as written misses this by rounding, or by the decimals of its file. Its real joint
vectors q in the pose G solve the ideal arm at the target ``e1' ... e6'(q)``, which differs from G = ``e1 ... e6(q)`` by
a known amount. So where all eight roots of the ideal arm are enclosed for every target so close to G, the real
solutions of the arm as written lie in these eight boxes.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from flint import acb, acb_mat, arb

from urdf_ik.verify.proof.loop import ORDER, Loop, twist

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from urdf_ik.verify.proof.loop import Axes

    Complex = NDArray[np.complex128]

EIGHT = 8
_NEAR = 0.05  # a structure further off than this share of the arm, or this many rad, is not tried


def ideal(loop: Loop) -> Loop | None:
    """The loop of the nearest arm with three axes that meet or are parallel, for every target that is needed; or None.

    Args:
        loop: the arm as written at a pose.

    Returns:
        The loop of the ideal arm. Its ``G`` is a ball that holds the ideal arm's target for every real solution of the
        arm as written.
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
    return Loop(axes, target)


def roots(loop: Loop, starts: Complex, number: int, rng: np.random.Generator, rounds: int = 40) -> Complex:
    """Distinct approximate complex roots, ``number`` of them if so many are found.

    Newton's method in doubles from the starts and their conjugates, then from random complex vectors.

    Args:
        loop: the loop equations.
        starts: (k, 6) known joint vectors [rad].
        number: how many roots there are.
        rng: source of the random starts.
        rounds: how often 256 random starts are tried.
    """
    twists = np.array([[[complex(t[i, k]) for k in range(4)] for i in range(4)] for t in loop.twists])
    G = np.array([[complex(acb(loop.G[i, k].real.mid(), loop.G[i, k].imag.mid())) for k in range(4)] for i in range(4)])
    found: list[Complex] = []
    for turn in range(rounds + 1):
        q = starts.astype(complex) if turn == 0 else rng.uniform(-np.pi, np.pi, (256, 6)) + 1j * rng.normal(0, 1.5, (256, 6))
        for root in _newton(twists, G, q):
            for each in (root, root.conj()):
                if all(_apart(each, other) > 1e-7 for other in found):
                    found.append(each)
        if len(found) >= number:
            break
    return np.array(found).reshape(-1, 6)


def _newton(twists: Complex, G: Complex, q: Complex) -> Complex:
    """The ends (m, 6) of Newton's method that are roots, and not half a turn off."""
    for _ in range(40):
        X, J = _swept(twists, G, q)
        move = np.linalg.solve(J + 1e-14 * np.eye(6), _six(X)[..., None])[..., 0]
        most = np.abs(move).max(1, keepdims=True)
        move = np.where(np.isfinite(most), move * np.minimum(1.0, 0.5 / np.maximum(most, 1e-300)), 0.0)
        q = q - move
        q = np.where(np.abs(q.imag).max(1, keepdims=True) < 20.0, q, 0.1 * q)
    X, _ = _swept(twists, G, q)
    size = np.exp(np.abs(q.imag).sum(1))
    good = (np.abs(_six(X)).max(1) < 1e-13 * size) & (np.abs(np.trace(X[:, :3, :3], axis1=1, axis2=2) - 3) < 1)
    out: Complex = q[good]
    return out


def _swept(twists: Complex, G: Complex, q: Complex) -> tuple[Complex, Complex]:
    X = np.broadcast_to(np.eye(4, dtype=complex), (len(q), 4, 4))
    moved = []
    for place, j in enumerate(ORDER):
        if place == 3:
            X = X @ G
        K = twists[place]
        a = -q[:, j, None, None]
        moved.append(-X @ K @ _inverse(X))
        X = X @ (np.eye(4) + np.sin(a) * K + (1 - np.cos(a)) * (K @ K))
    J = np.empty((len(q), 6, 6), complex)
    for place, j in enumerate(ORDER):
        J[:, :, j] = _six(moved[place] @ X)
    return X, J


def _inverse(X: Complex) -> Complex:
    out = np.zeros_like(X)
    R = np.swapaxes(X[:, :3, :3], 1, 2)
    out[:, :3, :3], out[:, :3, 3:], out[:, 3, 3] = R, -R @ X[:, :3, 3:], 1
    return out


def _six(A: Complex) -> Complex:
    skew = np.stack([A[:, 2, 1] - A[:, 1, 2], A[:, 0, 2] - A[:, 2, 0], A[:, 1, 0] - A[:, 0, 1]], 1) / 2
    return np.concatenate([A[:, :3, 3], skew], 1)


def _apart(a: Complex, b: Complex) -> float:
    d = a - b
    return float(np.abs((d.real + np.pi) % (2 * np.pi) - np.pi + 1j * d.imag).max())


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
        sine = sum(((a - b * cosine.mid()) ** 2 for a, b in zip(axis, middle, strict=True)), arb(0))
        if not (sine < _NEAR**2 and abs(cosine) > 0.5):
            return None
        out[k] = (middle if cosine > 0 else [-x for x in middle], at)
    return tuple(out)


def _difference(written: Axes, changed: Axes) -> tuple[arb, arb]:
    """Bounds on the entries of ``e1' ... e6' - e1 ... e6`` over all real joint vectors: rotation, translation.

    ``R' - R = sin(q) (S' - S) + (1 - cos q) (S'^2 - S^2)`` of each joint, and ``t' - t = (R - R') p' + (1 - R) (p' - p)``,
    where the last is at most twice the distance of p' from the axis. A rotation keeps lengths, so the differences of the
    rotations add up, and each moves what stands behind it by at most its length.
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
