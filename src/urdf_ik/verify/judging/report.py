"""Judgement: the report on a solver, counts by kind of pose, and every fault with its pose."""

from __future__ import annotations

from dataclasses import dataclass
from xml.sax.saxutils import escape, quoteattr

from urdf_ik.errors import printable
from urdf_ik.support.text import Section
from urdf_ik.verify.reports import Report, outcome

WRONG, MISSING, DOUBLED, OUTSIDE, FAILED = "wrong", "missing", "doubled", "outside limits", "failed"
FAULTS = (WRONG, MISSING, DOUBLED, FAILED)
"""Kinds of faults; a solution outside the limits is one only if the solver had to stay within them."""

_SHOWN = 6


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
    def passed(self) -> bool:
        """Whether nothing is wrong, missing or doubled at any pose."""
        return not self.faults and not self.unlooked

    def title(self) -> str:
        """Who was judged on what.

        Example:
            >>> Judgement("mine", "arm", "base", "tip", 5, 0, 1e-7, False, (), ()).title()
            'mine on arm, base to tip: 5 poses of each kind, seed 0'
        """
        return (
            f"{self.solver} on {self.robot}, {self.base} to {self.tip}: {self.n} poses of each kind, seed {self.seed}"
        )

    def sections(self) -> tuple[Section, ...]:
        """The counts as a table.

        Example:
            >>> import urdf_ik
            >>> from urdf_ik.verify import judge
            >>> arm = urdf_ik.load("puma_560")
            >>> judge(arm, lambda T: arm.ik(T).to_array(), n=1).sections()[0].rows[0][:4]
            ('random', '1', '8', '8')
        """
        header = ("poses", "number", "expected", "found", "wrong", "missing", "doubled", "outside limits", "failed")
        rows = tuple(
            (k.name, *map(str, (k.poses, k.expected, k.found, k.wrong, k.missing, k.doubled, k.outside, k.failed)))
            for k in self.kinds
        )
        return (Section("", header, rows, left=("poses",)),)

    def lines(self) -> tuple[str, ...]:
        """The first faults of each sort, and how to see their poses again.

        Example:
            >>> Judgement("mine", "arm", "base", "tip", 5, 0, 1e-7, False, (), ()).lines()
            ()
        """
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

    def verdict(self) -> str:
        """The last line.

        Example:
            >>> Judgement("mine", "arm", "base", "tip", 5, 0, 1e-7, False, (), ()).verdict()
            'PASSED: 0 poses, nothing wrong, missing or doubled'
        """
        counts = [(sum(each.fault == fault for each in self.faults), fault) for fault in (*FAULTS, OUTSIDE)]
        parts = ", ".join(f"{count} {fault}" for count, fault in counts if count)
        poses = sum(kind.poses for kind in self.kinds)
        ended, left_out = outcome(self.passed, bool(self.faults)), f"; {self.unlooked}" if self.unlooked else ""
        return f"{ended}: {poses} poses, {parts or 'nothing wrong, missing or doubled'}{left_out}"

    def to_junit(self) -> str:
        """JUnit XML: a test suite a kind of pose, a test case a sort of fault.

        Example:
            >>> Judgement("mine", "arm", "base", "tip", 5, 0, 1e-7, False, (), ()).to_junit()[:5]
            '<?xml'
        """
        suites = []
        for kind in self.kinds:
            cases = []
            for fault in (*FAULTS, OUTSIDE) if self.within_limits else FAULTS:
                own = [each for each in self.faults if each.fault == fault and each.kind == kind.name]
                text = "".join(f"{printable(each, 1000)}\n" for each in own)
                body = f"<failure message={quoteattr(f'{len(own)} {fault}')}>{escape(text)}</failure>" if own else ""
                cases.append(
                    f"<testcase classname={quoteattr(kind.name)} name={quoteattr(f'none {fault}')}>{body}</testcase>"
                )
            failures = sum("<failure" in case for case in cases)
            suites.append(
                f'<testsuite name={quoteattr(kind.name)} tests="{len(cases)}" failures="{failures}">'
                f"{''.join(cases)}</testsuite>"
            )
        if self.unlooked:
            suites.append(
                '<testsuite name="time limit" tests="1" failures="1"><testcase classname="time limit" '
                f'name="every pose"><failure message={quoteattr(self.unlooked)}></failure></testcase></testsuite>'
            )
        head = '<?xml version="1.0" encoding="utf-8"?>'
        return f"{head}\n<testsuites name={quoteattr(self.title())}>{''.join(suites)}</testsuites>\n"
