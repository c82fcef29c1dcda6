"""``Solver``: a chain with its family and compiled solver."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, Any

from urdf_ik.errors import UnsupportedArm
from urdf_ik.ik.families import FamilyMember, RedundantMember
from urdf_ik.ik.refusals import unsupported
from urdf_ik.ik.tasks import Control, Targets
from urdf_ik.kinematics.chain import Chain
from urdf_ik.kinematics.chain.free_axis import FreeAxis
from urdf_ik.kinematics.chain.redundancy import Redundancy
from urdf_ik.kinematics.structure import Structure
from urdf_ik.support.tolerances import DEFAULT
from urdf_ik.typing import Array

if TYPE_CHECKING:
    from urdf_ik import _core
    from urdf_ik.ik.contacts import Contacts


@dataclass(frozen=True, eq=False)
class Solver:
    """A chain, its family, and the compiled solver that serves it. :func:`urdf_ik.ik.preparation.prepare` makes it.

    Attributes:
        name: the robot's name, for messages.
        chain: screw axes of the joints from base to tip.
        structure: how the axes lie to each other, and how the arm is solved.
        control: what the joints control of the tip.
        task: what a target is; 'pose' unless another one was asked for.
        targets: what reads targets of a task other than 'pose'; None for poses.
        member: the arm as a member of its family; None where no solver takes it.
        core: the compiled solver; None where no solver takes the arm.
        single: the compiled solver where targets are poses: it takes a single pose without detours.
        branches: names of the columns of a pose's solutions.
        free_axis: a line in the tip about which it may be turned.
        given: names of joints whose values are redundancy parameters because the user chose them.
        velocity_limits: (n,) rad/s or m/s, the URDF's; infinite where it gives none.
        contacts: answers whether solutions touch anything.
        remake: makes this solver again with other settings.
        why_none: (solver, target, redundancy) -> why a target has no solution.
        by_task: solvers of the same chain for other tasks, made when they are first asked for.
    """

    name: str
    chain: Chain
    structure: Structure
    control: Control
    task: str
    targets: Targets | None
    member: FamilyMember | None
    core: _core.Solver | None
    single: _core.Solver | None
    branches: tuple[str, ...]
    free_axis: FreeAxis | None
    given: tuple[str, ...]
    velocity_limits: Array
    contacts: Contacts
    remake: Callable[..., Solver]
    why_none: Callable[[Solver, Array, Array | None], str]
    by_task: dict[str, Solver] = field(default_factory=dict)

    @property
    def joint_names(self) -> tuple[str, ...]:
        """Movable joints, base to tip."""
        return self.chain.joint_names

    @property
    def dof(self) -> int:
        """Number of movable joints."""
        return self.chain.n

    @property
    def limits(self) -> Array:
        """(n, 2) rad or m; a continuous joint has (-inf, inf)."""
        return self.chain.limits

    @property
    def parameters(self) -> tuple[Redundancy, ...]:
        """Every redundancy parameter, in the order in which solving takes their values; () for most arms."""
        return self.member.parameters if isinstance(self.member, RedundantMember) else ()

    @property
    def parameter(self) -> Redundancy | None:
        """The first redundancy parameter; None where a pose leaves nothing free."""
        return self.parameters[0] if self.parameters else None

    @property
    def redundant_member(self) -> RedundantMember:
        """The member of a family with a redundancy parameter.

        Raises:
            UnsupportedArm: no solver takes the arm, or a pose leaves nothing free.
        """
        if isinstance(self.require_member(), RedundantMember):
            return self.member  # type: ignore[return-value]
        raise UnsupportedArm(
            f"{self.name}: {self.dof} joints ({', '.join(self.joint_names)}) leave nothing free in a pose; only arms "
            "with seven, or with a free axis (Arm.with_free_axis), have a redundancy parameter"
        )

    @cached_property
    def fixed(self) -> Solver:
        """This solver without a free axis: the rotation about it counts."""
        return self if self.free_axis is None else self.again(free_axis=None)

    @cached_property
    def mirrors(self) -> tuple[tuple[int, bool], ...]:
        """At most two triples of joints in which two solutions can be each other's images: the first, whether parallel.

        Their axes meet in a point or are parallel, to rounding; see mirrored.hpp of the core.
        """
        found: list[tuple[int, bool]] = []
        for triple in self.structure.triples:
            first, parallel = triple.first - 1, triple.relation == "parallel"
            exact = triple.imperfection <= DEFAULT.exact_structure * (1.0 if parallel else self.chain.size)
            turning = not self.chain.prismatic[first : first + 3].any()
            if exact and turning and all(first >= other + 3 for other, _ in found):
                found.append((first, parallel))
        return tuple(found[:2])

    def require_member(self) -> FamilyMember:
        """The arm as a member of its family.

        Raises:
            UnsupportedArm: no solver takes it.
        """
        if self.member is None:
            raise unsupported(self.name, self.chain, self.structure)
        return self.member

    def again(self, **changed: Any) -> Solver:
        """This solver with other settings: those of :func:`urdf_ik.ik.preparation.prepare`."""
        return self.remake(**{**self._settings, **changed})

    @property
    def _settings(self) -> dict[str, Any]:
        return {
            "name": self.name,
            "chain": self.chain,
            "velocity_limits": self.velocity_limits,
            "contacts": self.contacts,
            "task": self.task,
            "free_axis": self.free_axis,
            "given": self.given,
        }

    def __reduce__(self) -> tuple[Callable[..., Solver], tuple[Any, ...]]:
        return _remade, (self.remake, self._settings)


def _remade(remake: Callable[..., Solver], settings: dict[str, Any]) -> Solver:
    """A solver as it was before it was pickled or copied: the compiled part is prepared again."""
    return remake(**settings)
