"""The arm with one joint given, for the compiled solver of the others."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from urdf_ik._core import Solver
from urdf_ik.ik.families.general import SINGULAR
from urdf_ik.ik.families.parts.explanations import off_by
from urdf_ik.ik.families.parts.family import FamilyMember, columns, self_motion
from urdf_ik.ik.families.parts.written import Numbers, written
from urdf_ik.kinematics.chain import Chain, is_redundant, kinds_of, sampled, typical_stretch
from urdf_ik.kinematics.chain.free_axis import turning
from urdf_ik.kinematics.chain.redundancy import Redundancy, locked_joint
from urdf_ik.kinematics.structure import Structure, analyse
from urdf_ik.support.angles import amount
from urdf_ik.support.text import quoted
from urdf_ik.support.tolerances import DEFAULT
from urdf_ik.typing import Array

Choose = Callable[[Structure, Chain], FamilyMember | None]

# If the Jacobian without an end joint nearly loses rank everywhere (smallest singular value below _POOR, lengths as
# shares of the size), a joint in the middle is held if its smallest singular value is _BETTER times as large.
_POOR, _BETTER = 1e-3, 30.0


def prepare_degenerate(chain: Chain, six: Sequence[Choose]) -> FamilyMember | None:
    """The plan of seven joints that holds one in the middle; None where an end joint will do.

    Args:
        chain: seven joints.
        six: each takes six joints, the cheaper ones first.
    """
    ends = max(typical_stretch(_locked_at_zero(chain, k)) for k in (0, 6))
    if ends >= _POOR:
        return None
    for k in range(6):
        if _is_shared(chain, k) and not is_redundant(rest := _locked_at_zero(chain, k)):
            relations = analyse(rest)
            plan = next((plan for each in six if (plan := each(relations, rest)) is not None), None)
            if plan is not None:
                return _held_shared(chain, k, plan)
    k = freest(chain)
    if ends >= DEFAULT.singular and typical_stretch(_locked_at_zero(chain, k)) < _BETTER * ends:
        return None
    return _prepare_sampled(chain, k)


def freest(chain: Chain) -> int:
    """The joint without which the six others move the tip best, in as many ways as the seven do."""
    J = chain.jacobian(sampled(chain))
    J[:, :3] /= chain.size
    J[:, :, chain.prismatic] *= chain.size
    rank = int((np.median(np.linalg.svd(J, compute_uv=False), axis=0) > DEFAULT.singular).sum())
    left = [np.linalg.svd(np.delete(J, k, axis=2), compute_uv=False)[:, rank - 1] for k in range(chain.n)]
    return int(np.argmax(np.median(left, axis=1)))


def _locked_at_zero(chain: Chain, k: int) -> Chain:
    return chain.lock({chain.joint_names[k]: 0.0})


def _is_shared(chain: Chain, k: int) -> bool:
    """Whether joints ``k`` and ``k + 1`` turn about one axis, or slide along one direction, to rounding."""
    first, second = chain.H[k : k + 2]
    across = float(np.linalg.norm(np.cross(first, second)))
    if chain.prismatic[k] != chain.prismatic[k + 1] or across > DEFAULT.exact_structure:
        return False
    apart = np.linalg.norm(np.cross(chain.P[k + 1], first))
    return bool(chain.prismatic[k] or apart <= DEFAULT.exact_structure * chain.size)


def _held_shared(chain: Chain, k: int, plan: FamilyMember) -> FamilyMember:
    """The plan that gives joint ``k``, by that of the others with it at zero."""
    parameter = locked_joint(chain, k)
    still = np.zeros((3, 3, 4))
    still[0, :, :3] = np.eye(3)
    arm = Numbers(
        kind="one joint given",
        motion=still,
        turns=not bool(chain.prismatic[k]),
        last=False,
        value=parameter.default,
        solver=plan.solver.arm,
        before=k,
        opposite=bool(chain.H[k] @ chain.H[k + 1] < 0.0),
    )
    after = chain.joint_names[k + 1]
    return replace(
        plan,
        name=f"{kinds_of(chain)}, joint {k + 1} given: {plan.name}",
        reason=f"joints {k + 1} and {k + 2} have one axis; with joint {k + 1} given, of the six others {plan.reason}",
        method=f"Joint {k + 1} ({parameter.joint}) is given, {after} takes its value back. {plan.method}",
        solver=Solver(arm),
        parameters=(parameter,),
        self_motion=self_motion(chain, k),
        value_of=lambda Q, T: parameter.wrapped(Q[:, k : k + 1]),
        why=lambda T, values: f"{_with(parameter, values)}, or at any other: {plan.why(T)}",
    )


def _prepare_sampled(chain: Chain, k: int) -> FamilyMember:
    """The plan of seven joints that become singular everywhere when either end joint is given: ``k`` is."""
    parameter = locked_joint(chain, k)
    arm = Numbers(kind="sampled with one held", written=written(chain), held=k, value=parameter.default)

    def why(T: Array, values: Array) -> str:
        return f"{_with(parameter, values)}: {off_by(chain.lock({parameter.joint: float(values[0])}), T)}"

    return SINGULAR.member(
        chain,
        arm,
        name=f"{kinds_of(chain)}, joint {k + 1} given: by search",
        reason="whichever of the first and the last joint is given, the six others are singular everywhere",
        method=f"Joint {k + 1} ({parameter.joint}) is given; Newton's method on the URDF as written from fixed starts: "
        "what the six others leave, samples where that is a continuum",
        parameters=(parameter,),
        self_motion=None if is_redundant(chain) else self_motion(chain, k),
        value_of=lambda Q, T: parameter.wrapped(Q[:, k : k + 1]),
        why=why,
    )


def _with(parameter: Redundancy, values: Array) -> str:
    """The beginning of an explanation: which joint is given, and where."""
    return f"with {quoted(parameter.joint)} at {amount(values[0], parameter.unit, '.6g')}"


KEPT = 1024
"""Number of plans that are kept, the most recently used ones."""
_SAMPLES = (0.137, 0.411, 0.659, 0.893)
"""Shares of the joint's range at which the family of the other joints is determined."""


def prepare_middle(
    chain: Chain, k: int, number: int, plan_of: Callable[[Chain], FamilyMember | None]
) -> FamilyMember | None:
    """The plan that holds joint ``k``; None where the other joints have no solver.

    Args:
        chain: seven joints or more.
        k: the joint.
        number: the joint's number in texts.
        plan_of: finds the plan of the others' chain.
    """
    parameter = locked_joint(chain, k)
    low, high = parameter.range if np.isfinite(parameter.range).all() else (-chain.size, chain.size)
    name = chain.joint_names[k]

    @lru_cache(KEPT)
    def at_value(value: float) -> FamilyMember | None:
        return plan_of(chain.lock({name: value}))

    plans: list[FamilyMember] = []
    for share in _SAMPLES:
        if (plan := at_value(low + share * (high - low))) is None:
            return None
        plans.append(plan)
    if (plan := at_value(parameter.default)) is not None:
        plans.append(plan)
    first = plans[0]
    same = all(plan.branches == first.branches for plan in plans)
    branches = first.branches if same else columns(max(len(plan.branches) for plan in plans))

    def why(T: Array, values: Array) -> str:
        plan = at_value(float(values[0]))
        rest = "the other joints have no solver" if plan is None else plan.explain(T, values[1:])
        return f"{_with(parameter, values)}: {rest}"

    def value_of(Q: Array, T: Array) -> Array:
        own = parameter.wrapped(Q[:, k : k + 1])
        if not first.parameters:
            return own
        rows = []
        for q, pose in zip(Q, T, strict=True):
            plan: Any = at_value(float(q[k]))
            rows.append(plan.value_of(np.delete(q, k)[None], pose[None])[0])
        return np.hstack([own, np.array(rows).reshape(len(Q), -1)])

    parameters = (parameter, *first.parameters)
    solver: Any = _SolverAtEach(at_value, k, chain.n, len(branches), parameters)
    return replace(
        first,
        name=f"joint {number} given: {first.name}",
        reason=f"with joint {number} given, as asked, almost every value makes an arm of which {first.reason}",
        method=f"Joint {number} ({name}) is given, and the arm of the others is prepared for its value. {first.method}",
        branches=branches,
        solver=solver,
        parameters=parameters,
        self_motion=self_motion(chain, k) if chain.n == 7 and not first.parameters else None,
        value_of=value_of,
        why=why,
        swivel=None,
    )


class PythonSolver:
    """What solutions ask of a compiled solver, for one whose ``solve`` is Python."""

    numbers = 16
    joints: int
    branches: int
    parameters = 0
    solve: Callable[..., int]

    def one(self, *_: Any) -> None:
        """None: single poses are solved by ``solve``."""

    def one_near(self, *_: Any) -> None:
        """None: single poses are solved by ``solve``."""

    def many(
        self,
        kind: Any,
        solver: Any,
        branches: tuple[str, ...],
        T: Array,
        q_ref: Array | None,
        values: Array | None,
        threads: int | None,
        out: Any,
    ) -> Any:
        """The solutions of poses (..., 4, 4) as a ``kind``, in the memory of ``out`` if given; None: one is no pose."""
        batch = T.shape[:-2]
        count = int(np.prod(batch))
        q = np.empty((count, self.branches, self.joints))
        flags = np.empty((count, self.branches), np.uint8)
        if self.solve(T.reshape(-1, 4, 4), q_ref, q, flags, values, threads or 1) >= 0:
            return None
        q, flags = q.reshape(*batch, *q.shape[1:]), flags.reshape(*batch, flags.shape[1])
        if out is None:
            return kind(solver, T, q, flags, branches, redundancy=values)
        out._poses[...], out._q[...], out._info[...] = T, q, flags
        return out


class _SolverAtEach(PythonSolver):
    """Solves by a plan for each value of a joint."""

    def __init__(
        self,
        at_value: Callable[[float], FamilyMember | None],
        k: int,
        joints: int,
        branches: int,
        parameters: Sequence[Redundancy],
    ) -> None:
        """Take the plans of the other joints by the value of joint ``k``, and the parameters, the joint's first."""
        self._at_value, self._k = at_value, k
        self.joints, self.branches, self.parameters = joints, branches, len(parameters)
        self._defaults = np.array([each.default for each in parameters])

    def solve(
        self,
        T: Array,
        q_ref: Array | None,
        q: Array,
        flags: NDArray[np.uint8],
        values: Array | None = None,
        threads: int = 1,
    ) -> int:
        """Solve poses (m, 4, 4) into q (m, B, n) and flags (m, B); index of the first that is no pose, or -1."""
        given = np.tile(self._defaults, len(T)) if values is None else values
        given = given.reshape(len(T), self.parameters)
        q[...], flags[...] = np.nan, 0
        k, others = self._k, np.delete(np.arange(self.joints), self._k)
        for value in np.unique(given[:, 0]):
            rows = np.flatnonzero(given[:, 0] == value)
            plan = self._at_value(float(value))
            if plan is None:
                continue
            count = len(plan.branches)
            found, marks = np.empty((len(rows), count, len(others))), np.empty((len(rows), count), np.uint8)
            near = None if q_ref is None else np.ascontiguousarray(q_ref[others])
            rest = np.ascontiguousarray(given[rows, 1:]).reshape(-1) if self.parameters > 1 else None
            bad = plan.solver.solve(np.ascontiguousarray(T[rows]), near, found, marks, rest, threads)
            if bad >= 0:
                return int(rows[bad])
            count = min(count, self.branches)
            q[rows[:, None, None], np.arange(count)[:, None], others] = found[:, :count]
            q[rows, :count, k] = np.where(marks[:, :count] & 1, value, np.nan)
            flags[rows, :count] = marks[:, :count]
        return -1


COSTS = ("in closed form", "by a quartic", "in closed form nearby, and refined", "by elimination")
"""How six joints are solved, the cheapest first: 0.3, 1, 10 and 60 us a pose, by the tables of docs/speed.md."""


def prepare(
    chain: Chain, seven: Choose, six_ways: Sequence[Choose], given: tuple[str, ...] = ()
) -> FamilyMember | None:
    """The plan that holds all joints but six; None where no six joints have a solver.

    Args:
        chain: seven joints or more.
        seven: takes seven joints by a family of their own.
        six_ways: each takes six joints, the cheaper ones first; a later one is used if no earlier one takes them.
        given: names of joints to hold. If too few are named, the end joint whose others have the cheapest solver is
            held too; a joint in the middle only if no end joint is possible.
    """
    if chain.n == 7 and not given and (in_the_middle := prepare_degenerate(chain, six_ways)) is not None:
        return in_the_middle
    for six in six_ways:
        plan = _prepared(chain, seven, six, given, tuple(range(1, chain.n + 1)))
        if plan is not None:
            return plan
    if given:
        return None
    others = (prepare(chain, seven, six_ways, (name,)) for name in chain.joint_names[1:-1])
    return next((plan for plan in others if plan is not None), None)


def _prepared(
    chain: Chain, seven: Choose, six: Choose, given: tuple[str, ...], numbers: tuple[int, ...]
) -> FamilyMember | None:
    """See :func:`prepare`; the joints are called by ``numbers``."""
    if chain.n == 6:
        return None if given or is_redundant(chain) else six(analyse(chain), chain)
    if chain.n == 7 and not given and (own := seven(analyse(chain), chain)) is not None:
        return own
    last = chain.n - 1
    named = [chain.joint_names.index(name) for name in given]
    middle = next((k for k in named if 0 < k < last), None)
    if middle is not None:
        name, *others = (chain.joint_names[middle], *(n for n in given if n != chain.joint_names[middle]))

        def at(rest: Chain) -> FamilyMember | None:
            return _prepared(rest, seven, six, tuple(others), _without(numbers, middle))

        return prepare_middle(chain, middle, numbers[middle], at)
    ends = [k for k in named if k in (0, last)] or [last, 0]
    plans: dict[int, FamilyMember] = {}
    for k in ends:
        name = chain.joint_names[k]
        others = [each for each in given if each != name]
        plan = _prepared(chain.lock({name: 0.0}), seven, six, tuple(others), _without(numbers, k))
        if plan is not None:
            plans[k] = plan
            if plan.family.by_elimination:
                break  # the other end costs the same
    if not plans:
        return None
    k = min(plans, key=lambda end: cost(plans[end]))
    why = "as asked" if given else f"whose others are solved {COSTS[cost(plans[k])]}"
    return _held(chain, k, plans[k], numbers[k], why)


def _without(numbers: tuple[int, ...], k: int) -> tuple[int, ...]:
    return (*numbers[:k], *numbers[k + 1 :])


def cost(plan: FamilyMember) -> int:
    """Index in ``COSTS``: exact closed forms, exact ones with a quartic, those near an ideal arm, eliminations."""
    if plan.family.by_elimination:
        return 3
    return int(not plan.family.by_quadratics) if plan.is_exact else 2


def _held(chain: Chain, k: int, plan: FamilyMember, number: int, why: str) -> FamilyMember:
    parameter = locked_joint(chain, k)
    motion, turns, last = _motion_back(chain, k), not bool(chain.prismatic[k]), k > 0
    arm = Numbers(
        kind="one joint given",
        motion=motion,
        turns=turns,
        last=last,
        value=parameter.default,
        solver=plan.solver.arm,
        before=-1,  # an end joint
        opposite=False,
    )

    def value_of(Q: Array, T: Array) -> Array:
        return np.hstack([parameter.wrapped(Q[:, k : k + 1]), plan.value_of(np.delete(Q, k, axis=1), T)])

    def why_at(T: Array, values: Array) -> str:
        value = float(values[0])
        back = np.eye(4)
        back[:3] = np.tensordot([1.0, np.cos(value), np.sin(value)] if turns else [1.0, value, 0.0], motion, 1)
        return f"{_with(parameter, values)}: {plan.explain(T @ back if last else back @ T, values[1:])}"

    kinds = kinds_of(chain)
    if chain.prismatic[k]:
        kinds = f"{kinds_of(chain.lock({chain.joint_names[k]: 0.0}))} on a slide"
    others = ("six", "seven", "eight")[chain.n - 7]
    return replace(
        plan,
        name=f"{kinds}: {plan.name}" if chain.prismatic[k] else f"{kinds}, joint {number} given: {plan.name}",
        reason=f"with joint {number} given, {why}: {plan.reason}",
        method=f"Joint {number} ({parameter.joint}) is given, the {others} others are solved. {plan.method}",
        solver=Solver(arm),
        parameters=(parameter, *plan.parameters),
        self_motion=None if plan.parameters else self_motion(chain, k),
        value_of=value_of,
        why=why_at,
        swivel=None,
    )


def _motion_back(chain: Chain, k: int) -> Array:
    """(3, 3, 4) the inverse of the motion of joint ``k``, in the base's frame or, of the last joint, in the tip's."""
    h, p = chain.H[k], chain.points[k]
    if k:
        h, p = chain.R_tip.T @ h, chain.R_tip.T @ (p - chain.P.sum(axis=0))
    if not chain.prismatic[k]:
        return turning(-h, p)
    motion = np.zeros((3, 3, 4))
    motion[0, :, :3] = np.eye(3)
    motion[1, :, 3] = -h
    return motion
