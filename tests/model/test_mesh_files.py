"""What a mesh's file may be: no way out of its folders, no endless pipe, no numbers that are none, no growth."""

from __future__ import annotations

import base64
import json
import os
import struct
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import urdf_ik
from urdf_ik import ArgumentError, Mesh, UrdfError, World
from urdf_ik.model import link_shapes, meshes

ARM = """<robot name="m"><link name="a"><collision><geometry><box size="1 1 1"/></geometry></collision></link>
<link name="b"/><link name="c"><visual><geometry><mesh filename="{mesh}"/></geometry></visual>
<collision><geometry><mesh filename="{mesh}"/></geometry></collision></link>
<joint name="i" type="continuous"><parent link="a"/><child link="b"/><axis xyz="0 0 1"/></joint>
<joint name="j" type="continuous"><parent link="b"/><child link="c"/><origin xyz="1 0 0"/><axis xyz="0 0 1"/></joint>
</robot>"""
CORNERS = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], dtype=np.float32)
FACES = np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]], dtype=np.uint32)
OBJ = "".join(f"v {x} {y} {z}\n" for x, y, z in CORNERS) + "".join(f"f {a + 1} {b + 1} {c + 1}\n" for a, b, c in FACES)


def stl(corners: Any = CORNERS) -> bytes:
    """Four triangles as binary STL."""
    body = b"".join(struct.pack("<12fH", 0, 0, 0, *np.asarray(corners, np.float32)[f].ravel(), 0) for f in FACES)
    return bytes(80) + struct.pack("<I", len(FACES)) + body


def gltf(uri: str | None = None, nodes: Any = None) -> str:
    """The same as glTF, its numbers inside or at ``uri``."""
    data = FACES.tobytes() + CORNERS.tobytes()
    inside = "data:application/octet-stream;base64," + base64.b64encode(data).decode()
    return json.dumps({
        "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}],
        "nodes": nodes or [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 1}, "indices": 0}]}],
        "buffers": [{"uri": uri or inside, "byteLength": len(data)}],
        "bufferViews": [{"buffer": 0, "byteOffset": 0, "byteLength": FACES.nbytes},
                        {"buffer": 0, "byteOffset": FACES.nbytes, "byteLength": CORNERS.nbytes}],
        "accessors": [{"bufferView": 0, "componentType": 5125, "count": FACES.size, "type": "SCALAR"},
                      {"bufferView": 1, "componentType": 5126, "count": len(CORNERS), "type": "VEC3",
                       "min": [0, 0, 0], "max": [1, 1, 1]}],
    })  # fmt: skip


def dae(nodes: str, library: str = "") -> str:
    """The same as COLLADA."""
    numbers = " ".join(f"{x:g}" for x in CORNERS.ravel())
    corners = " ".join(str(k) for k in FACES.ravel())
    return f"""<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1"><asset><unit meter="1"/>
<up_axis>Z_UP</up_axis></asset><library_geometries><geometry id="g"><mesh><source id="p"><float_array id="f" count="12">
{numbers}</float_array><technique_common><accessor source="#f" count="4" stride="3"><param name="X" type="float"/>
<param name="Y" type="float"/><param name="Z" type="float"/></accessor></technique_common></source><vertices id="v">
<input semantic="POSITION" source="#p"/></vertices><triangles count="4"><input semantic="VERTEX" source="#v"
offset="0"/><p>{corners}</p></triangles></mesh></geometry></library_geometries>{library}<library_visual_scenes>
<visual_scene id="s">{nodes}</visual_scene></library_visual_scenes><scene><instance_visual_scene url="#s"/></scene>
</COLLADA>"""


PLACED = '<node id="n"><instance_geometry url="#g"/></node>'


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A robot's folder beside a file that is none of its business."""
    (tmp_path / "robot").mkdir()
    (tmp_path / "secret.bin").write_bytes(FACES.tobytes() + CORNERS.tobytes())
    (tmp_path / "secret.mtl").write_text("newmtl secret\n")
    return tmp_path / "robot"


def refused(folder: Path, name: str, content: str | bytes, words: str) -> None:
    """The mesh is refused by an arm's collision model, as an obstacle, and for a picture."""
    data = content.encode() if isinstance(content, str) else content
    (folder / name).write_bytes(data)
    (folder / "arm.urdf").write_text(ARM.format(mesh=name))
    arm = urdf_ik.load(folder / "arm.urdf")
    with pytest.raises(UrdfError, match=words):
        arm.cell.collisions.in_collision([0.0, 0.0])
    world = World()
    world.add("m", Mesh(str(folder / name)))
    with pytest.raises(ArgumentError, match=words):
        urdf_ik.load("planar_2r").clearance([0.0, 0.0], world)
    shapes = link_shapes.read(arm.model)
    assert any(__import__("re").search(words, line) for line in shapes.missing), shapes.missing


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf, 3e38])
def test_numbers_that_are_none_are_refused(folder: Path, value: float) -> None:
    """One vertex that is not finite, and all of them: a pair with such a mesh would touch always, or never."""
    for count in (1, 4):
        corners = CORNERS.copy()
        corners[:count, 1] = value
        refused(folder, "a.stl", stl(corners), r"vertex 0 is|cannot read|no triangles|cannot be read")
