"""Joint vectors that the checks draw, and an arm's answers to poses: solutions, redundancy parameters, contacts."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from urdf_ik.arm import Arm
from urdf_ik.cell.pinocchio_reference import Reference
from urdf_ik.ik.solutions import IKSolutions
from urdf_ik.typing import Array
from urdf_ik.verify.description import Row, flat, matrix

if TYPE_CHECKING:
    from urdf_ik.cell import CollisionModel

COUNTS = {"random": 20, "round": 10, "near limits": 10, "near singularity": 10}
"""Poses of each kind that a lock file has solved."""

PLANTED = {"random": 8, "round": 6, "at limits": 6}
"""Joint vectors of each kind at which a lock file keeps Pinocchio's pose."""

KINDS = ("random", "round", "at limits", "near limits", "near singularity", "own")
"""Kinds of poses in a lock file; 'own' are the user's."""

NEAR = (1e-2, 1e-3, 1e-4)
"""Distances [rad or m] from a limit or a singularity, in turn. Nearer to one, rounding of the pose decides how many
solutions it has, and another processor may round in another way."""

TOUCHING = 1e-6
"""Distance [m] below which nobody can tell whether two shapes touch."""

AT_ONCE = 8
"""Poses that are solved before the time is looked at."""

_TRIES, _ROUNDS = 64, 12
_TIED = 1e-13
"""Singular values this close are equal to rounding, which differs from processor to processor."""


@dataclass(frozen=True)
class Planted:
    """Where Pinocchio has the tip at a joint vector.

    Attributes:
        kind: one of ``KINDS``.
        q: (n,) rad or m.
        T: 12 numbers, the upper three rows of the pose [m].
    """

    kind: str
    q: Row
    T: Row


@dataclass(frozen=True)
class Answer:
    """One solution of a pose.

    Attributes:
        q: (n,) rad or m.
        branch: its branch.
        within_limits: whether it, or an image a turn away, lies inside the joint limits.
        singular: whether the Jacobian loses rank there.
        contact: whether something touches that must not; None: not checked, or too near to tell.
    """

    q: Row
    branch: str
    within_limits: bool
    singular: bool
    contact: bool | None


@dataclass(frozen=True)
class Pose:
    """A pose and every solution of it.

    Attributes:
        kind: one of ``KINDS``.
        T: 12 numbers, the upper three rows of the pose [m].
        redundancy: values of the redundancy parameters at which it was solved, or () for an arm without.
        answers: the solutions.
    """

    kind: str
    T: Row
    redundancy: Row
    answers: tuple[Answer, ...]

    @property
    def matrix(self) -> Array:
        """The pose (4, 4) [m]."""
        return matrix(self.T)

    @property
    def q(self) -> Array:
        """(k, n) rad or m, the solutions."""
        return np.array([answer.q for answer in self.answers], dtype=np.float64)


def redundancy_at(arm: Arm, q: Array) -> Array | None:
    """Redundancy parameters (..., k) or (...) at joint vectors (..., n); None for an arm that has none."""
    return arm.redundancy_of(q) if arm.redundancy is not None else None


def solutions_of(arm: Arm, T: Array, redundancy: Array | None = None) -> IKSolutions:
    """Every solution of poses (m, 4, 4); an arm with few joints solves for the part of a pose that it controls."""
    if arm.task != "pose":
        return arm.for_task(arm.task).ik(arm.solver.control.target_of(T))
    return arm.ik(T) if redundancy is None else arm.ik(T, redundancy=redundancy)


def answered(arm: Arm, kind: str, T: Array, values: Array | None, shapes: "CollisionModel | None") -> list[Pose]:
    """Poses (m, 4, 4) with every solution at values (m,) or (m, k) of the redundancy parameters."""
    if not len(T):
        return []
    solutions = solutions_of(arm, T, values)
    within = solutions.within_limits().valid
    out = []
    for i in range(len(T)):
        parts = (solutions.q, solutions.names, within, solutions.singular)
        q, names, inside, singular = (part[i, solutions.valid[i]] for part in parts)
        flags = map(bool, inside), map(bool, singular), contacts(shapes, q)
        rows = zip(rounded(q), map(str, names), *flags, strict=True)
        redundancy = () if values is None else tuple(map(float, np.ravel(values[i])))
        out.append(Pose(kind, flat(T[i]), redundancy, tuple(Answer(*row) for row in rows)))
    return out


def rounded(q: Array) -> tuple[Row, ...]:
    """Joint vectors (k, n) rounded to 1e-12, so that a file differs only where an answer does."""
    return tuple(tuple(float(value) + 0.0 for value in row) for row in np.round(q, 12))


def contacts(shapes: "CollisionModel | None", q: Array) -> Sequence[bool | None]:
    """Whether each of the joint vectors (k, n) touches something; None where that is not known."""
    if shapes is None or not len(q):
        return [None] * len(q)
    hit, near = np.atleast_1d(shapes.in_collision(q)), np.atleast_1d(shapes.in_collision(q, TOUCHING))
    return [bool(a) if a == b else None for a, b in zip(hit, near, strict=True)]


def planted_vectors(reference: Reference, rng: np.random.Generator) -> tuple[Planted, ...]:
    """Joint vectors with the poses that Pinocchio gives for them."""
    lower, upper = reference.ranges.T
    n = reference.dof
    drawn = {
        "random": rng.uniform(lower, upper, (PLANTED["random"], n)),
        "round": np.vstack([np.zeros(n), round_vectors(reference, rng, PLANTED["round"] - 1)]),
        "at limits": np.where(rng.integers(0, 2, (PLANTED["at limits"], n)), lower, upper),
    }
    return tuple(
        Planted(kind, q, flat(T))
        for kind, Q in drawn.items()
        for q, T in zip(rounded(Q), reference.pose(np.round(Q, 12)), strict=True)
    )


def drawn_vectors(arm: Arm, kind: str, rng: np.random.Generator, count: int) -> Array:
    """Joint vectors (count, n) of a kind of ``COUNTS``."""
    reference = arm.cell.reference
    if kind == "round":
        return round_vectors(reference, rng, count)
    if kind == "near limits":
        return _near_limits(reference, rng, count)
    if kind == "near singularity":
        return near_singularity(arm, rng, count)
    lower, upper = reference.ranges.T
    return rng.uniform(lower, upper, (count, reference.dof))


def round_vectors(reference: Reference, rng: np.random.Generator, count: int) -> Array:
    """Joints at multiples of 45 degrees or 0.1 m, inside the limits: (count, n)."""
    lower, upper = reference.ranges.T
    grain = np.where(reference.prismatic, 0.1, 0.25 * np.pi)
    drawn = np.round(rng.uniform(lower, upper, (count, reference.dof)) / grain) * grain
    return np.clip(drawn, lower, upper)


def _near_limits(reference: Reference, rng: np.random.Generator, count: int) -> Array:
    lower, upper = reference.ranges.T
    Q = rng.uniform(lower, upper, (count, reference.dof))
    for k in range(count):
        near = NEAR[k % len(NEAR)] * (upper - lower).clip(max=1.0)
        for i in rng.integers(0, reference.dof, min(2, reference.dof)):
            Q[k, i] = lower[i] + near[i] if rng.integers(0, 2) else upper[i] - near[i]
    return Q


def near_singularity(arm: Arm, rng: np.random.Generator, count: int, *, away: bool = True) -> Array:
    """Joint vectors (count, n) at which the Jacobian's smallest singular value is least, or one joint beside that."""
    reference = arm.cell.reference
    lower, upper = reference.ranges.T
    Q: Array = rng.uniform(lower, upper, (count, reference.dof))
    for k in range(count if reference.dof else 0):
        tried: Array = rng.uniform(lower, upper, (_TRIES, reference.dof))
        q = tried[int(np.argmin(least_singular_value(arm, tried)))]
        first = int(rng.integers(reference.dof))
        for joint in (first, (first + 1) % reference.dof, (first + 2) % reference.dof):
            low, high = lower[joint], upper[joint]
            for _ in range(_ROUNDS):  # ever finer about the least, down to rounding
                line: Array = np.tile(q, (1 + _TRIES, 1))  # the present one first: it stays where no other is better
                line[1:, joint] = np.linspace(low, high, _TRIES)
                value = least_singular_value(arm, line)
                q = line[int(np.argmax(value <= value.min() + _TIED))]
                step = (high - low) / (_TRIES - 1)
                low, high = max(lower[joint], q[joint] - step), min(upper[joint], q[joint] + step)
        if away:
            beside = NEAR[k % len(NEAR)] * np.minimum(1.0, upper - lower)
            moved = q + np.diag(np.where(q + beside <= upper, beside, -beside))
            # The joint that leads out of the singularity, the first of several.
            value = least_singular_value(arm, moved)
            q = moved[int(np.argmax(value >= 0.99 * value.max()))]
        Q[k] = q
    return Q


def least_singular_value(arm: Arm, Q: Array) -> Array:
    """Smallest singular value (...) of the Jacobian at Q (..., n), lengths as shares of the arm's size."""
    J: Array = np.array(arm.jacobian(Q), dtype=np.float64)
    J[..., :3, :] /= arm.chain.size
    return np.asarray(np.linalg.svd(J, compute_uv=False)[..., -1], dtype=np.float64)
