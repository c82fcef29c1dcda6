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


@pytest.mark.parametrize(
    ("name", "content"),
    [("a.stl", stl()), ("a.STL", stl()), ("a.obj", OBJ), ("b.obj", "mtllib own.mtl\n" + OBJ), ("a.gltf", gltf()),
     ("a.dae", dae(PLACED))],
)  # fmt: skip
def test_sound_meshes_are_read(folder: Path, name: str, content: str | bytes) -> None:
    """A tetrahedron in each of the usual formats: the same distances, the same volume to be drawn."""
    (folder / "own.mtl").write_text("newmtl own\n")
    (folder / name).write_bytes(content if isinstance(content, bytes) else content.encode())
    (folder / "arm.urdf").write_text(ARM.format(mesh=name))
    arm = urdf_ik.load(folder / "arm.urdf")
    assert arm.clearance([0.0, 0.0]) == pytest.approx(0.5, abs=1e-6)
    (body,) = [shape for shape in link_shapes.read(arm.model).bodies if shape.link == "c"]
    assert body.mesh.volume == pytest.approx(1 / 6, rel=1e-5)


@pytest.mark.parametrize("name", ["../secret.bin", "{root}/secret.bin", "..%2Fsecret.bin", "link.bin"])
def test_a_gltf_opens_no_file_outside(folder: Path, name: str) -> None:
    """Neither up, nor absolute, nor percent-encoded, nor through a symbolic link."""
    (folder / "link.bin").symlink_to(folder.parent / "secret.bin")
    refused(folder, "a.gltf", gltf(name.format(root=folder.parent)), "leads outside the mesh roots")


@pytest.mark.parametrize("name", ["../secret.mtl", "{root}/secret.mtl", "link.mtl", "\\\n../secret.mtl"])
def test_an_obj_opens_no_file_outside(folder: Path, name: str) -> None:
    """Its materials come from its own folders."""
    (folder / "link.mtl").symlink_to(folder.parent / "secret.mtl")
    refused(folder, "a.obj", f"mtllib {name.format(root=folder.parent)}\n{OBJ}", "leads outside the mesh roots")


def test_a_pipe_is_not_waited_for(folder: Path) -> None:
    """A FIFO that a mesh names, or that is one, answers never."""
    os.mkfifo(folder / "pipe.mtl")
    refused(folder, "a.obj", f"mtllib pipe.mtl\n{OBJ}", "no regular file")
    os.mkfifo(folder / "pipe.stl")
    (folder / "arm.urdf").write_text(ARM.format(mesh="pipe.stl"))
    with pytest.raises(UrdfError, match="not found"):
        urdf_ik.load(folder / "arm.urdf").cell.collisions.in_collision([0.0, 0.0])
    with pytest.raises(ArgumentError, match="no file"):
        Mesh(folder / "pipe.stl").file()


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf, 3e38])
def test_numbers_that_are_none_are_refused(folder: Path, value: float) -> None:
    """One vertex that is not finite, and all of them: a pair with such a mesh would touch always, or never."""
    for count in (1, 4):
        corners = CORNERS.copy()
        corners[:count, 1] = value
        refused(folder, "a.stl", stl(corners), r"vertex 0 is|cannot read|no triangles|cannot be read")


def test_a_mesh_that_grows_is_refused(folder: Path) -> None:
    """Nodes that place others twice, thirty deep; nodes that hold themselves."""
    doubling = "".join(
        f'<node id="n{k}"><instance_node url="#n{k + 1}"/><instance_node url="#n{k + 1}"/></node>' for k in range(30)
    )
    library = f'<library_nodes>{doubling}<node id="n30"><instance_geometry url="#g"/></node></library_nodes>'
    refused(folder, "a.dae", dae('<node id="top"><instance_node url="#n0"/></node>', library), "come to more than")
    around = '<library_nodes><node id="x"><instance_node url="#x"/></node></library_nodes>'
    refused(folder, "b.dae", dae('<node id="top"><instance_node url="#x"/></node>', around), "hold themselves")
    nodes = [{"children": [k + 1, k + 1]} for k in range(30)] + [{"mesh": 0}]
    refused(folder, "c.gltf", gltf(nodes=nodes), "come to more than")
    refused(folder, "d.gltf", gltf(nodes=[{"children": [0]}]), "hold themselves")


def test_what_is_too_large_or_unknown_is_refused(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """By its size before it is read; by its kind, since others open further files."""
    refused(folder, "a.irr", "<irr_scene/>", "of the kind '.irr' are not read")
    refused(folder, "a.dae", '<!DOCTYPE x [<!ENTITY a "b">]>' + dae(PLACED), "DOCTYPE")
    refused(folder, "a.gltf", "{", "no valid glTF")
    refused(folder, "b.gltf", '{"meshes": [{"primitives": [{}]}]}', "no valid glTF")
    refused(folder, "a.glb", b"glTF" + bytes(30), "no valid glTF")
    monkeypatch.setattr(meshes, "MAX_BYTES", 2**10)
    refused(folder, "a.stl", stl() + bytes(2**10), "larger than")
