"""The loop equations of six turning joints in ball arithmetic: every number is a ball that encloses the true value."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Self

import numpy as np
from flint import acb, acb_mat, arb, ctx
from numpy.typing import NDArray

from urdf_ik.errors import UnsupportedArm
from urdf_ik.kinematics.chain import Chain
from urdf_ik.typing import Array

Axes = tuple[tuple[list[arb], list[arb]], ...]

ORDER = (2, 1, 0, 5, 4, 3)  # in which the joints turn X
PRECISION = 192  # bits; a double root of the pose as rounded splits by about 2^-26, which these separate
_HALF = acb("0.5")


@dataclass(frozen=True)
class Loop:
    """``X(q) = (e1 e2 e3)^-1 G (e4 e5 e6)^-1``, which is the identity where q reaches the pose.

    ``e_k`` turns about the screw axis k at the zero configuration and G is the pose times the inverse of the tip's pose
    at zero. Six equations say so: the position of X, and the vector of the skew part of its rotation. They also hold
    where X is half a turn; the trace of X tells these apart.

    Attributes:
        axes: unit direction and a point of each joint's axis at the zero configuration, joint 1 first.
        G: the 4x4 motion that the joints must make together. Where it is a ball, what is enclosed is enclosed for every
            motion in it.
    """

    axes: Axes
    G: acb_mat

    @cached_property
    def twists(self) -> tuple[acb_mat, ...]:
        """The six 4x4 matrices of the axes' twists, in the order in which X turns."""
        return tuple(twist(*self.axes[j]) for j in ORDER)

    @classmethod
    def of(cls, chain: Chain, T: Array) -> Self:
        """The loop of a chain at a pose, whose rotation is the one nearest to the matrix given.

        Lengths are shares of the sum of the steps between the axes.

        Args:
            chain: six turning joints.
            T: (4, 4) pose of the tip in the base [m].
        """
        if chain.n != 6 or chain.prismatic.any() or chain.followers:
            raise UnsupportedArm("a proof is checked for six turning joints, and this chain has others")
        ctx.prec = PRECISION
        size = arb(float(np.linalg.norm(chain.P[1:6], axis=1).sum()) or 1.0)
        at_zero = [
            [sum((arb(float(step)) for step in chain.P[: k + 1, i]), arb(0)) / size for i in range(3)] for k in range(7)
        ]
        axes = tuple((_unit([arb(float(x)) for x in chain.H[j]]), at_zero[j]) for j in range(6))
        tip = _motion(_rotation(chain.R_tip), at_zero[6])
        goal = _motion(_rotation(T[:3, :3]), [arb(float(x)) / size for x in T[:3, 3]])
        return cls(axes, goal * _inverse(tip))

    @property
    def out_of_reach(self) -> bool:
        """Whether axis 6 would be further from axis 1 than the steps between the axes' points are long together."""
        first, last = self.axes[0][1], self.axes[5][1]
        moved = [sum((self.G[i, k].real * last[k] for k in range(3)), self.G[i, 3].real) - first[i] for i in range(3)]
        steps = [[b - a for a, b in zip(self.axes[k][1], self.axes[k + 1][1], strict=True)] for k in range(5)]
        return bool(_length(moved) > sum((_length(step) for step in steps), arb(0)))

    def values(self, q: Sequence[acb]) -> acb_mat:
        """X at q, six balls."""
        return self._swept(q)[0]

    def jacobian(self, q: Sequence[acb]) -> tuple[acb_mat, acb_mat]:
        """X and the (6, 6) derivatives of the six equations by the joints, joint 1 first."""
        X, moved = self._swept(q)
        columns = {j: residual(moved[i] * X) for i, j in enumerate(ORDER)}
        return X, acb_mat([[columns[j][row] for j in range(6)] for row in range(6)])

    def hessian(self, q: Sequence[acb]) -> list[list[list[acb]]]:
        """The second derivatives, ``[i][j]`` a list of six."""
        X, moved = self._swept(q)
        out: list[list[list[acb]]] = [[[] for _ in range(6)] for _ in range(6)]
        for a in range(6):
            for b in range(a, 6):
                i, j = ORDER[a], ORDER[b]
                out[i][j] = out[j][i] = residual(moved[a] * moved[b] * X)
        return out

    def _swept(self, q: Sequence[acb]) -> tuple[acb_mat, list[acb_mat]]:
        """X, and the twist of each factor carried to the left end: dX/dq = moved X."""
        X, moved = _identity(), []
        for place, (j, generator) in enumerate(zip(ORDER, self.twists, strict=True)):
            if place == 3:
                X = X * self.G
            moved.append(-(X * generator * _inverse(X)))
            X = X * _turn(generator, -q[j])
        return X, moved


def is_identity(X: acb_mat) -> bool | None:
    """Whether X, which holds a root of the equations, is the identity; False: half a turn; None: it may be either."""
    trace = X[0, 0] + X[1, 1] + X[2, 2]  # 3 or -1: the rotation is symmetric, and its own inverse
    if not trace.contains(acb(-1)):
        return True
    return None if trace.contains(acb(3)) else False


def twist(h: list[arb], p: list[arb]) -> acb_mat:
    """The 4x4 matrix of the unit twist about the axis through p along h."""
    v = [p[1] * h[2] - p[2] * h[1], p[2] * h[0] - p[0] * h[2], p[0] * h[1] - p[1] * h[0]]
    rows = [[arb(0), -h[2], h[1], v[0]], [h[2], arb(0), -h[0], v[1]], [-h[1], h[0], arb(0), v[2]]]
    return acb_mat([*([acb(x) for x in row] for row in rows), [0, 0, 0, 0]])


def midpoints(values: Sequence[acb]) -> list[acb]:
    """The centres of balls, as exact numbers."""
    return [acb(value.real.mid(), value.imag.mid()) for value in values]


def box(centre: Sequence[acb], radius: arb) -> list[acb]:
    """Around each centre the square of half width ``radius``."""
    side = arb(0, radius)
    return [acb(c.real + side, c.imag + side) for c in centre]


def exact(values: NDArray[np.complex128] | Array) -> list[acb]:
    """Doubles as exact numbers."""
    return [acb(arb(float(v.real)), arb(float(v.imag))) for v in np.asarray(values, dtype=np.complex128)]


def largest(values: Sequence[acb]) -> arb:
    """An upper bound on the greatest absolute value."""
    out = arb(0)
    for value in values:
        out = out.max(value.abs_upper())
    return out


def _unit(v: list[arb]) -> list[arb]:
    length = _length(v)
    return [x / length for x in v]


def _length(v: list[arb]) -> arb:
    return sum((x * x for x in v), arb(0)).sqrt()


def _rotation(R: Array) -> list[list[arb]]:
    """The rotation nearest to a matrix of doubles that is all but a rotation, exact up to the precision."""
    M = acb_mat([[acb(float(x)) for x in row] for row in R])
    for _ in range(5):
        M = (M + M.transpose().inv()) * _HALF
        M = acb_mat([[acb(M[i, k].real.mid()) for k in range(3)] for i in range(3)])
    m = [[M[i, k].real for k in range(3)] for i in range(3)]
    diagonal = [m[0][0] + m[1][1] + m[2][2], m[0][0], m[1][1], m[2][2]]
    most = max(range(4), key=lambda i: float(diagonal[i]))
    if most == 0:
        q = [1 + diagonal[0], m[2][1] - m[1][2], m[0][2] - m[2][0], m[1][0] - m[0][1]]
    else:
        i = most - 1
        j, k = (i + 1) % 3, (i + 2) % 3
        q = [m[k][j] - m[j][k], arb(0), arb(0), arb(0)]
        q[1 + i] = 1 + m[i][i] - m[j][j] - m[k][k]
        q[1 + j], q[1 + k] = m[j][i] + m[i][j], m[k][i] + m[i][k]
    w, x, y, z = _unit([value.mid() for value in q])
    return [
        [w * w + x * x - y * y - z * z, 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), w * w - x * x + y * y - z * z, 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), w * w - x * x - y * y + z * z],
    ]


def _motion(R: list[list[arb]], p: list[arb]) -> acb_mat:
    return acb_mat([[acb(R[i][k]) for k in range(3)] + [acb(p[i])] for i in range(3)] + [[0, 0, 0, 1]])


def _turn(S: acb_mat, angle: acb) -> acb_mat:
    """exp(S angle) of a turning joint: 1 + sin S + (1 - cos) S^2, since S^3 = -S."""
    return _identity() + S * angle.sin() + (S * S) * (1 - angle.cos())


def _inverse(X: acb_mat) -> acb_mat:
    """The inverse of a motion: its rotation's transpose is its inverse, for complex angles too."""
    R = [[X[k, i] for k in range(3)] for i in range(3)]
    p = [-(R[i][0] * X[0, 3] + R[i][1] * X[1, 3] + R[i][2] * X[2, 3]) for i in range(3)]
    return acb_mat([[*R[i], p[i]] for i in range(3)] + [[0, 0, 0, 1]])


def _identity() -> acb_mat:
    return acb_mat([[int(i == k) for k in range(4)] for i in range(4)])


def residual(A: acb_mat) -> list[acb]:
    """The six equations at X, or their derivatives from those of X."""
    skew = ((A[2, 1] - A[1, 2]), (A[0, 2] - A[2, 0]), (A[1, 0] - A[0, 1]))
    return [A[0, 3], A[1, 3], A[2, 3], *(each * _HALF for each in skew)]


EIGHT = 8
_NEAR = 0.05  # a structure further off than this share of the arm, or this many rad, is not tried


def ideal(loop: Loop) -> tuple[Loop, float] | None:
    """The loop of the nearest arm with three axes that meet or are parallel, for every target that is needed; or None.

    Where three consecutive axes meet in a point or are parallel, six turning joints have at most eight isolated complex
    solutions (D. L. Pieper, "The kinematics of manipulators under computer control", 1968; C. Mavroidis and B. Roth,
    J. Mech. Des. 116, 1994). An arm as written misses this by rounding, or by the decimals of its file. Its real joint
    vectors q in the pose G solve the ideal arm at the target ``e1' ... e6'(q)``, which differs from
    G = ``e1 ... e6(q)`` by a known amount. So where all eight roots of the ideal arm are enclosed for every target so
    close to G, the real solutions of the arm as written lie in these eight boxes.

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
        rotated = (frobenius(Z - S) + 2 * frobenius(Z * Z - S * S)).upper()
        d = [a - b for a, b in zip(r, p, strict=True)]
        shift = norm([h[1] * d[2] - h[2] * d[1], h[2] * d[0] - h[0] * d[2], h[0] * d[1] - h[1] * d[0]])
        turn += rotated
        move += rotated * (norm(r) + behind) + 2 * shift
        behind += 2 * norm(p).max(norm(r))
    return turn.upper(), move.upper()


def norm(values: Iterable[acb | arb]) -> arb:
    """An upper bound on the 2-norm."""
    return sum((value.abs_upper() ** 2 for value in values), arb(0)).sqrt().upper()


def frobenius(M: acb_mat) -> arb:
    """An upper bound on the Frobenius norm."""
    return norm(M.entries())
