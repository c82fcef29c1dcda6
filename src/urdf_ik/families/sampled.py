"""Six joints that are singular at every joint vector: a pose that they reach leaves a continuum of solutions."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from urdf_ik._core import Solver
from urdf_ik.families.few_joints import Aim
from urdf_ik.families.parts.nearest import off_by
from urdf_ik.families.parts.plan import Plan, written_values

if TYPE_CHECKING:
    from urdf_ik.chain import Chain

_SAMPLES = 12
# A smallest singular value below this (lengths as shares of the size) is rounding.
_ROUNDING = 1e-12


def matches(chain: Chain) -> bool:
    """Whether the Jacobian of six revolute joints has lost rank at every sampled joint vector."""
    if chain.n != 6 or chain.prismatic.any():
        return False
    J = chain.jacobian(np.random.default_rng(3).uniform(-np.pi, np.pi, (_SAMPLES, 6)))
    J[:, :3] /= chain.size
    return bool(np.linalg.svd(J, compute_uv=False)[:, -1].max() < _ROUNDING)


def prepare(chain: Chain) -> Plan:
    """Newton's method from starts all over the joints: samples of the continuum."""
    return Plan(
        family="6R singular everywhere",
        method="Newton's method on the URDF as written from fixed starts: samples of the continuum that a pose leaves",
        branches=tuple(f"sample {k}" for k in range(1, 17)),
        imperfection=(0.0, 0.0),
        error=0.0,
        solver=Solver("sampled", {"written": written_values(chain)}),
        explain=lambda T: off_by(chain, Aim(), T[:3, :3], T[:3, 3]),
        by_elimination=True,
    )
