"""A search for all complex roots of the loop equations: Newton's method in doubles, then enclosures."""

import numpy as np
from flint import acb, arb
from numpy.typing import NDArray

from urdf_ik.verify.proof.loop import ORDER, Loop, exact
from urdf_ik.verify.proof.roots import ClusterEnclosure, Enclosure, cluster, single_root

Complex = NDArray[np.complex128]

Found = tuple[list[Enclosure], list[ClusterEnclosure]]

_STARTS = 256  # a round
_STEP = 0.5  # rad, the longest step
_SAME = 1e-7  # rad; ends of Newton's method that are closer are tried once
_CROWD = 1e-3  # rad; ends that are closer may belong to one cluster
_WEAK = 1e-3  # singular values below this share of the greatest are those of a cluster
_CLEAR = 7.0  # sum of the imaginary parts [rad] up to which a double tells a root from a vector near one
_FARTHEST = 20.0  # imaginary part [rad] beyond which e^(6 y) leaves no digit of a double


def search(loop: Loop, starts: NDArray[np.float64], number: int, rng: np.random.Generator, rounds: int) -> Found:
    """Enclosures of distinct roots, until they count ``number`` or the rounds are over.

    Args:
        loop: the loop equations.
        starts: (k, 6) known joint vectors [rad].
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
    for R in (1e-5, 1e-4, 1e-6, 1e-7, 1e-3, 1e-8):
        for share in (3.0, 30.0, 300.0):
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
