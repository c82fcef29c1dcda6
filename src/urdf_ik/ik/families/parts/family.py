"""Families and their members: a record of a family, and one of how an arm of it is solved."""

import re
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np

from urdf_ik._core import SelfMotion, Solver
from urdf_ik.ik.families.parts.explanations import off_by
from urdf_ik.ik.families.parts.written import Numbers, written
from urdf_ik.kinematics.chain import Chain
from urdf_ik.kinematics.chain.redundancy import Redundancy
from urdf_ik.kinematics.structure import Structure
from urdf_ik.support.tolerances import DEFAULT
from urdf_ik.typing import Array

_AXES = re.compile(r"\{([\d, ]+)\}")


@dataclass(frozen=True)
class Family:
    """A structure with a solver of its own.

    Attributes:
        name: what it is called; a plan may be called more, where that depends on the arm ('RRPR', 'reversed').
        reason: why these arms can be solved so, in words; '{4, 5, 6}' stands for the numbers of axes, so that they
            can be given for an arm that is seen from its tip.
        steps: how they are solved, in words.
        branches: names of the columns of a pose's solutions, as many as there are at most.
        by_quadratics: whether each joint follows from the root of a quadratic, one step after the other. Such an arm
            cannot change from one solution to another without crossing a singularity (see ``cuspidality``).
        matches: (structure, chain) -> whether an arm is of the family, exactly or nearly.
        prepare: (family, structure, chain) -> the plan of an arm that matches; None where it has none after all.
        variant: how it differs from the other families of its file, such as '2||3'.
        by_elimination: whether it has no closed form, so that all others come first.
    """

    name: str
    reason: str
    steps: str
    branches: tuple[str, ...]
    matches: Callable[[Structure, Chain], bool]
    prepare: Callable[["Family", Structure, Chain], "FamilyMember | None"]
    by_quadratics: bool = False
    variant: str = ""
    by_elimination: bool = False

    def plan(self, structure: Structure, chain: Chain) -> "FamilyMember | None":
        """The plan of an arm, None for an arm that is not of this family."""
        return self.prepare(self, structure, chain) if self.matches(structure, chain) else None

    def member(self, chain: Chain, arm: Numbers, error: float = 0.0, **own: Any) -> "FamilyMember":
        """An arm of this family, solved by ``arm``; what ``own`` does not say is the family's, in words too.

        ``error``: how far the arm is off the family, see :class:`FamilyMember`.
        """
        exact = error <= DEFAULT.exact_structure
        near = f"Nearest ideal arm in closed form ({self.steps}), refined by Newton's method on the URDF as written"
        common = {
            "family": self,
            "name": self.name,
            "reason": self.why() if exact else f"{self.why()}, exactly or nearly",
            "method": self.steps if self.by_elimination else f"Closed form: {self.steps}" if exact else near,
            "branches": self.branches,
            "error": error,
            "solver": Solver(arm),
            "why": partial(off_by, chain),
        }
        return FamilyMember(**{**common, **own})

    def why(self, joints: int = 6, *, from_tip: bool = False) -> str:
        """The reason in words, with the axes of an arm of so many joints counted from the base."""

        def numbers(match: re.Match[str]) -> str:
            axes = [int(number) for number in match[1].split(",")]
            *rest, last = sorted(joints + 1 - axis for axis in axes) if from_tip else axes
            return f"{', '.join(map(str, rest))} and {last}"

        return _AXES.sub(numbers, self.reason)


@dataclass(frozen=True, kw_only=True)
class FamilyMember:
    """An arm as a member of its family: how it is solved.

    Attributes:
        family: what it is a member of.
        name: the family's name with what this arm adds to it, such as ', reversed'.
        reason: why it can be solved so, in words.
        method: how it is solved, in words.
        branches: names of the columns.
        imperfection: (rad, m) of the relations that the family rests on.
        error: greatest difference between the poses of the ideal arm and of the arm as written, over sampled
            joint vectors [rad, share of size].
        solver: the compiled solver.
        why: (pose (4, 4) without a solution) -> why it has none; with redundancy parameters it takes their values,
            (parameters,), too.
        parameters: redundancy parameters, in the order of the solver's values; the one that was added last comes first.
        self_motion: follows the curves of joint vectors that hold a pose; None unless there is one parameter, and where
            joints mimic others.
        value_of: joint vectors (m, n) and the poses (m, 4, 4) that they are to reach -> values (m, parameters).
        swivel: the frames that a swivel angle is measured in: ``ends``; None for an arm without.
    """

    family: Family
    name: str
    reason: str
    method: str
    branches: tuple[str, ...]
    imperfection: tuple[float, float] = (0.0, 0.0)
    error: float = 0.0
    solver: Solver
    why: Callable[..., str]
    parameters: tuple[Redundancy, ...] = ()
    self_motion: SelfMotion | None = None
    value_of: Callable[[Array, Array], Array] = lambda Q, T: np.empty((len(Q), 0))
    swivel: Numbers | None = None

    @property
    def is_exact(self) -> bool:
        """Whether the arm as written is the ideal one, to rounding."""
        return self.error <= DEFAULT.exact_structure

    @property
    def by_quadratics(self) -> bool:
        """Whether each joint follows from the root of a quadratic, of the arm as written too."""
        return self.is_exact and self.family.by_quadratics

    @property
    def defaults(self) -> Array:
        """(parameters,) the values of the redundancy parameters that are solved for by default."""
        return np.array([parameter.default for parameter in self.parameters])

    def explain(self, T: Array, values: Array) -> str:
        """Why a pose (4, 4) has no solution at values (parameters,)."""
        return self.why(T, values) if self.parameters else self.why(T)


def self_motion(chain: Chain, joint: int, frames: Numbers | None = None) -> SelfMotion:
    """What follows the curves of seven joints that hold a pose.

    Args:
        chain: the joints.
        joint: the one whose value is the redundancy parameter; -1: it is a swivel angle.
        frames: ``ends`` that the swivel angle is measured in.
    """
    return SelfMotion(Numbers(written=written(chain), given=joint, ends=frames))


def columns(count: int) -> tuple[str, ...]:
    """Names of the columns where geometry gives none."""
    return tuple(f"solution {k}" for k in range(1, count + 1))


_OTHER_END = {"shoulder": "wrist", "wrist": "shoulder"}


def mirrored(plan: FamilyMember) -> FamilyMember:
    """The plan for an arm whose reversed chain ``plan`` was made for."""
    why = plan.family.why(from_tip=True)
    return replace(
        plan,
        name=f"{plan.name}, reversed",
        reason=why if plan.is_exact else f"{why}, exactly or nearly",
        method=f"{plan.method}; on the chain from tip to base",
        branches=tuple(" ".join(_OTHER_END.get(word, word) for word in name.split(" ")) for name in plan.branches),
        why=lambda T: f"seen from the tip, {plan.why(np.asarray(np.linalg.inv(T), dtype=np.float64))}",
        solver=Solver(Numbers(kind="reversed", solver=plan.solver.arm)),
    )
