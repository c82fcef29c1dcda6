"""Six joints that are singular at every joint vector: a pose that they reach leaves a continuum of solutions."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from urdf_ik._core import Solver
from urdf_ik.families.parts.aim import Aim
from urdf_ik.families.parts.family import Family, Plan
from urdf_ik.families.parts.nearest import off_by
from urdf_ik.families.parts.values import written_values

if TYPE_CHECKING:
    from urdf_ik.chain import Chain
    from urdf_ik.structure import Structure

_SAMPLES = 12
# A smallest singular value below this (lengths as shares of the size) is rounding.
_ROUNDING = 1e-12


def _matches(chain: Chain) -> bool:
    """Whether the Jacobian of six revolute joints has lost rank at every sampled joint vector."""
    if chain.n != 6 or chain.prismatic.any():
        return False
    J = chain.jacobian(np.random.default_rng(3).uniform(-np.pi, np.pi, (_SAMPLES, 6)))
    J[:, :3] /= chain.size
    return bool(np.linalg.svd(J, compute_uv=False)[:, -1].max() < _ROUNDING)


def _prepare(family: Family, structure: Structure, chain: Chain) -> Plan:
    """Newton's method from starts all over the joints: samples of the continuum."""
    return Plan(
        family=family,
        name=family.name,
        reason=family.reason,
        method=family.steps,
        branches=family.branches,
        solver=Solver(family.solver, {"written": written_values(chain)}),
        explain=lambda T: off_by(chain, Aim(), T[:3, :3], T[:3, 3]),
    )


FAMILY = Family(
    name="6R singular everywhere",
    reason="the Jacobian of these six joints loses rank at every joint vector",
    steps="Newton's method on the URDF as written from fixed starts: samples of the continuum that a pose leaves",
    branches=tuple(f"sample {k}" for k in range(1, 17)),
    by_quadratics=False,
    by_elimination=True,
    matches=lambda structure, chain: _matches(chain),
    prepare=_prepare,
    solver="sampled",
)
