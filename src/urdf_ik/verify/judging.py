"""Judgements of any solver on an arm: its wrong, missed and duplicate solutions, each with the pose to replay.

>>> import urdf_ik
>>> from urdf_ik.verify import judge
>>> arm = urdf_ik.load("puma_560")
>>> judge(arm, lambda T: arm.ik(T).to_array(), n=3).passed
True
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import astuple, dataclass
from itertools import product
from typing import Any

import numpy as np
from numpy.typing import NDArray

from urdf_ik.arm import Arm
from urdf_ik.cell.pinocchio_reference import pose_errors
from urdf_ik.errors import ArgumentError
from urdf_ik.support import inputs
from urdf_ik.support.angles import TURN, shortest
from urdf_ik.support.report import Report
from urdf_ik.support.text import Section
from urdf_ik.support.watch import Progress, Watch
from urdf_ik.typing import Array
from urdf_ik.verify.crosscheck import EXACT
from urdf_ik.verify.sameness import Sameness
from urdf_ik.verify.sampling import least_singular_value, near_singularity, redundancy_at, round_vectors, solutions_of

Solve = Callable[[Any], Any]
"""A solver: a pose (4, 4) [m] of the tip in the base in, joint vectors (k, n) [rad or m] out; or these and flags (k,)
that are true for those that the solver itself calls approximate."""

KINDS = ("random", "round", "tool down", "near singularity", "at singularity")
TOLERANCE = 1e-7
"""Error [m; rad] above which a solution is wrong, unless another is given."""

LIMIT = 1e-6
"""How far [rad or m] a solution may lie beyond a limit."""

TWICE = 1e-6
"""Two joint vectors closer than this in every joint [rad or m] are one solution, unless the pose has two there."""

_NEAR = 1e-5
_SINGULAR = 1e-5  # smallest singular value, lengths as shares of the arm's size: below it branches meet
_ALONG = np.linspace(0.0, 1.0, 9)[1:-1, None]  # places on the way from one solution to another
_FAR = 0.05  # rad or m: solutions further apart are two, however near a singularity

WRONG, MISSING, DOUBLED, OUTSIDE, FAILED = "wrong", "missing", "doubled", "outside limits", "failed"
FAULTS = (WRONG, MISSING, DOUBLED, FAILED)
"""Kinds of faults; a solution outside the limits is one only if the solver had to stay within them."""

_SHOWN = 6


def judge(
    arm: Arm,
    solve: Solve,
    *,
    n: int = 50,
    seed: int = 0,
    tolerance: float = TOLERANCE,
    within_limits: bool = False,
    name: str | None = None,
    time_limit: float | None = None,
    progress: Progress | None = None,
) -> Judgement:
    """Judge a solver on an arm: is each of its solutions one, and does it have all of them, once?

    The rules:

    - A returned joint vector is *wrong* if Pinocchio's pose for it misses the target by more than the tolerance. One
      that the solver flags as approximate is no claim: it is not wrong, and it counts where it reaches the target.
    - The solutions of a pose are those of this package, which Pinocchio has measured, and the joint vector that the
      pose was made of. One is *missing* if the solver returned no vector of the same connected set of solutions: a
      regular solution is a set of its own; two values of a double root, or two vectors between which the arm can move
      without leaving the pose by more than the tolerance, are one set.
    - A solution is *doubled* if it is regular and returned more than once. At a singular one branches meet, and one
      vector a branch is no fault.
    - With more than six joints a pose has infinitely many solutions, and the solver has to have one.
    - Solutions outside the limits are counted; they are faults only of a solver that is to stay within.

    Args:
        arm: the arm.
        solve: the solver: takes a pose (4, 4) of the tip in the base [m], returns joint vectors (k, n) [rad or m] in
            the order of ``arm.joint_names``; none: an empty array. Rows of NaN are no solutions. Or a tuple of these
            and flags (k,), true for approximate ones.
        n: poses of each of five kinds: random, joints at round angles, tool down, 1e-2 to 1e-4 from a singularity, and
            at one.
        seed: the same seed gives the same poses.
        tolerance: error [m; rad] above which a solution is wrong.
        within_limits: the solver returns only solutions inside the joint limits, so no others are expected.
        name: what the report calls it; default: the function's name.
        time_limit: s after which no more poses are given to the solver; what was left out did not pass.
        progress: called with (poses done, poses).

    Returns:
        The report: ``print`` it, or ``to_json()``.

    Raises:
        ArgumentError: ``solve`` cannot be called, or a number makes no sense.
        UnsupportedArm: this package does not solve the arm, so that nobody knows what is missing.

    Example:
        >>> import urdf_ik
        >>> arm = urdf_ik.load("puma_560")
        >>> judge(arm, lambda T: arm.ik(T).to_array()[1:], n=1, name="forgetful").passed
        False
    """
    inputs.arm(arm)
    if not callable(solve):
        raise ArgumentError(f"solve={solve!r} given; a function that takes a pose is needed")
    n = inputs.poses(n)
    tolerance = inputs.number(tolerance, "tolerance", low=0.0, high=1.0)
    watch = Watch(time_limit, progress)
    judged = _Judged(arm, solve, tolerance, bool(within_limits))
    index = 0
    for kind in KINDS:
        T, q, values = _poses(arm, kind, n, seed)
        for k in range(n):
            if watch.is_over:
                break
            judged.take(kind, index, T[k], None if q is None else q[k], None if values is None else values[k])
            index += 1
            watch.step(index, n * len(KINDS))
    poses = n * len(KINDS)
    return Judgement(
        solver=name or str(getattr(solve, "name", "") or getattr(solve, "__name__", type(solve).__name__)),
        robot=arm.name,
        base=arm.base,
        tip=arm.tip,
        n=n,
        seed=seed,
        tolerance=tolerance,
        within_limits=bool(within_limits),
        kinds=tuple(Kind(kind, *judged.counts[kind]) for kind in KINDS),
        faults=tuple(judged.faults),
        unlooked="" if index == poses else watch.ended(f"with {index} of {poses} poses: the others were"),
    )


def replay(arm: Arm, n: int, seed: int, index: int) -> Array:
    """Pose ``index`` of a judgement once more, (4, 4) [m].

    Raises:
        IndexError: there is no such pose.
    """
    T: Array = _poses(arm, KINDS[index // n], n, seed)[0][index % n]
    return T


def _poses(arm: Arm, kind: str, n: int, seed: int) -> tuple[Array, Array | None, Array | None]:
    """Poses (n, 4, 4) of a kind, the joint vectors that they were made of, and the redundancy parameters of these."""
    reference = arm.cell.reference
    rng = np.random.default_rng([seed, KINDS.index(kind)])
    lower, upper = reference.ranges.T
    q = rng.uniform(lower, upper, (n, reference.dof))
    if kind == "round":
        q = round_vectors(reference, rng, n)
    elif kind == "near singularity":
        q = near_singularity(arm, rng, n)
    elif kind == "at singularity":
        q = near_singularity(arm, rng, n, away=False)
    T = reference.pose(q)
    if kind != "tool down" or arm.task != "pose" or reference.dof < 6:
        return T, q, redundancy_at(arm, q)
    down = np.array([[1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, -1.0]])
    angle = rng.uniform(-np.pi, np.pi, n)
    turn = np.zeros((n, 3, 3))
    turn[:, 0, 0] = turn[:, 1, 1] = np.cos(angle)
    turn[:, 1, 0], turn[:, 0, 1], turn[:, 2, 2] = np.sin(angle), -np.sin(angle), 1.0
    T[:, :3, :3] = turn @ down
    return T, None, None


class _Judged:
    """The faults so far."""

    def __init__(self, arm: Arm, solve: Solve, tolerance: float, within_limits: bool) -> None:
        self.faults: list[Fault] = []
        self.counts = {kind: [0] * 9 for kind in KINDS}
        self._arm, self._solve, self._reference = arm, solve, arm.cell.reference
        self._tolerance, self._within = tolerance, within_limits
        six = arm.dof == 6 and arm.structure.is_6r
        self._sameness = Sameness(arm.chain, arm.cell.reference, tolerance) if six else None

    def take(self, kind: str, index: int, T: Array, made_of: Array | None, value: Any) -> None:
        """Judge one pose (4, 4), made of a joint vector (n,) where there is one."""
        counts = self.counts[kind]
        counts[0] += 1
        own = solutions_of(self._arm, T[None], None if value is None else np.asarray(value)[None])
        if self._within:
            own = own.within_limits()
        expected = own.q[0, own.valid[0]]
        if made_of is not None and self._arm.redundancy is None and not self._has(T, made_of, expected):
            expected = np.vstack([expected, made_of])
            counts[8] += 1
        counts[1] += len(expected)
        try:
            found, approximate = _read(self._solve(T.copy()), self._arm.dof)
            found = found[~approximate | (self._errors(found, T) <= self._tolerance)]
        except Exception as error:  # whatever a foreign solver raises is its fault
            counts[7] += 1
            self.faults.append(Fault(FAILED, kind, index, (), f"{type(error).__name__}: {error}"))
            return
        counts[2] += len(found)
        good = self._right(kind, index, T, found)
        self._doubled(kind, index, good, expected)
        self._outside(kind, index, good)
        if self._arm.redundancy is not None:
            if len(expected) and not len(good):
                self._add(MISSING, 4, kind, index, (), "no solution, where the pose has infinitely many")
            return
        for q in expected:
            if not self._has(T, q, good):
                gap = float(self._gaps(q, good).min(initial=np.inf))
                near = f"the nearest that it has is {gap:.2g} away" if len(good) else "it has none"
                self._add(MISSING, 4, kind, index, q, near)
        if len(good) and not self._within:
            exact = good[self._misses(self._reference.pose(good), T) <= EXACT]
            counts[8] += sum(not self._has(T, q, expected) for q in exact)

    def _right(self, kind: str, index: int, T: Array, found: Array) -> Array:
        """Those (m, n) that reach the pose."""
        errors = self._errors(found, T)
        right = errors <= self._tolerance
        for q, error in zip(found[~right], errors[~right], strict=True):
            known = np.isfinite(error)
            words = f"misses the pose by {error:.2g} (m, rad)" if known else "is infinite, or not a number in part"
            self._add(WRONG, 3, kind, index, q, words)
        out: Array = found[right]
        return out

    def _errors(self, found: Array, T: Array) -> Array:
        """By how much joint vectors (k, n) miss T (4, 4) [m; rad]; infinite where they are not finite."""
        out = np.full(len(found), np.inf)
        finite = np.isfinite(found).all(axis=1)
        if finite.any():
            out[finite] = self._misses(self._reference.pose(found[finite]), T)
        return out

    def _misses(self, found: Array, T: Array) -> Array:
        """By how much poses (k, 4, 4) miss T, in what the arm controls of a pose."""
        if self._arm.task == "pose":
            position, rotation = pose_errors(found, T)
            return np.maximum(position, rotation)
        control = self._arm.solver.control
        out: Array = np.abs(np.asarray(control.target_of(found)) - control.target_of(T[None])).max(axis=-1)
        return out

    def _doubled(self, kind: str, index: int, good: Array, expected: Array) -> None:
        sigma = least_singular_value(self._arm, good)
        for k in range(1, len(good)):
            if sigma[k] < _SINGULAR:
                continue
            # A solution a turn away is another joint vector; beside a fold there are two so near to each other.
            alike = int((np.abs(good[: k + 1] - good[k]).max(axis=1) < TWICE).sum())
            there = int((self._gaps(good[k], expected) < 2.0 * TWICE).sum()) if len(expected) else 0
            if alike > max(1, there):
                self._add(DOUBLED, 5, kind, index, good[k], "given before")

    def _outside(self, kind: str, index: int, good: Array) -> None:
        low, high = np.asarray(self._arm.limits).T
        for q in good:
            turns = np.where(self._reference.prismatic, 0.0, np.ceil((low - LIMIT - q) / TURN))
            image = q + np.where(np.isfinite(turns), turns, 0.0) * TURN
            image = q if self._within else image
            if ((image < low - LIMIT) | (image > high + LIMIT)).any():
                self.counts[kind][6] += 1
                if self._within:
                    k = int(np.argmax(np.maximum(low - q, q - high)))
                    words = (
                        f"{self._arm.joint_names[k]} is at {q[k]:.6g}, its limits are {low[k]:.6g} and {high[k]:.6g}"
                    )
                    self.faults.append(Fault(OUTSIDE, kind, index, tuple(map(float, q)), words))

    def _has(self, T: Array, q: Array, others: Array) -> bool:
        """Whether q (n,) is one of the others (k, n), double roots and continua considered."""
        if not len(others):
            return False
        gaps = self._gaps(q, others)
        if gaps.min() <= _NEAR:
            return True
        if any(self._joined(T, q, other) for other in others):
            return True
        if self._sameness is not None:
            return self._sameness.has(T, q, others)
        sigma = max(float(least_singular_value(self._arm, q[None])[0]), 1e-300)
        if gaps.min() <= _NEAR + min(10.0 * self._tolerance / sigma, _FAR):
            return True
        return any(self._one_root(T, q, others[k]) for k in np.flatnonzero(gaps < _FAR))

    def _joined(self, T: Array, q: Array, other: Array) -> bool:
        """Whether the arm stays in the pose on the straight way from the one to the other: one flat continuum."""
        step = other - q
        step = np.where(self._reference.prismatic, step, shortest(step))
        # Half a turn may go either way.
        half = [int(k) for k in np.flatnonzero(np.abs(np.abs(step) - np.pi) < _NEAR)]
        for signs in product((1.0, -1.0), repeat=len(half)):
            step[half] = np.pi * np.array(signs)
            if (self._misses(self._reference.pose(q + _ALONG * step), T) <= self._tolerance).all():
                return True
        return False

    def _one_root(self, T: Array, q: Array, other: Array) -> bool:
        step = q - other
        half = other + 0.5 * np.where(self._reference.prismatic, step, shortest(step))
        return bool(self._misses(self._reference.pose(half)[None], T)[0] <= self._tolerance)

    def _gaps(self, q: Array, others: Array) -> Array:
        step = others - q
        out: Array = np.abs(np.where(self._reference.prismatic, step, shortest(step))).max(axis=-1, initial=0.0)
        return out

    def _add(self, fault: str, column: int, kind: str, index: int, q: Any, words: str) -> None:
        self.counts[kind][column] += 1
        self.faults.append(Fault(fault, kind, index, tuple(float(each) for each in q), words))


def _read(answer: Any, n: int) -> tuple[Array, NDArray[np.bool_]]:
    """A solver's answer as joint vectors (k, n) and flags (k,); rows that are NaN throughout are left out.

    Raises:
        ArgumentError: it is something else.
    """
    flags: Any = None
    if isinstance(answer, tuple) and len(answer) == 2 and np.asarray(answer[1]).dtype == np.bool_:
        answer, flags = answer
    q = _vectors(answer, n)
    approximate = np.zeros(len(q), dtype=np.bool_) if flags is None else np.asarray(flags)
    if approximate.shape != (len(q),):
        raise ArgumentError(f"the solver returned {len(q)} joint vectors and flags of shape {approximate.shape}")
    known = ~np.isnan(q).all(axis=1)
    return q[known], approximate[known]


def _vectors(answer: Any, n: int) -> Array:
    if answer is None:
        return np.zeros((0, n))
    try:
        q = np.asarray(answer, dtype=np.float64)
    except (TypeError, ValueError):
        raise ArgumentError(f"the solver returned {answer!r}; joint vectors (k, {n}) are needed") from None
    if not q.size:
        return np.zeros((0, n))
    if q.ndim == 0 or q.shape[-1] != n:
        raise ArgumentError(f"the solver returned an array of shape {q.shape}; joint vectors (k, {n}) are needed")
    return q.reshape(-1, n)


@dataclass(frozen=True)
class Kind:
    """The poses of one kind.

    Attributes:
        name: 'random', 'round', 'tool down', 'near singularity' or 'at singularity'.
        poses: number of poses.
        expected: number of solutions of the poses.
        found: number of joint vectors that the solver returned.
        wrong: number of returned vectors that do not reach the pose, or are invalid.
        missing: number of solutions that the solver did not return.
        doubled: number of solutions that it returned more than once.
        outside: solutions outside the joint limits, whatever whole turns are added.
        failed: poses at which it raised an error.
        further: solutions that hold and that the reference set lacks: faults of the judge's own solver.
    """

    name: str
    poses: int
    expected: int
    found: int
    wrong: int
    missing: int
    doubled: int
    outside: int
    failed: int
    further: int


@dataclass(frozen=True)
class Fault:
    """One fault.

    Attributes:
        fault: 'wrong', 'missing', 'doubled', 'outside limits' or 'failed'.
        kind: kind of the pose.
        index: number of the pose; :func:`urdf_ik.verify.judging.replay` gives it again.
        q: (n,) rad or m, the joint vector at fault; () without one.
        words: by how much, or what was raised.
    """

    fault: str
    kind: str
    index: int
    q: tuple[float, ...]
    words: str

    def __str__(self) -> str:
        at = f", q = [{', '.join(f'{value:.9g}' for value in self.q)}]" if self.q else ""
        return f"{self.fault} at pose {self.index} ({self.kind}): {self.words}{at}"


@dataclass(frozen=True, repr=False)
class Judgement(Report):
    """A solver, judged on an arm.

    Attributes:
        solver: what it is called.
        robot: the robot's name.
        base: base link.
        tip: tip link.
        n: poses of each kind.
        seed: seed of the poses.
        tolerance: error [m; rad] above which a solution is wrong.
        within_limits: whether the solver had to return only solutions within the joint limits.
        kinds: counts by kind of pose.
        faults: every fault.
        unlooked: what the time limit left out; '' where every pose was judged.
    """

    solver: str
    robot: str
    base: str
    tip: str
    n: int
    seed: int
    tolerance: float
    within_limits: bool
    kinds: tuple[Kind, ...]
    faults: tuple[Fault, ...]
    unlooked: str = ""

    @property
    def faulty(self) -> bool:
        """Whether something is wrong, missing or doubled at a pose."""
        return bool(self.faults)

    def title(self) -> str:
        """The solver, the arm and the poses."""
        arm = f"{self.robot}, {self.base} to {self.tip}"
        return f"{self.solver} on {arm}: {self.n} poses of each kind, seed {self.seed}"

    def sections(self) -> tuple[Section, ...]:
        """The counts as a table."""
        header = ("poses", "number", "expected", "found", "wrong", "missing", "doubled", "outside limits", "failed")
        rows = tuple(tuple(map(str, astuple(kind)[:-1])) for kind in self.kinds)
        return (Section("", header, rows, left=("poses",)),)

    def lines(self) -> tuple[str, ...]:
        """The first faults of each sort, and how to see their poses again."""
        out = []
        for fault in (*FAULTS, OUTSIDE):
            own = [each for each in self.faults if each.fault == fault]
            out += [str(each) for each in own[:_SHOWN]]
            out += [f"... {len(own) - _SHOWN} more {fault}"] if len(own) > _SHOWN else []
        if self.faults:
            out.append(
                f"replay: T = urdf_ik.verify.judging.replay(arm, n={self.n}, seed={self.seed}, "
                f"index={self.faults[0].index})"
            )
        further = sum(kind.further for kind in self.kinds)
        out += [f"note: {further} solutions hold that the reference lacks"] if further else []
        return tuple(out)

    def summary(self) -> str:
        """The number of poses, and of each sort of fault."""
        counts = [(sum(each.fault == fault for each in self.faults), fault) for fault in (*FAULTS, OUTSIDE)]
        parts = ", ".join(f"{count} {fault}" for count, fault in counts if count)
        return f"{sum(kind.poses for kind in self.kinds)} poses, {parts or 'nothing wrong, missing or doubled'}"
