"""The properties that a cross-check compares, and their worst values."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from urdf_ik.arm import Arm
from urdf_ik.cell import CollisionModel
from urdf_ik.cell.pinocchio_reference import Reference, finite, pose_errors
from urdf_ik.errors import PoseError, UnsupportedArm
from urdf_ik.ik.solutions import IKSolutions
from urdf_ik.support import inputs
from urdf_ik.support.angles import shortest
from urdf_ik.typing import Array
from urdf_ik.verify.crosscheck.report import Row

ROUNDING = 1e-12
"""Kinematics: two programs that evaluate the same formula in a different order [m per m of the arm; rad]."""

EXACT = 1e-9
"""Solutions: the contract of ``ik`` [m; rad]."""

PLANTED = 1e-6
"""How near a solution must be to the planted joint vector [rad or m] where the Jacobian is well conditioned."""

SAME = 1e-9
"""The most that a solution may differ between batch and single [rad or m] where the Jacobian is well conditioned."""

CONDITIONING = 1e-11
"""Pose error, relative to the arm's size, that nobody can rely on getting below. A pose error e moves the joints by
up to e / sigma_min, sigma_min being the Jacobian's smallest singular value with its linear rows over the arm's size:
two correct answers to one pose differ by this much, and near a singularity that is more than any fixed tolerance."""

DUPLICATE = 1e-8
"""Two solutions of a pose closer than this in every joint [rad or m] are one."""

CONTACT = 2e-6
"""Distances [m]: twice the tolerance at which coal's iteration (GJK) stops, 1e-6."""


@dataclass
class Tally:
    """The worst value of one property so far.

    Attributes:
        name: the property.
        unit: unit of the values.
        tolerance: the most that is accepted, unless a value comes with its own.
        counted: the result is the sum of the values, which are numbers of cases, not the greatest.
    """

    name: str
    unit: str
    tolerance: float
    counted: bool = False
    checked: int = 0
    passed: bool = True
    worst: float = 0.0
    rank: float = -1.0
    at_worst: float | None = None
    index: int | None = None
    q: tuple[float, ...] | None = None
    detail: str = ""

    def add(
        self, value: float, index: int | None, q: Array | None, detail: str = "", tolerance: float | None = None
    ) -> None:
        """Take one value, found at ``q`` of pose ``index``; what is not a number counts as infinite."""
        value = float(np.inf if np.isnan(value) else value)
        limit = self.tolerance if tolerance is None else tolerance
        self.checked += 1
        self.passed &= value <= limit
        self.worst += value if self.counted else 0.0
        # Where each pose has its own tolerance, the worst is the one that uses most of it.
        rank = value if limit == self.tolerance or np.isinf(value) else value / limit * self.tolerance
        if rank > self.rank and (value > 0.0 or not self.counted):
            self.rank, self.at_worst, self.index, self.detail = rank, limit, index, detail
            self.q = None if q is None else tuple(float(each) for each in q)
            self.worst = self.worst if self.counted else value

    def add_each(self, values: Array, indices: Sequence[int], Q: Array, detail: str = "") -> None:
        """Take one value (m,) a pose."""
        for value, index, q in zip(values, indices, Q, strict=True):
            self.add(float(value), index, q, detail)

    def row(self) -> Row:
        """The report's row. Nothing compared is no pass."""
        return Row(
            name=self.name,
            unit=self.unit,
            worst=self.worst if self.checked else np.inf,
            tolerance=self.tolerance if self.at_worst is None else self.at_worst,
            passed=self.passed and self.checked > 0,
            checked=self.checked,
            index=self.index,
            q=self.q,
            detail=self.detail if self.checked else "nothing to compare",
        )


def limits(arm: Arm, reference: Reference) -> Tally:
    """Joint names in order, and limits."""
    tally = Tally("joints and limits", "rad, m", 0.0)
    if tuple(arm.joint_names) != reference.joint_names:
        tally.add(np.inf, None, None, f"joints {', '.join(arm.joint_names)}, not {', '.join(reference.joint_names)}")
        return tally
    for name, ours, theirs in zip(reference.joint_names, np.asarray(arm.limits), reference.limits, strict=True):
        same = ours == theirs  # inf - inf would be no number
        tally.add(float(np.abs(np.where(same, 0.0, ours) - np.where(same, 0.0, theirs)).max()), None, None, name)
    if not reference.joint_names:  # both say that nothing moves
        tally.add(0.0, None, None)
    return tally


class Kinematics:
    """Forward kinematics, Jacobian, the pose of every link; batch against single."""

    def __init__(self, arm: Arm, reference: Reference) -> None:
        self._arm, self._reference = arm, reference
        length = ROUNDING * max(1.0, reference.size)
        self._fk = (
            Tally("forward kinematics, position", "m", length),
            Tally("forward kinematics, rotation", "rad", ROUNDING),
        )
        self._jacobian = Tally("Jacobian", "m, 1", length)
        self._links = Tally("links, position", "m", length), Tally("links, rotation", "rad", ROUNDING)
        self._single = Tally("batch = single, kinematics", "m, 1", length)
        self.tallies = [*self._fk, self._jacobian, *self._links, self._single]

    def take(self, indices: Sequence[int], Q: Array, T: Array) -> None:
        """Compare at joint vectors Q (m, n), whose poses are T (m, 4, 4) to Pinocchio."""
        arm = self._arm
        F, J = np.asarray(arm.fk(Q)), np.asarray(arm.jacobian(Q))
        for tally, values in zip(self._fk, _difference(F, T), strict=True):
            tally.add_each(values, indices, Q)
        self._jacobian.add_each(np.abs(J - self._reference.jacobian(Q)).max(axis=(-2, -1), initial=0.0), indices, Q)
        ours, theirs = arm.link_poses(Q), self._reference.link_poses(Q)
        for link in sorted(set(ours) ^ set(theirs)):
            for tally in self._links:
                tally.add(np.inf, indices[0], Q[0], f"link {link!r} {'too many' if link in ours else 'is missing'}")
        for link in ours.keys() & theirs.keys():
            for tally, values in zip(self._links, _difference(np.asarray(ours[link]), theirs[link]), strict=True):
                worst = int(np.argmax(np.nan_to_num(values, nan=np.inf)))
                tally.checked += len(values) - 1
                tally.add(float(values[worst]), indices[worst], Q[worst], f"link {link!r}")
        for i, index in enumerate(indices):
            apart = max(np.abs(arm.fk(Q[i]) - F[i]).max(), np.abs(arm.jacobian(Q[i]) - J[i]).max(initial=0.0))
            self._single.add(float(apart), index, Q[i])


class Inverse:
    """Every solution's error, the planted joint vector, duplicates; batch against single.

    Attributes:
        skipped: (property, reason) of what cannot be checked.
    """

    def __init__(self, arm: Arm, reference: Reference) -> None:
        self._arm, self._reference = arm, reference
        self._error = Tally("solutions, position", "m", EXACT), Tally("solutions, rotation", "rad", EXACT)
        self._planted = Tally("planted joint vector", "rad, m", PLANTED)
        self._single = Tally("batch = single, solutions", "rad, m", SAME)
        self._duplicates = Tally("duplicates", "pairs", 0.0, counted=True)
        self.tallies = [*self._error, self._planted, self._single, self._duplicates]
        self.skipped: list[tuple[str, str]] = []
        # An arm with a redundancy parameter is asked for the planted vector's own value of it.
        if reference.dof > 6 and arm.redundancy is None:
            self.tallies.remove(self._planted)
            reason = f"with {reference.dof} joints a pose has infinitely many solutions"
            self.skipped.append((self._planted.name, reason))

    def take(self, indices: Sequence[int], Q: Array, T: Array) -> list[Array]:
        """Solve T (m, 4, 4), made of joint vectors Q (m, n); the solutions (k, n) of each pose."""
        nothing = [Q[:0] for _ in indices]
        if not self.tallies:
            return nothing
        try:
            own = None if self._arm.redundancy is None else self._arm.redundancy_of(Q)
            solutions = self._solve(T, own)
        except UnsupportedArm as error:
            self.skipped = [("inverse kinematics", str(error))]
            self.tallies = []
            return nothing
        found, valid, names = np.asarray(solutions.q), np.asarray(solutions.valid), solutions.branches
        errors = self._reference.errors(found, T[:, None])
        sigma = self._sigma_min(np.where(valid[..., None], found, np.nan))
        planted = CONDITIONING / np.maximum(self._sigma_min(Q), 1e-300)
        for i, index in enumerate(indices):
            columns = np.flatnonzero(valid[i])
            for b in map(int, columns):
                number = np.isfinite(found[i, b]).all()
                detail = f"branch {names[b]!r}" + ("" if number else ", marked valid, is not finite")
                for tally, values in zip(self._error, errors, strict=True):
                    tally.add(float(values[i, b]), index, found[i, b] if number else Q[i], detail)
            mine = found[i, columns]
            far = self._apart(mine, Q[i]).min(initial=np.inf)
            self._planted.add(float(far), index, Q[i], f"{len(mine)} solutions", PLANTED + float(planted[i]))
            at = None if own is None else own[i]
            self._compare_single(index, Q[i], T[i], at, found[i], valid[i], sigma[i], names)
            gaps = self._apart(mine[:, None], mine[None])
            doubled = int(np.count_nonzero(np.triu(gaps < DUPLICATE, k=1)))
            self._duplicates.add(doubled, index, Q[i], f"{doubled} of its pairs" if doubled else "")
        return [found[i, valid[i]] for i in range(len(indices))]

    def _compare_single(
        self,
        index: int,
        q: Array,
        T: Array,
        at: Array | None,
        found: Array,
        valid: NDArray[np.bool_],
        sigma: Array,
        names: Sequence[str],
    ) -> None:
        alone = self._solve(T, at)
        single, has = np.asarray(alone.q), np.asarray(alone.valid)
        for b in map(int, np.flatnonzero(valid | has)):
            if valid[b] and has[b]:
                apart, detail = float(self._apart(single[b], found[b])), f"branch {names[b]!r}"
            else:
                apart, detail = np.inf, f"branch {names[b]!r} only in the {'batch' if valid[b] else 'single answer'}"
            tolerance = SAME + CONDITIONING / max(float(np.nan_to_num(sigma[b])), 1e-300)
            self._single.add(apart, index, q, detail, tolerance)

    def _solve(self, T: Array, at: Array | None) -> IKSolutions:
        """Solutions of T (..., 4, 4), at values (...) or (..., p) of what redundancy parameters the arm has."""
        return self._arm.ik(T) if at is None else self._arm.ik(T, redundancy=at)

    def _apart(self, a: Array, b: Array) -> Array:
        """Largest difference (...) [rad or m] between joint vectors (..., n), revolute joints modulo 2 pi."""
        step = np.asarray(a - b)
        apart: Array = np.abs(np.where(self._reference.prismatic, step, shortest(step))).max(axis=-1, initial=0.0)
        return apart

    def _sigma_min(self, Q: Array) -> Array:
        """Smallest singular value (...) of the Jacobian at Q (..., n), its linear rows over the arm's size.

        Of an arm with redundancy parameters, the gradient of each is a row, too.
        """
        J = self._reference.jacobian(Q)
        J[..., :3, :] /= max(self._reference.size, 1e-300)
        out = np.full(Q.shape[:-1], np.nan)
        known = np.isfinite(Q).all(axis=-1)
        if self._arm.redundancy is not None:
            gradient = np.full((*Q.shape[:-1], len(self._arm.solver.parameters), Q.shape[-1]), np.nan)
            gradient[known] = self._gradient(Q[known])
            J = np.concatenate([J, gradient], axis=-2)
        out[known] = np.linalg.svd(J[known], compute_uv=False)[..., -1]
        return out

    def _gradient(self, Q: Array) -> Array:
        """Central differences (k, p, n) of the redundancy parameters at Q (k, n)."""
        step = 1e-6 * np.eye(Q.shape[-1])
        ahead, behind = (self._arm.redundancy_of(Q[:, None] + side * step) for side in (1.0, -1.0))
        return (shortest(ahead - behind) / 2e-6).reshape(len(Q), Q.shape[-1], -1).swapaxes(1, 2)


class Collision:
    """coal's shapes placed with the arm's link poses, against the same shapes placed by Pinocchio."""

    def __init__(self, arm: Arm, shapes: CollisionModel, most: int | None) -> None:
        self._arm, self._shapes = arm, shapes
        self._left: float = np.inf if most is None else inputs.whole(most, "collision_poses")
        self._verdict = Tally("collision, verdict", "cases", 0.0, counted=True)
        self._distance = Tally("collision, distance", "m", CONTACT)
        self.tallies = [self._verdict, self._distance]

    def take(self, indices: Sequence[int], Q: Array, solutions: Sequence[Array]) -> None:
        """Compare at the planted joint vectors Q (m, n) and the solutions (k, n) of each, while any may be compared."""
        for i, index in enumerate(indices):
            candidates = np.concatenate([Q[i : i + 1], solutions[i]])
            for (row,) in finite(candidates):
                if self._left < 1:
                    return
                self._left -= 1
                self._compare(index, candidates[row])

    def _compare(self, index: int, q: Array) -> None:
        shapes, poses = self._shapes, self._arm.link_poses(q)
        theirs, hit = float(shapes.distance(q)), bool(shapes.in_collision(q))
        try:
            ours, felt = float(shapes.distance_with(poses)), bool(shapes.in_collision_with(poses))
        except PoseError as error:
            self._distance.add(np.inf, index, q, str(error))
            self._verdict.add(1, index, q, str(error))
            return
        apart = 0.0 if ours == theirs else abs(ours - theirs)  # both infinite: no pair is checked
        self._distance.add(apart, index, q, _words(shapes.nearest_pair(q)))
        # Where shapes touch to within coal's own tolerance, either verdict is right.
        differ = hit != felt and not max(ours, theirs) <= CONTACT
        self._verdict.add(int(differ), index, q, ", ".join(map(" and ".join, shapes.colliding_pairs(q))))


def _words(nearest: Any) -> str:
    return "" if nearest is None else " and ".join(nearest.links)


def _difference(ours: Array, theirs: Array) -> tuple[Array, Array]:
    """Position [m] and rotation [rad] (...) between (..., 4, 4), where ours need not be a pose at all."""
    position, rotation = pose_errors(ours, theirs)
    # An angle does not see a stretched matrix, nor a bad last row.
    entries = np.abs(ours - theirs)
    entries[..., :3, 3] = 0.0
    return position, np.maximum(rotation, entries.max(axis=(-2, -1)))
