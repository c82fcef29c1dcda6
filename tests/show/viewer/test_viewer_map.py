"""The viewer with a workspace map: its points and their colours, the boundary, what is refused; without a browser."""

from __future__ import annotations

import io
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from command import call, succeed

import urdf_ik
from urdf_ik import Arm
from urdf_ik.errors import ArgumentError
from urdf_ik.maps import workspaces
from urdf_ik.show.viewer.map_view import MOST_POINTS, Voxels
from urdf_ik.support import palette

pytest.importorskip("viser", reason="pip install viser")

from urdf_ik.show.viewer import Viewer  # noqa: E402


@pytest.fixture(scope="module")
def arm() -> Arm:
    """The arm of the map."""
    return urdf_ik.load("zyyzyz_6r")


@pytest.fixture(scope="module")
def found(arm: Arm) -> workspaces.WorkspaceMap:
    """A coarse map with manipulability."""
    return workspaces.workspace(arm, voxel=0.5, orientations=6, manipulability=True)


class Choice:
    """What a widget passes on when the reader of the page has changed it."""

    client_id = 1
    client = None


def choose(widget: Any, value: object) -> None:
    """Set a widget as the reader of the page does."""
    widget.value = value
    for call_back in widget._impl.update_cb:
        call_back(Choice())


def test_the_points_are_the_voxels_that_are_reached(arm: Arm, found: workspaces.WorkspaceMap) -> None:
    """Each stands at the centre of a voxel that has a solution, and its colour is that of the voxel's own value."""
    voxels = Voxels(found, arm)
    assert voxels.holds == ("reach", "solutions", "manipulability")
    for what in voxels.holds:
        for axis in "xyz":
            cut = found.slice(axis, 0.3, what)
            layer = voxels.layer(axis, 0.3, what)
            assert (layer.reached, layer.voxels, layer.at) == (np.isfinite(cut.values).sum(), cut.values.size, cut.at)
            places, inside = found.grid.places(layer.points)
            assert inside.all() and len(places) == layer.reached
            values = found.values(what)[tuple(places.T)] / np.nanmax(found.values(what))
            assert np.abs(layer.colours.astype(int) - palette.shades(values)).max() <= 1


def test_the_colours_of_values_get_lighter_for_everyone() -> None:
    """From zero to one the luminance grows, also for those who lack one of the three kinds of cones.

    The matrices are those of Machado, Oliveira and Fernandes, "A Physiologically-based Model for Simulation of Color
    Vision Deficiency", 2009, for the whole loss of one kind.
    """
    shades = palette.shades(np.linspace(0.0, 1.0, 65)) / 255.0
    linear = np.where(shades <= 0.04045, shades / 12.92, ((shades + 0.055) / 1.055) ** 2.4)
    sights = [
        np.eye(3),
        np.array([[0.152286, 1.052583, -0.204868], [0.114503, 0.786281, 0.099216], [-0.003882, -0.048116, 1.051998]]),
        np.array([[0.367322, 0.860646, -0.227968], [0.280085, 0.672501, 0.047413], [-0.011820, 0.042940, 0.968881]]),
        np.array([[1.255528, -0.076749, -0.178779], [-0.078411, 0.930809, 0.147602], [0.004733, 0.691367, 0.303900]]),
    ]
    for sight in sights:
        luminance = np.clip(linear @ sight.T, 0.0, 1.0) @ [0.2126, 0.7152, 0.0722]
        assert (np.diff(luminance) > 0.0).all() and luminance[-1] > 0.6 > 0.05 > luminance[0]


def test_a_planar_map_stands_in_the_arms_plane() -> None:
    """Points that are reached stand where the tip can be in the base, whatever plane the arm moves in."""
    upright = urdf_ik.load("""<robot name="upright"><link name="a"/><link name="b"/><link name="c"/><link name="d"/>
        <joint name="one" type="continuous"><parent link="a"/><child link="b"/><origin xyz="0.1 0.4 0.3"/>
        <axis xyz="0 1 0"/></joint>
        <joint name="two" type="continuous"><parent link="b"/><child link="c"/><origin xyz="1 0 0"/>
        <axis xyz="0 1 0"/></joint>
        <joint name="end" type="fixed"><parent link="c"/><child link="d"/><origin xyz="0.5 0.2 0"/></joint></robot>""")
    voxels = Voxels(workspaces.workspace(upright, voxel=0.2), upright)
    assert voxels.across == "z"
    layer = voxels.layer("z", 0.0, "reach")
    assert layer.reached > 50
    tips = upright.fk(np.random.default_rng(0).uniform(-np.pi, np.pi, (200, 2)))[:, :3, 3]
    assert np.abs(layer.points[:, 1] - tips[0, 1]).max() < 1e-12
    distance = np.linalg.norm(layer.points[:, None] - [[0.1, tips[0, 1], 0.3]], axis=2)
    assert (distance > 1.0 - np.hypot(0.5, 0.2) - 1e-9).any() and distance.max() < 1.0 + np.hypot(0.5, 0.2)
    mesh = voxels.boundary()
    assert np.abs(np.abs(mesh.vertices[:, 1] - tips[0, 1]) - 0.1).max() < 1e-12


def test_a_layer_of_many_voxels_is_thinned_and_says_so(arm: Arm) -> None:
    """A page draws some 100 000 points; of more, one row and column in two is shown."""
    side = int(np.sqrt(2 * MOST_POINTS))
    box = [[-0.5, -0.5, 0.9], [0.5, 0.5, 0.9 + 1.0 / side]]
    many = workspaces.workspace(arm, 1.0 / side, 1, bounds=box, within_limits=False)
    counts = np.ones_like(many.solutions)
    full = workspaces.WorkspaceMap(many.about, many.grid, many.samples, counts, many.branch_poses)
    voxels = Voxels(full, arm)
    layer = voxels.layer("z", 0.9, "reach")
    assert layer.every == 2 and layer.reached == full.grid.count > 1.9 * MOST_POINTS
    assert len(layer.points) <= MOST_POINTS
    with Viewer(arm, port=0, workspace=full) as viewer:
        assert "One row in 2 is shown" in viewer.map.status.content


def test_the_widgets_choose_what_is_shown(arm: Arm, found: workspaces.WorkspaceMap) -> None:
    """Slider, axis, value and check box each change the scene; another arm takes the map away."""
    with Viewer(arm, port=0, workspace=found) as viewer:
        view = viewer.map
        before = view.points.points
        choose(view.slider, 1.6)
        assert viewer.settle(60.0) and view.layer.at == pytest.approx(found.slice("z", 1.6).at)
        assert before.shape != view.points.points.shape or not np.allclose(before, view.points.points)
        choose(view.axis, "x")
        assert viewer.settle(60.0)
        assert np.abs(view.points.points[:, 0] - view.layer.at).max() < 1e-6
        assert view.slider.min == pytest.approx(found.grid.coordinates(0)[0], abs=1e-3)
        colours = view.points.colors
        choose(view.what, "manipulability")
        assert viewer.settle(60.0) and not np.array_equal(colours, view.points.colors)
        assert view.status.content.startswith(workspaces.VALUES["manipulability"])
        assert view.boundary is None
        choose(view.outline, True)
        assert viewer.settle(60.0) and view.boundary.visible
        assert len(view.boundary.faces) == len(workspaces.boundary(found).faces)
        choose(view.outline, False)
        assert viewer.settle(60.0) and not view.boundary.visible
        viewer.open("planar_2r")
        assert viewer.settle(60.0) and viewer.map is None


def test_a_map_of_another_arm_is_refused(arm: Arm, found: workspaces.WorkspaceMap) -> None:
    """Another URDF, another tip, a value that the map does not hold, an axis that is none."""
    with pytest.raises(ArgumentError, match="another URDF of 'zyyzyz_6r'"):
        Voxels(found, urdf_ik.load(io.BytesIO(arm.model.xml.replace(b'lower="-3', b'lower="-2', 1))))
    with pytest.raises(ArgumentError, match="from base_link to tool0, and the arm is one from base_link to"):
        Voxels(found, urdf_ik.load("zyyzyz_6r", tip="link_6"))
    with Viewer(arm, port=0) as viewer:
        with pytest.raises(ArgumentError, match="the map holds no 'clearance'; it holds reach, solutions"):
            viewer.show_workspace(found, "clearance")
        with pytest.raises(ArgumentError, match="one of 'x', 'y', 'z' is needed"):
            viewer.show_workspace(found, axis="w")


def test_the_command_writes_a_page_with_a_map(arm: Arm, found: workspaces.WorkspaceMap, tmp_path: Path) -> None:
    """From a file and from a store; a store that is not complete is refused, and a layer without a map."""
    pytest.importorskip("zarr")
    found.save(tmp_path / "map.npz")
    plain = tmp_path / "plain.html"
    succeed("view", "zyyzyz_6r", "-o", str(plain))
    stored = workspaces.stored_workspace(arm, tmp_path / "map.zarr", voxel=0.5, orientations=2, block=60)
    for name in ("map.npz", "map.zarr"):
        page = tmp_path / f"{name}.html"
        succeed("view", "zyyzyz_6r", "--map", str(tmp_path / name), "--axis", "x", "--at", "0.3", "-o", str(page))
        assert page.stat().st_size > plain.stat().st_size
    assert "give --map, too" in call("view", "zyyzyz_6r", "--axis", "x", "-o", str(plain)).stderr
    journal = stored.path / ".urdf-ik" / "journal"
    journal.write_bytes(b"".join(journal.read_bytes().splitlines(keepends=True)[:-1]))
    refused = call("view", "zyyzyz_6r", "--map", str(stored.path), "-o", str(plain))
    assert refused.exit_code == 2 and "is not complete" in refused.stderr
