"""Joints that are held: the chain without them against Pinocchio with them at their values."""

import numpy as np
import pytest
from arms_seven import random_seven, skew, sliding
from chains import joint
from oracle import Oracle

import urdf_ik
from urdf_ik import ArgumentError, ChainError
from urdf_ik.cell import CollisionModel
from urdf_ik.cell.pinocchio_reference import Reference
from urdf_ik.verify import crosscheck

TEXT = sliding(skew(7), 4, -0.5, 0.5)
NAMES = tuple(f"joint_{k}" for k in range(1, 8))


@pytest.mark.parametrize(
    "locked",
    [
        {"joint_1": 0.7},
        {"joint_7": -1.1},
        {"joint_4": 0.3},
        {"joint_3": 2.0, "joint_4": -0.2, "joint_6": 4.0},
        dict.fromkeys(NAMES, 0.5),
    ],
    ids=["first", "last", "sliding", "three", "all"],
)
def test_the_rest_moves_as_pinocchio_says(locked: dict[str, float]) -> None:
    """Pose, Jacobian, links and limits of the free joints are those of the whole arm with the others held."""
    whole, arm, oracle = urdf_ik.load(TEXT, "base", "tool"), None, Oracle(TEXT)
    arm = urdf_ik.load(TEXT, "base", "tool", locked=locked)
    free = [k for k, name in enumerate(NAMES) if name not in locked]
    assert arm.joint_names == tuple(NAMES[k] for k in free)
    assert dict(arm.chain.locked) == locked
    assert arm.dof == len(free)
    np.testing.assert_array_equal(arm.limits, whole.limits[free])
    for q in np.random.default_rng(0).uniform(-0.5, 0.5, (5, 7)):
        full = np.array([locked.get(name, value) for name, value in zip(NAMES, q, strict=True)])
        np.testing.assert_allclose(arm.fk(full[free]), oracle.pose(full), atol=1e-13)
        np.testing.assert_allclose(arm.jacobian(full[free]), oracle.jacobian(full)[:, free], atol=1e-13)
        for link, pose in arm.link_poses(full[free]).items():
            np.testing.assert_allclose(pose, whole.link_poses(full)[link], atol=1e-13)
        reference = Reference(TEXT, "base", "tool", locked=locked)
        assert reference.joint_names == arm.joint_names
        np.testing.assert_allclose(reference.pose(full[free]), oracle.pose(full), atol=1e-13)
        np.testing.assert_allclose(reference.jacobian(full[free]), oracle.jacobian(full)[:, free], atol=1e-13)


def test_six_joints_left_are_solved() -> None:
    """Each end and the middle of an arm with seven joints held: the six others' planted joint vector is found."""
    text = random_seven("one before wrist, 2||3", 0).urdf
    oracle = Oracle(text)
    arm = urdf_ik.load(text, "base", "tool", locked={"joint_1": 0.8})
    assert arm.structure.family == "6R spherical wrist, 2||3"
    assert arm.redundancy is None
    for q in oracle.draw(np.random.default_rng(0), 10):
        q[0] = 0.8
        found = arm.ik(oracle.pose(q)).to_array()
        assert np.abs((found - q[1:] + np.pi) % (2.0 * np.pi) - np.pi).max(axis=1).min() < 1e-6


def test_locking_twice_and_nothing() -> None:
    """Joints locked one after the other are the same as at once; none leaves the chain as it is."""
    chain = urdf_ik.load(TEXT, "base", "tool").chain
    assert chain.lock({}) is chain
    once, twice = chain.lock({"joint_2": 0.4, "joint_5": 1.0}), chain.lock({"joint_2": 0.4}).lock({"joint_5": 1.0})
    q = np.linspace(-0.4, 0.4, 5)
    np.testing.assert_allclose(once.fk(q), twice.fk(q), atol=1e-14)
    assert once.locked == twice.locked == (("joint_2", 0.4), ("joint_5", 1.0))


def test_a_joint_that_mimics_a_held_one_stands_still() -> None:
    """A finger outside the chain that follows a locked joint is where Pinocchio puts it."""
    mimic = '<mimic joint="joint_2" multiplier="-2" offset="0.1"/>'
    finger = joint("follows", "revolute", "base", "finger", axis="0 0 1", more=mimic)
    text = TEXT.replace("</robot>", f'<link name="finger"/>{finger}</robot>')
    arm = urdf_ik.load(text, "base", "tool", locked={"joint_2": 0.6})
    reference = Reference(text, "base", "tool", locked={"joint_2": 0.6})
    q = np.linspace(-0.3, 0.3, 6)
    np.testing.assert_allclose(arm.link_poses(q)["finger"], reference.link_poses(q)["finger"], atol=1e-14)
    assert arm.link_poses(q)["finger"][0, 0] == pytest.approx(np.cos(-1.1))


def test_what_cannot_be_locked_is_named() -> None:
    """An unknown joint lists the joints that there are; a value that is no number tells the joint."""
    with pytest.raises(ChainError, match="joint_9") as unknown:
        urdf_ik.load(TEXT, "base", "tool", locked={"joint_9": 0.0})
    assert unknown.value.candidates == NAMES
    for value in (np.nan, "half", None):
        with pytest.raises(ArgumentError, match="joint_2"):
            urdf_ik.load(TEXT, "base", "tool", locked={"joint_2": value})  # type: ignore[dict-item]


def test_the_cross_check_holds_with_held_joints() -> None:
    """Pinocchio, held at the same values, confirms every property."""
    text = random_seven("one before wrist, 2||3", 0).urdf
    arm = urdf_ik.load(text, "base", "tool", locked={"joint_1": 0.8})
    assert crosscheck.check(arm, n=10, collision=False).passed


def test_collision_with_a_held_joint() -> None:
    """The collision model takes the free joints only, and places the shapes as the whole arm has them."""
    arm = urdf_ik.load("zyyzyz_6r", locked={"joint_3": 1.2})
    whole = CollisionModel(arm.model, arm.base, arm.tip)
    for q in np.random.default_rng(0).uniform(-2.0, 2.0, (10, 5)):
        full = np.insert(q, 2, 1.2)
        shared = set(arm.cell.collisions.checked_pairs) & set(whole.checked_pairs)
        ours = {pair for pair in arm.cell.collisions.colliding_pairs(q) if pair in shared}
        assert ours == {pair for pair in whole.colliding_pairs(full) if pair in shared}
