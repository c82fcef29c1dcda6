"""Meshes of a URDF: found inside the mesh roots and nowhere else; refused where a vertex is not finite."""

import re
import struct
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from chains import collision, joint, robot
from urdf_texts import TINY

import urdf_ik
from urdf_ik import ArgumentError, Mesh, UrdfError, World
from urdf_ik.model import link_shapes
from urdf_ik.model.urdf import read, resolve_mesh


@pytest.fixture
def meshes(tmp_path: Path) -> Path:
    """A package with a URDF, meshes in and outside it, and a link that leads out."""
    for name in ("pkg/urdf/near.stl", "pkg/meshes/far.stl", "secret.stl"):
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text("solid")
    (tmp_path / "pkg/urdf/arm.urdf").write_text(TINY)
    (tmp_path / "pkg/meshes/out.stl").symlink_to(tmp_path / "secret.stl")
    return tmp_path


@pytest.mark.parametrize(
    ("filename", "found"),
    [
        ("near.stl", "pkg/urdf/near.stl"),
        ("../meshes/far.stl", "pkg/meshes/far.stl"),
        ("package://pkg/meshes/far.stl", "pkg/meshes/far.stl"),
        ("model://pkg/meshes/far.stl", "pkg/meshes/far.stl"),
        ("package://pkg/urdf/../meshes/far.stl", "pkg/meshes/far.stl"),
        ("{root}/pkg/meshes/far.stl", "pkg/meshes/far.stl"),
        ("file://{root}/pkg/meshes/far.stl", "pkg/meshes/far.stl"),
    ],
)
def test_meshes_are_found_inside_the_roots(filename: str, found: str, meshes: Path) -> None:
    """Relative to the URDF, in a package that is a root, or by an absolute path into a root."""
    model = read(meshes / "pkg/urdf/arm.urdf", mesh_roots=[meshes / "pkg"])
    assert resolve_mesh(model, filename.format(root=meshes)) == meshes / found
    assert model.package_dirs == (str(meshes / "pkg/urdf"), str(meshes / "pkg"))


@pytest.mark.parametrize(
    ("filename", "problem"),
    [
        ("../../secret.stl", "outside the mesh roots"),
        ("package://pkg/../secret.stl", "leads outside"),
        ("file://{root}/secret.stl", "outside the mesh roots"),
        ("../meshes/out.stl", "outside the mesh roots"),
        ("absent.stl", "not found; searched .*urdf, .*pkg"),
        ("http://example.org/a.stl", "unknown kind of address"),
        ("$(find pkg)/meshes/far.stl", "xacro"),
    ],
)
def test_meshes_outside_the_roots_are_refused(filename: str, problem: str, meshes: Path) -> None:
    """Neither dots nor an absolute path nor a symbolic link leads out of the roots."""
    model = read(meshes / "pkg/urdf/arm.urdf", mesh_roots=[meshes / "pkg"])
    with pytest.raises(UrdfError, match=problem) as caught:
        resolve_mesh(model, filename.format(root=meshes))
    assert caught.value.hint
    assert str(caught.value.element).startswith("<mesh filename=")


ARM = robot(
    joint("i", "continuous", "a", "b", axis="0 0 1"),
    joint("j", "continuous", "b", "c", "1 0 0", axis="0 0 1"),
    a=collision('box size="1 1 1"'),
    c=collision('mesh filename="{mesh}"') + '<visual><geometry><mesh filename="{mesh}"/></geometry></visual>',
)
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
