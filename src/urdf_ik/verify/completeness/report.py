"""Completeness: the report on two independent methods for all solutions."""

from __future__ import annotations

from dataclasses import dataclass

from urdf_ik.support.text import Section
from urdf_ik.verify.completeness.sameness import Unmatched
from urdf_ik.verify.crosscheck.properties import EXACT
from urdf_ik.verify.reports import Report, outcome

SOLVER, SECOND, BOTH = "the solver", "the second way", "both"

_HEADER = ("poses", "number", "solver", "second way", "one double root", "one continuum", "differences")


def in_words(near: float | None) -> str:
    """Where poses were planted."""
    if near is None:
        return "random"
    return f"{near:.0e} rad from a singularity" if near else "at right angles"


@dataclass
class Group:
    """The poses at one distance from a singularity.

    Attributes:
        near: how far [rad] from a singularity they were planted; None: random ones; 0: at right angles.
        poses: how many.
        solver: solutions that the arm's solver found.
        second: solutions that the second way found.
        double_roots: solutions of one that are a double root of the other.
        continua: representatives of a continuum that the other represents elsewhere.
        differences: solutions that only one of them has, and planted joint vectors that neither has.
    """

    near: float | None
    poses: int = 0
    solver: int = 0
    second: int = 0
    double_roots: int = 0
    continua: int = 0
    differences: int = 0

    def add(self, solver: int, second: int, answer: Unmatched) -> None:
        """Count one pose.

        Example:
            >>> import numpy as np
            >>> from urdf_ik.verify.completeness.sameness import Unmatched
            >>> group = Group(None)
            >>> group.add(8, 8, Unmatched(np.zeros((17, 6))))
            >>> group.poses, group.solver, group.differences
            (1, 8, 0)
        """
        self.poses += 1
        self.solver += solver
        self.second += second
        self.double_roots += answer.double_roots
        self.continua += answer.continua
        self.differences += len(answer.only_first) + len(answer.only_second) + answer.planted_lost

    def cells(self) -> tuple[str, ...]:
        """The row of a table.

        Example:
            >>> Group(None, poses=10, solver=80, second=80).cells()
            ('random', '10', '80', '80', '0', '0', '0')
        """
        place = in_words(self.near)
        numbers = self.poses, self.solver, self.second, self.double_roots, self.continua, self.differences
        return place, *map(str, numbers)


@dataclass(frozen=True)
class Difference:
    """One solution that not both ways found.

    Attributes:
        index: number of the pose.
        near: how far [rad] from a singularity it was planted; None: a random one; 0: at right angles.
        planted: (6,) rad, the joint vector that made it.
        q: (6,) rad, the solution.
        missed_by: ``SOLVER``, ``SECOND``, or ``BOTH``, which is said of planted joint vectors.
        branch: its branch, or what else it is called.
        nearest: largest angle [rad] to the nearest other solution of the pose; infinite where there is none.
        sigma_min: smallest singular value of the Jacobian there, lengths as shares of the arm's size.
        position_error: [m] under Pinocchio.
        rotation_error: [rad] under Pinocchio.
    """

    index: int
    near: float | None
    planted: tuple[float, ...]
    q: tuple[float, ...]
    missed_by: str
    branch: str
    nearest: float
    sigma_min: float
    position_error: float
    rotation_error: float

    @property
    def counts(self) -> bool:
        """Whether it speaks against the solver: a solution that it missed, or one that does not hold."""
        return self.missed_by != SECOND or max(self.position_error, self.rotation_error) > EXACT

    def place(self) -> str:
        """The pose, in words.

        Example:
            >>> q = (0.1,) * 6
            >>> Difference(7, 1e-4, q, q, SECOND, "solution 1", 0.5, 1e-5, 0.0, 0.0).place()
            'pose 7, 1e-04 rad from a singularity, planted q = [0.1, 0.1, 0.1, 0.1, 0.1, 0.1]'
        """
        where = in_words(self.near)
        return f"pose {self.index}, {where}, planted q = [{', '.join(map(repr, self.planted))}]"

    def __str__(self) -> str:
        return (
            f"missed by {self.missed_by}: {self.branch}, nearest other {self.nearest:.1e} rad, "
            f"sigma_min {self.sigma_min:.1e}, error {self.position_error:.1e} m, {self.rotation_error:.1e} rad, "
            f"q = [{', '.join(map(repr, self.q))}]"
        )


@dataclass(frozen=True, repr=False)
class Completeness(Report):
    """Two ways to all solutions of an arm, compared.

    Attributes:
        robot: the robot's name.
        base: base link.
        tip: tip link.
        joint_names: joints of a joint vector, base to tip.
        n: number of random poses, of poses near singularities, and of poses at right angles.
        seed: seed of the joint vectors that made them.
        reference: who measured the errors, with the version.
        solver: the arm's solver.
        second: what it was compared with.
        groups: counts by distance from a singularity, random ones first.
        differences: every one.
        unlooked: what the time limit left out; '' where every pose was compared.

    Example:
        >>> import urdf_ik
        >>> from urdf_ik.verify import completeness
        >>> report = completeness.compare(urdf_ik.load("puma_560"), n=1)
        >>> report.passed, len(report.differences)
        (True, 0)
    """

    robot: str
    base: str
    tip: str
    joint_names: tuple[str, ...]
    n: int
    seed: int
    reference: str
    solver: str
    second: str
    groups: tuple[Group, ...]
    differences: tuple[Difference, ...]
    unlooked: str = ""

    @property
    def passed(self) -> bool:
        """Whether nothing speaks against the solver.

        It must have every solution that the second way found and every planted joint vector, and what only it has must
        reach the pose under Pinocchio. What the second way missed is reported, but no fault of the solver.
        """
        return not self._speaks_against and not self.unlooked

    @property
    def _speaks_against(self) -> bool:
        return any(difference.counts for difference in self.differences)

    def title(self) -> str:
        """The arm, the two ways, and who measured them.

        Example:
            >>> import urdf_ik
            >>> from urdf_ik.verify import completeness
            >>> completeness.compare(urdf_ik.load("puma_560"), n=1).title().splitlines()[0].split(":")[0]
            'puma_560, base_link to tool0'
        """
        arm = f"{self.robot}, {self.base} to {self.tip}"
        title = f"{arm}: all solutions by two ways, seed {self.seed}, {self.reference}"
        return f"{title}\nsolver:     {self.solver}\nsecond way: {self.second}"

    def sections(self) -> tuple[Section, ...]:
        """A table with a row for each distance from a singularity.

        Example:
            >>> import urdf_ik
            >>> from urdf_ik.verify import completeness
            >>> completeness.compare(urdf_ik.load("puma_560"), n=1).sections()[0].rows[0][:2]
            ('random', '1')
        """
        return (Section("", _HEADER, tuple(group.cells() for group in self.groups), left=("poses",)),)

    def lines(self) -> tuple[str, ...]:
        """Every difference under its pose, those that speak against the solver first.

        Example:
            >>> import urdf_ik
            >>> from urdf_ik.verify import completeness
            >>> completeness.compare(urdf_ik.load("puma_560"), n=1).lines()
            ()
        """
        lines, pose = [], None
        for difference in sorted(self.differences, key=lambda d: (not d.counts, d.index)):
            if (difference.counts, difference.index) != pose:
                pose = difference.counts, difference.index
                lines.append(difference.place())
            lines.append(f"    {difference}")
        return (*lines, "") if lines else ()

    def verdict(self) -> str:
        """The last line: who missed how many.

        Example:
            >>> import urdf_ik
            >>> from urdf_ik.verify import completeness
            >>> completeness.compare(urdf_ik.load("puma_560"), n=1).verdict()
            'PASSED: 3 poses, no difference'
        """
        poses = sum(group.poses for group in self.groups)
        missed = [difference.missed_by for difference in self.differences]
        parts = [f"{missed.count(who)} missed by {who}" for who in (SOLVER, SECOND, BOTH) if who in missed]
        ended, left_out = outcome(self.passed, self._speaks_against), f"; {self.unlooked}" if self.unlooked else ""
        return f"{ended}: {poses} poses, {', '.join(parts) or 'no difference'}{left_out}"
