"""A URDF's text with other numbers: only they change."""

from pathlib import Path

import pytest
from lxml import etree

from urdf_ik.errors import UrdfError
from urdf_ik.model.urdf.edits import with_numbers

TEXT = """<?xml version='1.0' encoding="iso8859-1"?>
<robot name="r"> <!-- <joint name="a"><origin xyz="9 9 9"/></joint> é -->
  <transmission name="s"><joint name="a"><origin xyz="4 4 4"/></joint></transmission>
  <link name="l"><visual><origin xyz="1 1 1"/></visual></link>
  <joint type="fixed" name='a' ><parent link="l"/><origin
     rpy = '0 0 1'
     xyz="0 0 1" /><child link="m>"/></joint>
  <joint name="b" type="fixed"><child link="n"/></joint>
  <joint name="c"/>
  <transmission name="t"><joint name="a"><origin xyz="5 5 5"/></joint></transmission>
</robot>"""


def test_only_the_numbers_change() -> None:
    """Comments, other origins and other joints of the same name stay; missing elements are added."""
    out = with_numbers(
        TEXT,
        {
            "a": {"origin": {"xyz": [0.0, 0.25, 1.0]}},
            "b": {"origin": {"xyz": [1.0, 2.0, 3.0]}, "axis": {"xyz": [0.0, 1.0, 0.0]}},
            "c": {"mimic": {"offset": [0.5]}},
        },
    ).decode()
    expected = (
        TEXT.replace('xyz="0 0 1"', 'xyz="0.0 0.25 1.0"')
        .replace('encoding="iso8859-1"', 'encoding="utf-8"')
        .replace('type="fixed"><child', 'type="fixed"><axis xyz="0.0 1.0 0.0"/><origin xyz="1.0 2.0 3.0"/><child')
        .replace('<joint name="c"/>', '<joint name="c"><mimic offset="0.5"/></joint>')
    )
    both = [etree.tostring(etree.fromstring(text.encode()), method="c14n") for text in (out, expected)]
    assert both[0] == both[1]


def test_joints_must_be_there(tmp_path: Path) -> None:
    """Bytes in the declared encoding are read; a joint that is missing is named."""
    path = tmp_path / "r.urdf"
    path.write_bytes(TEXT.encode("iso8859-1"))
    assert b'xyz="1.0 1.0 1.0"' in with_numbers(path, {"a": {"origin": {"xyz": [1, 1, 1]}}})
    with pytest.raises(UrdfError, match="'d'"):
        with_numbers(path, {"d": {"origin": {"xyz": [1, 1, 1]}}})
