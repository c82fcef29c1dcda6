"""check_proof(): whether answers that claim to be complete are, by theorems evaluated in ball arithmetic."""

from collections.abc import Sequence
from dataclasses import dataclass

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
from urdf_ik.ik.solutions import IKSolutions
from urdf_ik.kinematics.chain import Chain
from urdf_ik.support.watch import Progress
from urdf_ik.typing import Array
from urdf_ik.verify.proof.elimination import zeros
from urdf_ik.verify.proof.enclosure import between, enclosed
from urdf_ik.verify.proof.loop import Loop, exact, largest, midpoints, residual

_PRECISIONS = 2048, 8192  # bits; the first isolates the zeros of nearly every pose
_NEAR = 1e-2  # rad; zeros so near to the circle may belong to a solution of several, and stand so far from it
_SAME_POSE = 1e-10  # share of the arm's size, rad
_SOLUTION = 1e-6  # rad; from a root to the solution that is it


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

    The loop equations are set up anew from the chain's screw axes and the pose, and the zeros of their determinant are
    isolated. Each zero on the circle leads to one root, which is enclosed. The roots have to be the answer's solutions.

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
        for precision in _PRECISIONS:
            loop = Loop.of(arm.chain, T[i], precision)
            verdict, reason = examine(loop, q[i, valid[i]], clustered=status == "clustered")
            if verdict is not None:
                break
        found[verdict].append(_Refusal(i, status, reason))
    unproven, answers = looked_at - sum(map(len, found.values())), (tuple(found[None]), tuple(found[False]))
    return ProofCheck(arm.name, looked_at, unproven, len(found[True]), *answers, watch.unlooked)


def _same_axes(a: Chain, b: Chain) -> bool:
    """Whether two chains have the same screw axes, to the last bit."""
    parts = ("H", "P", "R_tip", "prismatic")
    return a is b or all(np.array_equal(getattr(a, part), getattr(b, part)) for part in parts)


def examine(loop: Loop, solutions: Array, *, clustered: bool = False) -> tuple[bool | None, str]:
    """Whether ``solutions`` are all solutions of the loop; None where this is not decided; and why.

    Args:
        loop: the loop equations of the pose.
        solutions: (k, 6) rad, the answer.
        clustered: whether the answer leaves some of its solutions to the rounding of the pose.
    """
    answer = [exact(q) for q in solutions]
    try:
        found = zeros(loop, _NEAR)
    except ArithmeticError as error:
        return None, str(error)
    roots: list[list[acb]] = []  # real ones of the arm as written, each enclosed
    others: list[list[acb]] = []  # real parts where a solution may stand for others
    singular: list[list[acb]] = []  # those where one has to
    for zero in found:
        real = [acb(x.real) for x in zero.q]
        single = enclosed(loop, zero.q if zero.off else real)
        if single is not None and not zero.off:
            roots.append(single.centre)
        elif not zero.off or _keeps_pose(loop, real):
            others.append(midpoints(real))
            if single is None or not any(abs(x.imag) > single.radius for x in single.centre):
                singular.append(others[-1])
    own: list[list[int]] = [[] for _ in roots]
    undecided = ""
    for n, q in enumerate(answer):
        apart = [float(largest(between(root, q))) for root in roots]
        best = int(np.argmin(apart)) if apart else None
        if best is not None and (apart[best] < _SOLUTION or not clustered and _as_one(loop, roots[best], q)):
            own[best].append(n)
        elif any(_as_one(loop, other, q) for other in roots + others):
            undecided = (
                undecided if clustered else f"solution {n} stands for roots that are not told to be one real root"
            )
        elif clustered and _keeps_pose(loop, q):
            undecided = f"solution {n} keeps the pose, and is near no real root"
        else:
            return False, f"solution {n} is near no real root"
    answered = [root for root, by in zip(roots, own, strict=True) if by] + answer
    for root, by in zip(roots, own, strict=True):
        if len(by) > 1:
            return False, f"solutions {by[0]} and {by[1]} are one root"
        if not any(_as_one(loop, root, other) for other in answered):
            return False, f"the real root ({_text(root)}) is not among the solutions"
        if not by and not clustered:
            undecided = f"a solution stands for the real root ({_text(root)}) and for another"
    for other in singular:
        if not (clustered and any(_as_one(loop, other, q) for q in answered)):
            undecided = f"there may be a solution at ({_text(other)}), which is singular"
    return (None, undecided) if undecided else (True, "")


def _keeps_pose(loop: Loop, q: Sequence[acb]) -> bool:
    return bool(largest(residual(loop.values(q))) < _SAME_POSE)


def _as_one(loop: Loop, root: Sequence[acb], q: Sequence[acb]) -> bool:
    """Whether two joint vectors are one to the tolerance of solutions: the pose is kept half way between them."""
    steps = between(q, root)
    if largest(steps) < _SOLUTION:
        return True
    return bool(largest(steps) < _NEAR) and _keeps_pose(
        loop, midpoints([a + step / 2 for a, step in zip(root, steps, strict=True)])
    )


def _text(q: Sequence[acb]) -> str:
    return ", ".join(f"{float(x.real):.9f}" for x in q)
