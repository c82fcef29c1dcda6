"""URDF texts to read, to break and to compare with Pinocchio's reading."""

import numpy as np
import pinocchio
import pytest
from chains import ReferenceModel, joint, robot

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


def arm(*joints: str) -> str:
    """A URDF from 'name type parent child' lines; its links are those that the joints name."""
    return robot(*(joint(*each.split()) for each in joints))


def frames_of_pinocchio(xml: str, values: dict[str, float]) -> dict[str, np.ndarray]:
    """Pose of every link in the root, from Pinocchio's own model of the URDF, in which no joint follows another."""
    reference = ReferenceModel(xml, mimic=False)
    reference.place(values)
    return {
        frame.name: reference.data.oMf[index].homogeneous
        for index, frame in enumerate(reference.model.frames)
        if frame.type == pinocchio.BODY
    }
