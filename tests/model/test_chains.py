"""Which chain of a URDF is meant where none is named: fingers, heads, tool frames, several arms, SRDF groups."""

import pytest
from urdf_texts import arm

import urdf_ik
from urdf_ik.errors import ChainError
from urdf_ik.model.srdf import chain_groups
from urdf_ik.model.urdf import read

ARM = tuple(f"j{k} revolute l{k - 1} l{k}" for k in range(1, 7))
TWO_ARMS = arm(
    "lift prismatic base torso",
    *(f"left_j{k} revolute {f'left_{k - 1}' if k > 1 else 'torso'} left_{k}" for k in range(1, 8)),
    *(f"right_j{k} revolute {f'right_{k - 1}' if k > 1 else 'torso'} right_{k}" for k in range(1, 8)),
    "pan revolute torso head",
)


@pytest.mark.parametrize(
    ("more", "tip"),
    [
        ((), "l6"),
        (("f1 prismatic l6 a", "f2 prismatic l6 b"), "l6"),
        (("finger1 revolute l6 a", "tip1 revolute a aa", "finger2 revolute l6 b", "finger3 revolute l6 c"), "l6"),
        (("gripper revolute l6 moving_jaw",), "l6"),
        (("gripper_roll revolute l6 gripper",), "gripper"),
        (("j7 revolute l6 gripper_link",), "gripper_link"),
        (("t fixed l6 flange", "u fixed flange tool0", "c fixed l6 camera"), "tool0"),
        (("t fixed l6 tool0", "g fixed tool0 hand_tcp", "f1 prismatic tool0 a", "f2 prismatic tool0 b"), "hand_tcp"),
        (("pan revolute l0 head", "tilt revolute head face"), "l6"),
        (("wheel1 continuous l0 w1", "wheel2 continuous l0 w2"), "l6"),
    ],
)  # fmt: skip
def test_the_tip_that_is_meant(more: tuple[str, ...], tip: str) -> None:
    """Fingers are no part of the arm, a wrist called gripper is; tool frames go before cameras, arms before heads."""
    model = read(arm(*ARM, *more))
    assert model.resolve_chain() == ("l0", tip)
    assert [each.tip for each in model.chains() if each.chosen] == [tip]


@pytest.mark.parametrize(("joints", "kind"), [(4, "limb"), (5, "arm")])
def test_five_joints_without_names_are_an_arm(joints: int, kind: str) -> None:
    """Where no name says what a limb is, its number of joints does."""
    (limb,) = read(arm(*ARM[:joints])).limbs()
    assert (limb.kind, len(limb.joints)) == (kind, joints)


def test_a_chain_begins_behind_a_floating_joint() -> None:
    """A mobile base has no joint vector: the arm on it does."""
    assert read(arm("free floating world l0", *ARM)).resolve_chain() == ("l0", "l6")


def test_two_tool_frames_are_in_doubt() -> None:
    """Where two links are named as tool frames the error lists both, and nothing is chosen."""
    model = read(arm(*ARM, "a fixed l6 left_tcp", "b fixed l6 right_tcp"))
    with pytest.raises(ChainError, match="several tool frames") as caught:
        model.resolve_chain()
    assert {"left_tcp", "right_tcp"} <= set(caught.value.candidates)
    assert not any(each.chosen for each in model.chains())


def test_several_arms_have_names() -> None:
    """Two arms are called left and right, begin where they part, and say what lies before."""
    model = read(TWO_ARMS)
    with pytest.raises(ChainError, match="'left': torso to left_7, 7 joints; 'right'"):
        model.resolve_chain()
    left, right, head = model.chains()
    assert (left.name, right.name, head.name) == ("left", "right", "head")
    assert left.before == ("lift",) and left.base == "torso"
    loaded = urdf_ik.load(TWO_ARMS, chain="right")
    assert (loaded.base, loaded.tip) == ("torso", "right_7")
    assert urdf_ik.load(TWO_ARMS, base="base", tip="left_7").joint_names == (*left.before, *left.joints)
    with pytest.raises(ChainError, match="is called 'middle'; there are 'left'"):
        urdf_ik.load(TWO_ARMS, chain="middle")
    with pytest.raises(urdf_ik.ArgumentError, match="say the same"):
        urdf_ik.load(TWO_ARMS, chain="left", tip="left_7")


def test_groups_of_an_srdf_are_the_chains() -> None:
    """A group with a chain is what is meant; several have to be named, and links that are not there are refused."""
    group = '<group name="{0}"><chain base_link="{1}" tip_link="{2}"/></group>'
    one = (
        f'<robot name="two">{group.format("arm", "base", "left_5")}<group name="g"><joint name="pan"/></group></robot>'
    )
    loaded = urdf_ik.load(TWO_ARMS, srdf=one)
    assert (loaded.base, loaded.tip, loaded.dof) == ("base", "left_5", 6)
    two = one.replace("</robot>", group.format("other", "torso", "right_7") + "</robot>")
    assert urdf_ik.load(TWO_ARMS, srdf=two, chain="other").tip == "right_7"
    with pytest.raises(ChainError, match="several chains.*candidates: arm, other"):
        urdf_ik.load(TWO_ARMS, srdf=two)
    with pytest.raises(ChainError, match="no chain 'left'"):
        urdf_ik.load(TWO_ARMS, srdf=two, chain="left")
    with pytest.raises(urdf_ik.UrdfError, match="tip_link='left_55'.*did you mean 'left_5"):
        chain_groups(two.replace("left_5", "left_55"), read(TWO_ARMS).links)
