"""Rows of joints that mimic each other: circles, multipliers of zero and nearly zero, mimics of mimics."""

import numpy as np
import pytest
from chains import joint, robot

import urdf_ik
from urdf_ik import UrdfError
from urdf_ik.cell.pinocchio_reference import Reference
from urdf_ik.model.urdf import read

AXES = (
    ("0 0 1", "0 0 0.3"), ("0 1 0", "0.1 0 0.1"), ("0 1 0", "0 0 0.4"), ("0 1 0", "0.1 0 0.4"), ("0 0 1", "0 0.1 0.1")
)  # fmt: skip


def arm_of(mimics: dict[int, str], count: int = 5) -> str:
    """Joints j0, j1, ... in a row, some of which mimic others: 'driver multiplier offset'."""
    follows = {k: '<mimic joint="{}" multiplier="{}" offset="{}"/>'.format(*text.split()) for k, text in mimics.items()}
    rows = enumerate(AXES[:count])
    return robot(
        *(
            joint(f"j{k}", "revolute", f"l{k}", f"l{k + 1}", xyz, axis=a, more=follows.get(k, ""))
            for k, (a, xyz) in rows
        )
    )


@pytest.mark.parametrize(
    ("mimics", "circle"),
    [
        ({0: "j1 1 0", 1: "j2 1 0", 2: "j1 1 0"}, "j1 -> j2 -> j1"),  # the first leads into a circle of the others
        ({0: "j1 1 0", 1: "j2 1 0", 2: "j0 1 0"}, "j0 -> j1 -> j2 -> j0"),
        ({0: "j3 1 0", 2: "j2 1 0"}, "mimics itself"),
        ({0: "j1 1 0", 1: "j2 1 0", 2: "j3 1 0", 3: "j4 1 0", 4: "j3 1 0"}, "j3 -> j4 -> j3"),
    ],
)
def test_circles_of_mimics_are_errors_of_the_chains_that_use_them(mimics: dict[int, str], circle: str) -> None:
    """Reading ends, one warning names the circle, and a chain before it loads."""
    xml = arm_of(mimics)
    model = read(xml)
    assert len(model.warnings) == 1 and circle in model.warnings[0].error.problem
    with pytest.raises(UrdfError, match="mimics itself"):
        urdf_ik.load(xml)
    beside = xml.replace("</robot>", '<link name="t"/>') + (
        '<joint name="turn" type="continuous"><parent link="l0"/><child link="t"/></joint></robot>'
    )
    assert urdf_ik.load(beside, tip="t").joint_names == ("turn",)


@pytest.mark.parametrize("multiplier", ["0", "1e-17", "-1e-200", "5e-324"])
@pytest.mark.parametrize("driver", ["j0", "j1"])
def test_a_joint_that_follows_by_nothing_stands_at_its_offset(multiplier: str, driver: str) -> None:
    """It is fixed, and the others are the arm that remains; every drawn joint vector is found."""
    arm = urdf_ik.load(arm_of({4: f"{driver} {multiplier} 0.2"}))
    assert arm.joint_names == ("j0", "j1", "j2", "j3") and not arm.chain.followers
    found_all(arm)


@pytest.mark.parametrize("multiplier", ["1e-12", "-1e-9", "1e-6"])
def test_a_joint_that_follows_by_little_is_solved(multiplier: str) -> None:
    """Pinocchio's forward kinematics hold with the small share, and no joint vector is lost."""
    arm = urdf_ik.load(arm_of({3: f"j1 {multiplier} 0.2"}, 4))
    assert arm.joint_names == ("j0", "j1", "j2")
    found_all(arm)


@pytest.mark.parametrize("shares", [("-0.5", "2"), ("0", "2"), ("1", "0"), ("1", "1e-12"), ("2", "0.5")])
def test_mimics_of_mimics_multiply_their_shares(shares: tuple[str, str]) -> None:
    """The row j3 -> j2 -> j1 is one share of j1; where it is zero the joint stands still."""
    arm = urdf_ik.load(arm_of({2: f"j1 {shares[0]} 0.1", 3: f"j2 {shares[1]} 0.2"}))
    assert arm.joint_names == ("j0", "j1", "j4")
    found_all(arm)


def found_all(arm: urdf_ik.Arm) -> None:
    """Forward kinematics are Pinocchio's, every solution reaches its pose, and those that were drawn are found."""
    reference = Reference(arm.model, arm.base, arm.tip)
    assert reference.joint_names == arm.joint_names
    for q in np.random.default_rng(3).uniform(-2.0, 2.0, (12, arm.dof)):
        T = reference.pose(q)
        np.testing.assert_allclose(arm.fk(q), T, atol=1e-12)
        found = arm.ik(T).to_array()
        assert np.abs(np.angle(np.exp(1j * (found - q)))).max(axis=1).min() < 1e-6
        position, angle = reference.errors(found, T)
        assert max(position.max(), angle.max()) < 1e-9
