"""The reference itself: Pinocchio's model, asked for a chain's poses, Jacobian and errors, against facts by hand."""

import math

import numpy as np
import pinocchio as pin
import pytest
from chains import joint, robot

from urdf_ik.cell.pinocchio_reference import Reference, pose_errors
from urdf_ik.errors import ChainError, UnsupportedArm
from urdf_ik.model import catalogue, urdf

# Joints b and c stand in the file before the joint that carries them; b is continuous; d slides.
TREE = robot(
    joint("c", "revolute", "two", "three", "1 0 0", axis="0 1 0"),
    joint("b", "continuous", "one", "two", "1 0 0", axis="0 0 2"),
    joint("a", "revolute", "base", "one", "0.1 0.2 0.3", axis="0 0 1"),
    joint("d", "prismatic", "three", "four", "0.5 0 0", axis="0 3 4"),
    joint("side", "revolute", "one", "arm", "0 0 1", axis="1 0 0"),
    joint("hand", "fixed", "arm", "finger", "0 0.4 0", axis="1 0 0"),
)


def about_z(angle: float) -> np.ndarray:
    """Rotation (4, 4) about z."""
    c, s = math.cos(angle), math.sin(angle)
    return np.array([[c, -s, 0, 0], [s, c, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1.0]])


def by_differences(reference: Reference, q: np.ndarray) -> np.ndarray:
    """Jacobian (6, n) by central differences of the pose."""
    columns = []
    for j in range(reference.dof):
        step = np.zeros(reference.dof)
        step[j] = 1e-6
        before, here, after = reference.pose(np.array([q - step, q, q + step]))
        turn = (after - before)[:3, :3] @ here[:3, :3].T / 2e-6
        columns.append([*(after - before)[:3, 3] / 2e-6, turn[2, 1], turn[0, 2], turn[1, 0]])
    return np.array(columns).T


def test_joints_are_matched_by_name_and_ordered_base_to_tip() -> None:
    """A joint vector runs from base to tip, whatever the order in the file, and a continuous joint is one number."""
    reference = Reference(TREE, "base", "four")
    assert reference.joint_names == ("a", "b", "c", "d")
    assert list(reference.prismatic) == [False, False, False, True]
    pose = reference.pose([0.3, 2.5, 0.0, 0.5])
    expected = np.eye(4)
    expected[:3, 3] = 0.1, 0.2, 0.3
    step = np.eye(4)
    step[0, 3] = 1.0
    slide = np.eye(4)
    slide[:3, 3] = 0.5, 0.5 * 0.6, 0.5 * 0.8
    np.testing.assert_allclose(pose, expected @ about_z(0.3) @ step @ about_z(2.5) @ step @ slide, atol=1e-14)


def test_ranges_hold_the_limits_or_one_turn() -> None:
    """Limits come from the URDF; a continuous joint has none, and is drawn from one turn; so is one with 1e9."""
    reference = Reference(TREE, "base", "four")
    np.testing.assert_array_equal(reference.limits, [[-3, 3], [-np.inf, np.inf], [-3, 3], [-3, 3]])
    np.testing.assert_array_equal(reference.ranges, [[-3, 3], [-np.pi, np.pi], [-3, 3], [-3, 3]])
    endless = Reference(TREE.replace('upper="3"', 'upper="1e9"'), "base", "four")
    np.testing.assert_allclose(endless.ranges[[0, 3]], [[-3, -3 + 2 * np.pi], [-3, -1]])


@pytest.mark.parametrize(
    ("base", "tip", "names"),
    [
        ("base", "four", ("a", "b", "c", "d")),
        ("two", "four", ("c", "d")),
        ("four", "base", ("d", "c", "b", "a")),
        ("three", "finger", ("c", "b", "side")),
        ("finger", "arm", ()),
    ],
)
def test_base_and_tip_anywhere(base: str, tip: str, names: tuple[str, ...]) -> None:
    """Poses, Jacobian and link poses are those of the tip seen from the base, wherever both lie in the tree."""
    reference = Reference(TREE, base, tip)
    assert reference.joint_names == names
    whole = {name: Reference(TREE, "base", name) for name in (base, tip)}
    rng = np.random.default_rng(1)
    for _ in range(5):
        values = dict.fromkeys(("a", "b", "c", "d", "side"), 0.0) | {name: rng.uniform(-2, 2) for name in names}
        to_base, to_tip = (each.pose([values[name] for name in each.joint_names]) for each in whole.values())
        q = np.array([values[name] for name in names])
        expected = np.linalg.inv(to_base) @ to_tip
        np.testing.assert_allclose(reference.pose(q), expected, atol=1e-14)
        np.testing.assert_allclose(reference.jacobian(q), by_differences(reference, q).reshape(6, -1), atol=1e-8)
        poses = reference.link_poses(q)
        assert set(poses) == {"base", "one", "two", "three", "four", "arm", "finger"}
        np.testing.assert_allclose(poses[tip], expected, atol=1e-14)
        np.testing.assert_allclose(poses[base], np.eye(4), atol=1e-14)


@pytest.mark.parametrize("name", ["zyyzyz_6r", "dh_6r", "ur5", "panda"])
def test_same_as_pinocchio_on_the_file(name: str) -> None:
    """The cleaned XML describes the same arm as the file: Pinocchio gives the same link poses for both."""
    entry = catalogue.resolve(name)
    reference = Reference(urdf.read(entry.path), entry.base, entry.tip)
    model = pin.buildModelFromUrdf(str(entry.path))
    data = model.createData()
    rng = np.random.default_rng(2)
    for _ in range(5):
        q = rng.uniform(*reference.ranges.T)
        full = pin.neutral(model)
        for joint_name, value in zip(reference.joint_names, q, strict=True):
            full[model.joints[model.getJointId(joint_name)].idx_q] = value
        pin.framesForwardKinematics(model, data, full)
        base = data.oMf[model.getFrameId(reference.base, pin.FrameType.BODY)]
        for link, pose in reference.link_poses(q).items():
            frame = model.getFrameId(link, pin.FrameType.BODY)
            np.testing.assert_allclose(pose, base.actInv(data.oMf[frame]).homogeneous, atol=1e-14)


MIMICS = {
    "followed by Pinocchio": (
        ("a", "revolute", ""),
        ("b", "revolute", '<mimic joint="a" multiplier="-2" offset="0.1"/>'),
    ),
    "of a continuous joint": (("a", "continuous", ""), ("b", "revolute", '<mimic joint="a" multiplier="3"/>')),
    "of a later joint": (("a", "revolute", '<mimic joint="b" offset="0.2"/>'), ("b", "revolute", "")),
}


@pytest.mark.parametrize("case", MIMICS)
def test_mimic_inside_the_chain(case: str) -> None:
    """A mimicking joint is no entry of q and moves with the one it follows, also where Pinocchio would refuse it."""
    pair = MIMICS[case]
    links = ("base", "one", "two")

    def text(follow: bool) -> str:
        parts = [
            joint(name, kind, links[i], links[i + 1], "1 0 0", axis="0 1 1", more=inside if follow else "")
            for i, (name, kind, inside) in enumerate(pair)
        ]
        return robot(*parts, joint("tip", "revolute", "two", "tool", "0 0 1", axis="1 0 0"))

    following, free = Reference(text(True), "base", "tool"), Reference(text(False), "base", "tool")
    driver = "b" if "later" in case else "a"
    assert following.joint_names == (driver, "tip")
    for value in (-0.7, 0.4):
        a, b = {
            "followed by Pinocchio": (value, -2 * value + 0.1),
            "of a continuous joint": (value, 3 * value),
            "of a later joint": (value + 0.2, value),
        }[case]
        np.testing.assert_allclose(following.pose([value, 0.3]), free.pose([a, b, 0.3]), atol=1e-14)
        q = np.array([value, 0.3])
        np.testing.assert_allclose(following.jacobian(q), by_differences(following, q), atol=1e-8)


def test_mimic_of_a_mimic_outside_the_chain() -> None:
    """A row of mimics that starts at a joint of the chain moves the links beside the chain."""
    reference = Reference(
        robot(
            joint("a", "revolute", "base", "one", "0 0 0", axis="0 0 1"),
            joint(
                "f",
                "revolute",
                "one",
                "left",
                "1 0 0",
                axis="0 0 1",
                more='<mimic joint="a" multiplier="2" offset="0.1"/>',
            ),
            joint("g", "revolute", "one", "right", "1 0 0", axis="0 0 1", more='<mimic joint="f" multiplier="-1"/>'),
        ),
        "base",
        "one",
    )
    poses = reference.link_poses([0.3])
    np.testing.assert_allclose(np.linalg.inv(poses["one"]) @ poses["left"], _at_one(0.7), atol=1e-14)
    np.testing.assert_allclose(np.linalg.inv(poses["one"]) @ poses["right"], _at_one(-0.7), atol=1e-14)


def _at_one(angle: float) -> np.ndarray:
    out = about_z(angle)
    out[0, 3] = 1.0
    return out


@pytest.mark.parametrize("angle", [0.0, 1e-12, 1e-8, 1e-3, 1.0, 3.0, math.pi - 1e-9, math.pi])
def test_rotation_error_is_exact_at_every_angle(angle: float) -> None:
    """The angle between two rotations is right to rounding, also where its cosine is 1 to the last digit."""
    turn = pin.exp3(np.array([0.6, 0.0, 0.8]) * 1.1)
    A, B = np.eye(4), np.eye(4)
    A[:3, :3] = turn
    B[:3, :3] = turn @ pin.exp3(np.array([2.0, -1.0, 2.0]) / 3.0 * angle)
    B[:3, 3] = 3e-12, 4e-12, 0.0
    position, rotation = pose_errors(A, B)
    assert position == pytest.approx(5e-12, rel=1e-12)
    assert rotation == pytest.approx(angle, abs=1e-15, rel=1e-15)


def test_errors_broadcast_and_leave_nan_rows_alone() -> None:
    """Errors of (poses, branches, n) against (poses, 1, 4, 4) come as (poses, branches), NaN where q is NaN."""
    reference = Reference(TREE, "base", "four")
    q = np.random.default_rng(4).uniform(-1, 1, (3, 2, 4))
    T = reference.pose(q[:, 0])
    q[1, 1] = np.nan
    position, rotation = reference.errors(q, T[:, None])
    assert position.shape == rotation.shape == (3, 2)
    assert position[:, 0].max() < 1e-14
    assert rotation[:, 0].max() < 1e-14
    np.testing.assert_array_equal(np.isnan(position), [[False, False], [False, True], [False, False]])
    assert reference.error(q[2, 1], T[2]) == (position[2, 1], rotation[2, 1])
    assert min(reference.error(q[2, 1], T[2])) > 1e-3


def test_links_that_are_not_there_and_joints_that_are_no_number() -> None:
    """Unknown links are listed; a floating joint in the chain is refused, one beside it is not."""
    with pytest.raises(ChainError, match="nope"):
        Reference(TREE, "base", "nope")
    floating = robot(
        joint("a", "revolute", "base", "one", "0 0 0", axis="0 0 1"),
        joint("f", "floating", "one", "two", "0 0 0", axis="0 0 1"),
    )
    with pytest.raises(UnsupportedArm, match="'f' .* 6 degrees"):
        Reference(floating, "base", "two")
    assert Reference(floating, "base", "one").joint_names == ("a",)
