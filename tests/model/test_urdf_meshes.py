"""Meshes of a URDF are found inside the mesh roots and nowhere else."""

from pathlib import Path

import pytest
from urdf_texts import TINY

from urdf_ik.errors import UrdfError
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
