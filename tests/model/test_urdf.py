"""Reading URDFs: yourdfpy and Pinocchio see the same robot, and oddities are forgiven."""

import io
import itertools

import numpy as np
import pinocchio
import pytest
import yourdfpy
from urdf_texts import TINY, edited, frames_of_pinocchio

from urdf_ik.model.urdf import read


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
    assert model.warnings == ()


@pytest.mark.parametrize(
    ("line", "old", "new"),
    [
        (3, "/>", "><visual/><collision/><inertial/></link>"),
        (3, "/>", '><visual><geometry><cone radius="x"/></geometry></visual></link>'),
        (3, "/>", '><collision><geometry><mesh filename="package://no/such.stl"/></geometry></collision></link>'),
        (3, "/>", '/><transmission><joint name="turn"/></transmission><gazebo reference="base"><a b="${c}"/></gazebo>'),
        (3, "/>", '/><xacro:property name="width" value="${2 * 3}"/>'),
        (3, "/>", "/><material/><material name='m'><color rgba='1'/></material>"),
        (12, "/>", '/><safety_controller/><dynamics damping="x"/><calibration rising=""/>'),
        (24, "/>", '/><axis xyz="0 0 0"/><limit lower="2" upper="1"/><mimic joint="nobody"/>'),
        (2, '"tiny"', '""'),
        (2, "<robot", '<robot version="1.2" xmlns="http://www.ros.org" xmlns:xi="http://x"'),
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
    assert [each.error.line for each in model.warnings] == [9, 4, 5, 6]
    assert [each.element.split()[0] for each in model.warnings] == [
        "<inertial>", "<origin>", "<box>", "<sphere>"
    ]  # fmt: skip
    assert all('<link name="base">' in each.element for each in model.warnings)
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
    <axis xyz="1e100 2e100 0"/><limit effort="1" velocity="1" lower="-2"/>
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
        measured = frames_of_pinocchio(model.xml.decode(), values)
        ours = {model.root: np.eye(4)}
        for joint in itertools.chain.from_iterable(model.path_between(model.root, link) for link in model.links):
            motion = np.eye(4)
            if joint.type == "prismatic":
                motion[:3, 3] = joint.axis * values[joint.name]
            else:
                motion[:3, :3] = pinocchio.AngleAxis(values[joint.name], joint.axis).toRotationMatrix()
            ours[joint.child] = ours[joint.parent] @ joint.origin @ motion
        for link in model.links:
            np.testing.assert_allclose(viewed.get_transform(link, model.root), measured[link], atol=1e-14)
            np.testing.assert_allclose(ours[link], measured[link], atol=1e-14)


def test_limits_have_the_defaults_of_the_standard() -> None:
    """A bound that is not written is zero, as Pinocchio takes it; a continuous joint has none."""
    model = read(AWKWARD)
    limits = {joint.name: (joint.lower, joint.upper) for joint in model.joints}
    assert limits == {"turn": (-1, 1), "slide": (0, 2), "push": (-2, 0), "wrist/1": (-np.inf, np.inf)}
    reference = pinocchio.buildModelFromXML(model.xml.decode())
    for name in ("turn", "slide", "push"):
        at = reference.joints[reference.getJointId(name)].idx_q
        assert (reference.lowerPositionLimit[at], reference.upperPositionLimit[at]) == limits[name]


@pytest.mark.parametrize(("kind", "scale"), [("revolute", 1e-9), ("prismatic", 7.0), ("continuous", 1e140)])
def test_axes_of_any_length_are_directions(kind: str, scale: float) -> None:
    """The length an axis is written with changes nothing, for us and for Pinocchio."""
    direction = np.array([2.0, -3.0, 6.0]) / 7
    written = " ".join(repr(float(each)) for each in direction * scale)
    model = read(edited(7, "revolute", kind, edited(11, "0 0 1", written)))
    np.testing.assert_allclose(model.joints[0].axis, direction, atol=1e-15)
    unit = read(edited(7, "revolute", kind, edited(11, "0 0 1", " ".join(map(repr, direction.tolist())))))
    poses = [frames_of_pinocchio(each.xml.decode(), {"turn": 0.7})["arm"] for each in (model, unit)]
    np.testing.assert_allclose(poses[0], poses[1], atol=1e-15)
