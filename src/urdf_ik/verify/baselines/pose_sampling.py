"""Poses that a lock file holds, and their solutions: random, round, near limits and near singularities."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from urdf_ik.arm import Arm
from urdf_ik.cell import CollisionModel
from urdf_ik.cell.pinocchio_reference import Reference
from urdf_ik.ik.solutions import IKSolutions
from urdf_ik.typing import Array
from urdf_ik.verify import arms
from urdf_ik.verify.baselines.records import Answer, Planted, Pose, answer_rows, pose_row

COUNTS = {"random": 20, "round": 10, "near limits": 10, "near singularity": 10}
"""Poses of each kind that are solved."""

PLANTED = {"random": 8, "round": 6, "at limits": 6}
"""Joint vectors of each kind at which Pinocchio's pose is kept."""

NEAR = (1e-2, 1e-3, 1e-4)
"""How far [rad or m] from a limit, or from a singularity, poses near one are, in turn. Nearer to one, rounding of the
pose decides how many solutions it has, and another processor may round in another way."""

TOUCHING = 1e-6
"""Distance [m] below which nobody can tell whether two shapes touch."""

AT_ONCE = 8
"""Poses that are solved before the time is looked at."""

_TRIES, _ROUNDS = 64, 12


def answered(arm: Arm, kind: str, T: Array, found: IKSolutions, values: Array | None,
             shapes: CollisionModel | None) -> list[Pose]:  # fmt: skip
    """Poses (m, 4, 4) with the solutions that were found for them."""
    within = found.within_limits().valid
    out = []
    for i in range(len(T)):
        valid = found.valid[i]
        touching = contacts(shapes, found.q[i, valid])
        rows = zip(answer_rows(found.q[i, valid]), found.names[i, valid], within[i, valid], found.singular[i, valid],
                   touching, strict=True)  # fmt: skip
        answers = tuple(
            Answer(q, str(branch), bool(inside), bool(singular), contact)
            for q, branch, inside, singular, contact in rows
        )
        redundancy = () if values is None else tuple(float(each) for each in np.ravel(values[i]))
        out.append(Pose(kind, pose_row(T[i]), redundancy, answers))
    return out


def contacts(shapes: CollisionModel | None, q: Array) -> Sequence[bool | None]:
    """Whether each of the joint vectors (k, n) touches something; None where that is not known."""
    if shapes is None or not len(q):
        return [None] * len(q)
    hit, near = np.atleast_1d(shapes.in_collision(q)), np.atleast_1d(shapes.in_collision(q, TOUCHING))
    return [bool(a) if a == b else None for a, b in zip(hit, near, strict=True)]


def solved(arm: Arm, kind: str, T: Array, Q: Array | None, shapes: CollisionModel | None) -> list[Pose]:
    """Poses (m, 4, 4) with every solution; ``Q`` (m, n) are the joint vectors that they were made of, if any."""
    if not len(T):
        return []
    values = None if Q is None else arms.redundancy_at(arm, Q)
    return answered(arm, kind, T, arms.solutions_of(arm, T, values), values, shapes)


def planted_vectors(reference: Reference, rng: np.random.Generator) -> tuple[Planted, ...]:
    """Joint vectors with the poses that Pinocchio gives for them."""
    lower, upper = reference.ranges.T
    n = reference.dof
    drawn = {
        "random": rng.uniform(lower, upper, (PLANTED["random"], n)),
        "round": np.vstack([np.zeros(n), round_vectors(reference, rng, PLANTED["round"] - 1)]),
        "at limits": np.where(rng.integers(0, 2, (PLANTED["at limits"], n)), lower, upper),
    }
    out = []
    for kind, Q in drawn.items():
        out += [
            Planted(kind, q, pose_row(T)) for q, T in zip(answer_rows(Q), reference.pose(np.round(Q, 12)), strict=True)
        ]
    return tuple(out)


def _random(arm: Arm, reference: Reference, rng: np.random.Generator, count: int) -> Array:
    lower, upper = reference.ranges.T
    drawn: Array = rng.uniform(lower, upper, (count, reference.dof))
    return drawn


def round_vectors(reference: Reference, rng: np.random.Generator, count: int) -> Array:
    """Joints at multiples of 45 degrees or 0.1 m, inside the limits: (count, n)."""
    lower, upper = reference.ranges.T
    grain = np.where(reference.prismatic, 0.1, 0.25 * np.pi)
    drawn = np.round(rng.uniform(lower, upper, (count, reference.dof)) / grain) * grain
    return np.clip(drawn, lower, upper)


def _rounded(arm: Arm, reference: Reference, rng: np.random.Generator, count: int) -> Array:
    return round_vectors(reference, rng, count)


def _near_limits(arm: Arm, reference: Reference, rng: np.random.Generator, count: int) -> Array:
    lower, upper = reference.ranges.T
    Q = rng.uniform(lower, upper, (count, reference.dof))
    for k in range(count):
        near = NEAR[k % len(NEAR)] * (upper - lower).clip(max=1.0)
        for i in rng.integers(0, reference.dof, min(2, reference.dof)):
            Q[k, i] = lower[i] + near[i] if rng.integers(0, 2) else upper[i] - near[i]
    return Q


def near_singularity(
    arm: Arm, reference: Reference, rng: np.random.Generator, count: int, *, away: bool = True
) -> Array:
    """Joint vectors (count, n) at which the Jacobian's smallest singular value is least, or one joint beside that."""
    lower, upper = reference.ranges.T
    Q: Array = rng.uniform(lower, upper, (count, reference.dof))
    for k in range(count if reference.dof else 0):
        tried: Array = rng.uniform(lower, upper, (_TRIES, reference.dof))
        q = tried[int(np.argmin(least_singular_value(arm, tried)))]
        first = int(rng.integers(reference.dof))
        for joint in (first, (first + 1) % reference.dof, (first + 2) % reference.dof):
            low, high = lower[joint], upper[joint]
            for _ in range(_ROUNDS):  # ever finer about the least, down to rounding
                line: Array = np.tile(q, (_TRIES, 1))
                line[:, joint] = np.linspace(low, high, _TRIES)
                q = line[int(np.argmin(least_singular_value(arm, line)))]
                step = (high - low) / (_TRIES - 1)
                low, high = max(lower[joint], q[joint] - step), min(upper[joint], q[joint] + step)
        if away:
            beside = NEAR[k % len(NEAR)] * np.minimum(1.0, upper - lower)
            moved = q + np.diag(np.where(q + beside <= upper, beside, -beside))
            # The joint that leads out of the singularity.
            q = moved[int(np.argmax(least_singular_value(arm, moved)))]
        Q[k] = q
    return Q


def least_singular_value(arm: Arm, Q: Array) -> Array:
    """Smallest singular value (...) of the Jacobian at Q (..., n), lengths as shares of the arm's size."""
    J: Array = np.array(arm.jacobian(Q), dtype=np.float64)
    J[..., :3, :] /= arm.chain.size
    least: Array = np.asarray(np.linalg.svd(J, compute_uv=False)[..., -1], dtype=np.float64)
    return least


def made_by() -> tuple[tuple[str, str], ...]:
    """Versions of the packages that compute a baseline."""
    import pinocchio as pin

    from urdf_ik.version import __version__

    return (("pinocchio", str(pin.__version__)), ("urdf-ik", __version__))


DRAWN = {"random": _random, "round": _rounded, "near limits": _near_limits, "near singularity": near_singularity}
