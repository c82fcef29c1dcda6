"""Maps in stores: the same numbers as maps in memory, read by others, block by block, and what is refused."""

from __future__ import annotations

import json
import pickle
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from command import call, succeed
from scipy.spatial.transform import Rotation

import urdf_ik
from urdf_ik.maps import workspaces
from urdf_ik.maps.engine.store_folder import finished
from urdf_ik.maps.workspaces.cells import MANY, cells
from urdf_ik.maps.workspaces.store import block_jobs

xarray = pytest.importorskip("xarray")
ASKED: dict[str, Any] = {"voxel": 0.7, "orientations": 11, "manipulability": True, "margin": True}


@pytest.fixture(scope="module")
def arm() -> urdf_ik.Arm:
    """A six-joint arm."""
    return urdf_ik.load("zyyzyz_6r")


@pytest.fixture(scope="module")
def stored(arm: urdf_ik.Arm, tmp_path_factory: pytest.TempPathFactory) -> workspaces.StoredMap:
    """A map of it in blocks, those at the end smaller."""
    found = urdf_ik.maps.workspace(arm, **ASKED, store=tmp_path_factory.mktemp("maps") / "map.zarr", block=90)
    assert isinstance(found, workspaces.StoredMap)
    return found


@pytest.fixture(scope="module")
def whole(arm: urdf_ik.Arm) -> workspaces.WorkspaceMap:
    """The same in memory."""
    return workspaces.workspace(arm, **ASKED)


def same(one: workspaces.WorkspaceMap, other: workspaces.WorkspaceMap) -> None:
    """Two maps hold the same."""
    assert one.about == other.about and one.grid.shape == other.grid.shape
    np.testing.assert_allclose(one.grid.lower, other.grid.lower, atol=1e-12)
    for name in ("samples", "solutions", "branch_poses", "within", "free", "manipulability", "margin", "clearance"):
        np.testing.assert_array_equal(getattr(one, name), getattr(other, name))


def test_a_store_holds_what_memory_would(stored: workspaces.StoredMap, whole: workspaces.WorkspaceMap) -> None:
    """Every array, bit by bit; sums, layers and values without reading it whole; more than one block."""
    assert stored.complete and stored.blocks.count > 20
    same(stored.read(), whole)
    assert stored.totals() == whole.totals()
    for axis, at, what in (("z", 0.3, "reach"), ("x", -1.0, "margin"), ("y", 0.0, "manipulability")):
        layer, expected = stored.slice(axis, at, what), whole.slice(axis, at, what)
        np.testing.assert_array_equal(layer.values, expected.values)
        assert (layer.axes, layer.across, layer.what) == (expected.axes, expected.across, expected.what)
        np.testing.assert_allclose([*layer.extent, layer.at], [*expected.extent, expected.at], atol=1e-12)
    np.testing.assert_array_equal(stored.values("solutions"), whole.values("solutions"))
    assert workspaces.opened(stored.path).grid.shape == whole.grid.shape


def test_plain_xarray_reads_it(stored: workspaces.StoredMap, whole: workspaces.WorkspaceMap) -> None:
    """Dimensions, coordinates in metres, attributes; no other call, and no warning."""
    found = xarray.open_zarr(stored.path)
    assert found.solutions.dims == ("x", "y", "z", "orientation") and found.solutions.dtype == np.uint8
    assert found.branch_poses.dims == ("x", "y", "z", "branch")
    np.testing.assert_array_equal(found.within.values, whole.within)
    np.testing.assert_array_equal(found.margin.values, whole.margin)
    np.testing.assert_allclose(found.x.values, whole.grid.coordinates(0), rtol=0, atol=0)
    assert found.x.attrs["units"] == "m" and found.attrs["complete"] is True
    assert found.attrs["urdf_sha256"] == whole.about.urdf_sha256 and found.attrs["base"] == whole.about.base
    assert found.sel(x=0.0, y=0.0, z=1.0, method="nearest").solutions.sizes == {"orientation": 11}
    np.testing.assert_array_equal(found.samples.values, whole.samples)


def test_a_flipped_bit_is_seen_by_every_reader_and_made_again(arm: urdf_ik.Arm, tmp_path: Path) -> None:
    """Zarr's own checksum refuses the chunk; the same call makes it again, and only it."""
    path = tmp_path / "map.zarr"
    made = workspaces.workspace(arm, 0.9, 5, store=path, block=300)
    file = max((path / "solutions" / "c").rglob("0"), key=lambda each: each.is_file() and each.stat().st_size)
    good = file.read_bytes()
    file.write_bytes(good[:20] + bytes([good[20] ^ 1]) + good[21:])
    with pytest.raises(ValueError, match="checksum"):
        xarray.open_zarr(path).solutions.load()
    with pytest.raises(urdf_ik.JobError, match="solutions is damaged"):
        made.totals()
    ticks: list[int] = []
    workspaces.workspace(arm, 0.9, 5, store=path, block=300, progress=lambda done, total: ticks.append(done))
    assert len(ticks) == 2 and file.read_bytes() == good


def test_what_is_not_made_yet_is_refused(arm: urdf_ik.Arm, tmp_path: Path) -> None:
    """A run that was interrupted leaves a map that says so; the blocks that are there can be read."""
    path = tmp_path / "map.zarr"

    def stop(done: int, total: int) -> None:
        if done > total // 2:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt, match="chunks are kept"):
        workspaces.workspace(arm, 0.7, 11, store=path, block=90, progress=stop)
    found = workspaces.StoredMap(path)
    assert not found.complete and "not complete" in repr(found)
    assert xarray.open_zarr(path).attrs["complete"] is False
    first = found.grid.coordinates(0)[0]
    assert found.read([[first - 0.1, -9, -9], [first + 0.1, 9, 9]]).grid.shape[0] == 1
    with pytest.raises(urdf_ik.JobError, match=r"not complete: \d+ of the \d+ blocks"):
        found.totals()
    again = workspaces.workspace(arm, 0.7, 11, store=path, block=90)
    assert again.complete and len(finished(path)) == again.blocks.count


def test_targets_are_looked_up_in_their_cells(
    arm: urdf_ik.Arm, stored: workspaces.StoredMap, whole: workspaces.WorkspaceMap
) -> None:
    """At the centres the numbers themselves; anywhere else those of the nearest turn, found one by one."""
    rng = np.random.default_rng(2)
    T = arm.fk(rng.uniform(-3.0, 3.0, (300, 6)))
    found = whole.look_up(T)
    np.testing.assert_array_equal(stored.look_up(T), found)
    np.testing.assert_array_equal(stored.look_up(T, "margin"), whole.look_up(T, "margin"))
    for k in range(0, 300, 10):
        place = np.floor((T[k, :3, 3] - whole.grid.lower) / whole.grid.voxel).astype(int)
        turned = [np.trace(sample.T @ T[k, :3, :3]) for sample in whole.samples]
        assert found[k] == whole.counts[(*place, int(np.argmax(turned)))]
    far = np.eye(4)
    far[0, 3] = 50.0
    assert stored.look_up([far]).tolist() == [0] and np.isnan(whole.look_up([far], "margin")).all()
    with pytest.raises(urdf_ik.ArgumentError, match=r"takes poses \(m, 4, 4\)"):
        stored.look_up([[0.0, 0.0, 0.0]])


@pytest.mark.parametrize("count", [MANY // 2, MANY + 1])
def test_the_nearest_orientation_is_the_least_turn_away(arm: urdf_ik.Arm, count: int) -> None:
    """Few orientations are compared with each pose, many are found by a tree: by SciPy's angles it is the same one."""
    rng = np.random.default_rng(3)
    T, samples = arm.fk(rng.uniform(-3.0, 3.0, (2000, 6))), Rotation.random(count, rng)
    grid = workspaces.Grid(np.full(3, -9.0), 1.0, (18, 18, 18))
    found = cells(grid, samples.as_matrix(), "pose", T)
    for k in range(0, 2000, 50):
        turns = (samples.inv() * Rotation.from_matrix(T[k, :3, :3])).magnitude()
        assert turns[found.samples[k]] == pytest.approx(turns.min(), abs=1e-9)
    T[7, 0, 0] += 0.1
    with pytest.raises(urdf_ik.PoseError, match="no rotation") as error:
        cells(grid, samples.as_matrix(), "pose", T)
    assert error.value.index == (7,)


def test_obstacles_count_and_travel_with_the_question(arm: urdf_ik.Arm, tmp_path: Path) -> None:
    """Free counts and clearances by the arm's own answers, after pickling; another world is another question."""
    world = urdf_ik.World()
    world.add("wall", urdf_ik.Box((0.1, 3.0, 3.0)), urdf_ik.pose([1.4, 0.0, 0.0]))
    options: dict[str, Any] = {"voxel": 1.1, "orientations": 2, "collision_free": True, "clearance": True}
    changed = urdf_ik.load("zyyzyz_6r")
    changed = changed.with_cell(changed.cell.allow(*changed.cell.collisions.checked_pairs[0]))
    found = workspaces.workspace(changed, **options, world=world)
    for place in np.argwhere(found.solutions > 0)[::7]:
        target = np.eye(4)
        target[:3, :3] = found.samples[place[3]]
        target[:3, 3] = [found.grid.coordinates(axis)[place[axis]] for axis in range(3)]
        left = changed.ik(target).within_limits().collision_free(world)
        q = left.q[left.valid]
        assert found.free[tuple(place)] == len(q)
        if len(q):
            assert found.clearance[tuple(place)] == pytest.approx(changed.clearance(q, world).max(), rel=1e-6)
    asked = block_jobs.Question(changed, found.grid, found.samples, ("solutions", "within", "free"), world, None, 1, 99)
    assert pickle.loads(pickle.dumps(asked)).pairs == asked.pairs != arm.cell.collisions.checked_pairs
    path = tmp_path / "map.zarr"
    workspaces.workspace(changed, **options, world=world, store=path)
    world.move("wall", urdf_ik.pose([1.3, 0.0, 0.0]))
    with pytest.raises(urdf_ik.JobError, match="world is "):
        workspaces.workspace(changed, **options, world=world, store=path)
    with pytest.raises(urdf_ik.JobError, match="pairs_sha256 is "):
        workspaces.workspace(arm, **options, world=world, store=path)


def test_what_a_store_cannot_be_is_said(arm: urdf_ik.Arm, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Another grid or arm, too full a disk, a store of something else, options that do not go together."""
    path = tmp_path / "map.zarr"
    workspaces.workspace(arm, 0.9, 5, store=path)
    with pytest.raises(urdf_ik.JobError, match=r"grid\.voxel is 0\.9 in the store and 0\.8 now"):
        workspaces.workspace(arm, 0.8, 5, store=path)
    with pytest.raises(urdf_ik.JobError, match=r"urdf_sha256 is "):
        workspaces.workspace(urdf_ik.load("dh_6r"), 0.9, 5, bounds=[[0, 0, 0], [1, 1, 1]], store=path)
    with pytest.raises(urdf_ik.ArgumentError, match="leave one of the two out"):
        workspaces.workspace(arm, store=path, output="map.npz")  # type: ignore[call-overload]
    with pytest.raises(urdf_ik.ArgumentError, match="a world is given"):
        workspaces.workspace(arm, world=urdf_ik.World())
    monkeypatch.setattr(workspaces.grid.free_space, "free_disk", lambda _: 2**20)
    with pytest.raises(urdf_ik.JobError, match=r"poses take up to .* on the disk.*1 MiB free"):
        workspaces.workspace(arm, 0.1, store=tmp_path / "large.zarr")
    assert not (tmp_path / "large.zarr").exists()
    with pytest.raises(urdf_ik.JobError, match="no store of this package"):
        workspaces.StoredMap(tmp_path)


def test_the_command_makes_a_store_and_goes_on_with_it(tmp_path: Path) -> None:
    """The same sums as a map in a file; a picture of a layer; options that do not go together."""
    path, file = tmp_path / "map.zarr", tmp_path / "map.npz"
    asked = ("workspace", "zyyzyz_6r", "--voxel", "0.9", "--orientations", "5")
    text = succeed(*asked, "--store", str(path))
    assert text == succeed(*asked, "--store", str(path))
    assert text.splitlines()[:-1] == succeed(*asked, "-o", str(file)).replace(str(file), str(path)).splitlines()[:-1]
    data = json.loads(succeed(*asked, "--store", str(path), "-f", "json"))
    assert data["poses"]["reached"] == workspaces.StoredMap(path).totals().reached_poses
    picture = tmp_path / "map.png"
    succeed("plot", "zyyzyz_6r", "workspace", "--map", str(path), "-o", str(picture))
    assert picture.stat().st_size > 1000
    for wrong, words in (
        (("--workers", "2"), "give --store"),
        (("--store", str(path), "--workers", "2", "--scheduler", "tcp://127.0.0.1:9"), "workers of its own"),
        (("--store", str(path), "-o", str(file)), "into a file or into a store"),
        (("--store", str(file)), "is a file"),
    ):
        result = call(*asked, *wrong)
        assert result.exit_code == 2 and words in " ".join(result.stderr.replace("│", " ").split()), result.stderr


def test_parts_are_cut_and_joined_block_by_block(
    stored: workspaces.StoredMap, whole: workspaces.WorkspaceMap, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A part holds what the map holds there; two halves, also with an overlap, are the map; others are refused."""
    at = float(stored.grid.coordinates(0)[3])
    monkeypatch.setattr(workspaces.StoredMap, "read", lambda *_: pytest.fail("it was read whole"))
    left = workspaces.cut(stored, tmp_path / "left.zarr", [[-9, -9, -9], [at, 9, 9]])
    right = workspaces.cut(stored, tmp_path / "right.zarr", [[at + 0.1, -9, -9], [9, 9, 9]])
    wide = workspaces.cut(stored, tmp_path / "wide.zarr", [[at - 1.0, -9, -9], [9, 9, 9]])
    joined = [workspaces.join(left, other, tmp_path / f"{k}.zarr") for k, other in enumerate((right, wide))]
    assert workspaces.differences(stored, stored)[1:] == (0, 0, 0, 0, 0, 0)
    with pytest.raises(urdf_ik.ArgumentError, match="do not fill a box"):
        corner = workspaces.cut(stored, tmp_path / "corner.zarr", [[at + 0.1, -9, -9], [9, 0, 9]])
        workspaces.join(left, corner, tmp_path / "none.zarr")
    with pytest.raises(urdf_ik.ArgumentError, match="other grids"):
        workspaces.differences(left, right)
    monkeypatch.undo()
    assert left.grid.shape[0] == 4 and left.complete
    np.testing.assert_array_equal(left.read().margin, whole.margin[:4])  # type: ignore[index]
    for each in joined:
        same(each.read(), whole)


def test_two_maps_are_compared(arm: urdf_ik.Arm, stored: workspaces.StoredMap, tmp_path: Path) -> None:
    """Without the limits more is reached, and nothing less; the sums are those of both in memory."""
    options = {"voxel": ASKED["voxel"], "orientations": ASKED["orientations"], "within_limits": False}
    free = workspaces.workspace(arm, **options, store=tmp_path / "free.zarr")
    found = workspaces.differences(stored, free)
    one, other = stored.read().counts.astype(int), free.read().counts.astype(int)
    assert found.poses == one.size and found.only_first == found.fewer == found.voxels_only_first == 0
    assert found.only_second == ((one == 0) & (other > 0)).sum() > 0
    assert found.more == ((one > 0) & (other > one)).sum() > 0
    with pytest.raises(urdf_ik.ArgumentError, match="differ in counted"):
        workspaces.join(stored, free, tmp_path / "none.zarr")


def test_the_boundary_is_closed_and_holds_what_is_reached(whole: workspaces.WorkspaceMap) -> None:
    """Every edge belongs to as many faces one way as the other; the volume inside is that of the voxels."""
    for least in (0.0, 0.5):
        mesh = workspaces.boundary(whole, least)
        edges = np.concatenate([mesh.faces[:, [a, b]] for a, b in ((0, 1), (1, 2), (2, 0))])
        forward = {
            tuple(edge): count for edge, count in zip(*np.unique(edges, axis=0, return_counts=True), strict=True)
        }
        assert all(forward.get(edge[::-1]) == count for edge, count in forward.items())
        a, b, c = (mesh.vertices[mesh.faces[:, k]] for k in range(3))
        volume = np.einsum("ij,ij->i", a, np.cross(b, c)).sum() / 6.0
        assert volume == pytest.approx((np.nan_to_num(whole.values()) > least).sum() * whole.grid.voxel**3, rel=1e-9)
