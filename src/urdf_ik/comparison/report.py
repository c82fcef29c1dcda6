"""What a comparison of two arms found. Lengths in m, angles in rad; the text shows mm and degrees."""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass
from typing import Any

from urdf_ik.comparison import sentences
from urdf_ik.crosscheck.report import plain


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
    """The limits of a joint, lower and upper [rad or m], infinite where there are none."""

    joint: str
    joint_b: str
    a: tuple[float, float]
    b: tuple[float, float]

    @property
    def same(self) -> bool:
        """Whether both limits are the same number."""
        return self.a == self.b


@dataclass(frozen=True)
class Reach:
    """How both arms answer the same poses.

    Attributes:
        made_by: whose joint vectors made the poses, 'A' or 'B'; they were drawn within its limits.
        poses: how many.
        solved: poses that A, and that B, has a solution for.
        within_limits: poses that A, and that B, has a solution for within its limits.
        solutions: solutions of A, and of B, over all poses.
        same_number: poses of which both have the same number of solutions.
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
        poses: how many were compared.
        unmatched: solutions of A without a counterpart in B.
        median: (n,) rad or m, of the difference of each joint, an angle's on the circle; NaN where none was compared.
        worst: (n,) rad or m, likewise.
    """

    branch: str
    matched: str
    poses: int
    unmatched: int
    median: tuple[float, ...]
    worst: tuple[float, ...]


@dataclass(frozen=True)
class ToolError:
    """Where B's tip is when it is given A's joint vectors, against where A's is, as Pinocchio measures both.

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


@dataclass(frozen=True)
class Comparison:
    """Two arms, compared; ``print`` shows it as tables.

    Attributes:
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
    """

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

    def to_dict(self) -> dict[str, Any]:
        """The comparison as plain lists, numbers and text; numbers that are not finite are the text 'inf', 'nan'."""
        out: dict[str, Any] = plain(asdict(self))
        return {"units": {"length": "m", "angle": "rad"}, **out}

    def to_json(self) -> str:
        """:meth:`to_dict` as strict JSON."""
        return json.dumps(self.to_dict(), indent=2, allow_nan=False) + "\n"

    def sections(self) -> tuple[sentences.Section, ...]:
        """The tables of the text, in order."""
        return sentences.sections(self)

    def __str__(self) -> str:
        return "\n\n".join(map(str, self.sections()))
