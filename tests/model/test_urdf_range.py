"""Numbers of a URDF that are out of range: refused with the element, or read without overflow."""

import numpy as np
import pytest
from lxml import etree

import urdf_ik
from urdf_ik import ArgumentError, UrdfError

ARM = """<robot name="r"><link name="a"/><link name="b"/><link name="c"/><link name="d"/>
<joint name="i" type="revolute"><parent link="a"/><child link="b"/><axis xyz="{axis}"/>
<limit lower="{lower}" upper="{upper}" effort="1" velocity="{velocity}"/></joint>
<joint name="j" type="continuous"><parent link="b"/><child link="c"/><origin xyz="{xyz}" rpy="{rpy}"/>
<axis xyz="0 0 1"/>
</joint><joint name="k" type="fixed"><parent link="c"/><child link="d"/><origin xyz="0.5 0 0"/></joint></robot>"""
SANE = {"axis": "0 0 1", "lower": "-1", "upper": "1", "xyz": "1 0 0", "rpy": "0 0 0", "velocity": "1"}


def text(**changed: str) -> str:
    """The arm with other numbers."""
    return ARM.format(**{**SANE, **changed})


@pytest.mark.parametrize("value", ["1e16", "-1.7e308"])
@pytest.mark.parametrize("where", ["xyz", "rpy"])
def test_lengths_and_angles_that_are_too_large_are_refused(value: str, where: str) -> None:
    """At each place of a joint's origin, with the joint named."""
    for place in range(3):
        numbers = ["0", "0", "0"]
        numbers[place] = value
        with pytest.raises(UrdfError, match="beyond 1e") as refused:
            urdf_ik.load(text(**{where: " ".join(numbers)}))
        assert refused.value.element == '<origin> of <joint name="j">' and refused.value.line == 4


@pytest.mark.parametrize("shape", ['box size="1e160 1 1"', 'mesh filename="a.stl" scale="1 1 1e200"'])
def test_shapes_that_are_too_large_are_left_out_by_name(shape: str) -> None:
    """They have no part in the arm's motion; who asks what it touches is told which shape is missing, and why."""
    body = '<link name="{}"><collision><geometry><{}/></geometry></collision></link>'
    xml = text().replace('<link name="a"/>', body.format("a", 'box size="1 1 1"'))
    arm = urdf_ik.load(xml.replace('<link name="d"/>', body.format("d", shape)))
    with pytest.raises(UrdfError, match=r"is beyond 1e\+15") as refused:
        arm.clearance([0.0, 0.0])
    assert refused.value.element == f'<{shape.split()[0]}> of <collision> of <link name="d">'


def test_limits_that_stand_for_none_leave_the_redundancy_parameter_where_postures_are() -> None:
    """Of a first joint up to 1e15 rad the middle would be 5e14, an angle without a digit: solutions missed by 15 mm."""
    arm = urdf_ik.load("panda")
    model = etree.fromstring(arm.model.xml)
    name = arm.redundancy.joint  # type: ignore[union-attr]
    (limit,) = model.xpath(f"joint[@name='{name}']/limit")
    limit.set("upper", "1e15")
    wide = urdf_ik.load(etree.tostring(model).decode(), arm.base, arm.tip)
    assert wide.redundancy is not None and wide.redundancy.default == 0.0
    T = wide.fk([0.3, 0.2, -0.4, -1.9, 0.5, 1.6, 0.0])
    reached = wide.fk(wide.ik(T).to_array())
    assert len(reached) and np.abs(reached - T).max() < 1e-9
    with pytest.raises(ArgumentError, match="up to 1e"):
        wide.ik(T, redundancy=5e14)
