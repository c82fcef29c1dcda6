"""check_proof(): whether answers that claim to be complete are, by theorems evaluated in ball arithmetic."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from urdf_ik.errors import ArgumentError
from urdf_ik.support import extras
from urdf_ik.support.report import Report
from urdf_ik.support.watch import Watch

try:
    from flint import acb
except ImportError as error:  # python-flint is an extra
    raise extras.missing("proofs are checked in ball arithmetic", "proof") from error

from urdf_ik.arm import Arm
from urdf_ik.ik.solutions import IKSolutions, Proof
from urdf_ik.kinematics.chain import Chain
from urdf_ik.support.watch import Progress
from urdf_ik.typing import Array
from urdf_ik.verify.proof.loop import EIGHT, Loop, exact, ideal, largest, residual
from urdf_ik.verify.proof.roots import ClusterEnclosure, Complex, Enclosure, enclosed, search, single_root

SIXTEEN = 16  # of six turning joints: E. J. F. Primrose, Mech. Mach. Theory 21, 1986
_ROUNDS = 20  # of the search for complex roots
_AS_GOOD_AS_IDEAL = 1e-9  # an arm so close to an ideal one has eight roots too far away to be found
_BESIDE, _SAME_POSE = 1e-2, 1e-10  # rad; share of the arm's size, rad
_TOGETHER = 1e-5  # rad; a solution of a clustered answer may stand for a pair that is real to this
_SOLUTION = 1e-6  # rad; solutions of an answer that are further from every root are none
_SHARP = 1e-9  # rad; a box as narrow as that is as good as its root


@dataclass(frozen=True)
class _Refusal:
    """One answer that claims more than holds.

    Attributes:
        index: the pose's place in the batch, counted through all of its axes.
        status: what the answer says.
        reason: what does not hold.
    """

    index: int
    status: str
    reason: str


@dataclass(frozen=True, repr=False)
class ProofCheck(Report):
    """What an independent check says of proven answers.

    Attributes:
        robot: the arm's name.
        poses: how many answers were looked at.
        unproven: how many of them do not claim to hold every solution; nothing is checked there.
        accepted: how many of the others are proven here, too.
        open: those that this check can neither prove nor disprove, each with the reason.
        refused: those that are wrong.
        unlooked: what the time limit left out; '' where every answer was looked at.
    """

    robot: str
    poses: int
    unproven: int
    accepted: int
    open: tuple[_Refusal, ...]
    refused: tuple[_Refusal, ...]
    unlooked: str = ""

    @property
    def faulty(self) -> bool:
        """Whether an answer was refused."""
        return bool(self.refused)

    def title(self) -> str:
        """The arm and the number of poses."""
        return f"proofs of {self.robot}, {self.poses} poses, in ball arithmetic"

    def lines(self) -> tuple[str, ...]:
        """The counts, and every answer that was not accepted."""
        counts = (
            f"accepted {self.accepted}",
            f"not claimed to be complete {self.unproven}",
            f"neither proven nor disproven here {len(self.open)}",
            f"refused {len(self.refused)}",
        )
        marked = [("refused", r) for r in self.refused] + [("open", r) for r in self.open]
        return (*counts, *(f"{word} pose {r.index} ({r.status}): {r.reason}" for word, r in marked))

    def summary(self) -> str:
        """How many answers were refused."""
        count = len(self.refused)
        return f"{count} answer{' claims' if count == 1 else 's claim'} more than holds" if count else ""


def check_proof(
    arm: Arm, solutions: IKSolutions, *, time_limit: float | None = None, progress: Progress | None = None
) -> ProofCheck:
    """Check every answer that claims to be complete, with no code of the solver.

    The loop equations are set up anew from the chain's screw axes and the pose. Where the answer's proof is a count of
    16 complex roots, each ball of it must hold one root, and no two the same: then
    there is no other root (Primrose 1986), and the real ones must be the answer's solutions. Where the solver went
    through the closed form of a family, this check finds the eight complex roots of the nearest ideal arm itself and
    encloses each for every target that the arm as written can stand for.

    Args:
        arm: what :func:`urdf_ik.load` returned; six turning joints.
        solutions: what ``arm.ik`` returned, unfiltered.
        time_limit: s after which no more answers are checked; what was left out did not pass.
        progress: called with (poses done, poses).

    Returns:
        The report; ``report.passed`` says whether no answer was refused or left out.

    Raises:
        ArgumentError: the solutions are of another arm, some of them were filtered out, or ``time_limit`` is no number
            of seconds.
        UnsupportedArm: the arm does not have six turning joints.

    Example:
        >>> import urdf_ik
        >>> arm = urdf_ik.load("zyyzyz_6r")
        >>> report = check_proof(arm, arm.ik(arm.fk([0.3, -0.5, 0.8, 0.4, 0.7, -0.2])))
        >>> report.passed, report.accepted
        (True, 1)
    """
    watch = Watch(time_limit, progress)
    if not _same_axes(solutions.solver.chain, arm.chain):
        raise ArgumentError("the solutions are of another arm")
    if solutions.filters:
        how = ", ".join(solutions.filters)
        raise ArgumentError(f"the solutions were filtered ({how}); give all that arm.ik returned")
    T = np.asarray(solutions.poses).reshape(-1, 4, 4)
    count = len(T)
    statuses = np.asarray(solutions.status).reshape(-1)
    q = np.asarray(solutions.q).reshape(count, -1, arm.dof)
    valid = np.asarray(solutions.valid).reshape(count, -1)
    found: dict[bool | None, list[_Refusal]] = {True: [], None: [], False: []}
    looked_at = 0
    for (i,) in watch.parts(count):
        status, looked_at = str(statuses[i]), i + 1
        if status not in ("complete", "clustered"):
            continue
        place = tuple(int(k) for k in np.unravel_index(i, solutions.shape))
        proof = solutions[place].proof if solutions.shape else solutions.proof
        loop, rng = Loop.of(arm.chain, T[i]), np.random.default_rng(i)
        verdict, reason = examine(loop, q[i, valid[i]], proof, rng, clustered=status == "clustered")
        found[verdict].append(_Refusal(i, status, reason))
    unproven, answers = looked_at - sum(map(len, found.values())), (tuple(found[None]), tuple(found[False]))
    return ProofCheck(arm.name, looked_at, unproven, len(found[True]), *answers, watch.unlooked)


def _same_axes(a: Chain, b: Chain) -> bool:
    """Whether two chains have the same screw axes, to the last bit."""
    parts = ("H", "P", "R_tip", "prismatic")
    return a is b or all(np.array_equal(getattr(a, part), getattr(b, part)) for part in parts)


def examine(
    loop: Loop, solutions: Array, proof: Proof | None, rng: np.random.Generator, *, clustered: bool = False
) -> tuple[bool | None, str]:
    """Whether ``solutions`` are all solutions of the loop; None where this is not decided; and why.

    Args:
        loop: the loop equations of the pose.
        solutions: (k, 6) rad, the answer.
        proof: the solver's account of the complex roots; None where it has none.
        rng: source of the starts of the search for complex roots.
        clustered: whether the answer leaves some of its solutions to the rounding of the pose.
    """
    answer = _Answer(solutions, clustered)
    if loop.out_of_reach:
        return _answered(loop, answer, [], [])
    near = ideal(loop)
    if near is not None and near[1] < _AS_GOOD_AS_IDEAL:
        return _by_family(loop, near[0], answer, rng)
    starts: list[Complex] = [solutions.astype(np.complex128)]
    starts += [] if proof is None else [proof.roots]
    singles, clusters = search(loop, np.concatenate(starts), SIXTEEN, rng, _ROUNDS)
    count = len(singles) + sum(group.count for group in clusters)
    if count == SIXTEEN:
        return _answered(loop, answer, singles, clusters)
    if near is None:
        return None, f"{count} of {SIXTEEN} roots are enclosed"
    return _by_family(loop, near[0], answer, rng)


class _Answer(NamedTuple):
    """Solutions (k, 6) rad, and whether some of them are left to the rounding of the pose."""

    solutions: Array
    clustered: bool


def _by_family(loop: Loop, near: Loop, answer: _Answer, rng: np.random.Generator) -> tuple[bool | None, str]:
    boxes, _ = search(near, answer.solutions.astype(np.complex128), EIGHT, rng, _ROUNDS)
    if len(boxes) != EIGHT:
        return None, f"{len(boxes)} of the {EIGHT} roots of the nearest ideal arm are enclosed"
    singles: list[Enclosure] = []
    wide: list[Enclosure] = []
    for each in boxes:
        if not each.may_be_real:
            singles.append(each)  # no solution, but one near it may stand for such a pair
            wide.append(each)
            continue
        # A box around real numbers that holds this one, and exactly one root of the arm as written, which is real.
        found = enclosed(loop, [acb(value.real) for value in each.centre], 2 * each.radius)
        if isinstance(found, str):
            return None, f"beside a real root of the ideal arm, of the arm as written: {found}"
        if not all(found.apart(other) for other in wide):
            return None, "real roots of the ideal arm are too close to each other"
        # The box is as wide as the arms differ; a narrow one in it holds its root.
        wide.append(found)
        if not found.radius < _SHARP:
            root = single_root(loop, found.centre)
            if isinstance(root, str) or not root.distance(found.centre) + root.radius < found.radius:
                return None, "beside a real root of the ideal arm, that of the arm as written is not enclosed"
            found = root
        singles.append(found)
    return _answered(loop, answer, singles, [])


def _answered(
    loop: Loop, answer: _Answer, singles: Sequence[Enclosure], clusters: Sequence[ClusterEnclosure]
) -> tuple[bool | None, str]:
    """Whether the real roots are the solutions, each once; real roots nearer than rounding may stand as one."""
    near: list[list[int]] = [[] for _ in singles]
    between: list[list[acb]] = []  # solutions that stand for real roots and for a pair that is not real
    undecided = ""
    for n, q in enumerate(answer.solutions):
        here = exact(q)
        to_single = [root.distance(here) for root in singles]
        best = min(range(len(singles)), key=lambda k: float(to_single[k]), default=None)
        if best is not None and _as_one(loop, singles[best], here):
            if singles[best].real:
                near[best].append(n)
                continue
            off = float(largest([acb(value.imag) for value in singles[best].centre]))
            if answer.clustered and (off < _TOGETHER or any(r.real and _as_one(loop, r, here) for r in singles)):
                between.append(here)
            else:
                undecided = f"solution {n} stands for a pair of roots that are not real by {off:.1e} rad"
        elif not any(each.distance(here) < each.radius + _SOLUTION for each in clusters):
            if not answer.clustered or not largest(residual(loop.values(here))) < _SAME_POSE:
                return False, f"solution {n} is near no real root"
            undecided = f"solution {n} keeps the pose, and is near no real root"
    for k, group in enumerate(clusters):
        stands = any(group.distance(exact(q)) < group.radius + _SOLUTION for q in answer.solutions)
        if not stands and not any(abs(c.imag) > group.radius for c in group.centre):
            undecided = f"cluster {k} may be real, and no solution stands for it"
    answered = [root.centre for root, answers in zip(singles, near, strict=True) if answers] + between
    for root, answers in zip(singles, near, strict=True):
        if len(answers) > 1:
            return False, f"solutions {answers[0]} and {answers[1]} are one root"
        if root.real and not answers and not any(_as_one(loop, root, other) for other in answered):
            values = ", ".join(f"{float(c.real):.9f}" for c in root.centre)
            return False, f"the real root ({values}) is not among the solutions"
    return (None, undecided) if undecided else (True, "")


def _as_one(loop: Loop, root: Enclosure, q: Sequence[acb]) -> bool:
    """Whether a vector and a root are one to the tolerance of solutions: the pose is kept half way between them."""
    apart = root.distance(q)
    if apart < _SOLUTION:
        return True
    return bool(apart < _BESIDE and largest(residual(loop.values(root.towards(q)))) < _SAME_POSE)
