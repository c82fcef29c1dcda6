"""Cross-checks of an arm with Pinocchio, over random poses and every branch."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from urdf_ik.arm import Arm
from urdf_ik.cell.pinocchio_reference import Reference, pose_errors
from urdf_ik.errors import ArgumentError, PoseError, UnsupportedArm, UrdfError
from urdf_ik.support import inputs
from urdf_ik.support.angles import difference, shortest
from urdf_ik.support.report import Report
from urdf_ik.support.text import Section
from urdf_ik.support.watch import Progress, Watch
from urdf_ik.typing import Array

if TYPE_CHECKING:
    from urdf_ik.cell import CollisionModel

COLLISION_POSES = 2000
"""Joint vectors whose collision is compared: a distance between meshes takes a millisecond."""

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

_SCALED, _COUNTED = "of the arm's size, if above 1 m", "cases"
_PROPERTIES: dict[str, tuple[str, float, str]] = {
    "joints and limits": ("rad, m", 0.0, ""),
    "forward kinematics, position": ("m", ROUNDING, _SCALED),
    "forward kinematics, rotation": ("rad", ROUNDING, ""),
    "Jacobian": ("m, 1", ROUNDING, _SCALED),
    "links, position": ("m", ROUNDING, _SCALED),
    "links, rotation": ("rad", ROUNDING, ""),
    "batch = single, kinematics": ("m, 1", ROUNDING, _SCALED),
    "solutions, position": ("m", EXACT, ""),
    "solutions, rotation": ("rad", EXACT, ""),
    "planted joint vector": ("rad, m", PLANTED, ""),
    "batch = single, solutions": ("rad, m", SAME, ""),
    "duplicates": ("pairs", 0.0, _COUNTED),
    "collision, verdict": ("cases", 0.0, _COUNTED),
    "collision, distance": ("m", CONTACT, ""),
}
PROPERTIES = tuple(_PROPERTIES)
"""The rows of a report, in order; it omits those that cannot be checked, and ``CrossCheck.skipped`` says why."""
_INVERSE, _COLLISION = PROPERTIES[7:12], PROPERTIES[12:]

_CHUNK = 256  # poses at a time: the link poses and solutions of all need not be in memory together


def check(
    arm: Arm,
    n: int = 200,
    seed: int = 0,
    collision: bool | None = None,
    *,
    time_limit: float | None = None,
    progress: Progress | None = None,
) -> "CrossCheck":
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
    n = inputs.poses(n)
    watch = Watch(time_limit, progress)
    reference, tallies = arm.cell.reference, _Tallies(arm)
    if tallies.joints():
        shapes = tallies.shapes(collision)
        left = COLLISION_POSES
        for part in watch.parts(n, _CHUNK):
            Q = np.array([_draw(reference, seed, index) for index in part])
            T = reference.pose(Q)
            tallies.kinematics(part, Q, T)
            solutions = tallies.inverse(part, Q, T)
            if shapes is not None:
                left -= tallies.collisions(part, Q, solutions, shapes, left)
    return CrossCheck(
        **PlantedReport.subject(arm, n, seed),
        # What time left nothing to compare of is no failure.
        rows=tuple(tally.row() for tally in tallies.of.values() if tally.checked or not watch.unlooked),
        skipped=tuple(tallies.skipped),
        unlooked=watch.unlooked,
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
    return np.asarray(np.random.default_rng([seed, index]).uniform(lower, upper))


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
        pose = "" if self.index is None else f"pose {self.index}"
        q = "" if self.q is None else f"q = [{', '.join(map(repr, self.q))}]"
        return ", ".join(filter(None, (pose, self.detail, q)))


@dataclass(frozen=True, repr=False)
class PlantedReport(Report):
    """A report on an arm at the poses that Pinocchio makes of drawn joint vectors."""

    robot: str
    base: str
    tip: str
    joint_names: tuple[str, ...]
    n: int
    seed: int
    reference: str

    @staticmethod
    def subject(arm: Arm, n: int, seed: int) -> dict[str, Any]:
        """These fields."""
        import pinocchio as pin

        fields = {name: getattr(arm.cell.reference, name) for name in ("base", "tip", "joint_names")}
        return {"robot": arm.name, **fields, "n": n, "seed": seed, "reference": f"Pinocchio {pin.__version__}"}


@dataclass(frozen=True, repr=False)
class CrossCheck(PlantedReport):
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
            self.q = None if q is None else tuple(map(float, q))
            self.worst = self.worst if self.counted else value

    def row(self) -> Row:
        """The report's row. Nothing compared is no pass."""
        worst = self.worst if self.checked else np.inf
        tolerance = self.tolerance if self.at_worst is None else self.at_worst
        detail = self.detail if self.checked else "nothing to compare"
        passed = self.passed and self.checked > 0
        return Row(self.name, self.unit, worst, tolerance, passed, self.checked, self.index, self.q, detail)


class _Tallies:
    """The properties of an arm, held against Pinocchio's model.

    Attributes:
        of: the tally of each property that is checked.
        skipped: (property, reason) of what cannot be checked.
    """

    def __init__(self, arm: Arm) -> None:
        self._arm, self._reference = arm, arm.cell.reference
        size = max(1.0, self._reference.size)
        self.of = {
            name: _Tally(name, unit, tolerance * (size if kind == _SCALED else 1.0), kind == _COUNTED)
            for name, (unit, tolerance, kind) in _PROPERTIES.items()
        }
        self.skipped: list[tuple[str, str]] = []

    def _skip(self, names: Sequence[str], what: str, reason: str) -> None:
        self.of = {name: tally for name, tally in self.of.items() if name not in names}
        self.skipped.append((what, reason))

    def joints(self) -> bool:
        """Compare joint names and limits; whether the joints are the same."""
        tally, ours, theirs = self.of["joints and limits"], tuple(self._arm.joint_names), self._reference.joint_names
        if ours != theirs:
            tally.add(np.inf, None, None, f"joints {', '.join(ours)}, not {', '.join(theirs)}")
            self._skip(PROPERTIES[1:], "all else", "the arm's joints are not Pinocchio's")
            return False
        for name, mine, other in zip(theirs, np.asarray(self._arm.limits), self._reference.limits, strict=True):
            same = mine == other  # inf - inf would be no number
            tally.add(float(np.abs(np.where(same, 0.0, mine) - np.where(same, 0.0, other)).max()), None, None, name)
        if not theirs:  # both say that nothing moves
            tally.add(0.0, None, None)
        # An arm with a redundancy parameter is asked for the planted vector's own value of it.
        if self._reference.dof > 6 and self._arm.redundancy is None:
            name, reason = "planted joint vector", f"with {len(theirs)} joints a pose has infinitely many solutions"
            self._skip([name], name, reason)
        return True

    def shapes(self, wanted: bool | None) -> "CollisionModel | None":
        """The shapes whose collision is compared; None where it is skipped."""
        from urdf_ik.cell import CollisionModel

        arm, reason = self._arm, "not asked for"
        if wanted is not False:
            shapes = CollisionModel(arm.model, arm.base, arm.tip, locked=dict(arm.chain.locked))
            if shapes.has_geometry and shapes.checked_pairs:
                return shapes
            if wanted and not shapes.has_geometry:
                raise UrdfError(shapes.missing, source=arm.model.source)
            reason = "no pair of links is left that must not touch" if shapes.has_geometry else shapes.missing
        self._skip(_COLLISION, "collision", reason)
        return None

    def kinematics(self, indices: Sequence[int], Q: Array, T: Array) -> None:
        """Forward kinematics, Jacobian and links at joint vectors Q (m, n), whose poses are T to Pinocchio."""
        arm, of = self._arm, self.of
        F, J = np.asarray(arm.fk(Q)), np.asarray(arm.jacobian(Q))
        off = np.abs(J - self._reference.jacobian(Q)).max(axis=(-2, -1), initial=0.0)
        for name, values in (*_pose_errors("forward kinematics", F, T), ("Jacobian", off)):
            for value, index, q in zip(values, indices, Q, strict=True):
                of[name].add(float(value), index, q)
        ours, theirs = arm.link_poses(Q), self._reference.link_poses(Q)
        for link in sorted(set(ours) | set(theirs)):
            if link not in ours or link not in theirs:
                for name in ("links, position", "links, rotation"):
                    what = "too many" if link in ours else "is missing"
                    of[name].add(np.inf, indices[0], Q[0], f"link {link!r} {what}")
                continue
            for name, values in _pose_errors("links", np.asarray(ours[link]), theirs[link]):
                worst = int(np.argmax(np.nan_to_num(values, nan=np.inf)))
                of[name].checked += len(values) - 1
                of[name].add(float(values[worst]), indices[worst], Q[worst], f"link {link!r}")
        for i, index in enumerate(indices):
            apart = max(np.abs(arm.fk(Q[i]) - F[i]).max(), np.abs(arm.jacobian(Q[i]) - J[i]).max(initial=0.0))
            of["batch = single, kinematics"].add(float(apart), index, Q[i])

    def inverse(self, indices: Sequence[int], Q: Array, T: Array) -> list[Array]:
        """Solve T (m, 4, 4), made of joint vectors Q (m, n); the solutions (k, n) of each pose."""
        if "duplicates" not in self.of:
            return [Q[:0] for _ in indices]
        try:
            own = None if self._arm.redundancy is None else self._arm.redundancy_of(Q)
            solutions = self._arm.ik(T, redundancy=own)
        except UnsupportedArm as error:
            self.skipped = [each for each in self.skipped if each[0] not in _INVERSE]
            self._skip(_INVERSE, "inverse kinematics", str(error))
            return [Q[:0] for _ in indices]
        q, valid, names, of = np.asarray(solutions.q), np.asarray(solutions.valid), solutions.branches, self.of
        errors = self._reference.errors(q, T[:, None])
        sigma = self._sigma_min(np.where(valid[..., None], q, np.nan))
        room = CONDITIONING / np.maximum(self._sigma_min(Q), 1e-300)
        for i, index in enumerate(indices):
            for b in np.flatnonzero(valid[i]).tolist():
                known = np.isfinite(q[i, b]).all()
                detail = f"branch {names[b]!r}" + ("" if known else ", marked valid, is not finite")
                for name, values in zip(_INVERSE[:2], errors, strict=True):
                    of[name].add(float(values[i, b]), index, q[i, b] if known else Q[i], detail)
            mine = q[i, valid[i]]
            if "planted joint vector" in of:
                far = float(self._apart(mine, Q[i]).min(initial=np.inf))
                detail = f"{len(mine)} solutions"
                of["planted joint vector"].add(far, index, Q[i], detail, PLANTED + float(room[i]))
            alone = self._arm.ik(T[i], redundancy=None if own is None else own[i])
            single, has = np.asarray(alone.q), np.asarray(alone.valid)
            for b in np.flatnonzero(valid[i] | has).tolist():
                both = valid[i, b] and has[b]
                where = "" if both else f" only in the {'batch' if valid[i, b] else 'single answer'}"
                apart = float(self._apart(single[b], q[i, b])) if both else np.inf
                tolerance = SAME + CONDITIONING / max(float(np.nan_to_num(sigma[i, b])), 1e-300)
                of["batch = single, solutions"].add(apart, index, Q[i], f"branch {names[b]!r}{where}", tolerance)
            gaps = self._apart(mine[:, None], mine[None])
            doubled = int(np.count_nonzero(np.triu(gaps < DUPLICATE, k=1)))
            of["duplicates"].add(doubled, index, Q[i], f"{doubled} of its pairs" if doubled else "")
        return [q[i, valid[i]] for i in range(len(indices))]

    def collisions(
        self, indices: Sequence[int], Q: Array, solutions: Sequence[Array], shapes: "CollisionModel", most: int
    ) -> int:
        """Coal's shapes placed with the arm's link poses, against the same shapes placed by Pinocchio."""
        verdict, distance = (self.of[name] for name in _COLLISION)
        every = [(index, q) for i, index in enumerate(indices) for q in (Q[i], *solutions[i]) if np.isfinite(q).all()]
        every = every[:most]
        for index, q in every:
            poses = self._arm.link_poses(q)
            theirs, hit = float(shapes.distance(q)), bool(shapes.in_collision(q))
            try:
                ours = shapes.distance_with(poses)
            except PoseError as error:
                distance.add(np.inf, index, q, str(error))
                verdict.add(1, index, q, str(error))
                continue
            nearest = shapes.nearest_pair(q)
            apart = 0.0 if ours == theirs else abs(ours - theirs)  # both infinite: no pair is checked
            distance.add(apart, index, q, "" if nearest is None else " and ".join(nearest.links))
            # Where shapes touch to within coal's own tolerance, either verdict is right.
            differ = hit != (ours == 0.0) and not max(ours, theirs) <= CONTACT
            verdict.add(int(differ), index, q, ", ".join(map(" and ".join, shapes.colliding_pairs(q))))
        return len(every)

    def _apart(self, a: Array, b: Array) -> Array:
        """Largest difference (...) [rad or m] between joint vectors (..., n)."""
        return np.asarray(np.abs(difference(a, b, self._reference.prismatic)).max(axis=-1, initial=0.0))

    def _sigma_min(self, Q: Array) -> Array:
        """Smallest singular value (...) of the Jacobian at Q (..., n), its linear rows over the arm's size."""
        J = self._reference.jacobian(Q)
        J[..., :3, :] /= max(self._reference.size, 1e-300)
        out = np.full(Q.shape[:-1], np.nan)
        known = np.isfinite(Q).all(axis=-1)
        J, q = J[known], Q[known]
        if self._arm.redundancy is not None:
            step = 1e-6 * np.eye(Q.shape[-1])
            ahead, behind = (self._arm.redundancy_of(q[:, None] + side * step) for side in (1.0, -1.0))
            gradient = (shortest(ahead - behind) / 2e-6).reshape(len(q), Q.shape[-1], -1).swapaxes(1, 2)
            J = np.concatenate([J, gradient], axis=-2)
        out[known] = np.linalg.svd(J, compute_uv=False)[..., -1]
        return out


def _pose_errors(what: str, ours: Array, theirs: Array) -> tuple[tuple[str, Array], tuple[str, Array]]:
    """Position [m] and rotation [rad] (...) between (..., 4, 4), where ours need not be a pose at all."""
    position, rotation = pose_errors(ours, theirs)
    # An angle does not see a stretched matrix, nor a bad last row.
    entries = np.abs(ours - theirs)
    entries[..., :3, 3] = 0.0
    return (f"{what}, position", position), (f"{what}, rotation", np.maximum(rotation, entries.max(axis=(-2, -1))))
