"""Files that are no plain URDF: xacro, MJCF, and ROS packages; each held against Pinocchio or MuJoCo."""

import sys
from pathlib import Path

import numpy as np
import pytest
from chains import ReferenceModel, joint, robot
from lxml import etree

import urdf_ik
from urdf_ik.errors import MissingPackage, UrdfError
from urdf_ik.model.urdf import read, resolve_mesh
from urdf_ik.model.xml import floats, origin_of

XACRO = """<?xml version="1.0"?>
<robot xmlns:xacro="http://www.ros.org/wiki/xacro" name="made">
  <xacro:arg name="length" default="0.3"/>
  <xacro:property name="half" value="${pi / 2}"/>
  <xacro:include filename="$(find arm_parts)/urdf/link.xacro"/>
  <link name="base"/>
  <xacro:part name="1" parent="base" z="$(arg length)" roll="${half}"/>
  <xacro:part name="2" parent="link_1" z="${2 * 0.2}" roll="0.1"/>
</robot>
"""
PART = """<robot xmlns:xacro="http://www.ros.org/wiki/xacro">
  <xacro:macro name="part" params="name parent z roll">
    <link name="link_${name}">
      <visual><geometry><mesh filename="package://arm_parts/meshes/link.stl"/></geometry></visual>
    </link>
    <joint name="joint_${name}" type="revolute">
      <parent link="${parent}"/><child link="link_${name}"/>
      <origin xyz="0 0 ${z}" rpy="${roll} 0 0"/><axis xyz="0 1 0"/>
      <limit lower="-2" upper="2" effort="1" velocity="1"/>
    </joint>
  </xacro:macro>
</robot>
"""


@pytest.fixture
def workspace(tmp_path: Path) -> Path:
    """Two ROS packages: the arm, and the parts that it includes."""
    for name, file, text in (("arm", "arm.urdf.xacro", XACRO), ("arm_parts", "link.xacro", PART)):
        folder = tmp_path / "share" / name
        (folder / "urdf").mkdir(parents=True)
        (folder / "urdf" / file).write_text(text)
        (folder / "package.xml").write_text(f"<package><name>{name}</name></package>")
    (tmp_path / "share/arm_parts/meshes").mkdir()
    (tmp_path / "share/arm_parts/meshes/link.stl").write_text("solid")
    return tmp_path


def test_a_xacro_is_what_it_expands_to(workspace: Path) -> None:
    """Forward kinematics are Pinocchio's of the URDF that stands in the macros, with the default and with another."""
    for given, length in ((None, 0.3), ({"length": 0.75}, 0.75)):
        file = workspace / "share/arm/urdf/arm.urdf.xacro"
        arm = urdf_ik.load(file, mesh_roots=[workspace / "share"], xacro_args=given)
        reference = ReferenceModel(
            robot(
                joint("1", "revolute", "base", "link_1", f"0 0 {length}", f"{np.pi / 2!r} 0 0", "0 1 0"),
                joint("2", "revolute", "link_1", "link_2", "0 0 0.4", "0.1 0 0", "0 1 0"),
            )
        )
        reference.place({"1": 0.4, "2": -0.7})
        np.testing.assert_allclose(arm.fk([0.4, -0.7]), reference.pose("base", "link_2"), atol=1e-15)
        assert arm.limits.tolist() == [[-2.0, 2.0]] * 2


@pytest.mark.parametrize("variable", ["AMENT_PREFIX_PATH", "ROS_PACKAGE_PATH"])
def test_packages_are_found_by_the_environment(variable: str, workspace: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """$(find package) and package:// lead to the folders that ROS 2 or ROS 1 would find."""
    for each in ("AMENT_PREFIX_PATH", "ROS_PACKAGE_PATH"):
        monkeypatch.delenv(each, raising=False)
    file = workspace / "share/arm/urdf/arm.urdf.xacro"
    with pytest.raises(UrdfError, match=r"no ROS package 'arm_parts' \(give the folder.*AMENT_PREFIX_PATH"):
        read(file)
    monkeypatch.setenv(variable, f"{workspace / 'nowhere'}:{workspace}")
    mesh = resolve_mesh(read(file), "package://arm_parts/meshes/link.stl")
    assert mesh == workspace / "share/arm_parts/meshes/link.stl"
    with pytest.raises(UrdfError, match="not found; searched .*ROS_PACKAGE_PATH"):
        resolve_mesh(read(file), "package://arm_pars/meshes/link.stl")
    with pytest.raises(UrdfError, match="leads outside"):
        resolve_mesh(read(file), "package://arm_parts/../../secret.stl")


def test_a_package_is_known_by_its_manifest(workspace: Path) -> None:
    """A URDF in a package finds the package's meshes, whatever its folder is called."""
    package = (workspace / "share/arm_parts").rename(workspace / "checkout-2")
    (package / "urdf/tiny.urdf").write_text('<robot name="tiny"><link name="base"/></robot>')
    model = read(package / "urdf/tiny.urdf")
    for name in ("package://arm_parts/meshes/link.stl", "../meshes/link.stl"):
        assert resolve_mesh(model, name) == package / "meshes/link.stl"


@pytest.mark.parametrize(
    ("text", "given", "words"),
    [
        ('<xacro:arg name="a" default="1"/>', {"b": 2}, r"it has no argument 'b'.*its arguments: a"),
        ("<link name='$(arg tool)'/>", None, "xacro cannot expand it.*tool.*--xacro-arg NAME:=VALUE"),
        ("<link name='${nothing}'/>", None, "xacro cannot expand it.*nothing"),
        ("<link name='a'", None, "xacro cannot expand it"),
    ],
)
def test_a_broken_xacro_says_what_is_missing(
    text: str, given: dict[str, object] | None, words: str, tmp_path: Path
) -> None:
    """Unknown arguments, arguments without a value, unknown names and malformed XML are told apart."""
    file = tmp_path / "broken.xacro"
    file.write_text(f'<robot name="x" xmlns:xacro="http://www.ros.org/wiki/xacro">{text}<link name="b"/></robot>')
    with pytest.raises(UrdfError, match=words):
        read(file, xacro_args=given)


def test_a_xacro_under_another_name_says_how_it_is_expanded(tmp_path: Path) -> None:
    """A .urdf that holds xacro is not run by itself: the message says how, and that works."""
    file = tmp_path / "arm.urdf"
    file.write_text(XACRO.replace("$(find arm_parts)/urdf/", ""))
    (tmp_path / "link.xacro").write_text(PART)
    with pytest.raises(UrdfError, match=r"end the file's name in \.xacro, or give xacro_args \(--xacro-arg"):
        read(file, strict=True)
    assert len(read(file, xacro_args={}).joints) == 2


def test_missing_packages_say_how_to_install_them(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Without xacro or mujoco their files name the extra that brings them."""
    for name in ("mujoco", "xacro"):
        monkeypatch.setitem(sys.modules, name, None)
    (tmp_path / "arm.xacro").write_text(XACRO)
    with pytest.raises(MissingPackage, match=r"pip install 'xacro>="):
        read(tmp_path / "arm.xacro")
    (tmp_path / "arm.xml").write_text("<mujoco/>")
    with pytest.raises(MissingPackage, match=r"pip install 'mujoco>="):
        read(tmp_path / "arm.xml")


MJCF = """<mujoco model="m">
  <compiler angle="degree" meshdir="assets"/>
  <asset>
    <mesh name="there" file="there.obj" scale="1 1 2"/><mesh file="gone.stl"/>
    <texture name="t" type="2d" file="gone.png"/><material name="skin" texture="t"/>
  </asset>
  <worldbody>
    <geom type="plane" size="1 1 1"/>
    <body name="b1" pos="0 0 1" euler="0 90 30">
      <joint name="j1" axis="0 1 1" range="-90 90" pos="0.1 0.3 0" ref="20"/>
      <geom type="mesh" mesh="gone" material="skin"/>
      <geom type="capsule" size="0.1" fromto="0 0 0 0.2 0 1"/>
      <body name="b2" pos="0 0 1" quat="0.3 0.4 0.5 0.6">
        <joint name="slide" type="slide" axis="1 0 0" range="-1 1" ref="0.2"/>
        <joint name="j3" pos="0.1 0 0.1"/>
        <geom type="mesh" mesh="there" pos="0.1 0 0" euler="10 20 30"/>
        <body pos="0.1 0.2 0.3">
          <joint name="j4" axis="0 0 1"/>
          <geom size="0.1"/>
          <site name="end" pos="0.1 0 0" euler="20 30 40"/>
        </body>
      </body>
    </body>
  </worldbody>
  <equality><joint joint1="j3" joint2="j1" polycoef="0.1 2 0 0 0"/></equality>
</mujoco>
"""
OBJ = "v 0 0 0\nv 1 0 0\nv 0 2 0\nv 0 0 3\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n"


@pytest.fixture
def mjcf(tmp_path: Path) -> Path:
    """A model with a reference angle, anchors, two joints in a body, an equality and a mesh that is not there."""
    (tmp_path / "assets").mkdir()
    (tmp_path / "assets/there.obj").write_text(OBJ)
    (tmp_path / "m.xml").write_text(MJCF)
    return tmp_path / "m.xml"


def test_a_mujoco_model_moves_as_in_mujoco(mjcf: Path) -> None:
    """The site's pose is that of mj_kinematics at the same joint values, the equality kept; limits are the ranges."""
    mujoco = pytest.importorskip("mujoco")
    arm = urdf_ik.load(mjcf, tip="end")
    assert (arm.base, arm.joint_names) == ("world", ("j1", "slide", "j4"))
    np.testing.assert_allclose(arm.limits[:2], [[-np.pi / 2, np.pi / 2], [-1.0, 1.0]])
    text = MJCF.replace('<mesh file="gone.stl"/>', "").replace('file="gone.png"', 'builtin="flat" width="9" height="9"')
    text = text.replace('<geom type="mesh" mesh="gone" material="skin"/>', "")
    (mjcf.parent / "whole.xml").write_text(text)
    model = mujoco.MjModel.from_xml_path(str(mjcf.parent / "whole.xml"))
    data = mujoco.MjData(model)
    at = {name: int(model.joint(name).qposadr[0]) for name in ("j1", "slide", "j3", "j4")}
    for q in np.random.default_rng(0).uniform(-1.0, 1.0, (50, 3)):
        data.qpos[[at["j1"], at["slide"], at["j4"]]] = q
        data.qpos[at["j3"]] = 0.1 + 2.0 * (q[0] - np.deg2rad(20.0))
        mujoco.mj_kinematics(model, data)
        expected = np.eye(4)
        expected[:3, 3], expected[:3, :3] = data.site("end").xpos, data.site("end").xmat.reshape(3, 3)
        np.testing.assert_allclose(arm.fk(q), expected, atol=1e-14)


def test_shapes_of_a_mujoco_model_lie_where_they_do_there(mjcf: Path) -> None:
    """A mesh's vertices are in the body where MuJoCo has them; what a URDF cannot hold or is not there is reported."""
    mujoco = pytest.importorskip("mujoco")
    model = read(mjcf)
    body = etree.fromstring(model.xml).find("link[@name='b2']/collision")
    origin, scale = origin_of(body), floats(body.find("geometry/mesh"), "scale")
    vertices = np.array([[0.0, 0, 0], [1, 0, 0], [0, 2, 0], [0, 0, 3]]) * scale
    ours = vertices @ origin[:3, :3].T + origin[:3, 3]
    text = MJCF.replace('<mesh file="gone.stl"/>', "").replace('file="gone.png"', 'builtin="flat" width="9" height="9"')
    (mjcf.parent / "whole.xml").write_text(text.replace('<geom type="mesh" mesh="gone" material="skin"/>', ""))
    theirs = mujoco.MjModel.from_xml_path(str(mjcf.parent / "whole.xml"))
    geom = next(k for k in range(theirs.ngeom) if theirs.geom_type[k] == mujoco.mjtGeom.mjGEOM_MESH)
    R = np.zeros(9)
    mujoco.mju_quat2Mat(R, theirs.geom_quat[geom])
    there = theirs.mesh_vert @ R.reshape(3, 3).T + theirs.geom_pos[geom]
    near = np.linalg.norm(ours[:, None] - there[None], axis=-1).min(axis=1)
    assert near.max() < 1e-6  # MuJoCo keeps vertices in single precision
    assert resolve_mesh(model, body.find("geometry/mesh").get("filename")) == mjcf.parent / "assets/there.obj"
    assert [each.error.problem for each in model.warnings] == [
        "mesh 'gone': its file is not there",
        "a URDF has no shape for a plane",
    ]


def test_mujoco_models_are_read_from_files_only(mjcf: Path) -> None:
    """Text may not send MuJoCo's own parser to other files; a broken model brings MuJoCo's words along."""
    pytest.importorskip("mujoco")
    with pytest.raises(UrdfError, match="a MuJoCo model as text .save it"):
        read(MJCF)
    mjcf.write_text("<mujoco><worldbody><bodi/></worldbody></mujoco>")
    with pytest.raises(UrdfError, match="MuJoCo refuses the model: .*bodi"):
        read(mjcf)
