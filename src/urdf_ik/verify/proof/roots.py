"""Single roots and clusters of the loop equations, enclosed by theorems that are evaluated in ball arithmetic."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations_with_replacement, product
from math import factorial, prod
from typing import Self

import numpy as np
from flint import acb, acb_mat, arb
from numpy.typing import NDArray

from urdf_ik.verify.proof.loop import (
    ORDER,
    Loop,
    box,
    exact,
    frobenius,
    is_identity,
    largest,
    midpoints,
    norm,
    residual,
)

_STEPS = 8  # from fifteen digits to the precision, where the root is single
_LEAST, _GREATEST = arb(2) ** -150, arb(2) ** -4  # half widths of the boxes that are tried
_ALMOST_REAL = arb(2) ** -40


@dataclass(frozen=True)
class Enclosure:
    """A box that holds exactly one root of the loop, and nothing else.

    Attributes:
        centre: six complex angles [rad].
        radius: half width of the box in every real and imaginary part [rad].
        real: whether the root is real.
    """

    centre: tuple[acb, ...]
    radius: arb
    real: bool

    def distance(self, q: Sequence[acb]) -> arb:
        """An upper bound on the greatest distance [rad] of a joint's angle from the root, whole turns aside."""
        return largest(_between(self.centre, q)) + 2 * self.radius

    def apart(self, other: Self) -> bool:
        """Whether the boxes have no point in common, whole turns aside."""
        sides = self.radius + other.radius
        return any(abs(d.real) > sides or abs(d.imag) > sides for d in _between(self.centre, other.centre))

    def towards(self, q: Sequence[acb]) -> list[acb]:
        """The point half way from the centre to q, on the shorter way around."""
        steps = _between(q, self.centre)
        return midpoints([c + step / 2 for c, step in zip(self.centre, steps, strict=True)])

    @property
    def may_be_real(self) -> bool:
        """Whether the box holds a real point."""
        return not any(abs(c.imag) > self.radius for c in self.centre)


def single_root(loop: Loop, start: Sequence[acb]) -> Enclosure | str:
    """The root that Newton's method reaches from ``start``, enclosed by Krawczyk's test; or why there is none.

    With C an approximate inverse of the Jacobian at the centre c, ``-C f(c) + (1 - C J(B)) (B - c)`` inside B - c
    proves that B holds exactly one root (R. Krawczyk, Computing 4, 1969). It holds for analytic functions of complex
    boxes, as J(B) encloses the mean of the Jacobian along every segment of B.
    """
    centre = midpoints(start)
    step = arb("inf")
    for _ in range(_STEPS):
        try:
            X, J = loop.jacobian(centre)
            move = J.solve(_column(residual(X)))
        except ZeroDivisionError:
            return "the Jacobian cannot be told from a singular one"
        moved = midpoints([c - move[i, 0] for i, c in enumerate(centre)])
        taken = largest([a - b for a, b in zip(moved, centre, strict=True)])
        centre = moved
        if not taken < 1:
            return "Newton's method leaves the ball"
        if taken < _LEAST or not taken < step:
            break
        step = taken
    # The equations are real: with a root its conjugate is one, and in a box around real numbers they are the same.
    if largest([acb(c.imag) for c in centre]) < _ALMOST_REAL:
        on_axis = enclosed(loop, [acb(c.real) for c in centre])
        if not isinstance(on_axis, str):
            return on_axis
    return enclosed(loop, centre)


def enclosed(loop: Loop, centre: Sequence[acb], least: arb = _LEAST) -> Enclosure | str:
    """A box around ``centre``, at least of half width ``least``, that holds exactly one root; or why there is none."""
    X, J = loop.jacobian(centre)
    try:
        C = J.inv()
    except ZeroDivisionError:
        return "the Jacobian cannot be told from a singular one"
    C = acb_mat([[acb(C[i, k].real.mid(), C[i, k].imag.mid()) for k in range(6)] for i in range(6)])
    moved = C * _column(residual(X))
    radius = (2 * largest([moved[i, 0] for i in range(6)])).max(least)
    while radius < _GREATEST:
        around = box(centre, radius)
        X, J = loop.jacobian(around)
        rest = acb_mat([[int(i == k) for k in range(6)] for i in range(6)]) - C * J
        image = rest * _column(box([acb(0)] * 6, radius)) - moved
        if all(abs(image[i, 0].real) < radius and abs(image[i, 0].imag) < radius for i in range(6)):
            if not is_identity(X):
                return "it is half a turn off the pose"
            return Enclosure(tuple(centre), radius, all(c.imag.is_zero() for c in centre))
        radius *= 8
    return "no box around it holds exactly one root"


@dataclass(frozen=True)
class ClusterEnclosure:
    """A polydisc that holds exactly ``count`` roots of the loop, counted with multiplicity.

    Attributes:
        centre: six complex angles [rad].
        radius: every point of the polydisc is this close to the centre, in the 2-norm [rad].
        count: how many roots it holds.
    """

    centre: tuple[acb, ...]
    radius: arb
    count: int

    def distance(self, q: Sequence[acb]) -> arb:
        """The distance of q from the centre in the 2-norm [rad], whole turns aside."""
        return sum((abs(d) * abs(d) for d in _between(self.centre, q)), arb(0)).sqrt()


def cluster(loop: Loop, centre: NDArray[np.complex128], lost: int, R: float, rho: float) -> ClusterEnclosure | str:
    """Whether the polydisc around ``centre`` holds exactly ``2 ** lost`` roots, by Rouche's theorem; or why it may not.

    With J = U S V* at the centre, t are the coordinates along the ``lost`` last columns of V and y the others, and
    g = U* f has rows g' and g_t in the same way. On |y| <= rho, |t| <= R,

        g' = A y + B t + c' + quadratic',    g_t = Q(t) + (the rest)

    where the second derivatives are enclosed over the whole polydisc. There are as many roots as of (A y, Q(t)),
    which is 2^lost, if on |y| = rho the other terms of g' are smaller than A y, and on |t| = R those of g_t smaller
    than Q(t). Q has no zero but t = 0 where Macaulay's matrix of the quadrics has full rank, whose least singular value
    bounds |Q| / |t|^2 from below.

    Args:
        loop: the loop equations.
        centre: (6,) complex angles [rad].
        lost: how many singular values are small; 1 to 3.
        R: bound on |t| [rad].
        rho: bound on |y| [rad].
    """
    if not (1 <= lost <= 3 and 0 < R < 1 and 0 < rho < 1):
        return "a cluster has a rank that falls by 1 to 3, and radii between 0 and 1"
    here = exact(centre)
    X, J = loop.jacobian(here)
    U, _, Vh = np.linalg.svd(np.array([[complex(J[i, k]) for k in range(6)] for i in range(6)]))
    left, V = _matrix(U.conj().T), _matrix(Vh.conj().T)
    linear = left * J * V
    constant = left * _column(residual(X))
    reach = (arb(R) ** 2 + arb(rho) ** 2).sqrt()
    around = box(here, reach)
    if not is_identity(loop.values(around)):
        return "it is half a turn off the pose, or may be"
    second = _in_coordinates(loop.hessian(around), left, V)
    at_centre = _in_coordinates(loop.hessian(here), left, V)
    kept = range(6 - lost)
    free = range(6 - lost, 6)
    quadrics = [[[at_centre[row][i][j] / 2 for j in free] for i in free] for row in free]
    least = _least(quadrics)
    if not least > 0:
        return "its quadrics may have a common zero"
    A = acb_mat([[linear[i, k] for k in kept] for i in kept])
    try:
        weakest = 1 / frobenius(A.inv())
    except ZeroDivisionError:
        return "more singular values are small"

    changed = [[[second[row][i][j] - at_centre[row][i][j] for j in range(6)] for i in range(6)] for row in range(6)]
    r, p = arb(R), arb(rho)

    def others(rows: Sequence[int], leading: list[list[list[acb]]]) -> arb:
        """A bound on the terms of some rows of g but one: the constant, along t, and the second derivatives."""
        along_t = norm(leading[row][i][j] for row in rows for i in free for j in free)
        mixed = norm(second[row][i][j] for row in rows for i in free for j in kept)
        along_y = norm(second[row][i][j] for row in rows for i in kept for j in kept)
        flat = norm(constant[i, 0] for i in rows) + norm(linear[i, k] for i in rows for k in free) * r
        return flat + along_t * r**2 / 2 + mixed * r * p + along_y * p**2 / 2

    on_y = others(kept, second)
    on_t = others(free, changed) + norm(linear[i, k] for i in free for k in kept) * p
    if not weakest * p > on_y:
        return "Rouche's condition fails across the weak directions"
    if not least * r**2 > on_t:
        return "Rouche's condition fails along the weak directions"
    return ClusterEnclosure(tuple(here), reach * _frobenius_bound(V), 2**lost)


def _least(quadrics: list[list[list[acb]]]) -> arb:
    """A lower bound on |Q(t)| over |t| = 1 for r quadrics of r variables: Macaulay's matrix in weighted monomials.

    In degree d = r + 1 each quadric is multiplied by the monomials of degree d - 2. With the weights
    sqrt(d! / (a_1! ... a_r!)) the vector of monomials has the length |t|^d, so |Q(t)| is at least the least
    singular value.
    """
    r = len(quadrics)
    degree = r + 1
    rows_of = list(combinations_with_replacement(range(r), degree - 2))
    columns = {key: n for n, key in enumerate(combinations_with_replacement(range(r), degree))}
    table = [[acb(0)] * len(columns) for _ in range(len(rows_of) * r)]
    for n, (factor, quadric) in enumerate((f, q) for f in rows_of for q in quadrics):
        for i in range(r):
            for j in range(r):
                key = tuple(sorted((*factor, i, j)))
                table[n][columns[key]] += quadric[i][j] * _weight(factor, r) / _weight(key, r)
    M = acb_mat(table)
    approximate = np.linalg.pinv(np.array([[complex(x) for x in row] for row in table]))
    inverse = _matrix(approximate)
    error = frobenius(inverse * M - acb_mat([[int(i == k) for k in range(len(columns))] for i in range(len(columns))]))
    return (1 - error) / frobenius(inverse)


def _weight(key: Sequence[int], r: int) -> arb:
    return arb(factorial(len(key)) // prod(factorial(list(key).count(i)) for i in range(r))).sqrt()


def _in_coordinates(H: list[list[list[acb]]], left: acb_mat, V: acb_mat) -> list[list[list[acb]]]:
    """Second derivatives of U* f along the columns of V: ``[row][i][j]``."""
    rows = [V.transpose() * acb_mat([[H[i][j][row] for j in range(6)] for i in range(6)]) * V for row in range(6)]
    totals = [sum((rows[k] * left[row, k] for k in range(1, 6)), rows[0] * left[row, 0]) for row in range(6)]
    return [[[total[i, j] for j in range(6)] for i in range(6)] for total in totals]


def _matrix(values: NDArray[np.complex128]) -> acb_mat:
    return acb_mat([exact(row) for row in values])


def _column(values: Sequence[acb]) -> acb_mat:
    return acb_mat([[value] for value in values])


def _frobenius_bound(V: acb_mat) -> arb:
    """An upper bound on the 2-norm of a matrix that is unitary but for rounding."""
    off = V.conjugate().transpose() * V - acb_mat([[int(i == k) for k in range(6)] for i in range(6)])
    return (1 + frobenius(off)).sqrt()


def _between(a: Sequence[acb], b: Sequence[acb]) -> list[acb]:
    """The differences of angles, without whole turns."""
    out = []
    for one, other in zip(a, b, strict=True):
        d = one - other
        whole = round(float(d.real) / (2 * np.pi))
        out.append(acb(d.real - 2 * whole * arb.pi(), d.imag))
    return out


Complex = NDArray[np.complex128]

Found = tuple[list[Enclosure], list[ClusterEnclosure]]

_STARTS = 256  # a round
_STEP = 0.5  # rad, the longest step
_SAME = 1e-7  # rad; ends of Newton's method that are closer are tried once
_CROWD = 1e-3  # rad; ends that are closer may belong to one cluster
_WEAK = 1e-3  # singular values below this share of the greatest are those of a cluster
_CLEAR = 7.0  # sum of the imaginary parts [rad] up to which a double tells a root from a vector near one
_FARTHEST = 20.0  # imaginary part [rad] beyond which e^(6 y) leaves no digit of a double


def search(loop: Loop, starts: Complex, number: int, rng: np.random.Generator, rounds: int) -> Found:
    """Enclosures of distinct roots, until they count ``number`` or the rounds are over.

    Args:
        loop: the loop equations.
        starts: (k, 6) where the search begins [rad], such as known joint vectors.
        number: how many roots there are at most, counted with multiplicity.
        rng: source of the random starts.
        rounds: how often random starts are tried.
    """
    twists = np.array([[[complex(t[i, k]) for k in range(4)] for i in range(4)] for t in loop.twists])
    G = np.array([[complex(acb(loop.G[i, k].real.mid(), loop.G[i, k].imag.mid())) for k in range(4)] for i in range(4)])
    tried: list[Complex] = []
    singles: list[Enclosure] = []
    crowded: list[Complex] = []
    for turn in range(rounds + 1):
        q: Complex = starts.astype(np.complex128)
        if turn:
            q = rng.uniform(-np.pi, np.pi, (_STARTS, 6)) + 1j * rng.normal(0, 1.5, (_STARTS, 6))
        for end in _newton(twists, G, q):
            for root in (end, end.conj()):
                if any(_apart(root, other) < _SAME for other in tried):
                    continue
                tried.append(root)
                one = single_root(loop, exact(root))
                if isinstance(one, str):
                    if np.abs(root.imag).sum() < _CLEAR:
                        crowded.append(root)
                elif all(one.apart(other) for other in singles):
                    singles.append(one)
        if len(singles) >= number:
            return singles, []
        clusters = _clusters(loop, crowded)
        kept = [one for one in singles if all(outside(one, group) for group in clusters)]
        if len(kept) + sum(group.count for group in clusters) >= number:
            return kept, clusters
    return singles, []


def outside(one: Enclosure, group: ClusterEnclosure) -> bool:
    """Whether the box and the polydisc have no point in common."""
    corner = arb(12).sqrt() * one.radius  # six complex coordinates, each in a square
    return bool(group.distance(one.centre) > group.radius + corner)


def _clusters(loop: Loop, crowded: list[Complex]) -> list[ClusterEnclosure]:
    """Clusters around the ends of Newton's method that are no single roots, apart from each other."""
    groups: list[list[Complex]] = []
    for root in crowded:
        near = next((group for group in groups if _apart(root, group[0]) < _CROWD), None)
        if near is None:
            groups.append([root])
        else:
            near.append(root)
    found: list[ClusterEnclosure] = []
    for group in groups:
        centre = group[0] + np.mean([_turned(root - group[0]) for root in group], axis=0)
        one = _cluster_at(loop, centre)
        if one is not None and all(one.distance(other.centre) > one.radius + other.radius for other in found):
            found.append(one)
    return found


def _cluster_at(loop: Loop, centre: Complex) -> ClusterEnclosure | None:
    _, J = loop.jacobian(exact(centre))
    sizes = np.linalg.svd(np.array([[complex(J[i, k]) for k in range(6)] for i in range(6)]), compute_uv=False)
    lost = int((sizes < _WEAK * sizes[0]).sum())
    for R, share in product((1e-5, 1e-4, 1e-6, 1e-7, 1e-3, 1e-8), (3.0, 30.0, 300.0)):
        found = cluster(loop, centre, lost, R, share * R * R)
        if not isinstance(found, str):
            return found
    return None


def _newton(twists: Complex, G: Complex, q: Complex) -> Complex:
    """The ends (m, 6) of Newton's method that are roots, and not half a turn off."""
    for _ in range(40):
        X, J = _swept(twists, G, q)
        residual = _six(X)[..., None]
        try:
            move = np.linalg.solve(J, residual)[..., 0]
        except np.linalg.LinAlgError:  # one of the batch is exactly singular
            move = (np.linalg.pinv(J) @ residual)[..., 0]
        q = q - move * np.minimum(1.0, _STEP / np.maximum(np.abs(move).max(1, keepdims=True), _STEP))
        q = np.where(np.abs(q.imag).max(1, keepdims=True) < _FARTHEST, q, 0.1 * q)
    X, _ = _swept(twists, G, q)
    size = np.exp(np.abs(q.imag).sum(1))
    good = (np.abs(_six(X)).max(1) < 1e-13 * size) & (np.abs(np.trace(X[:, :3, :3], axis1=1, axis2=2) - 3) < 1)
    return np.asarray(q[good])


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


def _turned(d: Complex) -> Complex:
    """Differences of angles without whole turns."""
    return (d.real + np.pi) % (2 * np.pi) - np.pi + 1j * d.imag


def _apart(a: Complex, b: Complex) -> float:
    return float(np.abs(_turned(a - b)).max())
