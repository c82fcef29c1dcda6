"""Sameness: the comparison of two solution sets of one pose, up to rounding, double roots and continua.

Two joint vectors of one pose, both polished on the arm as written, count as one solution if

- they differ by no more than rounding of the pose explains: 1e-6 rad, plus 1e-13 over the Jacobian's smallest singular
  value, up to 1e-3 rad;
- or the arm is still in the pose half way between them, to the solvers' tolerance ``fold``: a double root;
- or both lie on one continuum of solutions: a walk from the one along the Jacobian's null direction, with the arm in
  the pose to ``fold`` at every step, leads to the other. The first step is 0.02 rad, too long for an isolated solution
  to stay in the pose, however near a singularity it lies.

A joint vector that misses the pose by more than 1e-9 under Pinocchio is not a solution, and always a difference.
"""

from dataclasses import dataclass, field

import numpy as np

from urdf_ik.cell.pinocchio_reference import Reference
from urdf_ik.kinematics.chain import Chain
from urdf_ik.support.angles import largest_apart, shortest
from urdf_ik.support.tolerances import DEFAULT
from urdf_ik.typing import Array
from urdf_ik.verify.crosscheck import EXACT
from urdf_ik.verify.second_method import descend, errors

SAME = 1e-6
ROUNDING = 1e-13
LOOSEST = 1e-3
"""Tolerances of the first rule [rad]."""

NEIGHBOURS = 1e-2
"""Vectors further apart than this in a joint [rad] are no double root."""

STEP, STEPS = 0.02, 2000
"""Length [rad] and greatest number of steps of a walk along a continuum, each way."""


@dataclass
class Unmatched:
    """Solutions that only one of two answers to a pose has.

    Attributes:
        only_first: (row, joint vector) of each solution that only the first answer has.
        only_second: the same for the second answer.
        planted_lost: whether neither answer has the planted joint vector.
        double_roots: number of solutions that only one answer has, but as a double root with another of the other's.
        continua: the same for representatives of one continuum.
        everything: (k, 6) both answers and the planted joint vector.
    """

    everything: Array
    only_first: list[tuple[int, Array]] = field(default_factory=list)
    only_second: list[tuple[int, Array]] = field(default_factory=list)
    planted_lost: bool = False
    double_roots: int = 0
    continua: int = 0


class Sameness:
    """Decides whether joint vectors are one solution; lengths are shares of the arm's size.

    Args:
        chain: the arm's chain.
        reference: Pinocchio's model of it.
        fold: pose error up to which the arm counts as in the pose, between two roots and along a continuum.
    """

    def __init__(self, chain: Chain, reference: Reference, fold: float = DEFAULT.fold) -> None:
        self.reference = reference
        self.singular = max(DEFAULT.singular, fold / STEP)
        """Smallest singular value below which a solution may be one of a continuum."""
        self._chain = chain
        self._fold = fold

    def unmatched(self, T: Array, planted: Array, first: Array, second: Array) -> Unmatched:
        """Compare two answers (k, 6), (m, 6) to the pose T (4, 4), made of a planted joint vector (6,)."""
        out = Unmatched(np.concatenate([first, second, planted[None]]))
        for mine, theirs, only in ((first, second, out.only_first), (second, first, out.only_second)):
            position, rotation = self.reference.errors(mine, T)
            for i, q in enumerate(mine):
                # A joint vector that misses the pose is not a solution, even if polishing would make it one.
                if max(position[i], rotation[i]) > EXACT or not self._has(T, q, theirs, out):
                    only.append((i, q))
        answered = np.concatenate([first, second])
        out.planted_lost = not self._has(T, planted, answered, None)
        return out

    def has(self, T: Array, q: Array, others: Array) -> bool:
        """Whether q (6,) is one of the others (k, 6), as solutions of the pose T (4, 4)."""
        return self._has(T, q, others, None)

    def sigma_min(self, q: Array) -> float:
        """Smallest singular value of the Jacobian at q (6,)."""
        return float(np.linalg.svd(self._jacobian(q), compute_uv=False)[-1])

    def to_nearest(self, q: Array, others: Array) -> float:
        """Largest angle [rad] from q to the nearest of the others that is not q itself; infinite without one."""
        far = largest_apart(others, q)
        return float(far[far > SAME].min(initial=np.inf))

    def _has(self, T: Array, q: Array, others: Array, count: Unmatched | None) -> bool:
        """Whether q (6,) is one of the others (k, 6); ``count`` counts double roots and continua."""
        if (largest_apart(others, q) <= SAME).any():
            return True
        q = descend(self._chain, T, q[None], 20, 0.0)[0][0]
        tolerance = SAME + min(ROUNDING / max(self.sigma_min(q), 1e-300), LOOSEST)
        others = descend(self._chain, T, others, 20, 0.0)[0]
        far = largest_apart(others, q)
        if (far <= tolerance).any():
            return True
        near = others[far < NEIGHBOURS]
        if any(self._error(T, q + 0.5 * shortest(other - q)) <= self._fold for other in near):
            if count is not None:
                count.double_roots += 1
            return True
        if self.sigma_min(q) > self.singular or not len(others):
            return False
        if self._on_one_continuum(T, q, others):
            if count is not None:
                count.continua += 1
            return True
        return False

    def _on_one_continuum(self, T: Array, q: Array, others: Array) -> bool:
        """Whether a walk along the continuum through q, if there is one, meets one of the others."""
        for sign in (1.0, -1.0):
            here, ahead = q, sign * np.linalg.svd(self._jacobian(q))[2][-1]
            for _ in range(STEPS):
                there = here + STEP * ahead
                if not self._correct(T, there):
                    break
                ahead = shortest(there - here)
                ahead /= np.linalg.norm(ahead)
                here = there
                if (largest_apart(others, here) < STEP).any():
                    return True
                if np.abs(shortest(here - q)).max() < 0.5 * STEP:
                    return False  # all the way round
        return False

    def _correct(self, T: Array, q: Array) -> bool:
        """Move q (6,), in place, back into the pose by steps across the continuum; False if the move is too long."""
        start = q.copy()
        for _ in range(8):
            (e,), (error,) = errors(self._chain, T, q[None])
            if error <= self._fold:
                return bool(np.abs(q - start).max() < 0.25 * STEP)
            # The correction leaves out the Jacobian's null direction.
            q += np.linalg.pinv(self._jacobian(q), rcond=10.0 * DEFAULT.singular) @ e
        return False

    def _error(self, T: Array, q: Array) -> float:
        return float(errors(self._chain, T, q[None])[1][0])

    def _jacobian(self, q: Array) -> Array:
        J = np.array(self._chain.jacobian(q))
        J[:3] /= self._chain.size
        return J
