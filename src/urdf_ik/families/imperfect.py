"""Arms that a family's relations hold for up to rounded decimals, or up to a calibration."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from urdf_ik._kernels import imperfect, parallel_shoulder, spherical_middle, spherical_wrist, three_parallel
from urdf_ik.families.general_6r import with_elimination

if TYPE_CHECKING:
    from urdf_ik.chain import Chain
    from urdf_ik.families.plan import Plan

_NEAR = {
    spherical_wrist.solve_parallel_23: imperfect.near_parallel_23,
    spherical_wrist.solve_intersecting_12: imperfect.near_intersecting_12,
    spherical_wrist.solve_parallel_12: imperfect.near_parallel_12,
    spherical_wrist.solve_general_shoulder: imperfect.near_general_shoulder,
    three_parallel.solve_intersecting_56: imperfect.near_intersecting_56,
    three_parallel.solve_general_wrist: imperfect.near_general_wrist,
    parallel_shoulder.solve_intersecting_56: imperfect.near_shoulder_intersecting_56,
    parallel_shoulder.solve_parallel_56: imperfect.near_shoulder_parallel_56,
    parallel_shoulder.solve_intersecting_45: imperfect.near_shoulder_intersecting_45,
    parallel_shoulder.solve_parallel_45: imperfect.near_shoulder_parallel_45,
    parallel_shoulder.solve_general_wrist: imperfect.near_shoulder_general_wrist,
    spherical_middle.solve_intersecting_56: imperfect.near_middle_intersecting_56,
    spherical_middle.solve_parallel_56: imperfect.near_middle_parallel_56,
    spherical_middle.solve_general_wrist: imperfect.near_middle_general_wrist,
}


def prepare(plan: Plan, chain: Chain) -> Plan:
    """The plan of the ideal arm, made to hold for the arm as written."""
    further = tuple(f"further {k}" for k in range(1, 17 - len(plan.branches)))
    return replace(
        plan,
        method=f"{plan.method}; near singularities by elimination too",
        branches=(*plan.branches, *further),
        arm=with_elimination(plan.arm, chain),
        solve=_NEAR[plan.solve],
        solver=None,
    )
