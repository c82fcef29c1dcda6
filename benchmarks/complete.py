"""Which share of poses does a solver answer completely? Measured by Pinocchio alone."""

from dataclasses import dataclass

import numpy as np
import pinocchio as pin
from peers import Peer
from robots import ReferenceModel

RESIDUAL = 1e-9  # m and rad: a joint vector further off than this reaches another pose
SINGULAR = 1e-6  # smallest singular value of the Jacobian at which the arm counts as singular
NEAR = tuple(10.0**-k for k in range(1, 8))  # rad from a singularity


@dataclass
class Tally:
    """What one solver did on one set of poses.

    Attributes:
        poses: how many it was given.
        complete: how many it answered with every solution that any solver found, the planted one included.
        answered: how many it answered with at least one solution.
        wrong: how many answers held a joint vector that does not reach the pose and was not flagged as approximate.
    """

    poses: int = 0
    complete: int = 0
    answered: int = 0
    wrong: int = 0


def draw_random(reference: ReferenceModel, n: int, rng: np.random.Generator) -> np.ndarray:
    """Draw n joint vectors (n, 6) over the whole torus."""
    return rng.uniform(-np.pi, np.pi, (n, 6))


def draw_singular(
    reference: ReferenceModel, n: int, rng: np.random.Generator, offsets: tuple[float, ...]
) -> np.ndarray:
    """Draw n joint vectors (n, 6), each one of the offsets [rad] away from a singularity along one joint.

    The singularity is where the determinant of the Jacobian changes sign along one joint, by bisection.
    """
    out: list[np.ndarray] = []
    while len(out) < n:
        q, joint = rng.uniform(-np.pi, np.pi, 6), int(rng.integers(6))

        def determinant(x: float, q: np.ndarray = q, joint: int = joint) -> float:
            moved = q.copy()
            moved[joint] = x
            return float(np.linalg.det(reference.jacobian(moved)))

        grid = np.linspace(-np.pi, np.pi, 24)
        values = [determinant(x) for x in grid]
        crossings = [i for i in range(23) if values[i] * values[i + 1] < 0.0]
        if not crossings:
            continue
        i = int(rng.choice(crossings))
        low, high, at_low = grid[i], grid[i + 1], values[i]
        for _ in range(55):
            middle = 0.5 * (low + high)
            at_middle = determinant(middle)
            if at_low * at_middle > 0.0:
                low, at_low = middle, at_middle
            else:
                high = middle
        q[joint] = 0.5 * (low + high) + offsets[len(out) % len(offsets)] * rng.choice([-1.0, 1.0])
        out.append(q)
    return np.array(out)


def _distance(solutions: np.ndarray, q: np.ndarray) -> np.ndarray:
    """Largest angle (k,) [rad] by which each of the solutions (k, 6) differs from q (6,), modulo 2 pi."""
    apart: np.ndarray = np.abs((solutions - q + np.pi) % (2.0 * np.pi) - np.pi).max(axis=-1)
    return apart


def _tolerance(reference: ReferenceModel, q: np.ndarray) -> float:
    """How far apart two polished answers may be and still be one solution: rounding over the conditioning."""
    return 1e-6 + min(1e-11 / max(_least_singular_value(reference, q), 1e-12), 1e-2)


def _least_singular_value(reference: ReferenceModel, q: np.ndarray) -> float:
    return float(np.linalg.svd(reference.jacobian(q), compute_uv=False)[-1])


def _polished(reference: ReferenceModel, q: np.ndarray, target: np.ndarray) -> np.ndarray:
    """The solution (6,) that an answer stands for, by Newton's method on Pinocchio's model.

    Near a singularity an answer with an error of 1e-9 may lie 1e-2 rad from the solution; without this it would count
    as one more solution, which all other solvers had missed.
    """
    best, least, here = q, reference.error(q, target), q
    for _ in range(6):
        pose = reference.pose(here)
        motion = pin.log6(pin.SE3(pose).actInv(pin.SE3(target)))  # by name: .vector of a temporary dangles
        here = here + np.linalg.lstsq(reference.jacobian(here), np.array(motion.vector), rcond=1e-13)[0]
        error = reference.error(here, target)
        if error < least:
            best, least = here, error
    return best


def tally(peers: list[Peer], reference: ReferenceModel, planted: np.ndarray, *, isolated: bool = False) -> list[Tally]:
    """Give every solver the pose of each planted joint vector (n, 6) and count what comes back.

    ``isolated``: only solutions at which the arm is not singular have to be there; of a curve of solutions every solver
    has others.
    """
    tallies = [Tally() for _ in peers]
    for q in planted:
        target = reference.pose(q)
        valid: list[np.ndarray] = []
        for peer, row in zip(peers, tallies, strict=True):
            found, approximate = peer.claims(target)
            none = np.isnan(found).any(axis=1)
            found, approximate = found[~none], approximate[~none]
            right = np.array([reference.error(x, target) <= RESIDUAL for x in found], dtype=bool)
            row.poses += 1
            row.wrong += not (right | approximate).all()
            row.answered += bool(right.any())
            valid.append(np.array([_polished(reference, x, target) for x in found[right]]).reshape(-1, 6))
        union = [(q, _tolerance(reference, q))]
        for x in np.concatenate(valid):
            if all(_distance(x, member) > tolerance for member, tolerance in union):
                union.append((x, _tolerance(reference, x)))
        if isolated:
            union = [(x, tolerance) for x, tolerance in union if _least_singular_value(reference, x) > SINGULAR]
        for found, row in zip(valid, tallies, strict=True):
            row.complete += len(found) > 0 and all((_distance(found, m) <= tolerance).any() for m, tolerance in union)
    return tallies
