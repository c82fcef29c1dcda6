"""Defects of a URDF: a table of the users of each part, and of the value assumed in place of a defective part.

A defect is an error if the loaded chain, the joints that it mimics, or the requested check use the part. Otherwise it
is a :class:`UrdfWarning`, and the reader assumes the value in the table.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

from urdf_ik.errors import UrdfError

CHAIN = "chains through it"
COLLISION = "collision checks"
TAKEN_FOR_FIXED = "the joint is fixed"
MOST_SHOWN = 20
"""An error lists at most so many defects."""


class Rule(NamedTuple):
    """One kind of defect: the element, the defect, the users that refuse it, and the assumption for all others."""

    element: str
    defect: str
    used_by: tuple[str, ...]
    assumed: str


RULES: dict[str, Rule] = {
    "robot name": Rule("`<robot>`", "no name", (), "it has an empty name"),
    "robot xacro": Rule("`<robot>`", "a left-over xacro instruction", (), "the instruction is ignored"),
    "link name": Rule("`<link>`", "no name", (), "the link is left out"),
    "link xacro": Rule("`<link>`", "a name with a xacro expression", (CHAIN,), "the name is taken as written"),
    "link twice": Rule("`<link>`", "a name that is taken", (CHAIN, COLLISION), "the second link is left out"),
    "joint name": Rule("`<joint>`", "no name, a reserved one or one that is taken", (CHAIN,), "another name"),
    "joint type": Rule("`<joint>`", "a type that is missing or unknown", (CHAIN,), TAKEN_FOR_FIXED),
    "joint xacro": Rule("`<joint>`", "a left-over xacro instruction", (CHAIN,), "the instruction is ignored"),
    "undeclared": Rule("`<parent>`, `<child>`", "a link without a `<link>`", (CHAIN,), "the link has no shapes"),
    "ends": Rule("`<parent>`, `<child>`", "missing, or no link named", (CHAIN, COLLISION), "the joint is left out"),
    "two parents": Rule("`<child>`", "a link with two parents", (CHAIN, COLLISION), "the second joint is left out"),
    "parts": Rule("`<link>`", "links in a circle, or apart from the robot", (CHAIN, COLLISION), "they are left out"),
    "origin": Rule("`<origin>` of a joint", "no finite numbers", (CHAIN, COLLISION), "zero"),
    "axis": Rule("`<axis>`", "no direction", (CHAIN,), TAKEN_FOR_FIXED),
    "limit": Rule("`<limit>`", "missing, or no finite bounds", (CHAIN,), TAKEN_FOR_FIXED),
    "bounds": Rule("`<limit>`", "lower above upper", (CHAIN,), "the two are swapped"),
    "turns": Rule("`<limit>`", "bounds of 30 to 720 rad, which may be degrees", (), "taken in rad"),
    "speeds": Rule("`<limit>`", "no velocity or effort", (), "no limit; Pinocchio gets 0 for it"),
    "velocity": Rule("`<limit>`", "velocity negative or no number", (CHAIN,), "0, which is no limit"),
    "effort": Rule("`<limit>`", "effort negative or no number", (CHAIN,), "0, which is no limit"),
    "rates": Rule("`<limit>`", "acceleration or jerk not positive, or no number", (), "no limit"),
    "mimic": Rule("`<mimic>`", "no joint to follow, a circle, or no finite numbers", (CHAIN,), "it moves by itself"),
    "collision": Rule("`<collision>`", "no shape, or one that no reader takes", (COLLISION,), "it is left out"),
    "visual": Rule("`<visual>`", "no shape, or one that no reader takes", (), "it is left out"),
    "inertial": Rule("`<inertial>`", "no mass, no inertia or no numbers", (), "it is left out"),
    "srdf element": Rule("an SRDF's element", "a name that SRDF does not have", (), "it is ignored"),
    "srdf link": Rule("an SRDF's element", "a link that the URDF does not have", (), "it allows nothing"),
}
"""Every defect that does not refuse the whole file. The rows of docs/how-to/load.md are these."""


@dataclass(frozen=True)
class UrdfWarning:
    """A defect in a part of a URDF; an error is raised only if the part is used.

    Attributes:
        rule: the row of ``RULES``.
        error: the error that is raised if the part is used.
        joints: a chain that uses one of these joints, or one that mimics them, is refused.
        links: a chain through one of these links is refused.
        collides: whether collision checks are refused.
    """

    rule: str
    error: UrdfError
    joints: tuple[str, ...] = ()
    links: tuple[str, ...] = ()
    collides: bool = False

    def __str__(self) -> str:
        error = self.error
        where = str(UrdfError(error.problem, source=error.source, line=error.line, element=error.element))
        return f"{where}; {self.assumed}"

    @property
    def assumed(self) -> str:
        """How the part was read, in words."""
        return RULES[self.rule].assumed

    @property
    def element(self) -> str:
        """The element at fault, such as ``<joint name="j2">``."""
        return self.error.element or ""

    def within(self, prefix: str) -> "UrdfWarning":
        """The same warning for a model whose joints and links have a prefix."""
        joints, links = (tuple(prefix + each for each in names) for names in (self.joints, self.links))
        return replace(self, joints=joints, links=links)


def together(errors: Sequence[UrdfError]) -> UrdfError:
    """One error for all defects of a file: the first, and after it the others with line, element and hint."""
    first = errors[0]
    if len(errors) == 1:
        return first
    others = [
        UrdfError(each.problem, source=f"line {each.line}" if each.line else "", element=each.element, hint=each.hint)
        for each in errors[1:MOST_SHOWN]
    ]
    unlisted = f"; and {len(errors) - MOST_SHOWN} more" if len(errors) > MOST_SHOWN else ""
    error = UrdfError(first.problem, source=first.source, line=first.line, element=first.element, hint=first.hint)
    error.args = (f"{first}; also {'; '.join(map(str, others))}{unlisted}",)
    return error


class Defects:
    """The defects of one file, in the order in which they are found."""

    def __init__(self) -> None:
        self.found: list[UrdfWarning] = []

    def add(
        self,
        rule: str,
        error: UrdfError,
        *,
        joints: Sequence[str] = (),
        links: Sequence[str] = (),
        collides: bool | None = None,
    ) -> None:
        """Record a defect; ``collides``, by default the rule's, says whether collision checks are refused."""
        stops = COLLISION in RULES[rule].used_by if collides is None else collides
        kept = error.with_traceback(None)
        self.found.append(UrdfWarning(rule, kept, tuple(joints), tuple(links), stops))
