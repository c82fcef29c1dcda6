"""Judgements of any solver on an arm: its wrong, missed and duplicate solutions, each with the pose to replay.

>>> import urdf_ik
>>> from urdf_ik.verify import judge
>>> arm = urdf_ik.load("puma_560")
>>> judge(arm, lambda T: arm.ik(T).to_array(), n=3).passed
True
"""

import importlib
import json
import runpy
import shlex
import subprocess
import traceback
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import astuple, dataclass
from itertools import product
from typing import Any

import numpy as np
from numpy.typing import NDArray

from urdf_ik.arm import Arm
from urdf_ik.cell.pinocchio_reference import pose_errors
from urdf_ik.errors import ArgumentError, UrdfIkError
from urdf_ik.model.poses import pose
from urdf_ik.support import inputs
from urdf_ik.support.angles import TURN, difference
from urdf_ik.support.report import Report
from urdf_ik.support.text import Section
from urdf_ik.support.watch import Progress, Watch
from urdf_ik.typing import Array
from urdf_ik.verify.completeness import Sameness
from urdf_ik.verify.crosscheck import EXACT
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
    progress: Progress | None = None,
) -> "Judgement":
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
    if not callable(solve):
        raise ArgumentError(f"solve={solve!r} given; a function that takes a pose is needed")
    n = inputs.poses(n)
    tolerance = inputs.number(tolerance, "tolerance", low=0.0, high=1.0)
    watch, judged = Watch(None, progress), _Judged(arm, solve, tolerance, bool(within_limits))
    kinds = []
    for number, kind in enumerate(KINDS):
        judged.kind = Kind(kind)
        kinds.append(judged.kind)
        T, q, values = _poses(arm, kind, n, seed)
        for k in range(n):
            judged.take(number * n + k, T[k], None if q is None else q[k], None if values is None else values[k])
            watch.step(number * n + k + 1, n * len(KINDS))
    return Judgement(
        solver=name or str(getattr(solve, "name", "") or getattr(solve, "__name__", type(solve).__name__)),
        robot=arm.name,
        base=arm.base,
        tip=arm.tip,
        n=n,
        seed=seed,
        tolerance=tolerance,
        within_limits=bool(within_limits),
        kinds=tuple(kinds),
        faults=tuple(judged.faults),
    )


def replay(arm: Arm, n: int, seed: int, index: int) -> Array:
    """Pose ``index`` of a judgement once more, (4, 4) [m].

    Raises:
        IndexError: there is no such pose.
    """
    return np.asarray(_poses(arm, KINDS[index // n], n, seed)[0][index % n])


def _poses(arm: Arm, kind: str, n: int, seed: int) -> tuple[Array, Array | None, Array | None]:
    """Poses (n, 4, 4) of a kind, the joint vectors that they were made of, and the redundancy parameters of these."""
    reference = arm.cell.reference
    rng = np.random.default_rng([seed, KINDS.index(kind)])
    lower, upper = reference.ranges.T
    q = rng.uniform(lower, upper, (n, reference.dof))
    if kind == "round":
        q = round_vectors(reference, rng, n)
    elif kind in ("near singularity", "at singularity"):
        q = near_singularity(arm, rng, n, away=kind == "near singularity")
    T = reference.pose(q)
    if kind != "tool down" or arm.task != "pose" or reference.dof < 6:
        return T, q, redundancy_at(arm, q)
    turns = rng.uniform(-np.pi, np.pi, (n, 1)) * [0.0, 0.0, 1.0]
    T[:, :3, :3] = pose(np.zeros(3), rotvec=turns)[:, :3, :3] @ np.diag([1.0, -1.0, -1.0])
    return T, None, None


class _Judged:
    """The faults so far, and the counts of the poses of a kind."""

    kind: "Kind"

    def __init__(self, arm: Arm, solve: Solve, tolerance: float, within_limits: bool) -> None:
        self.faults: list[Fault] = []
        self._traced = False
        self._arm, self._solve, self._reference = arm, solve, arm.cell.reference
        self._tolerance, self._within = tolerance, within_limits
        six = arm.dof == 6 and arm.structure.is_6r
        self._sameness = Sameness(arm.chain, arm.cell.reference, tolerance) if six else None

    def take(self, index: int, T: Array, made_of: Array | None, value: Any) -> None:
        """Judge one pose (4, 4), made of a joint vector (n,) where there is one."""
        counts, redundant = self.kind, self._arm.redundancy is not None
        counts.poses += 1
        own = solutions_of(self._arm, T[None], None if value is None else np.asarray(value)[None])
        own = own.within_limits() if self._within else own
        expected = own.q[0, own.valid[0]]
        if made_of is not None and not redundant and not self._has(T, made_of, expected):
            expected = np.vstack([expected, made_of])
            counts.further += 1
        counts.expected += len(expected)
        try:
            found, approximate = _read(self._solve(T.copy()), self._arm.dof)
            errors = self._errors(found, T)
        except Exception as error:  # whatever a foreign solver raises is its fault
            words = f"{type(error).__name__}: {error}"
            if not self._traced and error.__traceback__ is not None and not isinstance(error, UrdfIkError):
                frames = traceback.format_exception(type(error), error, error.__traceback__.tb_next)
                words, self._traced = "".join(frames).rstrip(), True
            self._add(FAILED, index, (), words)
            return
        claimed, right = ~approximate | (errors <= self._tolerance), errors <= self._tolerance
        counts.found += int(claimed.sum())
        for q, off in zip(found[claimed & ~right], errors[claimed & ~right], strict=True):
            words = f"misses the pose by {off:.2g} (m, rad)"
            self._add(WRONG, index, q, words if np.isfinite(off) else "is infinite, or not a number in part")
        good = found[right]
        self._doubled(index, good, expected)
        self._outside(index, good)
        if redundant:
            if len(expected) and not len(good):
                self._add(MISSING, index, (), "no solution, where the pose has infinitely many")
            return
        for q in expected:
            if not self._has(T, q, good):
                gap = float(self._gaps(q, good).min(initial=np.inf))
                near = f"the nearest that it has is {gap:.2g} away" if len(good) else "it has none"
                self._add(MISSING, index, q, near)
        if len(good) and not self._within:
            exact = good[self._misses(self._reference.pose(good), T) <= EXACT]
            counts.further += sum(not self._has(T, q, expected) for q in exact)

    def _errors(self, found: Array, T: Array) -> Array:
        """By how much joint vectors (k, n) miss T (4, 4) [m; rad]; infinite where they are not finite."""
        out, known = np.full(len(found), np.inf), np.isfinite(found).all(axis=1)
        if known.any():
            out[known] = self._misses(self._reference.pose(found[known]), T)
        return out

    def _misses(self, found: Array, T: Array) -> Array:
        """By how much poses (k, 4, 4) miss T, in what the arm controls of a pose."""
        if self._arm.task == "pose":
            position, rotation = pose_errors(found, T)
            return np.maximum(position, rotation)
        control = self._arm.solver.control
        return np.asarray(np.abs(np.asarray(control.target_of(found)) - control.target_of(T[None])).max(axis=-1))

    def _doubled(self, index: int, good: Array, expected: Array) -> None:
        sigma = least_singular_value(self._arm, good)
        for k in range(1, len(good)):
            # A solution a turn away is another joint vector; beside a fold there are two so near to each other.
            alike = int((np.abs(good[: k + 1] - good[k]).max(axis=1) < TWICE).sum())
            there = int((self._gaps(good[k], expected) < 2.0 * TWICE).sum()) if len(expected) else 0
            if sigma[k] >= _SINGULAR and alike > max(1, there):
                self._add(DOUBLED, index, good[k], "given before")

    def _outside(self, index: int, good: Array) -> None:
        low, high = np.asarray(self._arm.limits).T
        for q in good:
            turns = np.where(self._reference.prismatic, 0.0, np.ceil((low - LIMIT - q) / TURN))
            image = q if self._within else q + np.where(np.isfinite(turns), turns, 0.0) * TURN
            if not ((image < low - LIMIT) | (image > high + LIMIT)).any():
                continue
            if not self._within:
                self.kind.outside += 1
                continue
            k = int(np.argmax(np.maximum(low - q, q - high)))
            words = f"{self._arm.joint_names[k]} is at {q[k]:.6g}, its limits are {low[k]:.6g} and {high[k]:.6g}"
            self._add(OUTSIDE, index, q, words)

    def _has(self, T: Array, q: Array, others: Array) -> bool:
        """Whether q (n,) is one of the others (k, n), double roots and continua considered."""
        if not len(others):
            return False
        gaps = self._gaps(q, others)
        if gaps.min() <= _NEAR or any(self._joined(T, q, other) for other in others):
            return True
        if self._sameness is not None:
            return bool(self._sameness.has(T, q, others))
        sigma = max(float(least_singular_value(self._arm, q[None])[0]), 1e-300)
        if gaps.min() <= _NEAR + min(10.0 * self._tolerance / sigma, _FAR):
            return True
        near = others[gaps < _FAR]
        half = near + 0.5 * difference(q, near, self._reference.prismatic)  # a double root
        return bool(len(near) and (self._misses(self._reference.pose(half), T) <= self._tolerance).any())

    def _joined(self, T: Array, q: Array, other: Array) -> bool:
        """Whether the arm stays in the pose on the straight way from the one to the other: one flat continuum."""
        step = difference(other, q, self._reference.prismatic)
        # Half a turn may go either way.
        half = np.flatnonzero(np.abs(np.abs(step) - np.pi) < _NEAR)
        for signs in product((1.0, -1.0), repeat=len(half)):
            step[half] = np.pi * np.array(signs)
            if (self._misses(self._reference.pose(q + _ALONG * step), T) <= self._tolerance).all():
                return True
        return False

    def _gaps(self, q: Array, others: Array) -> Array:
        return np.asarray(np.abs(difference(others, q, self._reference.prismatic)).max(axis=-1, initial=0.0))

    def _add(self, fault: str, index: int, q: Any, words: str) -> None:
        counter = "outside" if fault == OUTSIDE else fault
        setattr(self.kind, counter, getattr(self.kind, counter) + 1)
        self.faults.append(Fault(fault, self.kind.name, index, tuple(map(float, q)), words))


def _read(answer: Any, n: int) -> tuple[Array, NDArray[np.bool_]]:
    """A solver's answer as joint vectors (k, n) and flags (k,); rows that are NaN throughout are left out."""
    flags: Any = None
    if isinstance(answer, tuple) and len(answer) == 2 and np.asarray(answer[1]).dtype == np.bool_:
        answer, flags = answer
    try:
        q = np.asarray([] if answer is None else answer, dtype=np.float64)
    except (TypeError, ValueError):
        raise ArgumentError(f"the solver returned {answer!r}; joint vectors (k, {n}) are needed") from None
    if q.size and (q.ndim == 0 or q.shape[-1] != n):
        raise ArgumentError(f"the solver returned an array of shape {q.shape}; joint vectors (k, {n}) are needed")
    q = q.reshape(-1, n) if q.size else np.zeros((0, n))
    approximate = np.zeros(len(q), dtype=np.bool_) if flags is None else np.asarray(flags)
    if approximate.shape != (len(q),):
        raise ArgumentError(f"the solver returned {len(q)} joint vectors and flags of shape {approximate.shape}")
    known = ~np.isnan(q).all(axis=1)
    return q[known], approximate[known]


@dataclass
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
    poses: int = 0
    expected: int = 0
    found: int = 0
    wrong: int = 0
    missing: int = 0
    doubled: int = 0
    outside: int = 0
    failed: int = 0
    further: int = 0


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
        unlooked: what was left out: nothing, ''.
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
            pose = f"n={self.n}, seed={self.seed}, index={self.faults[0].index}"
            out.append(f"replay: T = urdf_ik.verify.judging.replay(arm, {pose})")
        further = sum(kind.further for kind in self.kinds)
        out += [f"note: {further} solutions hold that the reference lacks"] if further else []
        return tuple(out)

    def summary(self) -> str:
        """The number of poses, and of each sort of fault."""
        counts = [(sum(each.fault == fault for each in self.faults), fault) for fault in (*FAULTS, OUTSIDE)]
        parts = ", ".join(f"{count} {fault}" for count, fault in counts if count)
        return f"{sum(kind.poses for kind in self.kinds)} poses, {parts or 'nothing wrong, missing or doubled'}"


FORMS = "module:function, file.py:function, or process:COMMAND"
_PATIENCE = 1.0  # s for a process to end by itself when its input is closed


@contextmanager
def opened(spec: str) -> Iterator[Solve]:
    """The solver that a text names; a process ends at the end of the block.

    Args:
        spec: ``module:function`` or ``file.py:function``, which takes a pose (4, 4); or ``process:COMMAND``, which
            reads {"T": [[...], ...]} and answers {"q": [[...], ...]}, a line each, in the arm's order of joints, and
            {"error": text} where it cannot. "approximate" may flag joint vectors that are no claim.
    """
    place, _, name = spec.rpartition(":")
    if spec.startswith("process:"):
        with _process(shlex.split(spec.removeprefix("process:"))) as solve:
            yield solve
        return
    if not place:
        raise ArgumentError(f"no solver {spec!r}; give {FORMS}")
    try:
        found = runpy.run_path(place) if place.endswith(".py") else vars(importlib.import_module(place))
    except Exception as error:  # a module of the user's may raise anything
        reason = f"{type(error).__name__}: {error}"
        raise ArgumentError(f"solver {spec!r} cannot be imported: {reason}; give {FORMS}") from None
    function = found.get(name)
    if not callable(function):
        raise ArgumentError(f"{place} has no function {name!r}; give {FORMS}")
    yield function


@contextmanager
def _process(command: list[str]) -> Iterator[Solve]:
    try:
        process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, bufsize=1)
    except (OSError, ValueError, IndexError) as error:
        raise ArgumentError(f"the solver {' '.join(command)!r} cannot be started: {error}") from None
    stdin, stdout = process.stdin, process.stdout
    assert stdin is not None and stdout is not None

    def solve(T: Array) -> Any:
        try:
            stdin.write(json.dumps({"T": np.asarray(T).tolist()}) + "\n")
            line = stdout.readline()
        except OSError:
            line = ""
        if not line:
            raise ArgumentError(f"the process ended with status {process.wait()}")
        try:
            answer = json.loads(line)
            q = answer["q"]
        except (ValueError, TypeError, KeyError, RecursionError):
            raise ArgumentError(f"the process answered {line[:80]!r}; an object with 'q' is needed") from None
        return (q, np.array(answer["approximate"])) if "approximate" in answer else q

    try:
        yield solve
    finally:
        try:
            process.communicate(timeout=_PATIENCE)
        except subprocess.TimeoutExpired:
            process.kill()
            process.communicate()
