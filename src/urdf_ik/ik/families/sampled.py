"""Arms that are singular at every joint vector: a pose that they reach has a continuum of solutions.

These are six joints whose Jacobian loses rank everywhere, and seven joints that become such an arm when either end
joint is held. For those a joint in the middle is held. The six others are then a different arm for every value, so
nothing can be prepared for them.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from typing import ClassVar

import numpy as np

from urdf_ik._core import SelfMotion, Solver
from urdf_ik.ik.families.parts.explanations import given_in_words, off_by
from urdf_ik.ik.families.parts.family import Family, FamilyMember, RedundantMember
from urdf_ik.ik.families.parts.written import FreeArm, Written, written
from urdf_ik.kinematics.chain import Chain, is_redundant, kinds_of
from urdf_ik.kinematics.chain.redundancy import locked_joint
from urdf_ik.kinematics.structure import Structure
from urdf_ik.typing import Array


@dataclass(frozen=True, kw_only=True, eq=False)
class _SampledArm:
    """Six joints that are singular everywhere: ``SampledArm`` of the core.

    Attributes:
        written: the arm as its URDF has it.
    """

    kind: ClassVar = "sampled"
    written: Written


@dataclass(frozen=True, kw_only=True, eq=False)
class _SampledHeldArm:
    """Seven joints, one of them held: ``SampledHeldArm`` of the core.

    Attributes:
        written: the arm as its URDF has it.
        held: index of the joint that is held.
        value: its value where no other is given [rad, m].
    """

    kind: ClassVar = "sampled with one held"
    written: Written
    held: int
    value: float


def _prepare(family: Family, structure: Structure, chain: Chain) -> FamilyMember:
    """Newton's method from starts all over the joints: samples of the continuum."""
    return FamilyMember(
        family=family,
        name=f"{kinds_of(chain)} singular everywhere",
        reason=family.reason,
        method=family.steps,
        branches=family.branches,
        solver=Solver(_SampledArm(written=written(chain))),
        explain=partial(off_by, chain),
    )


FAMILY = Family(
    name="six joints, singular everywhere",
    reason="the Jacobian of these six joints loses rank at every joint vector",
    steps="Newton's method on the URDF as written from fixed starts: samples of the continuum that a pose leaves",
    branches=tuple(f"sample {k}" for k in range(1, 17)),
    by_quadratics=False,
    by_elimination=True,
    matches=lambda structure, chain: chain.n == 6 and is_redundant(chain),
    prepare=_prepare,
)


def prepare_held(chain: Chain, k: int) -> RedundantMember:
    """The plan of seven joints that holds joint ``k``, any of them, and looks for what the six others leave."""
    parameter = locked_joint(chain, k)
    arm = _SampledHeldArm(written=written(chain), held=k, value=parameter.default)

    def explain_at(T: Array, at: Array) -> str:
        rest = chain.lock({parameter.joint: float(at[0])})
        why = off_by(rest, T)
        return f"{given_in_words(parameter, at[0])}: {why}"

    return RedundantMember(
        family=FAMILY,
        name=f"{kinds_of(chain)}, joint {k + 1} given: by search",
        reason="whichever of the first and the last joint is given, the six others are singular everywhere",
        method=f"Joint {k + 1} ({parameter.joint}) is given; Newton's method on the URDF as written from fixed starts: "
        "what the six others leave, samples where that is a continuum",
        branches=FAMILY.branches,
        solver=Solver(arm),
        parameters=(parameter,),
        self_motion=None if is_redundant(chain) else SelfMotion(FreeArm(written=arm.written, given=k)),
        value_of=lambda Q, T: parameter.wrapped(Q[:, k : k + 1]),
        explain=lambda T: explain_at(T, np.array([parameter.default])),
        explain_at=explain_at,
    )
