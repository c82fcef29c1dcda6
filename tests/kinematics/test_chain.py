"""Chains against Pinocchio: kinematics of any base and tip, joints beside the chain, limits."""

import itertools
import math
from dataclasses import replace

import numpy as np
import pytest
from chains import HAND, RIGHT, ReferenceModel, joint, random_tree, robot, serial
from numpy.typing import NDArray

from urdf_ik.errors import ChainError, UnsupportedArm
from urdf_ik.kinematics.chain import Chain, from_urdf
from urdf_ik.model import urdf

Array = NDArray[np.float64]


def assert_agrees(chain: Chain, reference: ReferenceModel, q: Array) -> None:
    """FK and Jacobian at one joint vector are Pinocchio's."""
    reference.place(dict(zip(chain.joint_names, q, strict=True)))
    np.testing.assert_allclose(chain.fk(q), reference.pose(chain.base, chain.tip), atol=2e-13)
    expected = reference.jacobian(chain.base, chain.tip, chain.joint_names)
    np.testing.assert_allclose(chain.jacobian(q), expected, atol=2e-13)


@pytest.mark.parametrize("seed", range(4))
def test_any_base_and_tip_of_a_tree(seed: int) -> None:
    """Between any two links, up, down or over a branching, FK, Jacobian and every link's pose are Pinocchio's."""
    xml = random_tree(seed)
    model, reference = urdf.read(xml), ReferenceModel(xml)
    rng = np.random.default_rng(seed)
    for base, tip in itertools.product(model.links, repeat=2):
        chain = from_urdf(model, base, tip)
        if not chain.n:
            continue
        q = rng.uniform(-2.5, 2.5, chain.n)
        assert_agrees(chain, reference, q)
        poses = chain.link_poses(q)
        assert set(poses) == set(model.links)
        for link, pose in poses.items():
            np.testing.assert_allclose(pose, reference.pose(base, link), atol=5e-13, err_msg=f"{base} {tip} {link}")


@pytest.mark.parametrize("seed", range(4))
def test_only_joints_between_base_and_tip_move_the_tip(seed: int) -> None:
    """The chain's joints are those, and all those, whose column of Pinocchio's relative Jacobian is not zero."""
    xml = random_tree(seed)
    model, reference = urdf.read(xml), ReferenceModel(xml)
    movable = tuple(joint.name for joint in model.joints if joint.type != "fixed")
    reference.place({name: 0.3 for name in movable})
    for base, tip in itertools.product(model.links, repeat=2):
        columns = reference.jacobian(base, tip, movable)
        moving = {name for name, column in zip(movable, columns.T, strict=True) if np.abs(column).max() > 1e-9}
        assert set(from_urdf(model, base, tip).joint_names) == moving


@pytest.mark.parametrize("seed", range(4))
def test_swapped_base_and_tip(seed: int) -> None:
    """From tip to base the joints come in the opposite order, with the same values, and the pose is the inverse."""
    model = urdf.read(random_tree(seed))
    rng = np.random.default_rng(seed)
    for base, tip in itertools.combinations(model.links, 2):
        there, back = from_urdf(model, base, tip), from_urdf(model, tip, base)
        assert back.joint_names == there.joint_names[::-1]
        np.testing.assert_array_equal(back.limits, there.limits[::-1])
        if not there.n:
            continue
        q = rng.uniform(-2.5, 2.5, there.n)
        np.testing.assert_allclose(back.fk(q[::-1]) @ there.fk(q), np.eye(4), atol=1e-12)


@pytest.mark.parametrize(
    "kinds", ["R", "RRPR", "PRRRRRR", "PPP", "CRCRCR", "RCPRCP", "FRRRRRR", "RRRFRRR", "RRRRRRF", "FFFRFFRFFPFF"]
)
def test_joint_types_and_fixed_joints(kinds: str) -> None:
    """Any mix of joints, with fixed ones before, between and behind them: as Pinocchio has it."""
    xml = serial(kinds)
    chain, reference = from_urdf(urdf.read(xml), "l0", f"l{len(kinds)}"), ReferenceModel(xml)
    assert "".join({"revolute": "R", "continuous": "C", "prismatic": "P"}[k] for k in chain.joint_types) == (
        kinds.replace("F", "")
    )
    for q in np.random.default_rng(1).uniform(-3.0, 3.0, (5, chain.n)):
        assert_agrees(chain, reference, q)


@pytest.mark.parametrize("kind", ["revolute", "continuous", "prismatic"])
@pytest.mark.parametrize("axis", ["0 0 -1", "1e-3 0 0", "3 4 12", "-1e6 1e6 1", "0.6 0 0.8", "1 1e-9 0"])
def test_axes_of_any_length_and_direction(kind: str, axis: str) -> None:
    """An axis need not be a unit vector, or along a coordinate: it is a direction, for sliding joints as well."""
    xml = robot(joint("j", kind, "a", "b", "0.1 0.2 0.3", "0.4 0.5 0.6", axis), joint("f", "fixed", "b", "c", "1 2 3"))
    chain, reference = from_urdf(urdf.read(xml), "a", "c"), ReferenceModel(xml)
    for value in (-2.0, 0.0, 1.3):
        assert_agrees(chain, reference, np.array([value]))
    np.testing.assert_allclose(np.linalg.norm(chain.H, axis=1), 1.0, atol=1e-15)


def test_screw_axes_are_pinocchios_zero_configuration() -> None:
    """H are directions of the joints, P steps between points on them, and R_tip the tip's rotation, all at q = 0."""
    xml = serial("FRPRCRF", seed=5)
    chain, reference = from_urdf(urdf.read(xml)), ReferenceModel(xml)
    reference.place({})
    home = reference.pose("l0", "l7")
    jacobian = reference.jacobian("l0", "l7", chain.joint_names)
    turning = ~chain.prismatic
    assert list(turning) == [True, False, True, True, True]
    np.testing.assert_allclose(chain.H[turning], jacobian[3:, turning].T, atol=1e-14)
    np.testing.assert_allclose(chain.H[~turning], jacobian[:3, ~turning].T, atol=1e-14)
    # The speed at the tip is the axis crossed with the arm from any point of it.
    arms = home[:3, 3] - chain.points
    np.testing.assert_allclose(np.cross(chain.H, arms)[turning], jacobian[:3, turning].T, atol=1e-13)
    np.testing.assert_allclose(chain.P.sum(axis=0), home[:3, 3], atol=1e-14)
    np.testing.assert_allclose(chain.R_tip, home[:3, :3], atol=1e-14)
    assert (chain.H.shape, chain.P.shape, chain.n) == ((5, 3), (6, 3), 5)


def test_base_and_tip_without_a_joint_between_them() -> None:
    """Rigidly joined links, or one link twice, make a chain of no joints whose pose is constant."""
    xml = robot(joint("f", "fixed", "a", "b", "1 2 3", "0.1 0.2 0.3"), joint("j", "revolute", "b", "c", axis="0 0 1"))
    model, reference = urdf.read(xml), ReferenceModel(xml)
    reference.place({})
    for base, tip in (("a", "b"), ("b", "a"), ("c", "c")):
        chain = from_urdf(model, base, tip)
        assert (chain.n, chain.jacobian([]).shape, chain.limits.shape) == (0, (6, 0), (0, 2))
        np.testing.assert_allclose(chain.fk([]), reference.pose(base, tip), atol=1e-15)
        assert chain.fk(np.empty((3, 0))).shape == (3, 4, 4)


@pytest.mark.parametrize(("base", "tip"), [("base", "tool"), ("tool", "base"), ("drawer", "tool"), ("camera", "base")])
def test_links_beside_the_chain(base: str, tip: str) -> None:
    """Joints outside the chain stay at zero, floating ones too; those that mimic one of its joints follow it."""
    xml = HAND.format(RIGHT)
    model, reference = urdf.read(xml), ReferenceModel(xml)
    chain = from_urdf(model, base, tip)
    for q in np.random.default_rng(4).uniform(-2.0, 2.0, (5, chain.n)):
        reference.place(dict(zip(chain.joint_names, q, strict=True)))
        poses = chain.link_poses(q)
        assert set(poses) == set(model.links)
        for link, pose in poses.items():
            np.testing.assert_allclose(pose, reference.pose(base, link), atol=1e-13, err_msg=link)


@pytest.mark.parametrize(("driver", "factor", "shift"), [("b", 2.0, -0.3), ("left", -3.0, 0.1), ("lid", 5.0, 0.2)])
def test_mimics_of_mimics_and_of_continuous_joints(driver: str, factor: float, shift: float) -> None:
    """A joint may follow a continuous one, or one that follows another: value = multiplier * driver + offset.

    Pinocchio refuses both; here it is given the values instead.
    """
    plain = HAND.format("")
    xml = HAND.format(f'<mimic joint="{driver}" multiplier="{factor}" offset="{shift}"/>')
    chain, reference = from_urdf(urdf.read(xml), "base", "tool"), ReferenceModel(plain)
    q = np.array([0.8, -0.6])
    follows = {"b": q[1], "left": 0.1 * q[0], "lid": 0.7}[driver]
    reference.place({"a": q[0], "b": q[1], "right": factor * follows + shift})
    np.testing.assert_allclose(chain.link_poses(q)["right"], reference.pose("base", "right"), atol=1e-14)


@pytest.mark.parametrize(
    ("base", "tip", "kind", "name"),
    [
        ("base", "cart", "floating", "loose"),
        ("cart", "base", "floating", "loose"),
        ("tool", "rug", "planar", "flat"),
    ],
)
def test_joints_that_cannot_be_solved(base: str, tip: str, kind: str, name: str) -> None:
    """Floating and planar joints in the chain are refused, by name and with the reason."""
    with pytest.raises(UnsupportedArm, match=f"'{name}'.*{kind}"):
        from_urdf(urdf.read(HAND.format(RIGHT)), base, tip)


def test_unknown_links() -> None:
    """A base or tip that the URDF lacks is refused, with the links that there are."""
    model = urdf.read(serial("RR"))
    for base, tip in (("nope", "l2"), ("l0", "nope")):
        with pytest.raises(ChainError, match="nope") as error:
            from_urdf(model, base, tip)
        assert error.value.candidates == ("l0", "l1", "l2")


def test_limits() -> None:
    """A continuous joint has none, whatever its element says; the others have the URDF's, in the chain's order."""
    tight = '<limit lower="-0.5" upper="1.5" effort="1" velocity="1"/>'
    short = tight.replace("-0.5", "0").replace("1.5", "0.2")
    xml = robot(
        joint("c", "prismatic", "l2", "l3", axis="1 0 0", more=short),
        joint("a", "continuous", "l0", "l1", axis="1 0 0", more=tight),
        joint("b", "revolute", "l1", "l2", axis="0 1 0", more=tight),
        joint("d", "continuous", "l3", "l4", axis="0 0 1"),
    )
    model = urdf.read(xml)
    np.testing.assert_array_equal(
        from_urdf(model, "l0", "l4").limits, [[-np.inf, np.inf], [-0.5, 1.5], [0.0, 0.2], [-np.inf, np.inf]]
    )
    # Walked upwards a joint's value means the same, and so do its limits.
    np.testing.assert_array_equal(from_urdf(model, "l3", "l1").limits, [[0.0, 0.2], [-0.5, 1.5]])


def test_size_is_the_length_of_the_links() -> None:
    """Tolerances are relative to the steps from axis 1 to the tip: the place of the base does not matter."""
    chain = from_urdf(urdf.read(serial("RRPR")))
    assert chain.size == pytest.approx(sum(math.hypot(*step) for step in chain.P[1:]), rel=1e-14)
    assert replace(chain, P=np.concatenate([[[9.0, 9.0, 9.0]], chain.P[1:]])).size == chain.size
    assert replace(chain, P=np.zeros((5, 3))).size == 1.0
