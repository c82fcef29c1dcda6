"""Cross-checks of an arm with Pinocchio, over random poses and every branch."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from urdf_ik.arm import Arm
from urdf_ik.cell.pinocchio_reference import Reference, finite, pose_errors
from urdf_ik.errors import ArgumentError, PoseError, UnsupportedArm, UrdfError
from urdf_ik.ik.solutions import IKSolutions
from urdf_ik.support import inputs
from urdf_ik.support.angles import shortest
from urdf_ik.support.report import Report
from urdf_ik.support.text import Section
from urdf_ik.support.watch import Progress, Watch
from urdf_ik.typing import Array

if TYPE_CHECKING:
    from urdf_ik.cell import CollisionModel

PROPERTIES = (
    "joints and limits",
    "forward kinematics, position",
    "forward kinematics, rotation",
    "Jacobian",
    "links, position",
    "links, rotation",
    "batch = single, kinematics",
    "solutions, position",
    "solutions, rotation",
    "planted joint vector",
    "batch = single, solutions",
    "duplicates",
    "collision, verdict",
    "collision, distance",
)
"""The rows of a report, in order; it omits a row that cannot be checked, and ``Report.skipped`` gives the reason."""

COLLISION_POSES = 2000
"""Joint vectors whose collision is compared: a distance between meshes takes a millisecond."""

_CHUNK = 256  # poses at a time: the link poses and solutions of all need not be in memory together


def check(
    arm: Arm,
    n: int = 200,
    seed: int = 0,
    collision: bool | None = None,
    *,
    collision_poses: int | None = COLLISION_POSES,
    time_limit: float | None = None,
    progress: Progress | None = None,
) -> CrossCheck:
    """Compare an arm against Pinocchio's own model of the same URDF.

    Joint vectors are drawn within the limits, Pinocchio makes the poses, the arm solves them. Compared are: joints and
    limits, forward kinematics, Jacobian, the pose of every link, batch and single answers, the error of every
    solution, whether the planted joint vector is among the solutions, duplicates, and collision: coal's shapes placed
    with the arm's link poses, against the same shapes placed by Pinocchio, for planted joint vectors and solutions.

    Args:
        arm: what :func:`urdf_ik.load` returned.
        n: number of poses.
        seed: the same seed gives the same report; :func:`replay` gives pose i of it again.
        collision: compare collision, too; None: where the URDF has collision shapes and all of them can be read.
        collision_poses: most joint vectors whose collision is compared; None: all.
        time_limit: s after which no more poses are checked; what was left out did not pass.
        progress: called with (poses done, n).

    Returns:
        The report; ``report.passed`` says whether all is well.

    Raises:
        UrdfError: ``collision`` is true, and there are no collision shapes or not all of them can be read.
        ArgumentError: n is below 1, or ``time_limit`` is no number of seconds.

    Example:
        >>> import urdf_ik
        >>> check(urdf_ik.load("planar_2r"), n=5).passed
        True
    """
    inputs.arm(arm)
    n = inputs.poses(n)
    watch = Watch(time_limit, progress)
    reference = arm.cell.reference
    tallies, skipped, unlooked = [_limits(arm, reference)], [], ""
    if tuple(arm.joint_names) != reference.joint_names:
        skipped.append(("all else", "the arm's joints are not Pinocchio's"))
    else:
        kinematics, inverse = _Kinematics(arm, reference), _Inverse(arm, reference)
        touching, reason = _collision(arm, collision, collision_poses)
        for start in range(0, n, _CHUNK):
            if watch.is_over:
                unlooked = watch.ended(f"with {start} of {n} poses: the others were")
                break
            indices = range(start, min(start + _CHUNK, n))
            Q = np.array([_draw(reference, seed, index) for index in indices])
            T = reference.pose(Q)
            kinematics.take(indices, Q, T)
            solutions = inverse.take(indices, Q, T)
            if touching is not None:
                touching.take(indices, Q, solutions)
            watch.step(indices.stop, n)
        tallies += kinematics.tallies + inverse.tallies
        tallies += [] if touching is None else touching.tallies
        skipped += inverse.skipped + ([("collision", reason)] if reason else [])
    import pinocchio as pin

    return CrossCheck(
        robot=arm.name,
        base=reference.base,
        tip=reference.tip,
        joint_names=reference.joint_names,
        n=n,
        seed=seed,
        reference=f"Pinocchio {pin.__version__}",
        # What time left nothing to compare of is no failure.
        rows=tuple(tally.row() for tally in tallies if tally.checked or not unlooked),
        skipped=tuple(skipped),
        unlooked=unlooked,
    )


def replay(arm: Arm, seed: int, index: int) -> tuple[Array, Array]:
    """Pose ``index`` of a check once more: it depends on the arm, the seed and the index alone.

    Args:
        arm: the arm that was checked.
        seed: the report's seed.
        index: the row's index.

    Returns:
        The planted joint vector (n,) [rad or m] and Pinocchio's pose for it, (4, 4) [m].
    """
    q = _draw(arm.cell.reference, seed, index)
    return q, arm.cell.reference.pose(q)


def _draw(reference: Reference, seed: int, index: int) -> Array:
    """Joint vector (n,) of pose ``index``, within the limits or one turn."""
    lower, upper = reference.ranges.T
    q: Array = np.random.default_rng([seed, index]).uniform(lower, upper)
    return q


def _collision(arm: Arm, wanted: bool | None, most: int | None) -> tuple[_Collision | None, str]:
    """The comparison of collisions, or None and the reason why it is skipped."""
    if wanted is False:
        return None, "not asked for"
    from urdf_ik.cell import CollisionModel

    shapes = CollisionModel(arm.model, arm.base, arm.tip, locked=dict(arm.chain.locked))
    if not shapes.has_geometry:
        if wanted:
            raise UrdfError(shapes.missing, source=arm.model.source)
        return None, shapes.missing
    if not shapes.checked_pairs:
        return None, "no pair of links is left that must not touch"
    return _Collision(arm, shapes, most), ""


@dataclass(frozen=True)
class Row:
    """One property of an arm, held against Pinocchio.

    Attributes:
        name: the property.
        unit: unit of ``worst`` and ``tolerance``.
        worst: the worst value found, infinite where something was missing or not a number; a number of cases for the
            properties that are counted.
        tolerance: the most that is accepted; where it depends on the pose, that of the worst one.
        passed: whether every value was accepted.
        checked: how many values were compared.
        index: number of the pose in which the worst value, or the first counted case, was found; None where there is
            no such pose.
        q: joint vector (n,) [rad or m] at which it was found.
        detail: branch, link or joint that it belongs to, or what was missing.
    """

    name: str
    unit: str
    worst: float
    tolerance: float
    passed: bool
    checked: int
    index: int | None = None
    q: tuple[float, ...] | None = None
    detail: str = ""

    def place(self) -> str:
        """Where the worst value was found, in words."""
        parts = [
            "" if self.index is None else f"pose {self.index}",
            self.detail,
            "" if self.q is None else f"q = [{', '.join(map(repr, self.q))}]",
        ]
        return ", ".join(filter(None, parts))


@dataclass(frozen=True, repr=False)
class CrossCheck(Report):
    """An arm of this package against Pinocchio.

    Attributes:
        robot: the robot's name.
        base: base link.
        tip: tip link.
        joint_names: joints of a joint vector, base to tip.
        n: number of random poses.
        seed: seed of the joint vectors that made them.
        reference: name and version of the reference.
        rows: one a property.
        skipped: (property, reason) of what could not be checked.
        unlooked: what the time limit left out; '' where every pose was checked.
    """

    robot: str
    base: str
    tip: str
    joint_names: tuple[str, ...]
    n: int
    seed: int
    reference: str
    rows: tuple[Row, ...]
    skipped: tuple[tuple[str, str], ...] = ()
    unlooked: str = ""

    @property
    def failed(self) -> tuple[Row, ...]:
        """The rows that did not pass."""
        return tuple(row for row in self.rows if not row.passed)

    @property
    def faulty(self) -> bool:
        """Whether a property does not hold; ``skipped`` says what was not checked."""
        return bool(self.failed)

    def row(self, name: str) -> Row:
        """The row of a property.

        Raises:
            ArgumentError: there is no such row; the message lists the rows.
        """
        for row in self.rows:
            if row.name == name:
                return row
        raise ArgumentError(f"no row {name!r}; rows: {', '.join(row.name for row in self.rows)}")

    def title(self) -> str:
        """The arm, the poses and the reference."""
        poses = "1 random pose" if self.n == 1 else f"{self.n} random poses"
        return f"{self.robot}, {self.base} to {self.tip}: {poses}, seed {self.seed}, against {self.reference}"

    def sections(self) -> tuple[Section, ...]:
        """A table with a row a property."""
        header = ("property", "worst", "tolerance", "unit", "checked", "result")
        rows = tuple(
            (r.name, f"{r.worst:.2g}", f"{r.tolerance:.2g}", r.unit, str(r.checked), "passed" if r.passed else "FAILED")
            for r in self.rows
        )
        return (Section("", header, rows, left=("property", "unit", "result")),)

    def lines(self) -> tuple[str, ...]:
        """What was not checked, where each failure is, and how to replay it."""
        lines = [f"not checked: {name}: {reason}" for name, reason in self.skipped]
        lines += [f"FAILED {row.name}: {row.place() or 'at no particular pose'}" for row in self.failed]
        indices = [row.index for row in self.failed if row.index is not None]
        if indices:
            call = f"urdf_ik.verify.crosscheck.replay(arm, seed={self.seed}, index={indices[0]})"
            lines.append(f"replay: q, T = {call}")
        return tuple(lines)

    def summary(self) -> str:
        """How many properties hold."""
        return f"{sum(row.passed for row in self.rows)} of {len(self.rows)} properties hold"


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
class _Tally:
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


def _limits(arm: Arm, reference: Reference) -> _Tally:
    """Joint names in order, and limits."""
    tally = _Tally("joints and limits", "rad, m", 0.0)
    if tuple(arm.joint_names) != reference.joint_names:
        tally.add(np.inf, None, None, f"joints {', '.join(arm.joint_names)}, not {', '.join(reference.joint_names)}")
        return tally
    for name, ours, theirs in zip(reference.joint_names, np.asarray(arm.limits), reference.limits, strict=True):
        same = ours == theirs  # inf - inf would be no number
        tally.add(float(np.abs(np.where(same, 0.0, ours) - np.where(same, 0.0, theirs)).max()), None, None, name)
    if not reference.joint_names:  # both say that nothing moves
        tally.add(0.0, None, None)
    return tally


class _Kinematics:
    """Forward kinematics, Jacobian, the pose of every link; batch against single."""

    def __init__(self, arm: Arm, reference: Reference) -> None:
        self._arm, self._reference = arm, reference
        length = ROUNDING * max(1.0, reference.size)
        self._fk = (
            _Tally("forward kinematics, position", "m", length),
            _Tally("forward kinematics, rotation", "rad", ROUNDING),
        )
        self._jacobian = _Tally("Jacobian", "m, 1", length)
        self._links = _Tally("links, position", "m", length), _Tally("links, rotation", "rad", ROUNDING)
        self._single = _Tally("batch = single, kinematics", "m, 1", length)
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
        for link in sorted(set(ours) & set(theirs)):
            for tally, values in zip(self._links, _difference(np.asarray(ours[link]), theirs[link]), strict=True):
                worst = int(np.argmax(np.nan_to_num(values, nan=np.inf)))
                tally.checked += len(values) - 1
                tally.add(float(values[worst]), indices[worst], Q[worst], f"link {link!r}")
        for i, index in enumerate(indices):
            apart = max(np.abs(arm.fk(Q[i]) - F[i]).max(), np.abs(arm.jacobian(Q[i]) - J[i]).max(initial=0.0))
            self._single.add(float(apart), index, Q[i])


class _Inverse:
    """Every solution's error, the planted joint vector, duplicates; batch against single.

    Attributes:
        skipped: (property, reason) of what cannot be checked.
    """

    def __init__(self, arm: Arm, reference: Reference) -> None:
        self._arm, self._reference = arm, reference
        self._error = _Tally("solutions, position", "m", EXACT), _Tally("solutions, rotation", "rad", EXACT)
        self._planted = _Tally("planted joint vector", "rad, m", PLANTED)
        self._single = _Tally("batch = single, solutions", "rad, m", SAME)
        self._duplicates = _Tally("duplicates", "pairs", 0.0, counted=True)
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


class _Collision:
    """coal's shapes placed with the arm's link poses, against the same shapes placed by Pinocchio."""

    def __init__(self, arm: Arm, shapes: CollisionModel, most: int | None) -> None:
        self._arm, self._shapes = arm, shapes
        self._left = np.inf if most is None else most
        self._verdict = _Tally("collision, verdict", "cases", 0.0, counted=True)
        self._distance = _Tally("collision, distance", "m", CONTACT)
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
