"""URDF texts to read, to break and to compare with Pinocchio's reading."""

import itertools

import numpy as np
import pinocchio
import pytest

from urdf_ik.errors import UrdfError
from urdf_ik.model.urdf import read

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
    """The error that reading ``source`` raises, where every defect is one."""
    with pytest.raises(UrdfError) as caught:
        read(source, strict=True, **options)  # type: ignore[arg-type]
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
