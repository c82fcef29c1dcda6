"""Meshes with vertices that are not finite are refused."""

import re
import struct
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import urdf_ik
from urdf_ik import ArgumentError, Mesh, UrdfError, World
from urdf_ik.model import link_shapes

ARM = """<robot name="m"><link name="a"><collision><geometry><box size="1 1 1"/></geometry></collision></link>
<link name="b"/><link name="c"><visual><geometry><mesh filename="{mesh}"/></geometry></visual>
<collision><geometry><mesh filename="{mesh}"/></geometry></collision></link>
<joint name="i" type="continuous"><parent link="a"/><child link="b"/><axis xyz="0 0 1"/></joint>
<joint name="j" type="continuous"><parent link="b"/><child link="c"/><origin xyz="1 0 0"/><axis xyz="0 0 1"/></joint>
</robot>"""
CORNERS = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], dtype=np.float32)
FACES = np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]], dtype=np.uint32)


def stl(corners: Any = CORNERS) -> bytes:
    """Four triangles as binary STL."""
    body = b"".join(struct.pack("<12fH", 0, 0, 0, *np.asarray(corners, np.float32)[f].ravel(), 0) for f in FACES)
    return bytes(80) + struct.pack("<I", len(FACES)) + body


def refused(tmp_path: Path, name: str, content: str | bytes, words: str) -> None:
    """The mesh is refused by an arm's collision model, as an obstacle, and for a picture."""
    data = content.encode() if isinstance(content, str) else content
    (tmp_path / name).write_bytes(data)
    (tmp_path / "arm.urdf").write_text(ARM.format(mesh=name))
    arm = urdf_ik.load(tmp_path / "arm.urdf")
    with pytest.raises(UrdfError, match=words):
        arm.cell.collisions.in_collision([0.0, 0.0])
    world = World()
    world.add("m", Mesh(str(tmp_path / name)))
    with pytest.raises(ArgumentError, match=words):
        urdf_ik.load("planar_2r").clearance([0.0, 0.0], world)
    _, missing = link_shapes.read(arm.model)
    assert any(re.search(words, line) for line in missing), missing


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf, 3e38])
def test_numbers_that_are_none_are_refused(tmp_path: Path, value: float) -> None:
    """One vertex that is not finite, and all of them: a pair with such a mesh would touch always, or never."""
    for count in (1, 4):
        corners = CORNERS.copy()
        corners[:count, 1] = value
        refused(tmp_path, "a.stl", stl(corners), r"vertex 0 is|cannot read|no triangles|cannot be read")
