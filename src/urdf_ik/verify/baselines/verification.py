"""verify(): compares an arm with a baseline, and reports moved frames, vanished branches and the poses."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import linear_sum_assignment

from urdf_ik.arm import Arm
from urdf_ik.cell import CollisionModel
from urdf_ik.cell.pinocchio_reference import Reference
from urdf_ik.errors import UnsupportedArm, printable
from urdf_ik.support import inputs
from urdf_ik.support.angles import shortest
from urdf_ik.support.tolerances import DEFAULT as SOLVERS
from urdf_ik.support.watch import Progress, Watch
from urdf_ik.typing import Array
from urdf_ik.verify import arms
from urdf_ik.verify.baselines.pose_sampling import AT_ONCE, answered, least_singular_value
from urdf_ik.verify.baselines.records import Answer, Pose, Recorded
from urdf_ik.verify.change import DEFAULT, Difference, Tolerance, apart, ignored, moved, summed
from urdf_ik.verify.change_search import differences, greatest_change, order_of
from urdf_ik.verify.crosscheck.properties import CONDITIONING, PLANTED
from urdf_ik.verify.description import Description, described, matrix
from urdf_ik.verify.reports import Report, outcome

LOOSEST = 1e-2
"""Joint values [rad or m] further apart than this are no rounding, however near a singularity."""

ONE_BRANCH = 0.5
"""Solutions nearer to each other than this [rad or m] are one that moved; beyond it one is lost and one gained."""

LIMIT_MARGIN = 1e-6
"""Distance [rad or m] from a limit below which rounding says on which side of it a solution is."""

FOLD = 1e-12
"""Square of the smallest singular value below which rounding of the pose decides whether a solution is there."""

_MOST_PLACES = 6


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
    def passed(self) -> bool:
        """Whether there is no difference that counts, and nothing was left out for want of time."""
        return not self.differences and not self.unlooked

    def title(self) -> str:
        """The names of the compared sides.

        Example:
            >>> import urdf_ik
            >>> arm = urdf_ik.load("planar_2r")
            >>> urdf_ik.freeze(arm).verify(arm).title()
            'planar_2r, base_link to tool0, against its lock'
        """
        return f"{self.arm.title}, against its lock"

    def lines(self) -> tuple[str, ...]:
        """Every difference and note, a line each.

        Example:
            >>> import urdf_ik
            >>> arm = urdf_ik.load("planar_2r")
            >>> urdf_ik.freeze(arm).verify(arm).lines()
            ()
        """
        out = list(summed(self.differences))
        out += [f"ignored: {each}" for each in self.ignored]
        out += [f"note: {each}" for each in self.notes]
        out += list(dict.fromkeys(f"replay: {each.replay}" for each in self.differences if each.replay))
        return tuple(out)

    def verdict(self) -> str:
        """The last line.

        Example:
            >>> import urdf_ik
            >>> arm = urdf_ik.load("planar_2r")
            >>> urdf_ik.freeze(arm).verify(arm).verdict().split(';')[0]
            'PASSED: no difference'
        """
        count = len(self.differences)
        found = f"{count} difference{'' if count == 1 else 's'}" if count else "no difference"
        then, now = self.solutions
        ended, left_out = outcome(self.passed, bool(self.differences)), f"; {self.unlooked}" if self.unlooked else ""
        return f"{ended}: {found}; {self.poses} poses, {then} solutions then, {now} now{left_out}"


def verify(
    baseline: Recorded,
    arm: Arm,
    *,
    tolerance_mm: float | None = None,
    tolerance_deg: float | None = None,
    ignore: str | Iterable[str] = (),
    time_limit: float | None = None,
    progress: Progress | None = None,
) -> Verification:
    """See :meth:`urdf_ik.verify.baselines.Baseline.verify`."""
    inputs.arm(arm)
    watch = Watch(time_limit, progress)
    tolerance, skipped = Tolerance.read(tolerance_mm, tolerance_deg), ignored(ignore)
    then, now = baseline.arm, described(arm)
    found = list(differences(then, now, tolerance))
    notes = _notes(then, now)
    if baseline.unlooked:
        notes.append(f"making the lock was {baseline.unlooked}")
    today: dict[int, Pose] = {}
    if then.dof != now.dof or then.sliding != now.sliding:
        notes.append("forward kinematics and solutions were not compared: the joints are others")
    else:
        order = order_of(then, now)
        reference = arms.reference_of(arm)
        found += _planted(baseline, reference, order, tolerance)
        try:
            today = _answers(baseline, arm, order, "collisions" in skipped, notes, watch)
        except UnsupportedArm as error:
            if baseline.poses:
                found.append(Difference("solutions", "", f"the arm cannot be solved any more: {printable(error, 300)}"))
        else:
            distance, angle = greatest_change(then, now)
            size = max(reference.size, 1e-300)
            change = min(distance, tolerance.distance) / size + min(angle, tolerance.angle)
            found += _solutions(baseline, today, arm, reference, order, change)
    unlooked = ""
    if watch.is_over and len(today) < len(baseline.poses):
        unlooked = watch.ended(f"with {len(today)} of {len(baseline.poses)} poses: the others were")
    return Verification(
        arm=now,
        frozen=then,
        differences=tuple(each for each in found if each.kind not in skipped),
        ignored=tuple(each for each in found if each.kind in skipped),
        notes=tuple(notes),
        poses=len(today),
        solutions=(
            sum(len(baseline.poses[index].answers) for index in today),
            sum(len(pose.answers) for pose in today.values()),
        ),
        unlooked=unlooked,
    )


def _notes(then: Description, now: Description) -> list[str]:
    out = []
    if then.family != now.family:
        out.append(f"the family was {then.family or 'none'}, and is {now.family or 'none'}")
    if then.robot != now.robot:
        out.append(f"the robot's name was {printable(then.robot)!r}, and is {printable(now.robot)!r}")
    return out


def _planted(
    baseline: Recorded, reference: Reference, order: tuple[int, ...], tolerance: Tolerance
) -> list[Difference]:
    """Pinocchio's poses at the baseline's joint vectors, the worst one."""
    worst = (-1.0, 0.0, 0.0, 0)
    for index, each in enumerate(baseline.planted):
        q = np.empty(len(order))
        q[list(order)] = each.q
        distance, angle = apart(matrix(each.T), reference.pose(q))
        if distance > tolerance.distance * _reach(reference) or angle > tolerance.angle * (1 + len(order)):
            rank = distance / DEFAULT.distance + angle / DEFAULT.angle
            worst = max(worst, (rank, distance, angle, index))
    if worst[0] < 0.0:
        return []
    _, distance, angle, index = worst
    name = f"forward kinematics, {baseline.arm.tip}"
    replay = f"lock.planted[{index}].q, at which the lock has the pose lock.planted[{index}].T"
    return [Difference("kinematics", name, f"{moved(distance, angle)} at most", distance, angle, replay)]


def _reach(reference: Reference) -> float:
    """By how much small changes of every joint add up."""
    return (1.0 + reference.dof) * max(1.0, reference.size)


def _answers(
    baseline: Recorded, arm: Arm, order: tuple[int, ...], no_contacts: bool, notes: list[str], watch: Watch
) -> dict[int, Pose]:
    """Today's answers to the poses of the baseline by their numbers, joints in its order; as many as time allows."""
    groups: dict[bool, list[int]] = {}
    for index, pose in enumerate(baseline.poses):
        groups.setdefault(bool(pose.redundancy), []).append(index)
    shapes = None
    if baseline.contacts:
        notes.append(f"contacts were {baseline.contacts} when the lock was made")
    elif not no_contacts:
        shapes, unchecked = arm.cell.to_check(True)
        notes += [f"contacts not checked: {unchecked}"] if unchecked else []
    out: dict[int, Pose] = {}
    for with_values, indices in groups.items():
        if with_values and baseline.arm.redundancy != arms.parameters_of(arm):
            notes.append(
                f"{len(indices)} poses were not solved: the redundancy parameters were "
                f"{', '.join(baseline.arm.redundancy)}, and are {', '.join(arms.parameters_of(arm)) or 'none'}"
            )
            # A pose that was not solved is as it was.
            out |= {index: baseline.poses[index] for index in indices}
            continue
        for start in range(0, len(indices), AT_ONCE):
            if watch.is_over:
                break
            some = indices[start : start + AT_ONCE]
            for index, pose in zip(some, _solved(baseline, arm, some, with_values, shapes), strict=True):
                answers = tuple(replace(each, q=tuple(each.q[k] for k in order)) for each in pose.answers)
                out[index] = replace(pose, kind=baseline.poses[index].kind, answers=answers)
            watch.step(len(out), len(baseline.poses))
    return out


def _solved(
    baseline: Recorded, arm: Arm, some: list[int], with_values: bool, shapes: CollisionModel | None
) -> list[Pose]:
    """Today's answers to some poses of the baseline, at the values of redundancy parameters that it has."""
    T, values = np.array([baseline.poses[index].matrix for index in some]), None
    if with_values:
        values = np.array([baseline.poses[index].redundancy for index in some])
        values = values[:, 0] if values.shape[1] == 1 else values
    return answered(arm, "random", T, arms.solutions_of(arm, T, values), values, shapes)


@dataclass
class _Found:
    """Differences found at the poses: places of lost, gained and moved solutions, changed limits and contacts."""

    lost: list[tuple[int, str]]
    gained: list[tuple[int, str]]
    moved: list[tuple[float, int, int]]
    limits: list[tuple[int, str]]
    contacts: list[tuple[int, str]]


def _solutions(
    baseline: Recorded,
    today: dict[int, Pose],
    arm: Arm,
    reference: Reference,
    order: tuple[int, ...],
    change: float,
) -> list[Difference]:
    """Differences of the solutions; ``change`` is the tolerated change of the arm [rad, share of its size]."""
    found = _Found([], [], [], [], [])
    for index, now in sorted(today.items()):
        then = baseline.poses[index]
        _compare(found, index, then, now, _Same(arm, reference, order, then.matrix, change), baseline.arm)
    out = []
    for what, places in (("lost", found.lost), ("gained", found.gained)):
        if places:
            out.append(Difference("solutions", "", f"{what}: {_places(places)}", replay=_replay(places[0][0])))
    if found.moved:
        gap, index, joint = max(found.moved)
        name = baseline.arm.joint_names[joint]
        slides = baseline.arm.joint_types[joint] == "prismatic"
        far = f"{gap * 1e3:.4g} mm" if slides else f"{math.degrees(gap):.4g} deg"
        words = f"{len(found.moved)} solutions have other joint values, {name} by up to {far} at pose {index}"
        sizes = (gap, 0.0) if slides else (0.0, gap)
        out.append(Difference("solutions", "", words, *sizes, replay=_replay(index)))
    if found.limits:
        words = f"in limits or not has changed: {_places(found.limits)}"
        out.append(Difference("limits", "", words, replay=_replay(found.limits[0][0])))
    if found.contacts:
        words = f"contacts have changed: {_places(found.contacts)}"
        out.append(Difference("collisions", "", words, replay=_replay(found.contacts[0][0])))
    return out


def _replay(index: int) -> str:
    return f"arm.ik(lock.poses[{index}].matrix), against lock.poses[{index}].answers"


def _places(places: list[tuple[int, str]]) -> str:
    """How many at which poses, branch by branch."""
    branches: dict[str, list[int]] = {}
    for index, branch in places:
        branches.setdefault(branch, []).append(index)
    parts = []
    for branch, indices in list(branches.items())[:_MOST_PLACES]:
        shown = ", ".join(map(str, sorted(set(indices))[:_MOST_PLACES])) + (
            ", ..." if len(indices) > _MOST_PLACES else ""
        )
        parts.append(f"{branch!r} at pose {shown}")
    parts += [f"and {len(branches) - _MOST_PLACES} branches more"] if len(branches) > _MOST_PLACES else []
    return f"{len(places)} solution{'' if len(places) == 1 else 's'}, {'; '.join(parts)}"


@dataclass
class _Same:
    """Whether two solutions of a pose are one, to what rounding and a tolerated change of the arm leave.

    Attributes:
        arm: the arm of today.
        reference: Pinocchio's model of it.
        order: its joints in the order of the baseline's.
        T: (4, 4) m, the pose.
        change: tolerated change of the arm [rad, share of its size].
    """

    arm: Arm
    reference: Reference
    order: tuple[int, ...]
    T: Array
    change: float

    def gaps(self, q: Array, other: Array) -> Array:
        """Differences (k, m, n) of the joints of q (k, n) and other (m, n)."""
        step = q[:, None] - other[None]
        slides = self.reference.prismatic[list(self.order)]
        return np.abs(np.where(slides, step, shortest(step)))

    def room(self, q: Array) -> Array:
        """How far apart (k,) [rad or m] two answers near q (k, n) may be, and still be one."""
        sigma = self.sigma_min(q)
        out: Array = np.minimum(CONDITIONING / sigma, LOOSEST) + np.minimum(10.0 * self.change / sigma, ONE_BRANCH)
        return out + PLANTED

    def is_fragile(self, q: Array) -> bool:
        """Whether the change, or rounding, may join a solution (n,) with another one, so that both are gone.

        Near a fold the smallest singular value falls with the root of the distance to it.
        """
        return bool(self.sigma_min(q[None])[0] ** 2 <= 10.0 * self.change + FOLD)

    def sigma_min(self, q: Array) -> Array:
        """Smallest singular value (k,) of the Jacobian at q (k, n), lengths as shares of the arm's size."""
        return np.maximum(least_singular_value(self.arm, self._own(q)), 1e-300)

    def one_root(self, q: Array, other: Array) -> bool:
        """Whether the arm is in the pose half way between two joint vectors (n,): one double root."""
        step = q - other
        slides = self.reference.prismatic[list(self.order)]
        half = other + 0.5 * np.where(slides, step, shortest(step))
        position, rotation = self.reference.error(self._own(half), self.T)
        return max(position / max(self.reference.size, 1e-300), rotation) <= 1e2 * SOLVERS.fold

    def _own(self, q: Array) -> Array:
        out = np.empty_like(q)
        out[..., list(self.order)] = q
        return out


def _compare(found: _Found, index: int, then: Pose, now: Pose, same: _Same, arm: Description) -> None:
    """Pair the solutions of a pose, and note what is different."""
    before, after = list(then.answers), list(now.answers)
    if not before or not after:
        found.lost += [(index, each.branch) for each in before if not same.is_fragile(np.array(each.q))]
        found.gained += [(index, each.branch) for each in after if not same.is_fragile(np.array(each.q))]
        return
    gaps = same.gaps(then.q, now.q)
    far = gaps.max(axis=-1)
    rows, columns = linear_sum_assignment(np.minimum(far, 1e6))
    room = same.room(then.q)
    paired, taken = {}, set()
    for i, k in zip(rows.tolist(), columns.tolist(), strict=True):
        free = before[i].singular and after[k].singular
        if far[i, k] > ONE_BRANCH and not free:
            continue
        paired[i] = k
        taken.add(k)
        if far[i, k] <= room[i] or free or same.is_fragile(then.q[i]):
            continue
        if not same.one_root(then.q[i], now.q[k]):
            found.moved.append((float(far[i, k]), index, int(np.argmax(gaps[i, k]))))
    for i, each in enumerate(before):
        if i not in paired and not _double(same, then.q[i], now.q, each, after):
            found.lost.append((index, each.branch))
    for k, each in enumerate(after):
        if k not in taken and not _double(same, now.q[k], then.q, each, before):
            found.gained.append((index, each.branch))
    limits = np.array(arm.limits)
    for i, k in paired.items():
        one, other = before[i], after[k]
        if one.within_limits != other.within_limits and not _at_limit(one, limits, max(room[i], LIMIT_MARGIN)):
            found.limits.append((index, one.branch))
        if None not in (one.contact, other.contact) and one.contact != other.contact:
            found.contacts.append((index, one.branch))


def _double(same: _Same, q: Array, others: Array, one: Answer, all_others: list[Answer]) -> bool:
    """Whether a solution without an equal among the others is not a difference.

    It may vanish by rounding, form a double root with one of them, or represent the same continuum as one of them.
    """
    if same.is_fragile(q):
        return True
    near = same.gaps(q[None], others).max(axis=-1)[0]
    if any(same.one_root(q, others[k]) for k in np.flatnonzero(near < LOOSEST)):
        return True
    return one.singular and any(other.singular for other in all_others)


def _at_limit(answer: Answer, limits: Array, margin: float) -> bool:
    """Whether a joint is within ``margin`` of a limit, modulo full turns, so that rounding decides."""
    q = np.array(answer.q)[:, None]
    gap = np.abs(q - limits)
    turned = np.abs(shortest(np.where(np.isfinite(limits), q - limits, np.pi)))
    return bool(np.minimum(gap, turned).min(initial=np.inf) <= margin)
