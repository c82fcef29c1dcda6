"""Poses as people teach them: right angles, straight and folded elbows, aligned wrists, and combinations of these."""

import arms
import arms_closed_forms
import closed_forms
import contract
import numpy as np
import pytest
import seven_joints
from arms_few import BUILDS, SLIDES, apart, few
from arms_general import near_member
from arms_mimic import LINKAGES, linkage
from arms_seven import SEVEN
from cases import MEMBERS_OF, assert_exact, described, from_catalogue, named, nearest, rows, thinned, worst_error
from with_reference import arm_and_reference, distances, scaled_jacobian

FAMILIES = tuple(arms.KINDS)
MORE = tuple(arms_closed_forms.KINDS)
CATALOGUE = ("zyyzyz_6r", "dh_6r", "ur5", "ur10")


@pytest.mark.parametrize("name", thinned(CATALOGUE, 2))
def test_catalogue(name: str) -> None:
    """Arms of the catalogue."""
    contract.holds_at_corners(from_catalogue(name), 24, 1)


@pytest.mark.parametrize("kind", thinned(FAMILIES, 4))
def test_families(kind: str) -> None:
    """Spherical wrists and three parallel axes, oblique, at right angles, and with rounded frames."""
    for name in MEMBERS_OF[kind]:
        contract.holds_at_corners(named(name), 12, 2)


@pytest.mark.parametrize("kind", thinned(MORE, 8))
def test_closed_forms(kind: str) -> None:
    """Three parallel axes at one end, a spherical triple in the middle."""
    for case in closed_forms.members(kind)[:2]:
        contract.holds_at_corners(case, 8, 3)


@pytest.mark.parametrize("kind", thinned(FAMILIES, 4))
@pytest.mark.parametrize("eps", [1e-9, 1e-5, 1e-3])
def test_imperfect_members(kind: str, eps: float) -> None:
    """Members that are off by rounded decimals or a calibration."""
    contract.holds_at_corners(described(near_member(kind, eps, 1)), 5, 8)


@pytest.mark.parametrize("name", CATALOGUE)
def test_round_poses(name: str) -> None:
    """Round positions with round orientations."""
    contract.holds_at_round_poses(from_catalogue(name), 2, 4)


@pytest.mark.parametrize("kind", SEVEN)
def test_seven_joints(kind: str) -> None:
    """Seven joints, at the planted value of the parameter."""
    for variant in ((0, False, False), (1, True, True)):
        case = seven_joints.member(kind, *variant)
        for q in contract.round_vectors(7, np.zeros(7, np.bool_), np.random.default_rng(5), 10):
            target = case.oracle.pose(q)
            found = assert_exact(case, case.arm.ik(target, redundancy=float(case.arm.redundancy_of(q))), target)
            assert len(found) > 0, (case.name, q.tolist())
            tolerance = seven_joints.tolerance(case, q)
            assert tolerance > 1e-3 or nearest(found, q) <= tolerance, (case.name, q.tolist())


@pytest.mark.parametrize("name", thinned([*BUILDS, *SLIDES], 3))
def test_few_joints_and_slides(name: str) -> None:
    """One to five joints, and six with slides."""
    for seed in range(2):
        case = few(name, seed)
        for q in contract.round_vectors(case.arm.dof, case.arm.chain.prismatic, np.random.default_rng(6), 10):
            target = case.oracle.pose(q)
            found = rows(case.arm.ik(target))
            assert len(found) > 0, (case.name, q.tolist())
            assert worst_error(case, found, target) <= 1e-9
            tolerance = case.oracle.tolerance(q)
            assert tolerance > 1e-3 or apart(case, found, q).min() <= tolerance, (case.name, q.tolist())


@pytest.mark.parametrize("name", thinned(LINKAGES, 3))
def test_joints_that_mimic(name: str) -> None:
    """Chains in which joints mimic others."""
    for seed in range(2):
        arm, reference = arm_and_reference(linkage(name, seed))
        drawn = contract.round_vectors(arm.dof, arm.chain.prismatic, np.random.default_rng(7), 8)
        for q in np.clip(drawn, *reference.ranges.T):  # joints that drive others have no images outside
            target = reference.pose(q)
            found = arm.ik(target).to_array()
            assert len(found) > 0, (name, q.tolist())
            assert max(part.max() for part in reference.errors(found, target)) <= 1e-9
            sigma = np.linalg.svd(scaled_jacobian(reference, q), compute_uv=False)[-1]
            tolerance = 1e-6 + 1e-11 / max(sigma, 1e-14)
            assert tolerance > 1e-3 or distances(arm, found, q).min() <= tolerance, (name, q.tolist())
