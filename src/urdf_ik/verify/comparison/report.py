"""Comparison: the report on two arms. Its fields are in m and rad; its text shows mm and degrees."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from urdf_ik.support.display import html_of, short
from urdf_ik.support.text import Section
from urdf_ik.verify.change import DEFAULT, Difference, same_limit, summed
from urdf_ik.verify.reports import Written

_MM = 1000.0


@dataclass(frozen=True)
class Side:
    """One of the two arms.

    Attributes:
        robot: the robot's name.
        source: where its URDF was read from.
        base: base link.
        tip: tip link.
        joint_names: base to tip.
        prismatic: (n,) true for joints that slide.
    """

    robot: str
    source: str
    base: str
    tip: str
    joint_names: tuple[str, ...]
    prismatic: tuple[bool, ...]


@dataclass(frozen=True)
class Fact:
    """One thing that is known of both arms' structure, in words."""

    what: str
    a: str
    b: str

    @property
    def same(self) -> bool:
        """Whether it is the same for both."""
        return self.a == self.b


@dataclass(frozen=True)
class AxisChange:
    """How a joint axis of B lies to that of A at q = 0, each in its own base.

    Attributes:
        joint: the joint's name in A.
        joint_b: its name in B.
        angle: between the directions, 0 to pi [rad].
        distance: of the axis of B from the origin of A's joint [m]; 0 for a joint that slides, whose axis has no place.
        flipped: whether the direction is the opposite one, so that the joint turns the other way.
    """

    joint: str
    joint_b: str
    angle: float
    distance: float
    flipped: bool


@dataclass(frozen=True)
class LimitChange:
    """The limits of a joint, lower and upper [rad or m], infinite where there is no limit."""

    joint: str
    joint_b: str
    a: tuple[float, float]
    b: tuple[float, float]

    @property
    def same(self) -> bool:
        """Whether both limits are the same to rounding."""
        return all(same_limit(mine, other) for mine, other in zip(self.a, self.b, strict=True))


@dataclass(frozen=True)
class Reach:
    """Solutions of both arms for the same poses.

    Attributes:
        made_by: 'A' or 'B', the arm whose joint vectors, drawn within its limits, made the poses; 'you' for given ones.
        poses: number of poses.
        solved: number of poses with a solution, for A and for B.
        within_limits: number of poses with a solution within the limits, for A and for B.
        solutions: number of solutions over all poses, for A and for B.
        same_number: number of poses for which both arms have the same number of solutions.
    """

    made_by: str
    poses: int
    solved: tuple[int, int]
    within_limits: tuple[int, int]
    solutions: tuple[int, int]
    same_number: int


@dataclass(frozen=True)
class BranchChange:
    """Joint values of one branch of A against those of B, over the poses that A's joint vectors made.

    Attributes:
        branch: its name in A.
        matched: 'name' where B has a branch of that name and no axis is flipped, else 'nearest': of each pose's
            solutions in B the nearest, joints that turn the other way taken with the other sign.
        poses: number of poses compared.
        unmatched: number of solutions of A without a counterpart in B.
        median: (n,) rad or m, median difference of each joint, for angles on the circle; NaN if none was compared.
        worst: (n,) rad or m, greatest difference of each joint, likewise.
    """

    branch: str
    matched: str
    poses: int
    unmatched: int
    median: tuple[float, ...]
    worst: tuple[float, ...]


@dataclass(frozen=True)
class ToolError:
    """Difference between the tip poses of A and B at the same joint vectors, both computed by Pinocchio.

    Attributes:
        joint_vectors: how many were tried: A's solutions of the poses that it made.
        position: median, 95th percentile and worst [m].
        rotation: the same [rad].
        q: (n,) rad or m, the joint vector of the worst position.
    """

    joint_vectors: int
    position: tuple[float, float, float]
    rotation: tuple[float, float, float]
    q: tuple[float, ...]


@dataclass(frozen=True, repr=False)
class Comparison(Written):
    """Two arms, compared; ``print`` shows it as tables.

    Attributes:
        differences: what is different beyond rounding, or the tolerances given, in words.
        a: the first arm.
        b: the second arm.
        n: number of poses that each of them made.
        seed: seed of the joint vectors.
        structure: what is known of their axes and how they are solved.
        axes: joint by joint; empty where their numbers differ.
        tip: distance [m] and angle [rad] between the tips at q = 0, each in its own base.
        limits: joint by joint; empty where their numbers differ.
        farthest: greatest distance [m] of the tip from the base's origin that sampled joint vectors show, of A and B.
        reach: the poses that A made, and those that B made; empty where one of them cannot be solved.
        branches: joint values, branch by branch; empty where they cannot be compared.
        tool: what happens when A's joint vectors are used on B; None where they cannot be.
        notes: what was not compared, and why.

    Example:
        >>> import urdf_ik
        >>> comparison = urdf_ik.compare(urdf_ik.load("planar_2r"), urdf_ik.load("planar_2r_unit"), n=5)
        >>> [round(length, 3) for length in comparison.farthest]
        [0.196, 2.0]
    """

    differences: tuple[Difference, ...]
    a: Side
    b: Side
    n: int
    seed: int
    structure: tuple[Fact, ...]
    axes: tuple[AxisChange, ...]
    tip: tuple[float, float]
    limits: tuple[LimitChange, ...]
    farthest: tuple[float, float]
    reach: tuple[Reach, ...]
    branches: tuple[BranchChange, ...]
    tool: ToolError | None
    notes: tuple[str, ...]

    @property
    def same(self) -> bool:
        """Whether both are the same arm, to rounding or the tolerances given."""
        return not self.differences

    def to_dict(self) -> dict[str, Any]:
        """The comparison as plain lists, numbers and text; numbers that are not finite are the text 'inf', 'nan'.

        Example:
            >>> import urdf_ik
            >>> comparison = urdf_ik.compare(urdf_ik.load("planar_2r"), urdf_ik.load("planar_2r_unit"), n=5)
            >>> comparison.to_dict()["b"]["robot"]
            'planar_2r_unit'
        """
        return {"same": self.same, "units": {"length": "m", "angle": "rad"}, **super().to_dict()}

    def verdict(self) -> str:
        """In a line, whether they differ.

        Example:
            >>> import urdf_ik
            >>> arm = urdf_ik.load("planar_2r")
            >>> urdf_ik.compare(arm, arm, n=5).verdict()
            'same to rounding'
        """
        count = len(self.differences)
        return f"{count} difference{'' if count == 1 else 's'}" if count else "same to rounding"

    def __repr__(self) -> str:
        return short(f"Comparison of {self.a.robot} and {self.b.robot}: {self.verdict()}", summed(self.differences))

    def _repr_html_(self) -> str:
        return html_of(f"{self.a.robot} and {self.b.robot}", self.verdict(), self.same, self.sections()[1:])

    def sections(self) -> tuple[Section, ...]:
        """The tables of the text, in order.

        Example:
            >>> import urdf_ik
            >>> comparison = urdf_ik.compare(urdf_ik.load("planar_2r"), urdf_ik.load("planar_2r_unit"), n=5)
            >>> print(comparison.sections()[4])
            limits: 2 of 2 joints differ
            joint    A lower  A upper  B lower  B upper  unit
            -------  -------  -------  -------  -------  ----
            joint_1     -105       99     -180      180  deg
            joint_2     -145     25.5     -180      180  deg
        """
        return tuple(section for make in _SECTIONS if (section := make(self)) is not None)

    def __str__(self) -> str:
        return "\n\n".join(map(str, self.sections()))


def _sides(comparison: Comparison) -> Section:
    named = (("A", comparison.a), ("B", comparison.b))
    return Section("\n".join(f"{letter}: {s.robot}, {s.base} to {s.tip} ({s.source})" for letter, s in named))


def _differences(comparison: Comparison) -> Section:
    return Section(comparison.verdict(), remarks=tuple(f"- {each}" for each in summed(comparison.differences)))


def _structure(comparison: Comparison) -> Section:
    facts = comparison.structure
    differ = sum(not fact.same for fact in facts)
    title = f"structure: {'the same' if not differ else f'{differ} of {len(facts)} facts differ'}"
    rows = tuple((fact.what, fact.a, fact.b, "" if fact.same else "differs") for fact in facts)
    return Section(title, ("", "A", "B", " "), rows, left=("", "A", "B", " "))


def _frames(comparison: Comparison) -> Section | None:
    distance, angle = comparison.tip
    tip = f"tip at q = 0: {_mm(distance)} mm and {_deg(angle)} deg apart"
    if distance <= DEFAULT.distance and angle <= DEFAULT.angle:
        tip = "tip at q = 0: at the same place"
    far = "farthest sampled tip from the base: A {:.4f} m, B {:.4f} m".format(*comparison.farthest)
    rows = tuple(
        (_pair(c.joint, c.joint_b), _deg(c.angle), _mm(c.distance), "flipped" if c.flipped else "")
        for c in comparison.axes
        if c.angle > DEFAULT.angle or c.distance > DEFAULT.distance
    )
    title = "frames: " + (f"{len(rows)} of {len(comparison.axes)} axes moved" if rows else "no axis moved")
    title = title if comparison.axes else "frames"
    return Section(title, ("joint", "turned [deg]", "moved [mm]", ""), rows, (tip, far), left=("joint", ""))


def _limits(comparison: Comparison) -> Section | None:
    if not comparison.limits:
        return None
    changed = [(change, slides) for change, slides in zip(comparison.limits, comparison.a.prismatic, strict=True)
               if not change.same]  # fmt: skip
    rows = tuple((_pair(c.joint, c.joint_b), *_bounds(c, slides)) for c, slides in changed)
    title = f"limits: {f'{len(rows)} of {len(comparison.limits)} joints differ' if rows else 'the same'}"
    return Section(title, ("joint", "A lower", "A upper", "B lower", "B upper", "unit"), rows, left=("joint", "unit"))


def _reach(comparison: Comparison) -> Section | None:
    rows = []
    for reach in comparison.reach:
        for k, letter in enumerate("AB"):
            rows.append(
                (
                    f"{reach.poses} poses of {reach.made_by}",
                    letter,
                    str(reach.solved[k]),
                    str(reach.within_limits[k]),
                    str(reach.solutions[k]),
                    f"{reach.solutions[k] / reach.poses:.2f}",
                    str(reach.same_number) if k == 0 else "",
                )
            )
    header = ("asked for", "arm", "reached", "within limits", "solutions", "a pose", "same in both")
    return Section("reach and solutions", header, tuple(rows), left=("asked for", "arm")) if rows else None


def _branches(comparison: Comparison) -> Section | None:
    if not comparison.branches:
        return None
    slides = comparison.a.prismatic
    units = ["mm" if sliding else "deg" for sliding in slides]
    header = ("branch", "matched by", "poses", "lost", *(f"q{i + 1} [{unit}]" for i, unit in enumerate(units)), "worst")
    rows = tuple(
        (
            branch.branch,
            branch.matched,
            str(branch.poses),
            str(branch.unmatched),
            *(_value(value, sliding) for value, sliding in zip(branch.median, slides, strict=True)),
            _worst(branch.worst, slides),
        )
        for branch in comparison.branches
    )
    title = f"joint differences, branch by branch: medians over {comparison.n} poses of A, and the worst"
    return Section(title, header, rows, left=("branch", "matched by", "worst"))


def _tool(comparison: Comparison) -> Section | None:
    tool = comparison.tool
    if tool is None:
        return None
    rows = (
        ("position [mm]", *map(_mm, tool.position)),
        ("rotation [deg]", *map(_deg, tool.rotation)),
    )
    at = f"worst at q = [{', '.join(f'{value:.6g}' for value in tool.q)}] (rad, m)" if any(tool.position) else ""
    title = f"tool error when A's joint vectors ({tool.joint_vectors}) are used on B"
    return Section(title, ("", "median", "95 %", "worst"), rows, (at,) if at else (), left=("",))


def _notes(comparison: Comparison) -> Section | None:
    return (
        Section("not compared", remarks=tuple(f"- {note}" for note in comparison.notes)) if comparison.notes else None
    )


def _pair(a: str, b: str) -> str:
    return a if a == b else f"{a} / {b}"


def _bounds(change: LimitChange, slides: bool) -> tuple[str, ...]:
    numbers = [_value(value, slides) for value in (*change.a, *change.b)]
    return *numbers, "mm" if slides else "deg"


def _worst(values: Sequence[float], slides: Sequence[bool]) -> str:
    """The joint that is farthest off, with its value."""
    if math.isnan(values[0]):
        return "-"
    k = max(range(len(values)), key=lambda i: values[i])
    return f"q{k + 1} {_value(values[k], slides[k])}" if values[k] else "0"


def _value(value: float, slides: bool) -> str:
    return _mm(value) if slides else _deg(value)


def _mm(value: float) -> str:
    return _number(value * _MM)


def _deg(value: float) -> str:
    return _number(math.degrees(value))


def _number(value: float) -> str:
    """Four digits after the point, fewer for what is exact; rounding errors in the form 1e-13."""
    if math.isnan(value):
        return "-"
    if value == 0.0:
        return "0"
    return f"{value:.4g}" if abs(value) < 1e-3 else f"{value:.4f}".rstrip("0").rstrip(".")


_SECTIONS = (_sides, _differences, _structure, _frames, _limits, _reach, _branches, _tool, _notes)
