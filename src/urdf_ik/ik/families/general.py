"""Six joints without a structure that a closed form could use, and those that have one only nearly.

Turning or with slides there are up to sixteen solutions; where the joints are singular everywhere, a continuum.
"""

from dataclasses import replace
from typing import Any

import numpy as np

from urdf_ik._core import Solver
from urdf_ik.ik.families.parts.elimination import elimination_arm
from urdf_ik.ik.families.parts.family import Family, FamilyMember, columns
from urdf_ik.ik.families.parts.written import Numbers, written
from urdf_ik.kinematics.chain import Chain, is_redundant, kinds_of
from urdf_ik.kinematics.dh.frames import rotation_z
from urdf_ik.kinematics.structure import Structure


def _prepare(family: Family, structure: Structure, chain: Chain) -> FamilyMember:
    """The elimination's constant matrices."""
    triples, reason = " and ".join(map(str, structure.triples)), family.reason
    if structure.is_6r:
        reason = "no three neighbouring axes meet in a point or are parallel, so no closed form applies"
        reason = f"{triples}, but no closed form applies to these six axes" if triples else reason
    return family.member(chain, elimination_arm(chain), name=f"{kinds_of(chain)} general", reason=reason)


TURNING = Family(
    name="6R general",
    reason="six turning joints, whatever their axes",
    steps="Elimination to one joint's angle (Raghavan and Roth), to another one's where that leaves doubts, Newton's "
    "method on the URDF as written",
    branches=columns(16),
    by_elimination=True,
    matches=lambda structure, chain: structure.is_6r,
    prepare=_prepare,
)


def _matches(structure: Structure) -> bool:
    """Whether six joints have one slide, or two that are not opposite in the loop: joints 1 and 4, 2 and 5, 3 and 6."""
    slides = [i for i, kind in enumerate(structure.joint_types) if kind == "prismatic"]
    return len(structure.joint_types) == 6 and len(slides) in (1, 2) and slides[-1] - slides[0] != 3


WITH_SLIDES = Family(
    name="six joints with slides, general",
    reason="one or two of six joints slide, and no three axes at an end meet in a point, so no closed form applies",
    steps="Elimination to one joint's value (Raghavan and Roth), a slide as tan(t / 2), Newton's method on the URDF as "
    "written",
    branches=columns(16),
    by_elimination=True,
    matches=lambda structure, chain: _matches(structure) and not is_redundant(chain),
    prepare=_prepare,
)


def behind(plan: FamilyMember, chain: Chain) -> FamilyMember:
    """The plan of an arm whose wrist meets only nearly, with elimination behind it."""
    return replace(
        plan,
        method="Elimination to one joint's value (Raghavan and Roth), Newton's method on the URDF as written",
        branches=columns(16),
        solver=Solver(elimination_arm(chain)),
    )


def _prepare_singular(family: Family, structure: Structure, chain: Chain) -> FamilyMember:
    """Newton's method from starts all over the joints: samples of the continuum."""
    arm = Numbers(kind="sampled", written=written(chain))
    return family.member(chain, arm, name=f"{kinds_of(chain)} singular everywhere")


SINGULAR = Family(
    name="six joints, singular everywhere",
    reason="the Jacobian of these six joints loses rank at every joint vector",
    steps="Newton's method on the URDF as written from fixed starts: samples of the continuum that a pose leaves",
    branches=tuple(f"sample {k}" for k in range(1, 17)),
    by_elimination=True,
    matches=lambda structure, chain: chain.n == 6 and is_redundant(chain),
    prepare=_prepare_singular,
)


def beside(plan: FamilyMember, chain: Chain) -> FamilyMember:
    """The plan of the ideal arm that is nearest to six turning joints, made to hold for the arm as written."""
    further = tuple(f"further {k}" for k in range(1, 17 - len(plan.branches)))
    return replace(
        plan,
        method=f"{plan.method}; near singularities by elimination too",
        branches=(*plan.branches, *further),
        solver=Solver(_imperfect(plan.solver.arm, chain)),
    )


def _imperfect(family: Any, chain: Chain) -> Numbers:
    ideal = family.ideal
    base, tool = np.eye(4), np.eye(4)
    base[:3, :3], base[:3, 3] = ideal.base_rotation.T, ideal.base_origin
    tool[:3, :3], tool[:3, 3] = ideal.tool_rotation.T, -ideal.tool_rotation.T @ ideal.tool_point
    inner = np.array([np.vstack([step, [0.0, 0.0, 0.0, 1.0]]) for step in np.array(chain.motion.steps)])
    inner[0], inner[-1] = np.linalg.inv(base) @ inner[0], inner[-1] @ np.linalg.inv(tool)
    # Both take the ideal arm's angles.
    back = np.array([rotation_z(-offset)[:3, :3] for offset in (*ideal.offset, 0.0)])
    inner, steps = np.ascontiguousarray(inner[:, :3]), ideal.steps.copy()
    inner[:, :, :3], steps[:, :, :3] = inner[:, :, :3] @ back, steps[:, :, :3] @ back
    return Numbers(
        kind="imperfect",
        family=family,
        elimination=elimination_arm(chain, near=True),
        inner_steps=inner,
        ideal_steps=steps,
    )
