"""Solutions of two arms for the same poses, and the distances between them."""

from __future__ import annotations

import re
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from urdf_ik.arm import Arm
from urdf_ik.cell.pinocchio_reference import Reference
from urdf_ik.ik.solutions import IKSolutions
from urdf_ik.support.angles import shortest
from urdf_ik.support.text import quoted
from urdf_ik.typing import Array
from urdf_ik.verify import arms
from urdf_ik.verify.comparison.report import BranchChange, Reach, ToolError

# 'solution 3', 'further 1': such a number says nothing about the posture, unlike 'elbow up'.
_NUMBERED = re.compile(r"\d+$")


class Drawn:
    """Joint vectors of an arm, drawn within its limits.

    Attributes:
        q: (n, dof) rad or m.
        reference: Pinocchio's model of the arm.
    """

    def __init__(self, arm: Arm, n: int, seed: int) -> None:
        self.reference = arms.reference_of(arm)
        lower, upper = self.reference.ranges.T
        self.arm = arm
        self.q: Array = np.random.default_rng(seed).uniform(lower, upper, (n, arm.dof))

    @cached_property
    def T(self) -> Array:
        """(n, 4, 4) their poses, as Pinocchio has them."""
        return self.reference.pose(self.q)


@dataclass(frozen=True, eq=False)
class Given:
    """Poses (m, 4, 4) [m] that no arm's joint vectors made."""

    T: Array


class Answers:
    """The solutions of two arms for the poses that one of them made."""

    def __init__(self, a: Arm, b: Arm, drawn: Drawn | Given) -> None:
        """Solve.

        Raises:
            UnsupportedArm: one of them cannot be solved.
        """
        self.a, self.b = _solve(a, drawn), _solve(b, drawn)

    @property
    def of_a(self) -> Array:
        """(m, n) rad or m, every solution of A."""
        return self.a.q[self.a.valid]

    def reach(self, made_by: str) -> Reach:
        """How many poses each has a solution for, and how many solutions."""
        within = [solutions.within_limits().count for solutions in (self.a, self.b)]
        return Reach(
            made_by=made_by,
            poses=len(self.a.count),
            solved=(_number(self.a.count), _number(self.b.count)),
            within_limits=(_number(within[0]), _number(within[1])),
            solutions=(int(self.a.count.sum()), int(self.b.count.sum())),
            same_number=_number(self.a.count == self.b.count),
        )

    def branches(self, order: list[int], signs: Array) -> tuple[BranchChange, ...]:
        """Every branch of A that has solutions, against B.

        Args:
            order: B's joints in A's order.
            signs: (n,) -1 for the joints that turn the other way in B, else 1. Where one does, names of branches mean
                other postures ('front' is said along the first axis), and the nearest posture counts.
        """
        theirs = {name: k for k, name in enumerate(self.b.branches) if not _NUMBERED.search(name)}
        theirs = theirs if (signs > 0.0).all() else {}
        out = []
        for k, name in enumerate(self.a.branches):
            rows = np.flatnonzero(self.a.valid[:, k])
            if not len(rows):
                continue
            mine, others = self.a.q[rows, k], self.b.q[rows][..., order]
            if name in theirs:
                column = np.full(len(rows), theirs[name])
            else:
                far = self._gap(mine[:, None], others * signs).max(axis=-1)
                column = np.argmin(np.where(self.b.valid[rows], far, np.inf), axis=1)
            gaps = self._gap(mine, others[np.arange(len(rows)), column])
            gaps = gaps[~np.isnan(gaps).any(axis=1)]  # where B has that solution
            nothing = np.full(len(order), np.nan)
            out.append(
                BranchChange(
                    branch=name,
                    matched="name" if name in theirs else "nearest",
                    poses=len(gaps),
                    unmatched=len(rows) - len(gaps),
                    median=_floats(np.median(gaps, axis=0) if len(gaps) else nothing),
                    worst=_floats(gaps.max(axis=0) if len(gaps) else nothing),
                )
            )
        return tuple(out)

    def _gap(self, q: Array, other: Array) -> Array:
        """Difference of each joint (..., n), that of an angle on the circle."""
        difference = np.abs(q - other)
        out: Array = np.where(self.a.rotary, np.abs(shortest(difference)), difference)
        return out


def paired(a: Arm, b: Arm) -> tuple[list[int] | None, str]:
    """B's joints in the order of A's, or None and the reason why they are not the same joints."""
    if a.dof != b.dof:
        return None, f"A has {a.dof} joints and B has {b.dof}"
    order = list(range(b.dof))
    if set(a.joint_names) == set(b.joint_names):
        order = [b.joint_names.index(name) for name in a.joint_names]
    for i, k in enumerate(order):
        if a.chain.prismatic[i] != b.chain.prismatic[k]:
            kinds = ["slides" if arm.chain.prismatic[j] else "turns" for arm, j in ((a, i), (b, k))]
            ours, theirs = quoted(a.joint_names[i]), quoted(b.joint_names[k])
            return None, f"joint {ours} of A {kinds[0]}, joint {theirs} of B {kinds[1]}"
    return order, ""


def cautions(a: Arm, b: Arm) -> list[str]:
    """Cautions about the comparison of the numbers of solutions."""
    out = []
    if a.task != b.task:
        out.append(f"like with like: A is asked for the {a.task}, B for the {b.task}, which is what each controls")
    elif a.dof != b.dof and min(a.dof, b.dof) < 6:
        out.append("all poses alike: with fewer than six joints an arm reaches only those of its own kind")
    for letter, arm, other in (("A", a, b), ("B", b, a)):
        if arm.redundancy is not None:
            own = "the one that made the pose" + ("" if _same_parameter(arm, other) else ", of other poses the default")
            out.append(
                f"all solutions of {letter}: with {arm.dof} joints a pose has infinitely many; counted are those at "
                f"one value of the redundancy parameter, {own}"
            )
    return out


def tool_error(a: Reference, b: Reference, q: Array, order: list[int]) -> ToolError | None:
    """Difference between the tip poses of A and B at joint vectors ``q`` (m, n) of A; None without one."""
    if not len(q):
        return None
    swapped = np.empty_like(q)
    swapped[:, order] = q
    position, rotation = b.errors(swapped, a.pose(q))
    return ToolError(len(q), _spread(position), _spread(rotation), _floats(q[int(np.argmax(position))]))


def _solve(arm: Arm, drawn: Drawn | Given) -> IKSolutions:
    """Solutions of ``arm`` for the poses of ``drawn``, as far as its task controls them."""
    values = None
    if isinstance(drawn, Drawn) and (arm is drawn.arm or _same_parameter(arm, drawn.arm)):
        values = arms.redundancy_at(drawn.arm, drawn.q)
    return arms.solutions_of(arm, drawn.T, values)


def _same_parameter(a: Arm, b: Arm) -> bool:
    one, other = arms.parameters_of(a), arms.parameters_of(b)
    return bool(one) and one == other


def _spread(values: Array) -> tuple[float, float, float]:
    """Median, 95th percentile, greatest."""
    return float(np.median(values)), float(np.percentile(values, 95.0)), float(values.max())


def _number(flags: NDArray[np.bool_] | NDArray[np.intp]) -> int:
    return int(np.count_nonzero(flags))


def _floats(values: Array) -> tuple[float, ...]:
    return tuple(float(value) for value in values)
