"""Reading URDFs: what is refused and how, and that yourdfpy and Pinocchio see the same robot in what is left."""

from __future__ import annotations

import io
import itertools
import time
from pathlib import Path

import numpy as np
import pinocchio
import pytest
import yourdfpy
from hypothesis import given
from hypothesis import strategies as st

from urdf_ik.errors import ChainError, UrdfError, UrdfIkError
from urdf_ik.urdf import UrdfModel, read, resolve_mesh

TINY = """<?xml version="1.0"?>
<robot name="tiny">
  <link name="base"/>
  <link name="arm"/>
  <link name="hand"/>
  <link name="tool"/>
  <joint name="turn" type="revolute">
    <parent link="base"/>
    <child link="arm"/>
    <origin xyz="0 0 1" rpy="0 0 0.5"/>
    <axis xyz="0 0 1"/>
    <limit lower="-1" upper="2" effort="3" velocity="4"/>
  </joint>
  <joint name="slide" type="prismatic">
    <parent link="arm"/>
    <child link="hand"/>
    <axis xyz="0 2 0"/>
    <limit lower="0" upper="1" effort="3" velocity="4"/>
    <mimic joint="turn" multiplier="0.5" offset="0.1"/>
  </joint>
  <joint name="flange" type="fixed">
    <parent link="hand"/>
    <child link="tool"/>
    <origin xyz="0.1 0 0"/>
  </joint>
</robot>
"""


def edited(line: int, old: str, new: str, text: str = TINY) -> str:
    """``text`` with ``old`` replaced by ``new`` in one line, counted from 1."""
    lines = text.split("\n")
    assert old in lines[line - 1]
    lines[line - 1] = lines[line - 1].replace(old, new)
    return "\n".join(lines)


def refused(source: object, **options: object) -> UrdfError:
    """The error that reading ``source`` raises."""
    with pytest.raises(UrdfError) as caught:
        read(source, **options)  # type: ignore[arg-type]
    return caught.value


def arm(*joints: str, extra: str = "") -> str:
    """A URDF from 'name type parent child' lines; its links are those that the joints name."""
    parts = [each.split() for each in joints]
    links = dict.fromkeys(itertools.chain.from_iterable((each[2], each[3]) for each in parts))
    limit = '<limit lower="-1" upper="1" effort="1" velocity="1"/>'
    return (
        '<robot name="r">'
        + "".join(f'<link name="{link}"/>' for link in links)
        + "".join(
            f'<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>{limit}</joint>'
            for name, kind, parent, child in parts
        )
        + extra
        + "</robot>"
    )


def frames_of_pinocchio(xml: str, values: dict[str, float]) -> dict[str, np.ndarray]:
    """Pose of every link in the root, from Pinocchio's own model of the URDF."""
    model = pinocchio.buildModelFromXML(xml)
    q = pinocchio.neutral(model)
    for name, value in values.items():
        joint = model.joints[model.getJointId(name)]
        entries = [value] if joint.nq == 1 else [np.cos(value), np.sin(value)]
        q[joint.idx_q : joint.idx_q + joint.nq] = entries
    data = model.createData()
    pinocchio.framesForwardKinematics(model, data, q)
    return {
        frame.name: data.oMf[index].homogeneous
        for index, frame in enumerate(model.frames)
        if frame.type == pinocchio.BODY
    }


def test_a_sound_urdf_is_read_whole() -> None:
    """Every attribute of every joint arrives as written, with its line; what is not written has its default."""
    model = read(TINY)
    assert (model.name, model.root, model.source, model.path) == ("tiny", "base", "<text>", None)
    assert model.links == ("base", "arm", "hand", "tool")
    turn, slide, flange = model.joints
    assert (turn.name, turn.type, turn.parent, turn.child, turn.line) == ("turn", "revolute", "base", "arm", 7)
    assert (turn.lower, turn.upper, turn.effort, turn.velocity, turn.mimic) == (-1.0, 2.0, 3.0, 4.0, None)
    np.testing.assert_allclose(turn.origin[:3, 3], [0, 0, 1])
    np.testing.assert_allclose(turn.origin[:2, 0], [np.cos(0.5), np.sin(0.5)])
    np.testing.assert_array_equal(slide.axis, [0, 1, 0])
    assert slide.mimic == ("turn", 0.5, 0.1)
    assert (flange.lower, flange.upper, flange.effort, flange.velocity) == (-np.inf, np.inf, None, None)
    assert model.left_out == ()


def test_the_model_cannot_be_changed_by_accident() -> None:
    """Fields are frozen and arrays are read-only, so an arm never differs from the URDF it was read from."""
    model = read(TINY)
    with pytest.raises(AttributeError):
        model.root = "arm"  # type: ignore[misc]
    for joint in model.joints:
        with pytest.raises(ValueError, match="read-only"):
            joint.origin[0, 3] = 1.0
        with pytest.raises(ValueError, match="read-only"):
            joint.axis[0] = 1.0


JOINT = '<joint name="turn">'
LIMIT = '<limit lower="-1" upper="2" effort="3" velocity="4"/>'
BROKEN = {
    # what is wrong: (line, old, new, line reported, element, words of the problem, words of the mend)
    "no robot name": (2, ' name="tiny"', "", 2, "<robot>", "no name", 'name="..."'),
    "unknown version": (2, "<robot", '<robot version="2.0"', 2, "<robot>", "'2.0'", "1.2"),
    "link without name": (4, ' name="arm"', "", 4, "<link>", "no name", 'name="..."'),
    "link with empty name": (4, '"arm"', '""', 4, '<link name="">', "no name", 'name="..."'),
    "joint without name": (7, ' name="turn"', "", 7, "<joint>", "no name", 'name="..."'),
    "duplicated link": (4, '"arm"', '"base"', 4, '<link name="base">', "taken by line 3", "of its own"),
    "duplicated joint": (14, '"slide"', '"turn"', 14, JOINT, "taken by line 7", "of its own"),
    "reserved joint name": (7, '"turn"', '"universe"', 7, '<joint name="universe">', "Pinocchio's own", "another name"),
    "unknown type": (7, "revolute", "ball", 7, JOINT, "'ball'", "revolute, continuous, prismatic, fixed"),
    "type in capitals": (7, "revolute", "Revolute", 7, JOINT, "'Revolute'", "revolute"),
    "no type": (7, ' type="revolute"', "", 7, JOINT, "type is missing", "revolute"),
    "no parent": (8, '<parent link="base"/>', "", 7, JOINT, "<parent> is missing", "<parent link="),
    "no child": (9, '<child link="arm"/>', "", 7, JOINT, "<child> is missing", "<child link="),
    "parent without link": (8, ' link="base"', "", 8, f"<parent> of {JOINT}", "link is missing", "<parent link="),
    "undeclared parent": (8, '"base"', '"bose"', 8, f"<parent> of {JOINT}", "'bose' is not declared", "base"),
    "undeclared child": (9, '"arm"', '"harm"', 9, f"<child> of {JOINT}", "'harm' is not declared", "arm"),
    "two parents": (16, '"hand"', '"arm"', 16, '<child> of <joint name="slide">', "'turn' at line 7", "closed loop"),
    "cycle": (8, '"base"', '"tool"', 7, JOINT, "arm <- tool <- hand <- arm", "tree"),
    "self loop": (8, '"base"', '"arm"', 7, JOINT, "cycle: arm <- arm", "tree"),
    "several roots": (6, "/>", '/><link name="lost"/>', 6, '<link name="lost">', "base, lost", "fixed joints"),
    "NaN in xyz": (10, "0 0 1", "0 nan 1", 10, f"<origin> of {JOINT}", "'nan' is no finite number", "3 numbers"),
    "infinity in rpy": (10, "0 0 0.5", "0 -inf 0", 10, f"<origin> of {JOINT}", "'-inf'", "finite"),
    "overflow in xyz": (10, "0 0 1", "0 0 1e400", 10, f"<origin> of {JOINT}", "'1e400'", "finite"),
    "two values in xyz": (10, '"0 0 1"', '"0 1"', 10, f"<origin> of {JOINT}", "2 values instead of 3", "3 numbers"),
    "four values in rpy": (10, "0 0 0.5", "0 0 0 0.5", 10, f"<origin> of {JOINT}", "4 values", "3 numbers"),
    "empty xyz": (10, '"0 0 1"', '""', 10, f"<origin> of {JOINT}", "0 values instead of 3", "3 numbers"),
    "commas in xyz": (10, "0 0 1", "0,0,1", 10, f"<origin> of {JOINT}", "'0,0,1'", "spaces"),
    "digits only Python reads": (10, "0 0 1", "0 0 1_0", 10, f"<origin> of {JOINT}", "'1_0'", "decimal"),
    "a word in xyz": (10, "0 0 1", "0 0 one", 10, f"<origin> of {JOINT}", "'one'", "decimal"),
    "quaternion origin": (10, "rpy", 'quat_xyzw="0 0 0 1" rpy', 10, f"<origin> of {JOINT}", "quat_xyzw", "rpy"),
    "zero axis": (11, "0 0 1", "0 0 0", 11, f"<axis> of {JOINT}", "zero axis", "0 0 1"),
    "axis of rounding noise": (11, "0 0 1", "1e-17 0 0", 11, f"<axis> of {JOINT}", "zero axis", "direction"),
    "axis without xyz": (11, ' xyz="0 0 1"', "", 11, f"<axis> of {JOINT}", "xyz is missing", "3 numbers"),
    "short axis": (11, "0 0 1", "0 1", 11, f"<axis> of {JOINT}", "2 values instead of 3", "3 numbers"),
    "NaN in axis": (11, "0 0 1", "0 0 NaN", 11, f"<axis> of {JOINT}", "'NaN'", "finite"),
    "lower above upper": (12, '"-1"', '"3"', 12, f"<limit> of {JOINT}", "lower 3 is greater than upper 2", "swap"),
    "NaN limit": (12, '"-1"', '"nan"', 12, f"<limit> of {JOINT}", "'nan'", "finite"),
    "infinite limit": (12, '"2"', '"inf"', 12, f"<limit> of {JOINT}", "'inf'", "finite"),
    "empty limit": (12, '"2"', '""', 12, f"<limit> of {JOINT}", "0 values instead of 1", "a number"),
    "no effort": (12, ' effort="3"', "", 12, f"<limit> of {JOINT}", "effort is missing", "effort="),
    "no velocity": (12, ' velocity="4"', "", 12, f"<limit> of {JOINT}", "velocity is missing", "velocity="),
    "negative velocity": (12, '"4"', '"-4"', 12, f"<limit> of {JOINT}", "negative", "zero or more"),
    "no limit": (12, LIMIT, "", 7, JOINT, "revolute joint without <limit>", "continuous"),
    "mimic of nothing": (
        19, "turn", "trun", 19, '<mimic> of <joint name="slide">', "no such joint", "did you mean turn"
    ),
    "mimic without joint": (19, 'joint="turn"', "", 19, '<mimic> of <joint name="slide">', "missing", "to follow"),
    "mimic of itself": (19, "turn", "slide", 19, '<mimic> of <joint name="slide">', "mimics itself", "by itself"),
    "NaN in mimic": (19, '"0.5"', '"nan"', 19, '<mimic> of <joint name="slide">', "'nan'", "finite"),
    "circle of mimics": (
        12, "/>", '/><mimic joint="slide"/>', 12, f"<mimic> of {JOINT}", "turn -> slide -> turn", "by itself"
    ),
    "xacro in an origin": (10, "0 0 1", "0 0 ${height}", 10, f"<origin> of {JOINT}", "${height}", "run xacro first"),
    "xacro in a name": (4, '"arm"', '"$(arg prefix)arm"', 4, '<link name="$(arg prefix)arm">', "xacro", "run xacro"),
    "xacro in a reference": (8, '"base"', '"${p}base"', 8, f"<parent> of {JOINT}", "xacro", "run xacro first"),
    "xacro include": (3, "<link", "<xacro:include/><link", 3, "<xacro:include>", "xacro", "run xacro first"),
    "xacro in a joint": (11, "<axis", "<xacro:if/><axis", 11, f"<xacro:if> of {JOINT}", "xacro", "run xacro first"),
    "malformed": (9, '"arm"', "arm", 9, None, "malformed XML", "mend the XML"),
    "mismatched tag": (13, "</joint>", "</link>", 13, None, "malformed XML", "mend the XML"),
    "attribute written twice": (4, "<link", '<link name="a"', 4, None, "name redefined", "mend the XML"),
    "undeclared entity": (4, '"arm"', '"&arm;"', 4, None, "'arm' not defined", "mend the XML"),
    "DOCTYPE": (2, "<robot", "<!DOCTYPE robot><robot", 2, "<!DOCTYPE>", "DOCTYPE is refused", "delete"),
    "other root": (2, "<robot", "<sdf/><robot", 2, None, "Extra content", "mend the XML"),
}  # fmt: skip


@pytest.mark.parametrize("case", BROKEN)
def test_what_is_broken_is_refused_with_place_and_mend(case: str) -> None:
    """Each defect is named with its line, its element, its value and a mend, all of them in the message."""
    line, old, new, reported, element, problem, mend = BROKEN[case]
    error = refused(edited(line, old, new))
    assert (error.source, error.line, error.element) == ("<text>", reported, element)
    assert problem in error.problem
    assert error.mend is not None
    assert mend in error.mend
    assert str(error).startswith(f"<text>:{reported}: {element or ''}")
    assert error.problem in str(error)
    assert error.mend in str(error)


def test_the_file_is_named_in_the_error(tmp_path: Path) -> None:
    """A refusal of a file begins with file:line, as compilers write it, whatever its line ends are."""
    path = tmp_path / "broken arm.urdf"
    path.write_bytes(edited(11, "0 0 1", "0 0 0").replace("\n", "\r\n").encode())
    for source in (path, str(path)):
        assert str(refused(source)).startswith(f"{path}:11: <axis> of {JOINT}: ")


def test_truncated_xml_is_refused_wherever_it_ends() -> None:
    """No beginning of a URDF short of its last tag is taken for a smaller robot."""
    end = TINY.index("</robot>") + len("</robot>")
    for length in range(len(TINY.split(">")[0]) + 1, end, 7):
        error = refused(TINY[:length])
        assert error.line is not None
        assert "malformed XML" in error.problem or "empty" in error.problem
    assert "</robot> is missing" in str(refused(TINY[: end - len("</robot>")]))


BILLION_LAUGHS = '<!DOCTYPE r [<!ENTITY a "ha"><!ENTITY b "&a;&a;&a;&a;&a;&a;&a;&a;">' + (
    "".join(f'<!ENTITY b{i} "{("&b" + (str(i - 1) if i else "") + ";") * 9}">' for i in range(12)) + "]>"
)


@pytest.mark.parametrize("encoding", ["utf-8", "utf-16", "utf-8-sig", "utf-7"])
@pytest.mark.parametrize(
    "doctype",
    [
        '<!DOCTYPE robot SYSTEM "http://localhost:1/x.dtd">',
        '<!DOCTYPE robot [<!ENTITY x SYSTEM "file:///etc/passwd">]>',
        BILLION_LAUGHS,
    ],
)
def test_a_doctype_is_refused_before_an_entity_is_expanded(doctype: str, encoding: str) -> None:
    """No entity reaches a file, the network or the memory, in any encoding and behind any comment."""
    text = f'<?xml version="1.0" encoding="{encoding}"?>\n<!-- <robot> -->\n{doctype}<robot name="&b11;"/>'
    begun = time.perf_counter()
    error = refused(text.encode(encoding))
    assert (error.line, error.element) == (3, "<!DOCTYPE>")
    assert time.perf_counter() - begun < 1.0


def test_doctype_in_a_comment_is_harmless() -> None:
    """Only a real DOCTYPE is refused, not the word in a comment."""
    assert read("<!-- <!DOCTYPE robot> -->" + arm("j revolute a b")).root == "a"


@pytest.mark.parametrize("root", ["sdf", "mujoco", "u:robot xmlns:u='x'"])
def test_another_root_element_is_refused(root: str) -> None:
    """A model of another format is told apart from a broken URDF."""
    error = refused(f"\n<{root}/>")
    assert (error.line, error.mend is not None and "URDF is one <robot" in error.mend) == (2, True)


@pytest.mark.parametrize("text", ["", "  \n ", b"", b"\xef\xbb\xbf", "<!-- nothing -->", '<?xml version="1.0"?>'])
def test_an_empty_text_is_refused(text: str | bytes) -> None:
    """Nothing at all is no robot."""
    error = refused(text)
    assert "empty" in str(error) or "malformed" in str(error)


def test_a_robot_without_links_is_refused_and_one_link_is_enough() -> None:
    """The smallest robot is one link."""
    assert "no <link>" in str(refused('<robot name="r"/>'))
    assert read('<robot name="r"><link name="only"/></robot>').root == "only"


def test_a_cycle_off_the_root_is_refused() -> None:
    """A loop of links beside the tree, which Pinocchio drops in silence, is found and spelled out."""
    error = refused(arm("j revolute a b", "k revolute c d", "m revolute d c"))
    assert "cycle" in error.problem
    assert {"c", "d"} <= set(error.problem.replace("<-", " ").split())


def test_the_number_of_links_is_bounded() -> None:
    """500 links in a row are read, one more is refused, before a reader that would hang sees them."""
    chain = [f"j{i} fixed l{i} l{i + 1}" for i in range(500)]
    assert len(read(arm(*chain[:-1])).links) == 500
    error = refused(arm(*chain))
    assert "more than 500 links" in error.problem
    assert error.element == '<link name="l500">'


@pytest.mark.parametrize(
    ("line", "old", "new"),
    [
        (3, "/>", "><visual/><collision/><inertial/></link>"),
        (3, "/>", '><visual><geometry><cone radius="x"/></geometry></visual></link>'),
        (
            3,
            "/>",
            "><visual><geometry><:box/></geometry></visual><collision><geometry><a:b/></geometry></collision></link>",
        ),
        (3, "/>", '><collision><geometry><mesh filename="package://no/such.stl"/></geometry></collision></link>'),
        (3, "/>", '/><transmission><joint name="turn"/></transmission><gazebo reference="base"><a b="${c}"/></gazebo>'),
        (3, "/>", '/><xacro:property name="width" value="${2 * 3}"/>'),
        (3, "/>", "/><sensor:camera><controller:x/></sensor:camera>"),
        (3, "/>", "/><!-- a -- b --><?pi x?>"),
        (3, "/>", "/><material/><material name='m'><color rgba='1'/></material>"),
        (12, "/>", '/><safety_controller/><dynamics damping="x"/><calibration rising=""/>'),
        (24, "/>", '/><axis xyz="0 0 0"/><limit lower="2" upper="1"/><mimic joint="nobody"/>'),
        (2, '"tiny"', '""'),
        (2, "<robot", '<robot version="1.2" xmlns="http://www.ros.org" xmlns:xi="http://x"'),
        (1, '"1.0"', '"0.0"'),
        (1, "<?xml", "\n \n<?xml"),
    ],
)
def test_what_does_not_touch_kinematics_is_forgiven(line: int, old: str, new: str) -> None:
    """A defect beside the joints leaves the robot as it is, and the clean URDF without the defect."""
    model, plain = read(edited(line, old, new)), read(TINY)
    assert (model.links, model.root) == (plain.links, plain.root)
    for joint, expected in zip(model.joints, plain.joints, strict=True):
        np.testing.assert_array_equal(joint.origin, expected.origin)
        np.testing.assert_array_equal(joint.axis, expected.axis)
        assert (joint.lower, joint.upper, joint.mimic) == (expected.lower, expected.upper, expected.mimic)
    values = {"turn": 0.3, "slide": 0.2}
    ours, theirs = (frames_of_pinocchio(each.xml.decode(), values) for each in (model, plain))
    np.testing.assert_allclose([ours[link] for link in plain.links], [theirs[link] for link in plain.links])


def test_shapes_that_no_reader_takes_are_left_out_and_reported() -> None:
    """A broken shape takes no sound one with it, and is reported, because a collision check would miss it."""
    shapes = """>
      <visual><origin xyz="0 x 0"/><geometry><box size="1 1 1"/></geometry></visual>
      <collision><geometry><box size="1,1,1"/></geometry></collision>
      <collision><geometry><sphere radius="-1"/></geometry></collision>
      <collision name="ball"><geometry><sphere radius="1"/></geometry></collision>
      <collision><geometry><capsule radius="1" length="2"/></geometry></collision>
      <inertial><mass value="1"/></inertial></link>"""
    model = read(edited(3, "/>", shapes))
    assert [error.line for error in model.left_out] == [9, 4, 5, 6]
    assert [str(error.element).split()[0] for error in model.left_out] == [
        "<inertial>", "<origin>", "<box>", "<sphere>"
    ]  # fmt: skip
    assert all('<link name="base">' in str(error.element) for error in model.left_out)
    pin_model = pinocchio.buildModelFromXML(model.xml.decode())
    geometry = pinocchio.buildGeomFromUrdfString(pin_model, model.xml.decode(), pinocchio.GeometryType.COLLISION)
    assert [type(each.geometry).__name__ for each in geometry.geometryObjects] == ["Sphere", "Capsule"]
    assert [each.name for each in model.robot.link_map["base"].collisions] == ["ball"]


AWKWARD = """\ufeff<?xml version="1.0" encoding="latin-1"?>
<!-- axis lengths, defaults, -- odd spaces, odd names -->
<robot name="r\u00f6b" xmlns:xacro="http://www.ros.org/wiki/xacro">
  <joint name="wrist/1" type="continuous">
    <child link="/hand"/><parent link="upper arm"/>
    <origin rpy="0.3 -1.2 2.5"/>
    <axis xyz="-0.2 0.5 0.7"/>
    <limit effort="1" velocity="2" lower="5" upper="-5"/>
  </joint>
  <link name="upper arm"><visual><geometry><cone/></geometry></visual></link><link name="/hand"/>
  <link name=" base "/><link name="foot &lt;&amp;&gt;"/><link name="\u624b"/>
  <joint name="turn" type="revolute">
    <parent link=" base "/><child link="upper arm"/>
    <origin xyz="  .1 \t -2e-1
            +3. "/>
    <limit lower=" -1 " upper="1" effort="0" velocity="0"/>
  </joint>
  <joint name="slide" type="prismatic">
    <parent link="/hand"/><child link="foot &lt;&amp;&gt;"/>
    <axis xyz="3e-7 0 -4e-7"/><limit effort="1" velocity="1" upper="2"/>
  </joint>
  <joint name="push" type="prismatic">
    <parent link="/hand"/><child link="\u624b"/>
    <origin xyz="1 2 3" rpy="1.5708 0 3.14159"/>
    <axis xyz="1e200 2e200 0"/><limit effort="1" velocity="1" lower="-2"/>
  </joint>
</robot>
""".replace("\n", "\r\n")


def test_yourdfpy_and_pinocchio_agree_on_the_clean_urdf() -> None:
    """Whatever the file's oddities, both readers place every link of the clean URDF alike, and so do we."""
    model = read(AWKWARD)
    viewed = yourdfpy.URDF.load(io.BytesIO(model.xml), load_meshes=False)
    rng = np.random.default_rng(3)
    for _ in range(5):
        values = {joint.name: float(rng.uniform(-1, 1)) for joint in model.joints}
        viewed.update_cfg(values)
        judged = frames_of_pinocchio(model.xml.decode(), values)
        ours = {model.root: np.eye(4)}
        for joint in itertools.chain.from_iterable(model.path_between(model.root, link) for link in model.links):
            motion = np.eye(4)
            if joint.type == "prismatic":
                motion[:3, 3] = joint.axis * values[joint.name]
            else:
                motion[:3, :3] = pinocchio.AngleAxis(values[joint.name], joint.axis).toRotationMatrix()
            ours[joint.child] = ours[joint.parent] @ joint.origin @ motion
        for link in model.links:
            np.testing.assert_allclose(viewed.get_transform(link, model.root), judged[link], atol=1e-14)
            np.testing.assert_allclose(ours[link], judged[link], atol=1e-14)


def test_limits_have_the_defaults_of_the_standard() -> None:
    """A bound that is not written is zero, as Pinocchio takes it; a continuous joint has none."""
    model = read(AWKWARD)
    limits = {joint.name: (joint.lower, joint.upper) for joint in model.joints}
    assert limits == {"turn": (-1, 1), "slide": (0, 2), "push": (-2, 0), "wrist/1": (-np.inf, np.inf)}
    judge = pinocchio.buildModelFromXML(model.xml.decode())
    for name in ("turn", "slide", "push"):
        at = judge.joints[judge.getJointId(name)].idx_q
        assert (judge.lowerPositionLimit[at], judge.upperPositionLimit[at]) == limits[name]


@pytest.mark.parametrize("scale", [1e-9, 1e-3, 0.999, 7.0, 1e160])
@pytest.mark.parametrize("kind", ["revolute", "prismatic", "continuous"])
def test_axes_of_any_length_are_directions(kind: str, scale: float) -> None:
    """The length an axis is written with changes nothing, for us and for Pinocchio."""
    direction = np.array([2.0, -3.0, 6.0]) / 7
    written = " ".join(repr(float(each)) for each in direction * scale)
    model = read(edited(7, "revolute", kind, edited(11, "0 0 1", written)))
    np.testing.assert_allclose(model.joints[0].axis, direction, atol=1e-15)
    unit = read(edited(7, "revolute", kind, edited(11, "0 0 1", " ".join(map(repr, direction.tolist())))))
    poses = [frames_of_pinocchio(each.xml.decode(), {"turn": 0.7})["arm"] for each in (model, unit)]
    np.testing.assert_allclose(poses[0], poses[1], atol=1e-15)


@pytest.mark.parametrize(
    "make",
    [
        lambda path: path,
        str,
        lambda path: path.read_text(encoding="utf-8"),
        lambda path: path.read_bytes(),
        lambda path: "\n\n  " + path.read_text(encoding="utf-8"),
        lambda path: "\ufeff" + path.read_text(encoding="utf-8"),
        lambda path: b"\xef\xbb\xbf" + path.read_bytes(),
        lambda path: path.read_text(encoding="utf-8").encode("utf-16"),
        lambda path: io.BytesIO(path.read_bytes()),
        lambda path: io.StringIO(path.read_text(encoding="utf-8")),
        lambda path: path.read_text(encoding="utf-8").replace("\n", "\r\n").encode(),
        lambda path: path.read_text(encoding="utf-8").replace('"1.0"', '"1.0" encoding="UTF-8"'),
        lambda path: path.read_text(encoding="utf-8").replace('"1.0"', '"1.0" encoding="utf-16"'),
        lambda path: path.read_text(encoding="utf-8").replace('"1.0"', '"1.0" encoding="cp1252"').encode("cp1252"),
    ],
)
def test_every_kind_of_source_gives_the_same_robot(make: object, tmp_path: Path) -> None:
    """Path, text, bytes and streams, with any byte order mark, encoding and line ends, read alike."""
    path = tmp_path / "r\u00f6bot arm.urdf"
    path.write_text(TINY.replace("tool", "w\u00e9rkzeug"), encoding="utf-8")
    model = read(make(path))  # type: ignore[operator]
    assert model.xml == read(path).xml
    assert model.links[-1] == "w\u00e9rkzeug"


def test_open_files_are_read_and_named(tmp_path: Path) -> None:
    """A text or binary file that is open gives its name to the messages."""
    path = tmp_path / "a.urdf"
    path.write_text(edited(11, "0 0 1", "0 0 0"))
    for mode in ("r", "rb"):
        with path.open(mode) as file:
            assert refused(file).source == str(path)


@pytest.mark.parametrize(
    ("source", "problem"),
    [
        ("no_such_robot.urdf", "neither an existing file nor XML text"),
        (Path("no_such_robot.urdf"), "neither an existing file nor XML text"),
        ("robot: tiny\nlinks: 3\n" * 1000, "cannot read|neither"),
        ("null\0byte.urdf", "cannot read|neither"),
        (b"robot", "is no XML"),
        (b"\xff\xfe", "empty|no XML"),
        (None, "cannot read a URDF from NoneType"),
        (42, "cannot read a URDF from int"),
        ("<robot name='\udc80'/>", "not UTF-8"),
        (b"<robot name='r'>\n<link name='\xe9'/></robot>", "not utf-8 text: byte 0xe9"),
        (b'<?xml version="1.0" encoding="klingon"?><robot/>', "unusable encoding"),
        (b'<?xml version="1.0" encoding="hex"?><robot/>', "unusable encoding"),
        (b"<robot name='r'>\0</robot>", "malformed XML"),
        (io.TextIOWrapper(io.BytesIO(b"<robot name='\xe9'/>"), encoding="utf-8"), "cannot read the open file"),
    ],
)  # fmt: skip
def test_what_cannot_be_read_is_refused_in_words(source: object, problem: str) -> None:
    """A source that is no URDF text ends in an UrdfError with a mend, never in an error of Python's."""
    with pytest.raises(UrdfError, match=problem) as caught:
        read(source)  # type: ignore[arg-type]
    assert caught.value.mend
    assert len(str(caught.value)) < 500


def test_files_that_cannot_be_read_are_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A directory, a closed file, a file of bytes and a file without rights each say what they are."""
    (tmp_path / "inside.urdf").write_text(TINY)
    error = refused(tmp_path)
    assert "directory" in error.problem
    assert "inside.urdf" in str(error.mend)

    with (tmp_path / "inside.urdf").open() as closed:
        pass
    assert "closed file" in refused(closed).problem

    (tmp_path / "bytes.urdf").write_bytes(b"<robot>\n\xff\xff\n")
    assert refused(tmp_path / "bytes.urdf").line == 2

    def deny(_: Path) -> bytes:
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr(Path, "read_bytes", deny)
    assert "Permission denied" in refused(tmp_path / "inside.urdf").problem


def test_a_file_of_unreasonable_size_is_refused_unread(tmp_path: Path) -> None:
    """A file that could not be a URDF is refused by its size alone."""
    path = tmp_path / "huge.urdf"
    with path.open("wb") as file:
        file.truncate(2**40)
    assert "64 MiB" in refused(path).problem


MUTATIONS = st.tuples(
    st.integers(0, len(TINY)),
    st.integers(0, 40),
    st.one_of(
        st.just(""),
        st.text(max_size=3),
        st.sampled_from(["<", ">", '"', "&", "/", "\0", "nan", "1e999", "-", "0", "&#0;", "]]>", "<!--", "base", "${"]),
    ),
)


@given(st.lists(MUTATIONS, min_size=1, max_size=3), st.integers(0, 3))
def test_any_text_is_read_or_refused(mutations: list[tuple[int, int, str]], truncate: int) -> None:
    """A URDF with pieces cut out or put in is read or refused, never a crash; what is read, Pinocchio reads too."""
    text = TINY
    for start, length, put in mutations:
        text = text[:start] + put + text[start + length :]
    text = text[: len(text) // truncate] if truncate else text
    try:
        model = read(text if text.lstrip().startswith("<") else io.StringIO(text))
    except UrdfIkError as error:
        assert len(str(error)) < 1000
        return
    assert isinstance(model, UrdfModel)
    judge = pinocchio.buildModelFromXML(model.xml.decode())
    assert {frame.name for frame in judge.frames if frame.type == pinocchio.BODY} == set(model.links)
    assert all(np.isfinite(joint.origin).all() for joint in model.joints)
    np.testing.assert_allclose([np.linalg.norm(joint.axis) for joint in model.joints], 1.0)


BRANCHED = arm(
    "stand fixed world base_link",
    "j1 revolute base_link link1",
    "j2 continuous link1 link2",
    "flange fixed link2 flange",
    "tool fixed flange tool0",
    "camera fixed link2 camera",
    "lamp fixed base_link lamp",
)


def test_the_only_movable_chain_is_the_default() -> None:
    """From the root to the one leaf that moves; fixed leaves elsewhere do not make it ambiguous."""
    model = read(arm("s fixed world b", "j revolute b c", "k prismatic c d", "t fixed d tool", "l fixed b lamp"))
    assert model.default_chain() == model.resolve_chain() == ("world", "tool")
    assert model.resolve_chain(base="c") == ("c", "tool")
    assert model.resolve_chain(tip="c") == ("world", "c")
    assert model.resolve_chain("tool", "lamp") == ("tool", "lamp")
    assert [joint.name for joint in model.path_between("b", "tool")] == ["j", "k", "t"]
    assert model.path_between("b", "b") == ()


def test_several_leaves_on_the_last_link_are_ambiguous() -> None:
    """Flanges and cameras fixed to the last moving link are candidates, the deepest first."""
    with pytest.raises(ChainError, match=r"fixed to 'link2'.*tool0, camera") as caught:
        read(BRANCHED).default_chain()
    assert caught.value.candidates == ("tool0", "camera")


def test_several_movable_chains_are_ambiguous() -> None:
    """Two arms list their tips; below one of the shoulders the chain is clear."""
    model = read(arm("l revolute torso left", "r revolute torso right", "rh fixed right hand", "h fixed torso head"))
    with pytest.raises(ChainError, match="2 movable chains begin at 'torso'") as caught:
        model.resolve_chain()
    assert caught.value.candidates == ("hand", "left")
    assert model.resolve_chain(tip="left") == ("torso", "left")


def test_without_a_moving_joint_there_is_no_chain() -> None:
    """A rigid body, or a base at the very end, is refused in words."""
    with pytest.raises(ChainError, match="no movable chain"):
        read(arm("j fixed a b", "k floating b c")).default_chain()
    with pytest.raises(ChainError, match="no movable chain.*candidates: world"):
        read(BRANCHED).resolve_chain(base="tool0")


@pytest.mark.parametrize("role", ["base", "tip"])
def test_unknown_names_list_the_candidates(role: str) -> None:
    """A name that is not there brings the links with the closest first."""
    model = read(BRANCHED)
    with pytest.raises(ChainError, match=f"no {role} link 'tol0'; did you mean 'tool0'") as caught:
        model.resolve_chain(**{role: "tol0"})
    assert caught.value.candidates[0] == "tool0"
    assert set(caught.value.candidates) == set(model.links)
    with pytest.raises(ChainError, match="no link 'tol0'"):
        model.children("tol0")
    with pytest.raises(ChainError, match="'lamp' does not lie below 'link1'") as caught:
        model.path_between("link1", "lamp")
    assert set(caught.value.candidates) == {"link2", "flange", "tool0", "camera"}


def test_the_tree_is_walked_both_ways() -> None:
    """Parents and children are those of the file, in its order."""
    model = read(BRANCHED)
    assert model.parent_joint("world") is None
    assert model.parent_joint("tool0") is model.joints[4]
    assert [joint.child for joint in model.children("link2")] == ["flange", "camera"]
    assert model.children("tool0") == ()


@pytest.fixture
def meshes(tmp_path: Path) -> Path:
    """A package with a URDF, meshes in and outside it, and a link that leads out."""
    for name in ("pkg/urdf/near.stl", "pkg/meshes/far.stl", "secret.stl"):
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text("solid")
    (tmp_path / "pkg/urdf/arm.urdf").write_text(TINY)
    (tmp_path / "pkg/meshes/out.stl").symlink_to(tmp_path / "secret.stl")
    (tmp_path / "pkg/meshes/loop.stl").symlink_to(tmp_path / "pkg/meshes/loop.stl")
    return tmp_path


@pytest.mark.parametrize(
    ("filename", "found"),
    [
        ("near.stl", "pkg/urdf/near.stl"),
        ("../meshes/far.stl", "pkg/meshes/far.stl"),
        ("package://pkg/meshes/far.stl", "pkg/meshes/far.stl"),
        ("model://pkg/meshes/far.stl", "pkg/meshes/far.stl"),
        ("package://pkg/urdf/../meshes/far.stl", "pkg/meshes/far.stl"),
        ("{root}/pkg/meshes/far.stl", "pkg/meshes/far.stl"),
        ("file://{root}/pkg/meshes/far.stl", "pkg/meshes/far.stl"),
    ],
)
def test_meshes_are_found_inside_the_roots(filename: str, found: str, meshes: Path) -> None:
    """Relative to the URDF, in a package that is a root, or by an absolute path into a root."""
    model = read(meshes / "pkg/urdf/arm.urdf", mesh_roots=[meshes / "pkg"])
    assert resolve_mesh(model, filename.format(root=meshes)) == meshes / found
    assert model.package_dirs == (str(meshes / "pkg/urdf"), str(meshes / "pkg"))


@pytest.mark.parametrize(
    ("filename", "problem"),
    [
        ("../../secret.stl", "outside the mesh roots"),
        ("package://pkg/../secret.stl", "leads outside"),
        ("package://pkg/meshes/../../secret.stl", "leads outside"),
        ("package:////etc/passwd", "not found"),
        ("{root}/secret.stl", "outside the mesh roots"),
        ("file://{root}/secret.stl", "outside the mesh roots"),
        ("file:///etc/passwd", "outside the mesh roots"),
        ("../meshes/out.stl", "outside the mesh roots"),
        ("../meshes/loop.stl", "cannot look|not found"),
        ("../meshes", "not found"),
        ("absent.stl", "not found; searched .*urdf, .*pkg"),
        ("http://example.org/a.stl", "unknown kind of address"),
        ("$(find pkg)/meshes/far.stl", "xacro"),
        ("a\0b", "cannot look"),
    ],
)
def test_meshes_outside_the_roots_are_refused(filename: str, problem: str, meshes: Path) -> None:
    """Neither dots nor an absolute path nor a symbolic link leads out of the roots."""
    model = read(meshes / "pkg/urdf/arm.urdf", mesh_roots=[meshes / "pkg"])
    with pytest.raises(UrdfError, match=problem) as caught:
        resolve_mesh(model, filename.format(root=meshes))
    assert caught.value.mend
    assert str(caught.value.element).startswith("<mesh filename=")


def test_text_without_roots_has_no_meshes(meshes: Path) -> None:
    """XML text comes from no folder, so meshes need a root; a single one may be given as it is."""
    with pytest.raises(UrdfError, match="mesh_roots"):
        resolve_mesh(read(TINY), str(meshes / "secret.stl"))
    model = read(TINY, mesh_roots=str(meshes))
    assert resolve_mesh(model, "package://pkg/meshes/far.stl") == meshes / "pkg/meshes/far.stl"


def test_reading_is_fast() -> None:
    """An arm takes milliseconds to read: nothing but its kinematics is built."""
    text = arm(*(f"j{i} revolute l{i} l{i + 1}" for i in range(7)))
    read(text)
    best = min(_seconds(text) for _ in range(5))
    assert best < 0.015


def _seconds(text: str) -> float:
    begun = time.perf_counter()
    read(text)
    return time.perf_counter() - begun
