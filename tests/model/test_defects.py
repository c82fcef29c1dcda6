"""The table of defects, each from both sides: in a part that the chain uses an error, elsewhere a warning."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pinocchio
import pytest
from chains import ReferenceModel

import urdf_ik
from urdf_ik import ChainError, UrdfError
from urdf_ik.cell.pinocchio_reference import Reference
from urdf_ik.model.urdf import read
from urdf_ik.model.urdf.checks import CHAIN, COLLISION, RULES

LIMIT = '<limit lower="-2" upper="2" effort="1" velocity="1"/>'
JOINTS = {
    "shoulder": ("base", "upper", "0 0 0.3", "0 0 1"),
    "elbow": ("upper", "fore", "0.4 0 0", "0 1 0"),
    "wrist": ("fore", "tool0", "0.3 0 0", "1 0 0"),
    "grip": ("tool0", "left_finger", "0 0.02 0", "0 0 1"),
    "press": ("tool0", "right_finger", "0 -0.02 0", "0 0 1"),
    "wheel": ("base", "tyre", "0 0 0.1", "0 1 0"),
}
ROBOT = (
    '<robot name="r">\n'
    + "".join(f'<link name="{link}"></link>\n' for link in ("base", *(each[1] for each in JOINTS.values())))
    + "".join(
        f'<joint name="{name}" type="revolute">\n<parent link="{parent}"/>\n<child link="{child}"/>\n'
        f'<origin xyz="{xyz}"/>\n<axis xyz="{axis}"/>\n{LIMIT}\n</joint>\n'
        for name, (parent, child, xyz, axis) in JOINTS.items()
    )
    + "</robot>"
)
Sides = tuple[str, str]  # a joint and the link that it carries
INSIDE, OUTSIDE = ("elbow", "fore"), ("grip", "left_finger")


def joint(old: str, new: str) -> Callable[[Sides], str]:
    """The robot with something replaced in one joint."""

    def edit(side: Sides) -> str:
        start = ROBOT.index(f'<joint name="{side[0]}"')
        end = ROBOT.index("</joint>", start)
        text = ROBOT[start:end]
        assert old in text
        return ROBOT[:start] + text.replace(old, new, 1) + ROBOT[end:]

    return edit


def attribute(name: str, value: str) -> Callable[[Sides], str]:
    """The robot with the child link's or the joint's own number replaced."""

    def edit(side: Sides) -> str:
        return joint(f'{name}="{JOINTS[side[0]][2 if name == "xyz" else 3]}"', f'{name}="{value}"')(side)

    return edit


def axis(value: str) -> Callable[[Sides], str]:
    """The robot with another axis of one joint."""
    return lambda side: joint(f'<axis xyz="{JOINTS[side[0]][3]}"/>', f"<axis{value}/>")(side)


def link(new: str) -> Callable[[Sides], str]:
    """The robot with something written into one link."""
    return lambda side: ROBOT.replace(f'<link name="{side[1]}">', f'<link name="{side[1]}">{new}')


def more(text: str) -> Callable[[Sides], str]:
    """The robot with another element; {0} is the joint and {1} the link."""
    return lambda side: ROBOT.replace("</robot>", text.format(*side) + "</robot>")


def mimic(text: str) -> Callable[[Sides], str]:
    """The robot with a joint that mimics."""
    return joint(LIMIT, LIMIT + text)


def both(first: Callable[[Sides], str], second: str) -> Callable[[Sides], str]:
    """Two edits, the second of the last joint of the side's neighbours."""

    def edit(side: Sides) -> str:
        text, other = first(side), {"elbow": "wrist", "grip": "press"}[side[0]]
        at = text.index(LIMIT, text.index(f'<joint name="{other}"'))
        return text[:at] + LIMIT + second.format(side[0]) + text[at + len(LIMIT) :]

    return edit


BOX = "<geometry><box size='{}'/></geometry>"
PLACED = "<joint name='{}' type='fixed'><parent link='{}'/><child link='{}'/></joint>"
DEFECTS: dict[str, tuple[str, Callable[[Sides], str]]] = {
    # defect: (row of the table, how it comes about)
    "word in an origin": ("origin", attribute("xyz", "0 x 0")),
    "infinite origin": ("origin", attribute("xyz", "0 0 1e999")),
    "origin beyond 1e15": ("origin", attribute("xyz", "1e16 0 0")),
    "angle beyond 1e15": ("origin", joint("<origin ", '<origin rpy="0 0 -1.7e308" ')),
    "xacro in an origin": ("origin", attribute("xyz", "${x} 0 0")),
    "quaternion origin": ("origin", joint("<origin ", '<origin quat_xyzw="0 0 0 1" ')),
    "zero axis": ("axis", axis(' xyz="0 0 0"')),
    "axis without xyz": ("axis", axis("")),
    "unknown type": ("joint type", joint("revolute", "ball")),
    "no limit": ("limit", joint(LIMIT, "")),
    "NaN limit": ("limit", joint('upper="2"', 'upper="nan"')),
    "lower above upper": ("bounds", joint('lower="-2"', 'lower="3"')),
    "negative velocity": ("velocity", joint('velocity="1"', 'velocity="-1"')),
    "no velocity": ("speeds", joint(' velocity="1"', "")),
    "bounds in degrees": ("turns", joint('lower="-2" upper="2"', 'lower="-170" upper="170"')),
    "negative acceleration": ("rates", joint('velocity="1"', 'velocity="1" acceleration="-1"')),
    "no effort": ("speeds", joint(' effort="1"', "")),
    "mimic of nothing": ("mimic", mimic('<mimic joint="gone"/>')),
    "mimic of a fixed joint": (
        "mimic", lambda side: mimic('<mimic joint="wheel"/>')(side).replace(
            '<joint name="wheel" type="revolute">', '<joint name="wheel" type="fixed">')
    ),
    "mimic of itself": ("mimic", lambda side: mimic(f'<mimic joint="{side[0]}"/>')(side)),
    "mimics in a circle": (
        "mimic", lambda side: both(mimic(f'<mimic joint="{ {"elbow": "wrist", "grip": "press"}[side[0]] }"/>'),
                                   '<mimic joint="{}"/>')(side)
    ),
    "joint without a name": ("joint name", lambda side: joint(f' name="{side[0]}"', "")(side)),
    "joint name twice": ("joint name", more(PLACED.format("{0}", "base", "spare") + "<link name='spare'/>")),
    "joint called universe": ("joint name", lambda side: joint(side[0], "universe")(side)),
    "xacro in a joint": ("joint xacro", joint("<axis", '<xacro:if value="1"/><axis')),
    "undeclared child": ("undeclared", lambda side: ROBOT.replace(f'<link name="{side[1]}"></link>', "")),
    "two parents": ("two parents", more(PLACED.format("again", "base", "{1}"))),
    "link name twice": ("link twice", more("<link name='{1}'/>")),
    "xacro in a link's name": ("link xacro", lambda side: ROBOT.replace(f'"{side[1]}"', f'"$(arg p){side[1]}"')),
    "no child": ("ends", lambda side: joint(f'<child link="{side[1]}"/>', "")(side)),
    "box with commas": ("collision", link(f"<collision>{BOX.format('1,1,1')}</collision>")),
    "box beyond 1e15": ("collision", link(f"<collision>{BOX.format('1e160 1 1')}</collision>")),
    "scale beyond 1e15": (
        "collision", link("<collision><geometry><mesh filename='a.stl' scale='1 1 1e200'/></geometry></collision>")
    ),
    "sphere of negative radius": (
        "collision", link("<collision><geometry><sphere radius='-1'/></geometry></collision>")
    ),
    "broken picture": ("visual", link(f"<visual>{BOX.format('x')}</visual>")),
    "inertia without mass": ("inertial", link("<inertial/>")),
    "xacro beside the links": ("robot xacro", more("<xacro:sensor/>")),
    "link without a name": ("link name", more("<link/>")),
    "link apart": ("parts", more("<link name='lost'/>")),
    "links in a circle": ("parts", more(
        "<link name='p'/><link name='q'/>" + PLACED.format("pq", "p", "q") + PLACED.format("qp", "q", "p"))),
    "no robot name": ("robot name", lambda side: ROBOT.replace('<robot name="r">', "<robot>")),
}  # fmt: skip


def loaded(text: str) -> urdf_ik.Arm:
    """The arm from the base to the tool, which the gripper is behind."""
    return urdf_ik.load(text, "base", "tool0")


@pytest.mark.parametrize("case", DEFECTS)
def test_a_defect_beside_the_chain_is_a_warning(case: str) -> None:
    """The arm is that of the sound URDF, Pinocchio agrees, and one line says what was assumed; strict refuses it."""
    rule, edit = DEFECTS[case]
    text = edit(OUTSIDE)
    arm, sound = loaded(text), loaded(ROBOT)
    warning = arm.model.warnings[0]
    assert warning.rule == rule and warning.assumed == RULES[rule].assumed
    assert str(warning).startswith("<text>:") and "\n" not in str(warning) and str(warning).endswith(warning.assumed)
    q = [0.3, -0.4, 0.5]
    reference = Reference(arm.model, "base", "tool0")
    np.testing.assert_allclose(arm.fk(q), sound.fk(q), atol=1e-15)
    np.testing.assert_allclose(arm.fk(q), reference.pose(q), atol=1e-12)
    assert reference.warnings == arm.model.warnings
    np.testing.assert_allclose(arm.ik(arm.fk(q)).to_array(), sound.ik(sound.fk(q)).to_array(), atol=1e-9)
    ours, theirs = arm.link_poses(q), reference.link_poses(q)
    np.testing.assert_allclose([ours[name] for name in theirs], list(theirs.values()), atol=1e-12)
    with pytest.raises(UrdfError) as refused:
        urdf_ik.load(text, "base", "tool0", strict=True)
    assert str(refused.value).startswith(str(warning.error)) and refused.value.hint


@pytest.mark.parametrize("case", DEFECTS)
def test_a_defect_in_the_chain_is_an_error_where_the_table_says_so(case: str) -> None:
    """Chains through a part are refused with its line; parts that no chain uses do not stop one."""
    rule, edit = DEFECTS[case]
    text = edit(INSIDE)
    if CHAIN not in RULES[rule].used_by or rule == "parts":
        assert loaded(text).dof == 3
        return
    with pytest.raises(UrdfError) as refused:
        loaded(text)
    if rule != "ends":  # what is left of the chain falls apart
        assert str(refused.value) == str(read(text).warnings[0].error)
    assert refused.value.line and refused.value.hint
    with pytest.raises((UrdfError, ChainError)):
        urdf_ik.load(text)  # whatever is left, no shorter chain is taken for the arm


@pytest.mark.parametrize("case", [case for case, (rule, _) in DEFECTS.items() if COLLISION in RULES[rule].used_by])
def test_collision_checks_are_refused_where_shapes_are_missing_or_misplaced(case: str) -> None:
    """A shape that is left out, or stands at an assumed place, is not called free."""
    rule, edit = DEFECTS[case]
    shape = f"<collision>{BOX.format('0.1 0.1 0.1')}</collision>"
    arm = loaded(edit(OUTSIDE).replace('<link name="base">', f'<link name="base">{shape}'))
    if any(each.collides for each in arm.model.warnings):
        with pytest.raises(UrdfError):
            arm.clearance([0.0, 0.0, 0.0])
    else:  # what is left out has no shape
        assert rule in ("link twice", "parts")


def test_the_docs_hold_the_table() -> None:
    """Its rows are those that the reader follows."""
    text = (Path(__file__).parents[2] / "docs" / "how-to" / "load.md").read_text(encoding="utf-8")
    for element, defect, used_by, assumed in RULES.values():
        assert f"| {element} | {defect} | {', '.join(used_by) or 'nothing'} | {assumed} |" in text


def test_a_joint_that_is_mimicked_is_used() -> None:
    """A driver beside the chain, and one in a row of mimics, refuse the chain that they drive."""
    follows = mimic('<mimic joint="wheel"/>')(("elbow", "fore"))
    assert loaded(follows).joint_names == ("shoulder", "wheel", "wrist")
    at = follows.index('<joint name="wheel"')
    broken = follows[:at] + follows[at:].replace('upper="2"', 'upper="-3"')
    with pytest.raises(UrdfError, match="lower -2 is greater than upper -3") as refused:
        loaded(broken)
    assert refused.value.element == '<limit> of <joint name="wheel">'


def test_a_part_of_the_arm_that_is_apart_is_no_shorter_arm() -> None:
    """Where a typing error cuts the arm in two, the default chain is refused by its cause."""
    cut = ROBOT.replace('<parent link="fore"/>', '<parent link="four"/>')
    with pytest.raises(UrdfError, match="link 'four' is not declared.*did you mean 'fore"):
        urdf_ik.load(cut)
    assert urdf_ik.load(cut, "base", "fore").dof == 2
    with pytest.raises(UrdfError, match="is not declared|have no parent"):
        urdf_ik.load(cut, "base", "tool0")


def test_pinocchio_reads_what_is_read_here() -> None:
    """The clean URDF of every defect, on either side, is one that Pinocchio's parser takes."""
    for _, edit in DEFECTS.values():
        for side in (INSIDE, OUTSIDE):
            model = read(edit(side))
            theirs = pinocchio.buildModelFromXML(model.xml.decode())
            assert {each.name for each in theirs.frames if each.type == pinocchio.BODY} == set(model.links)


def test_an_error_names_all_defects_of_the_chain() -> None:
    """Five joints without a valid bound are one run, not five; the second and later ones come with their lines."""
    text = ROBOT.replace('lower="-2"', 'lower="two"')
    with pytest.raises(UrdfError) as refused:
        loaded(text)
    named = [name for name in JOINTS if f'of <joint name="{name}">' in str(refused.value)]
    assert named == ["shoulder", "elbow", "wrist"]  # those of the chain
    lines = [number for number, line in enumerate(text.splitlines(), 1) if "two" in line]
    assert all(f"line {number}: <limit>" in str(refused.value) for number in lines[1:3])
    with pytest.raises(UrdfError, match="wheel"):
        urdf_ik.load(text, "base", "tool0", strict=True)


def test_limits_without_effort_and_velocity_load() -> None:
    """Neither is used: the arm moves as Pinocchio's, which gets zeros, and no speed is limited."""
    arm = loaded(ROBOT.replace(' effort="1" velocity="1"', ""))
    assert np.isinf(arm.solver.velocity_limits).all() and len(arm.model.warnings) == len(JOINTS)
    model = pinocchio.buildModelFromXML(arm.model.xml.decode())
    assert not model.velocityLimit.any() and not model.effortLimit.any()
    q = [0.3, -0.4, 0.5]
    np.testing.assert_allclose(arm.fk(q), Reference(arm.model, "base", "tool0").pose(q), atol=1e-12)


SRDF = '<robot name="r">\n<disable_collisionss link1="base" link2="fore"/>\n{}</robot>'
FAR_PAIR = '<disable_collisions link1="base" link2="forre"/>\n<disable_collisions link1="base" link2="fore"/>\n'


def test_unknown_elements_and_links_of_an_srdf_are_warnings() -> None:
    """Each with its line and what may be meant; the other pairs count, and strict refuses all in one error."""
    arm = urdf_ik.load(ROBOT, "base", "tool0", srdf=SRDF.format(FAR_PAIR))
    element, link = arm.model.warnings
    assert "<text>:2: <disable_collisionss>" in str(element) and "did you mean 'disable_collisions'" in str(element)
    assert "<text>:3: <disable_collisions>" in str(link) and "forre; did you mean 'fore'" in str(link)
    assert len(arm.cell.disabled) == 1
    with pytest.raises(UrdfError, match=r"disable_collisionss(.|\n)*forre"):
        urdf_ik.load(ROBOT, "base", "tool0", srdf=SRDF.format(FAR_PAIR), strict=True)
    for slip, right in (('<group name="a"><chain base="base" tip_link="fore"/></group>', "base_link"),
                        ('<disable_collisions link1="base" link_2="fore"/>', "link2"),
                        ('<groop name="a"><chain base_link="base" tip_link="fore"/></groop>', "group")):  # fmt: skip
        with pytest.raises(urdf_ik.ChainError, match=f"no chain is called 'a'(.|\n)*did you mean '{right}'"):
            urdf_ik.load(ROBOT, srdf=f'<robot name="r">{slip}</robot>', chain="a")


QUATERNION = [0.1, -0.4, 0.3, 0.8]


@pytest.mark.parametrize("version", ["1.1", "1.2"])
def test_urdf_1_1_and_1_2_are_read_as_pinocchio_reads_them(version: str) -> None:
    """Quaternions of joints, which URDF 1.0 ignores and is therefore refused; both notations are one too many."""
    place = f'<origin quat_xyzw="{" ".join(map(str, QUATERNION))}" '
    text = ROBOT.replace("<origin ", place).replace('<robot name="r">', f'<robot name="r" version="{version}">')
    arm, reference, q = loaded(text), ReferenceModel(text), np.array([0.3, -0.4, 0.5])
    reference.place(dict(zip(arm.joint_names, q, strict=True)))
    np.testing.assert_allclose(arm.fk(q), reference.pose("base", "tool0"), atol=1e-14)
    with pytest.raises(UrdfError, match="ignored in URDF 1.0"):
        loaded(text.replace(f' version="{version}"', ""))
    with pytest.raises(UrdfError, match="both rpy and quat_xyzw"):
        loaded(text.replace(place, place + 'rpy="0 0 0" '))


def test_accelerations_and_jerks_of_urdf_1_2_are_kept_to() -> None:
    """A tracker's cycles and a timed plan stay within them; the least of acceleration and deceleration counts."""
    rates = ' acceleration="2" deceleration="1.5" jerk="4"/>'
    arm = loaded(ROBOT.replace('velocity="1"/>', f'velocity="1"{rates}'))
    tracker = arm.tracker([0.0, 0.0, 0.0], dt=0.01)
    np.testing.assert_array_equal(tracker.acceleration_limits, 1.5)
    plan = arm.follow(np.stack([arm.fk([0.1 * k, 0.05 * k, -0.02 * k]) for k in range(8)]))
    timed = plan.timed(dt=1e-3)
    jerk = np.diff(timed.qdd, axis=0) / 1e-3
    assert np.abs(timed.qd).max() <= 1.0 and np.abs(timed.qdd).max() <= 1.5
    assert 3.0 < np.abs(jerk[:-1]).max() <= 4.0 * (1.0 + 1e-2)  # the jerk is what limits this motion
    np.testing.assert_allclose(np.diff(timed.q, axis=0) / 1e-3, (timed.qd[1:] + timed.qd[:-1]) / 2, atol=1e-3)


@pytest.mark.parametrize("length", ["4.9e-324", "1e-200", "1e200"])
def test_an_axis_that_no_reader_can_normalize_is_refused(length: str) -> None:
    """Pinocchio turns such a joint about no axis, or not at all: its rotation is then no rotation."""
    with pytest.raises(UrdfError, match="an axis of length"):
        loaded(axis(f' xyz="0 0 {length}"')(INSIDE))
    text = axis(f' xyz="0 0 {length}"')(INSIDE)
    model = pinocchio.buildModelFromXML(text)
    data = model.createData()
    pinocchio.forwardKinematics(model, data, np.full(model.nq, 0.5))
    R = data.oMi[model.getJointId("elbow")].rotation
    assert np.abs(R @ R.T - np.eye(3)).max() > 0.1


def test_a_base_on_a_side_branch_has_the_tip_of_the_tree() -> None:
    """The pendant's frame of a UR, half a turn off the root: Pinocchio's pose in it; no other frame is offered."""
    side = '<link name="pendant"/>' + PLACED.format("turned", "base", "pendant").replace(
        "</joint>", "<origin rpy='0 0 3.141592653589793'/></joint>"
    )
    text = ROBOT.replace("</robot>", side + "</robot>")
    arm, q = urdf_ik.load(text, base="pendant"), [0.3, -0.4, 0.5]
    assert (arm.base, arm.tip) == ("pendant", urdf_ik.load(ROBOT).tip)
    np.testing.assert_allclose(arm.fk(q), Reference(arm.model, "pendant", arm.tip).pose(q), atol=1e-12)
    camera = '<link name="camera"/>' + PLACED.format("bracket", "tool0", "camera")
    with pytest.raises(ChainError) as refused:
        urdf_ik.load(text.replace("</robot>", camera + "</robot>"), base="camera")
    assert refused.value.candidates == ()
