"""Baselines: an arm's answers in a lock file, and the check of a later arm against them.

>>> import urdf_ik
>>> lock = urdf_ik.freeze(urdf_ik.load("planar_2r"))
>>> lock.verify(urdf_ik.load("planar_2r")).passed
True
"""

import json
import math
import os
from collections.abc import Iterable, Iterator
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from scipy.optimize import linear_sum_assignment

from urdf_ik.arm import Arm
from urdf_ik.cell.pinocchio_reference import Reference
from urdf_ik.errors import ArgumentError, UnsupportedArm
from urdf_ik.model.catalogue import Origin, origin_of
from urdf_ik.model.poses import as_pose_array, check_poses
from urdf_ik.support import files
from urdf_ik.support.angles import difference, shortest
from urdf_ik.support.report import Report, from_plain
from urdf_ik.support.text import counted, plain
from urdf_ik.support.tolerances import DEFAULT as SOLVERS
from urdf_ik.support.watch import Progress, Watch
from urdf_ik.typing import Array
from urdf_ik.verify import sampling
from urdf_ik.verify.crosscheck import CONDITIONING, PLANTED
from urdf_ik.verify.description import Description, described, from_dict, matrix, parameters_of
from urdf_ik.verify.differences import (
    DEFAULT,
    Difference,
    Tolerance,
    apart,
    differences,
    greatest_change,
    ignored,
    moved,
    order_of,
    summed,
)
from urdf_ik.verify.sampling import AT_ONCE, Answer, Planted, Pose, least_singular_value
from urdf_ik.version import __version__

FORMAT, VERSION = "urdf-ik lock", 1

ENDING = ".lock.json"
"""Of the name of a lock file."""

SIZE = 200_000
"""Bytes that a lock file has at most, unless the poses of its user need more."""

LOOSEST = 1e-2
"""Joint values [rad or m] further apart than this are no rounding, however near a singularity."""

ONE_BRANCH = 0.5
"""Solutions nearer to each other than this [rad or m] are one that moved; beyond it one is lost and one gained."""

LIMIT_MARGIN = 1e-6
"""Distance [rad or m] from a limit below which rounding says on which side of it a solution is."""

FOLD = 1e-12
"""Square of the smallest singular value below which rounding of the pose decides whether a solution is there."""

_SEED = 20_260_101
_MOST_SHOWN = 6


def lock_beside(robot: str | os.PathLike[str], folder: str | os.PathLike[str] | None = None) -> Path:
    """The lock file of a robot's file or name: NAME.lock.json in a folder, else beside the file."""
    path = Path(robot)
    name = path.name.partition(".")[0] + ENDING
    return path.with_name(name) if folder is None else Path(folder) / name


def freeze(arm: Arm, poses: Any = None, *, collisions: str | bool = True, progress: Progress | None = None) -> "Lock":
    """An arm's answers of today, to be compared with those of tomorrow.

    Kept are joints, axes, limits, shapes, Pinocchio's pose at 20 joint vectors, and every solution of 50 poses: random
    ones, joints at round angles, near limits and near singularities.

    Args:
        arm: the arm.
        poses: (..., 4, 4) m, poses of your own, which are kept as well.
        collisions: whether to keep which solutions touch something: True where the shapes can be read, with a warning
            where they cannot; 'require' to fail there; False: no.
        progress: called with (poses done, poses).

    Returns:
        The baseline; ``save`` writes it to a lock file.

    Raises:
        PoseError: one of ``poses`` is no pose.
        UrdfError: ``collisions="require"``, and not all shapes can be read.
        ArgumentError: ``collisions`` is none of these.

    Example:
        >>> import urdf_ik
        >>> lock = freeze(urdf_ik.load("planar_2r"))
        >>> len(lock.planted), sorted({pose.kind for pose in lock.poses})
        (20, ['near limits', 'near singularity', 'random', 'round'])
    """
    rng, reference = np.random.default_rng(_SEED), arm.cell.reference
    own = np.zeros((0, 4, 4)) if poses is None else check_poses(as_pose_array(poses)).reshape(-1, 4, 4)
    shapes, unchecked = arm.cell.to_check(collisions)
    planted = sampling.planted_vectors(reference, rng)
    vectors = {kind: sampling.drawn_vectors(arm, kind, rng, count) for kind, count in sampling.COUNTS.items()}
    import pinocchio as pin  # arms are loaded and described without it

    made_by = (("pinocchio", str(pin.__version__)), ("urdf-ik", __version__))
    origin = origin_of(arm.model.path, arm.model.sha256)
    baseline = Lock(described(arm), planted, (), unchecked and f"not checked: {unchecked}", made_by, origin)
    asked = [(kind, reference.pose(q), sampling.redundancy_at(arm, q)) for kind, q in vectors.items()]
    watch, total = Watch(None, progress), len(own) + sum(len(T) for _, T, _ in asked)
    solved: list[Pose] = []
    try:
        for kind, T, values in (*asked, ("own", own, None)):
            solved += sampling.answered(arm, kind, T, values, shapes)
            watch.step(len(solved), total)
    except UnsupportedArm:
        if len(own):
            raise
        return baseline
    kept, mine = solved[: total - len(own)], solved[total - len(own) :]
    baseline = replace(baseline, poses=tuple(kept))
    while (size := len(baseline.to_text())) > SIZE and len(kept) > len(sampling.COUNTS):
        # Every kind keeps its share.
        kept = kept[:: max(2, size // SIZE)]
        baseline = replace(baseline, poses=tuple(kept))
    return replace(baseline, poses=(*baseline.poses, *mine))


@dataclass(frozen=True)
class Lock:
    """An arm and its answers as they were: what :func:`urdf_ik.freeze` makes and a lock file holds.

    Attributes:
        arm: the arm.
        planted: joint vectors with Pinocchio's pose for each.
        poses: poses with every solution; () where no solver takes the arm.
        contacts: '' where contacts were checked, else why not.
        made_by: versions of the packages that computed it.
        origin: package, repository, commit and file of a robot that has a name; None for a file.

    Example:
        >>> import urdf_ik
        >>> lock = urdf_ik.freeze(urdf_ik.load("planar_2r"))
        >>> lock
        <Lock of planar_2r, base_link to tool0: 50 poses, ... solutions>
        >>> lock.save("arm.lock.json")
        >>> Lock.load("arm.lock.json") == lock
        True
    """

    arm: Description
    planted: tuple[Planted, ...]
    poses: tuple[Pose, ...]
    contacts: str = ""
    made_by: tuple[tuple[str, str], ...] = ()
    origin: Origin | None = None

    def __repr__(self) -> str:
        count = _count(self.poses)
        contacts = f", contacts {self.contacts}" if self.contacts else ""
        return f"<Lock of {self.arm.title}: {len(self.poses)} poses, {count} solutions{contacts}>"

    def verify(
        self,
        arm: Arm,
        *,
        tolerance_mm: float | None = None,
        tolerance_deg: float | None = None,
        ignore: str | Iterable[str] = (),
        time_limit: float | None = None,
        progress: Progress | None = None,
    ) -> "Verification":
        """What of this holds for an arm.

        Solutions are compared as sets: a solver that orders or names them in another way is no difference; a solution
        that is lost or gained is one.

        Args:
            arm: the arm of today.
            tolerance_mm: lengths [mm] up to which a change counts as none; default: 1e-6.
            tolerance_deg: angles [deg], likewise; default: 6e-8.
            ignore: kinds of differences that do not count: 'limits', 'collisions', 'visuals', 'names'.
            time_limit: s after which no more poses are solved; what was left out did not pass.
            progress: called with (poses done, poses).

        Raises:
            ArgumentError: a tolerance is negative, or a kind cannot be ignored.
            ArgumentError: ``time_limit`` is no number of seconds.

        Example:
            >>> import urdf_ik
            >>> lock = urdf_ik.freeze(urdf_ik.load("planar_2r"))
            >>> print(lock.verify(urdf_ik.load("planar_2r_unit"), ignore="collisions,visuals").differences[0])
            joint_2: its origin moved by 934 mm
        """
        watch = Watch(time_limit, progress)
        tolerance, skipped = Tolerance.read(tolerance_mm, tolerance_deg), ignored(ignore)
        then, now, notes = self.arm, described(arm), []
        differing = list(differences(then, now, tolerance))
        for what, was, today in (("family", then.family, now.family), ("robot's name", then.robot, now.robot)):
            if was != today:
                notes.append(f"the {what} was {was or 'none'}, and is {today or 'none'}")
        if self.origin is not None and self.origin.sha256 != arm.model.sha256:
            source = origin_of(arm.model.path, arm.model.sha256) or arm.model.source
            notes.append(f"the file was {self.origin}, and is {source}")
        solved: dict[int, Pose] = {}
        if then.dof != now.dof or then.sliding != now.sliding:
            notes.append("forward kinematics and solutions were not compared: the joints are others")
        else:
            order = order_of(then, now)
            differing += _planted(self, arm.cell.reference, order, tolerance)
            try:
                solved = _solved_today(self, arm, order, "collisions" in skipped, notes, watch)
            except UnsupportedArm as error:
                if self.poses:
                    differing.append(Difference("solutions", "", f"the arm cannot be solved any more: {error}"))
            differing += _solutions(self, solved, arm, order, tolerance, notes)
        unlooked = ""
        if watch.is_over and len(solved) < len(self.poses):
            unlooked = watch.ended(f"with {len(solved)} of {len(self.poses)} poses: the others were")
        before = [self.poses[index] for index in solved]
        return Verification(
            arm=now,
            frozen=then,
            differences=tuple(difference for difference in differing if difference.kind not in skipped),
            ignored=tuple(difference for difference in differing if difference.kind in skipped),
            notes=tuple(notes),
            poses=len(solved),
            solutions=(_count(before), _count(solved.values())),
            unlooked=unlooked,
        )

    def to_text(self) -> str:
        """The text of a lock file: one pose a line, sorted keys, numbers that read back exactly."""
        content = plain(asdict(self))
        for pose in content["poses"]:
            pose["solutions"] = pose.pop("answers")
        content |= {"contacts": self.contacts or "checked", "made_by": dict(self.made_by)}
        content |= {"format": FORMAT, "version": VERSION}
        if not self.origin:
            del content["origin"]
        return _lines(content) + "\n"

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the lock file.

        Raises:
            ArgumentError: it cannot be written.
        """
        files.write(path, self.to_text().encode())

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> "Lock":
        """Read a lock file.

        Raises:
            ArgumentError: it cannot be read, is no lock file, or one of a version that this release does not know.
        """
        return cls.from_text(files.read(path).decode("utf-8", "replace"), files.name_of(path))

    @classmethod
    def from_text(cls, text: str, name: str = "the text") -> "Lock":
        """The baseline of a lock file's text.

        Raises:
            ArgumentError: it is not the text of a lock file; the message calls it ``name``.
        """
        hint = "urdf-ik freeze writes one"
        data = files.document(text, FORMAT, VERSION, lambda problem: ArgumentError(f"{name} is {problem}; {hint}"))
        try:
            arm = from_dict(data["arm"])
            poses = [{**pose, "answers": pose["solutions"]} for pose in data["poses"]]
            made_by = sorted((key, str(value)) for key, value in data["made_by"].items())
            contacts = "" if data["contacts"] == "checked" else data["contacts"]
            planted = from_plain(tuple[Planted, ...], data["planted"], "planted")
            solved = from_plain(tuple[Pose, ...], poses, "poses")
            origin = from_plain(Origin | None, data.get("origin"), "origin")
            baseline = cls(arm, planted, solved, str(contacts), tuple(made_by), origin)
            baseline._require_complete()
        except (KeyError, TypeError, ValueError, AttributeError, OverflowError) as error:
            reason = f"{type(error).__name__} {error}"
            raise ArgumentError(f"{name} is a damaged lock file: {reason}; {hint} anew") from None
        return baseline

    def _require_complete(self) -> None:
        """Raise ValueError unless every row has its numbers and every pose its kind."""
        n = self.arm.dof
        rows = [(f"planted[{k}].q", planted.q, n) for k, planted in enumerate(self.planted)]
        rows += [(f"planted[{k}].T", planted.T, 12) for k, planted in enumerate(self.planted)]
        for k, pose in enumerate(self.poses):
            rows += [(f"poses[{k}].T", pose.T, 12), (f"poses[{k}].redundancy", pose.redundancy, len(pose.redundancy))]
            rows += [(f"poses[{k}].solutions[{i}].q", answer.q, n) for i, answer in enumerate(pose.answers)]
        for name, row, width in rows:
            if len(row) != width or not all(map(math.isfinite, row)):
                raise ValueError(f"{name}: {width} finite numbers are needed")
        for kind in (*(planted.kind for planted in self.planted), *(pose.kind for pose in self.poses)):
            if kind not in sampling.KINDS:
                raise ValueError(f"no kind of pose: {kind!r}")


def _lines(value: Any, indent: str = "\n") -> str:
    """JSON with sorted keys: a line for each entry of the upper levels, and for each element of a list of entries."""
    inner = indent + " "
    if isinstance(value, dict):
        parts = [f"{json.dumps(key)}: {_lines(value[key], inner)}" for key in sorted(value)]
        return "{" + inner + ("," + inner).join(parts) + indent + "}" if parts else "{}"
    if isinstance(value, list) and any(isinstance(entry, dict | list) for entry in value):
        parts = [json.dumps(entry, sort_keys=True, allow_nan=False) for entry in value]
        return "[" + inner + ("," + inner).join(parts) + indent + "]"
    return json.dumps(value, allow_nan=False)


@dataclass(frozen=True, repr=False)
class Verification(Report):
    """The result of verifying an arm against a baseline.

    Attributes:
        arm: the arm that was verified.
        frozen: the arm of the baseline.
        differences: the differences that count.
        ignored: the differences that the caller ignores.
        notes: parts that were not compared, and harmless differences such as the name of a family.
        poses: number of poses that were compared.
        solutions: number of solutions, then and now.
        unlooked: what the time limit left out; '' where every pose was compared.
    """

    arm: Description
    frozen: Description
    differences: tuple[Difference, ...]
    ignored: tuple[Difference, ...]
    notes: tuple[str, ...]
    poses: int
    solutions: tuple[int, int]
    unlooked: str = ""

    @property
    def faulty(self) -> bool:
        """Whether there is a difference that counts."""
        return bool(self.differences)

    def title(self) -> str:
        """The names of the compared sides."""
        return f"{self.arm.title}, against its lock"

    def lines(self) -> tuple[str, ...]:
        """Every difference and note, a line each."""
        lines = [*summed(self.differences), *(f"ignored: {difference}" for difference in self.ignored)]
        lines += [f"note: {note}" for note in self.notes]
        return (*lines, *replays(self.differences))

    def summary(self) -> str:
        """The number of differences, poses and solutions."""
        count, (then, now) = len(self.differences), self.solutions
        words = counted(count, "difference") if count else "no difference"
        return f"{words}; {self.poses} poses, {then} solutions then, {now} now"


def _count(poses: Iterable[Pose]) -> int:
    return sum(len(pose.answers) for pose in poses)


def replays(differing: Iterable[Difference]) -> tuple[str, ...]:
    """Lines that say how to see the differences again."""
    return tuple(dict.fromkeys(f"replay: {difference.replay}" for difference in differing if difference.replay))


def _planted(baseline: Lock, reference: Reference, order: tuple[int, ...], tolerance: Tolerance) -> list[Difference]:
    """Pinocchio's poses at the baseline's joint vectors, the worst one."""
    worst = (0.0, 0.0, 0.0, -1)
    # Small changes of every joint add up.
    longest = tolerance.distance * (1.0 + reference.dof) * max(1.0, reference.size)
    for index, planted in enumerate(baseline.planted):
        distance, angle = apart(matrix(planted.T), reference.pose(np.array(planted.q)[np.argsort(order)]))
        if distance > longest or angle > tolerance.angle * (1 + len(order)):
            worst = max(worst, (distance / DEFAULT.distance + angle / DEFAULT.angle, distance, angle, index))
    _, distance, angle, index = worst
    if index < 0:
        return []
    name = f"forward kinematics, {baseline.arm.tip}"
    q = baseline.planted[index].q
    vector = f"lock.planted[{index}].q" if list(order) == sorted(order) else [q[k] for k in np.argsort(order)]
    replay = f"arm.fk({vector})  # the lock has lock.planted[{index}].T, its upper three rows"
    return [Difference("kinematics", name, f"{moved(distance, angle)} at most", distance, angle, replay)]


def _solved_today(
    baseline: Lock, arm: Arm, order: tuple[int, ...], no_contacts: bool, notes: list[str], watch: Watch
) -> dict[int, Pose]:
    """Today's answers to the poses of the baseline by their numbers, joints in its order; as many as time allows."""
    shapes = None
    if baseline.contacts:
        notes.append(f"contacts were {baseline.contacts} when the lock was made")
    elif not no_contacts:
        shapes, unchecked = arm.cell.to_check(True)
        notes += [f"contacts not checked: {unchecked}"] if unchecked else []
    out: dict[int, Pose] = {}
    for with_values in (False, True):
        indices = [k for k, pose in enumerate(baseline.poses) if bool(pose.redundancy) == with_values]
        if indices and with_values and baseline.arm.redundancy != parameters_of(arm):
            notes.append(
                f"{len(indices)} poses were not solved: the redundancy parameters were "
                f"{', '.join(baseline.arm.redundancy)}, and are {', '.join(parameters_of(arm)) or 'none'}"
            )
            # A pose that was not solved is as it was.
            out |= {index: baseline.poses[index] for index in indices}
            continue
        for start in range(0, 0 if watch.is_over else len(indices), AT_ONCE):
            part = [baseline.poses[index] for index in indices[start : start + AT_ONCE]]
            values = np.array([pose.redundancy for pose in part]) if with_values else None
            values = values[:, 0] if values is not None and values.shape[1] == 1 else values
            solved = sampling.answered(arm, "random", np.array([pose.matrix for pose in part]), values, shapes)
            for index, then, now in zip(indices[start:], part, solved, strict=False):
                answers = tuple(replace(each, q=tuple(each.q[k] for k in order)) for each in now.answers)
                out[index] = replace(now, kind=then.kind, answers=answers)
            watch.step(len(out), len(baseline.poses))
            if watch.is_over:
                break
    return dict(sorted(out.items()))


_WORDS = {
    "lost": ("solutions", "lost"),
    "gained": ("solutions", "gained"),
    "limits": ("limits", "in limits or not has changed"),
    "contacts": ("collisions", "contacts have changed"),
}
"""Kind and words of what is different at a pose."""


def _solutions(
    baseline: Lock, today: dict[int, Pose], arm: Arm, order: tuple[int, ...], tolerance: Tolerance, notes: list[str]
) -> list[Difference]:
    """Differences of the solutions at the poses that were solved today; notes say what was not counted."""
    changes = {(what, counts): list[tuple[int, str]]() for counts in (True, False) for what in _WORDS}
    near = f"the tolerance of {tolerance.distance * 1e3:g} mm and {math.degrees(tolerance.angle):.2g} deg"
    near = "rounding" if tolerance == DEFAULT else near
    moves: list[tuple[float, int, int]] = []
    own = described(arm, shapes=False)
    distance, angle = greatest_change(baseline.arm, own)
    # Another limit, a tolerated one too, explains what is inside the limits or not.
    limited = tuple(own.limits[k] for k in order) != baseline.arm.limits
    size = max(arm.cell.reference.size, 1e-300)
    change = min(distance, tolerance.distance) / size + min(angle, tolerance.angle)
    for index, now in today.items():
        then = baseline.poses[index]
        same = _Same(arm, order, then.matrix, change, np.array(baseline.arm.limits))
        for what, branch, counts in same.changes(then, now, index, moves):
            changes[what, counts].append((index, branch))
    out = []
    for (what, counts), places in changes.items():
        if what == "limits" and counts and moves:
            gap, index, joint = max(moves)
            name, slides = baseline.arm.joint_names[joint], baseline.arm.joint_types[joint] == "prismatic"
            far = f"{gap * 1e3:.4g} mm" if slides else f"{math.degrees(gap):.4g} deg"
            words = f"{len(moves)} solutions have other joint values, {name} by up to {far} at pose {index}"
            sizes = (gap, 0.0) if slides else (0.0, gap)
            out.append(Difference("solutions", "", words, *sizes, replay=_replay(index)))
        if places and not counts:
            notes.append(f"{what}, not counted, being within {near} of a singularity: {_places(places)}")
        elif places:
            kind, words = _WORDS[what]
            kind = kind if what != "limits" or limited else "solutions"
            out.append(Difference(kind, "", f"{words}: {_places(places)}", replay=_replay(places[0][0])))
    return out


def _replay(index: int) -> str:
    return f"arm.ik(lock.poses[{index}].matrix)  # the lock has lock.poses[{index}].answers"


def _places(places: list[tuple[int, str]]) -> str:
    """How many at which poses, branch by branch."""
    branches: dict[str, list[int]] = {}
    for index, branch in places:
        branches.setdefault(branch, []).append(index)
    parts = []
    for branch, indices in list(branches.items())[:_MOST_SHOWN]:
        shown = ", ".join(map(str, sorted(set(indices))[:_MOST_SHOWN]))
        parts.append(f"{branch!r} at pose {shown}{', ...' if len(indices) > _MOST_SHOWN else ''}")
    parts += [f"and {len(branches) - _MOST_SHOWN} branches more"] if len(branches) > _MOST_SHOWN else []
    return f"{counted(len(places), 'solution')}, {'; '.join(parts)}"


@dataclass
class _Same:
    """Whether two solutions of a pose are one, to what rounding and a tolerated change of the arm leave.

    Attributes:
        arm: the arm of today.
        order: its joints in the order of the baseline's.
        T: (4, 4) m, the pose.
        change: tolerated change of the arm [rad, share of its size].
        limits: (n, 2) rad or m, of the baseline's arm.
    """

    arm: Arm
    order: tuple[int, ...]
    T: Array
    change: float
    limits: Array

    def changes(
        self, then: Pose, now: Pose, index: int, moves: list[tuple[float, int, int]]
    ) -> Iterator[tuple[str, str, bool]]:
        """Pair the solutions of a pose, and tell what is different, in which branch, and whether it counts."""
        before, after, paired = list(then.answers), list(now.answers), dict[int, int]()
        if before and after:
            gaps = np.abs(self._step(then.q[:, None], now.q[None]))
            far, room = gaps.max(axis=-1), self._room(then.q)
            for i, k in zip(*(each.tolist() for each in linear_sum_assignment(np.minimum(far, 1e6))), strict=True):
                free = before[i].singular and after[k].singular
                if far[i, k] > ONE_BRANCH and not free:
                    continue
                paired[i] = k
                near = far[i, k] <= room[i] or free or self._is_fragile(then.q[i])
                if not near and not self._one_root(then.q[i], now.q[k]):
                    moves.append((float(far[i, k]), index, int(np.argmax(gaps[i, k]))))
        alone = [("lost", a, now) for i, a in enumerate(before) if i not in paired]
        alone += [("gained", a, then) for k, a in enumerate(after) if k not in set(paired.values())]
        for what, answer, others in alone:
            yield what, answer.branch, self._is_missed(answer, others)
        for i, k in paired.items():
            old, new, gap = before[i], after[k], np.array(before[i].q)[:, None] - self.limits
            # Beside a limit, modulo full turns, rounding decides.
            turned = np.abs(shortest(np.where(np.isfinite(gap), gap, np.pi)))
            beside = np.minimum(np.abs(gap), turned).min(initial=np.inf) <= max(room[i], LIMIT_MARGIN)
            if old.within_limits != new.within_limits and not beside:
                yield "limits", old.branch, True
            if None not in (old.contact, new.contact) and old.contact != new.contact:
                yield "contacts", old.branch, True

    def _is_missed(self, answer: Answer, others: Pose) -> bool:
        """Whether a solution without an equal among the others is a difference."""
        q = np.array(answer.q)
        if self._is_fragile(q):
            return False
        if not others.answers:
            return True
        near = np.abs(self._step(q[None], others.q)).max(axis=-1)
        if any(self._one_root(q, others.q[k]) for k in np.flatnonzero(near < LOOSEST)):
            return False
        return not (answer.singular and any(other.singular for other in others.answers))

    def _step(self, q: Array, other: Array) -> Array:
        """Q less other (..., n), angles on the circle."""
        return difference(q, other, self.arm.cell.reference.prismatic[list(self.order)])

    def _room(self, q: Array) -> Array:
        """How far apart (k,) [rad or m] two answers near q (k, n) may be, and still be one."""
        sigma = self._sigma_min(q)
        out: Array = np.minimum(CONDITIONING / sigma, LOOSEST) + np.minimum(10.0 * self.change / sigma, ONE_BRANCH)
        return out + PLANTED

    def _is_fragile(self, q: Array) -> bool:
        """Whether the change, or rounding, may join a solution (n,) with another one, so that both are gone."""
        return bool(self._sigma_min(q[None])[0] ** 2 <= 10.0 * self.change + FOLD)

    def _sigma_min(self, q: Array) -> Array:
        """Smallest singular value (k,) of the Jacobian at q (k, n), lengths as shares of the arm's size."""
        return np.maximum(least_singular_value(self.arm, q[..., np.argsort(self.order)]), 1e-300)

    def _one_root(self, q: Array, other: Array) -> bool:
        """Whether the arm is in the pose half way between two joint vectors (n,): one double root."""
        reference = self.arm.cell.reference
        half = other + 0.5 * self._step(q, other)
        position, rotation = reference.error(half[np.argsort(self.order)], self.T)
        return max(position / max(reference.size, 1e-300), rotation) <= 1e2 * SOLVERS.fold
