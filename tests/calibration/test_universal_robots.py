"""Universal Robots' kinematics files, against Pinocchio's model of the URDF that their description package writes."""

import io

import numpy as np
import pytest

import urdf_ik
from urdf_ik.calibration import read_ur_kinematics, with_ur_kinematics
from urdf_ik.calibration.universal_robots import JOINTS, NUMBERS
from urdf_ik.cell.pinocchio_reference import Reference
from urdf_ik.errors import ArgumentError, UrdfError

# The nominal UR30 of the manufacturer's description package (config/ur30/default_kinematics.yaml).
NOMINAL = """kinematics:
  shoulder: {x: 0, y: 0, z: 0.23630000000000001, roll: -0, pitch: 0, yaw: -0}
  upper_arm: {x: 0, y: 0, z: 0, roll: 1.570796327, pitch: 0, yaw: -0}
  forearm: {x: -0.637, y: 0, z: 0, roll: -0, pitch: 0, yaw: -0}
  wrist_1: {x: -0.5037, y: 0, z: 0.20100000000000001, roll: -0, pitch: 0, yaw: -0}
  wrist_2: {x: 0, y: -0.1593, z: 0, roll: 1.570796327, pitch: 0, yaw: -0}
  wrist_3:
    x: 0
    y: 0.15429999999999999
    z: -3.1647459019915597e-11
    roll: 1.5707963265897931
    pitch: 3.1415926535897931
    yaw: 3.1415926535897931
  hash: calib_4890363623803256388
"""
LINKS = ("base_link_inertia", "shoulder_link", "upper_arm_link", "forearm_link", "wrist_1_link", "wrist_2_link",
         "wrist_3_link")  # fmt: skip


def urdf(text: str, prefix: str = "") -> str:
    """The arm's joints as the description package writes them: each origin from the file, each axis z."""
    origins = read_ur_kinematics(io.BytesIO(text.encode()))
    parts = [f'<link name="{prefix}{name}"/>' for name in ("base_link", *LINKS)]
    parts.append(
        f'<joint name="{prefix}base_link-base_link_inertia" type="fixed"><parent link="{prefix}base_link"/>'
        f'<child link="{prefix}base_link_inertia"/><origin xyz="0 0 0" rpy="0 0 3.141592653589793"/></joint>'
    )
    for k, (link, joint) in enumerate(JOINTS.items()):
        x, y, z, roll, pitch, yaw = origins[link]
        parts.append(
            f'<joint name="{prefix}{joint}" type="revolute"><!-- {link} --><parent link="{prefix}{LINKS[k]}"/>'
            f'<child link="{prefix}{LINKS[k + 1]}"/><origin xyz="{x} {y} {z}" rpy="{roll} {pitch} {yaw}"/>'
            '<axis xyz="0 0 1"/><limit lower="-6" upper="6" effort="1" velocity="1"/></joint>'
        )
    return f'<robot name="ur">{"".join(parts)}</robot>'


def calibrated() -> str:
    """A robot's own calibration: every number of the nominal one a little off."""
    rng = np.random.default_rng(0)
    lines = ["kinematics:"]
    for link, origin in read_ur_kinematics(io.BytesIO(NOMINAL.encode())).items():
        numbers = map(float, np.array(origin) + rng.normal(scale=1e-3, size=6))
        lines.append(
            f"  {link}: {{{', '.join(f'{name}: {value}' for name, value in zip(NUMBERS, numbers, strict=True))}}}"
        )
    return "\n".join([*lines, "  hash: calib_7", ""])


@pytest.mark.parametrize("prefix", ["", "left_"])
def test_the_urdf_is_that_of_the_description_package(prefix: str) -> None:
    """A nominal URDF with a calibration has Pinocchio's poses of the package's URDF made from it, to 1e-12."""
    text = calibrated()
    arm = urdf_ik.load(urdf(NOMINAL, prefix), tip=f"{prefix}wrist_3_link")
    ours = with_ur_kinematics(arm, read_ur_kinematics(io.BytesIO(text.encode()))).decode()
    q = np.random.default_rng(1).uniform(-3.0, 3.0, (50, 6))
    ends = (f"{prefix}base_link", f"{prefix}wrist_3_link")
    theirs = Reference(urdf(text, prefix), *ends).pose(q)
    assert np.abs(Reference(ours, *ends).pose(q) - theirs).max() <= 1e-12
    assert np.abs(urdf_ik.load(ours, *ends).fk(q) - theirs).max() <= 1e-12
    assert np.abs(arm.fk(q) - theirs).max() > 1e-4


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("forearm", "elbow", "no forearm"),
        ("x: -0.637", "x: wide", "forearm: x is 'wide'"),
        ("x: -0.637", "x: -637", "is it in mm"),
        ("kinematics:", "geometry:", "no 'kinematics'"),
        ("{x: 0, y: 0, z: 0, roll", "{x: 0, y: 0, z: 0 roll", "no YAML|upper_arm"),
    ],
)
def test_a_damaged_file_is_refused_in_words(old: str, new: str, words: str) -> None:
    """A link, a number, a unit or the YAML itself is wrong: the error names it."""
    with pytest.raises(ArgumentError, match=words):
        read_ur_kinematics(io.BytesIO(NOMINAL.replace(old, new).encode()))


def test_another_arm_is_refused_in_words() -> None:
    """An arm without these joints, one whose frames are others, and another model."""
    kinematics = read_ur_kinematics(io.BytesIO(NOMINAL.encode()))
    with pytest.raises(UrdfError, match="shoulder_pan_joint"):
        with_ur_kinematics(urdf_ik.load("puma_560"), kinematics)
    with pytest.raises(UrdfError, match="turn about z"):  # frames of the packages of before 2019
        with_ur_kinematics(urdf_ik.load("ur5"), kinematics)
    other = urdf_ik.load(urdf(NOMINAL.replace("-0.637", "-0.425")), tip="wrist_3_link")
    with pytest.raises(UrdfError, match="212 mm"):
        with_ur_kinematics(other, kinematics)
