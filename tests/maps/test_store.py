"""Maps in stores: the arrays of memory, also after a kill and from workers; read by others; what is refused."""

import json
import os
import signal
import socket
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from command import call, succeed

import urdf_ik
from urdf_ik.maps import cluster, workspaces

zarr = pytest.importorskip("zarr")
xarray = pytest.importorskip("xarray")
distributed = pytest.importorskip("distributed")
ASKED: dict[str, Any] = {"voxel": 0.7, "orientations": 11, "manipulability": True, "margin": True}
PATIENCE = 240.0
"""s, on a machine that may have other work."""


@pytest.fixture(scope="module")
def arm() -> urdf_ik.Arm:
    """A six-joint arm."""
    return urdf_ik.load("zyyzyz_6r")


@pytest.fixture(scope="module")
def stored(arm: urdf_ik.Arm, tmp_path_factory: pytest.TempPathFactory) -> workspaces.WorkspaceMap:
    """A map of it in blocks, those at the end smaller."""
    return workspaces.stored_workspace(arm, tmp_path_factory.mktemp("maps") / "map.zarr", **ASKED, block=90)


@pytest.fixture(scope="module")
def whole(arm: urdf_ik.Arm) -> workspaces.WorkspaceMap:
    """The same in memory."""
    return workspaces.workspace(arm, **ASKED)


def same(one: workspaces.WorkspaceMap, other: workspaces.WorkspaceMap) -> None:
    """Two maps have the same arrays, bit by bit."""
    assert one.about == other.about and one.grid.shape == other.grid.shape and one.names == other.names
    for name in one.names:
        np.testing.assert_array_equal(one.array(name), other.array(name))
    np.testing.assert_array_equal(one.samples, other.samples)


def test_a_store_contains_what_memory_would(stored: workspaces.WorkspaceMap, whole: workspaces.WorkspaceMap) -> None:
    """Every array, bit by bit; sums, layers, values and boxes by block; more than one block."""
    assert stored.complete and stored.blocks.count > 20
    same(stored, whole)
    same(stored.read(), whole)
    assert stored.totals() == whole.totals()
    for axis, at, what in (("z", 0.3, "reach"), ("x", -1.0, "margin"), ("y", 0.0, "manipulability")):
        layer, expected = stored.slice(axis, at, what), whole.slice(axis, at, what)
        np.testing.assert_array_equal(layer.values, expected.values)
        assert layer[1:] == expected[1:]
    np.testing.assert_array_equal(stored.values("solutions"), whole.values("solutions"))
    at = float(stored.grid.coordinates(0)[3])
    np.testing.assert_array_equal(stored.read([[-9, -9, -9], [at, 9, 9]]).margin, whole.margin[:4])  # type: ignore[index]


def test_plain_xarray_reads_it(stored: workspaces.WorkspaceMap, whole: workspaces.WorkspaceMap) -> None:
    """Dimensions, coordinates in metres, attributes; no other call, and no warning; a map in memory gives the same."""
    found = xarray.open_zarr(stored.path)
    assert found.solutions.dims == ("x", "y", "z", "orientation") and found.solutions.dtype == np.uint8
    assert found.branch_poses.dims == ("x", "y", "z", "branch")
    np.testing.assert_array_equal(found.within.values, whole.within)
    np.testing.assert_array_equal(found.margin.values, whole.margin)
    np.testing.assert_allclose(found.x.values, whole.grid.coordinates(0), rtol=0, atol=0)
    assert found.x.attrs["units"] == "m" and found.attrs["complete"] is True
    assert found.attrs["urdf_sha256"] == whole.about["urdf_sha256"] and found.attrs["base"] == whole.about["base"]
    assert found.sel(x=0.0, y=0.0, z=1.0, method="nearest").solutions.sizes == {"orientation": 11}
    for each in (stored.to_xarray(), whole.to_xarray()):
        xarray.testing.assert_equal(each, found)


def test_an_interrupted_run_is_continued(arm: urdf_ik.Arm, whole: workspaces.WorkspaceMap, tmp_path: Path) -> None:
    """Blocks that are there can be read, the others are refused; the next run computes only these."""
    path, ticks = tmp_path / "map.zarr", []

    def stop(done: int, total: int) -> None:
        if done > total // 2:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt, match=r"\d+ of \d+ blocks are kept"):
        workspaces.stored_workspace(arm, path, **ASKED, block=90, progress=stop)
    found = workspaces.opened(path)
    assert not found.complete and "not complete" in repr(found)
    assert xarray.open_zarr(path).attrs["complete"] is False
    first = found.grid.coordinates(0)[0]
    assert found.read([[first - 0.1, -9, -9], [first + 0.1, 9, 9]]).grid.shape[0] == 1
    with pytest.raises(urdf_ik.JobError, match=r"not complete: \d+ of the \d+ blocks"):
        found.array("solutions")
    missing = next(part for part in found.blocks.parts() if is_missing(found, part))
    zarr.open_group(str(path), mode="r+")["solutions"][missing] = 7  # killed between two arrays of a block
    again = workspaces.stored_workspace(arm, path, **ASKED, block=90, progress=lambda done, total: ticks.append(done))
    assert again.complete and 1 < len(ticks) < again.blocks.count
    same(again, whole)


def is_missing(found: workspaces.WorkspaceMap, part: Any) -> bool:
    """Whether a box of voxels cannot be read yet."""
    try:
        return not found.array("solutions", part).size
    except urdf_ik.JobError:
        return True


KILLED = """
import os, sys, urdf_ik
from urdf_ik.maps import stored_workspace

def progress(done, total):
    if done > float(sys.argv[2]) * total:
        os.kill(os.getpid(), 9)

stored_workspace(urdf_ik.load("zyyzyz_6r"), sys.argv[1], 0.7, 11, manipulability=True, margin=True, block=90,
    progress=progress)
"""


def test_killed_it_ends_with_the_same_arrays(arm: urdf_ik.Arm, whole: workspaces.WorkspaceMap, tmp_path: Path) -> None:
    """SIGKILL in the middle of the run, and no file under a temporary name counts."""
    path = tmp_path / "map.zarr"
    ended = subprocess.run([sys.executable, "-c", KILLED, str(path), "0.4"], check=False, timeout=PATIENCE)
    assert ended.returncode == -signal.SIGKILL and not workspaces.opened(path).complete
    same(workspaces.stored_workspace(arm, path, **ASKED, block=90), whole)


@pytest.fixture(scope="module")
def client() -> Iterator[Any]:
    """Two worker processes."""
    with cluster.connect(workers=2) as made:
        made.wait_for_workers(2, timeout=PATIENCE)
        yield made


def test_workers_compute_the_same_arrays(
    arm: urdf_ik.Arm, whole: workspaces.WorkspaceMap, client: Any, tmp_path: Path
) -> None:
    """Two workers, one of which is killed in the middle: the map is whole, and its arrays are the same."""
    path = tmp_path / "map.zarr"
    pid = next(iter(client.run(os.getpid).values()))
    killed: list[int] = []

    def progress(done: int, total: int) -> None:
        if done > total // 4 and not killed:
            killed.append(pid)
            os.kill(pid, signal.SIGKILL)

    same(workspaces.stored_workspace(arm, path, **ASKED, block=90, client=client, progress=progress), whole)
    assert killed
    client.wait_for_workers(2, timeout=PATIENCE)  # the cluster starts another one


def test_a_worker_with_another_version_is_refused(
    arm: urdf_ik.Arm, client: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The instruction set of this process differs from that of the workers: the last digits would."""
    ours = cluster.versions()
    monkeypatch.setattr(cluster, "versions", lambda: {**ours, "instructions": "v1"})
    with pytest.raises(urdf_ik.JobError, match=r"worker at .* and this process .* with v1.*URDF_IK_ISA"):
        workspaces.stored_workspace(arm, tmp_path / "map.zarr", **ASKED, client=client)


def test_a_scheduler_that_does_not_answer(monkeypatch: pytest.MonkeyPatch) -> None:
    """Nobody listens there, somebody listens who is no scheduler, or it is no address."""
    monkeypatch.setattr(cluster, "ANSWER_WITHIN", 0.5)
    with socket.socket() as silent:
        silent.bind(("127.0.0.1", 0))
        silent.listen()
        listening = f"tcp://127.0.0.1:{silent.getsockname()[1]}"
        for address in (listening, "tcp://127.0.0.1:9", "nonsense"):
            with pytest.raises(urdf_ik.JobError, match=r"no scheduler answers at .* within 0\.5 s"):
                cluster.connect(address)


@pytest.mark.slow
def test_a_scheduler_that_goes_away(arm: urdf_ik.Arm, whole: workspaces.WorkspaceMap, tmp_path: Path) -> None:
    """Given by its address and killed in the middle: the run ends in words, and this process continues it."""
    path = tmp_path / "map.zarr"
    with cluster.connect(workers=1) as owner:
        other = cluster.connect(owner.scheduler.address)

        def progress(done: int, total: int) -> None:
            if done > total // 4:
                owner.cluster.close()

        with pytest.raises(urdf_ik.JobError, match=r"scheduler at .* is gone"):
            workspaces.stored_workspace(arm, path, **ASKED, block=90, client=other, progress=progress)
        other.close()
    assert not workspaces.opened(path).complete
    same(workspaces.stored_workspace(arm, path, **ASKED, block=90), whole)


def test_obstacles_count_and_travel_with_the_question(arm: urdf_ik.Arm, client: Any, tmp_path: Path) -> None:
    """Free counts and clearances by the arm's own answers, on workers too; another world is another question."""
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
    path = tmp_path / "map.zarr"
    same(workspaces.stored_workspace(changed, path, **options, world=world, client=client), found)
    world.move("wall", urdf_ik.pose([1.3, 0.0, 0.0]))
    with pytest.raises(urdf_ik.JobError, match="world is "):
        workspaces.stored_workspace(changed, path, **options, world=world)
    with pytest.raises(urdf_ik.JobError, match="pairs_sha256 is "):
        workspaces.stored_workspace(arm, path, **options, world=world)


def test_what_a_store_cannot_be_is_said(arm: urdf_ik.Arm, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Another grid or arm, something else there, too full a disk, options that do not go together."""
    path = tmp_path / "map.zarr"
    workspaces.stored_workspace(arm, path, 0.9, 5)
    with pytest.raises(urdf_ik.JobError, match=r"grid is .*0\.9.* in the store and .*0\.8.* now"):
        workspaces.stored_workspace(arm, path, 0.8, 5)
    with pytest.raises(urdf_ik.JobError, match=r"urdf_sha256 is "):
        workspaces.stored_workspace(urdf_ik.load("dh_6r"), path, 0.9, 5, bounds=[[0, 0, 0], [1, 1, 1]])
    (tmp_path / "file").write_text("text")
    (tmp_path / "full").mkdir()
    (tmp_path / "full" / "letter").write_text("text")
    for other, words in (
        (tmp_path / "file", "no store of this package"),
        (tmp_path / "full", "no store of this package"),
        (Path("missing") / "store", "in a folder that is there"),
        ("s3://bucket/map.zarr", "a store is a folder on a disk"),
    ):
        with pytest.raises(urdf_ik.JobError, match=words):
            workspaces.stored_workspace(arm, other, 0.9, 5)
    assert os.listdir(tmp_path / "full") == ["letter"]
    with pytest.raises(urdf_ik.JobError, match="no store of this package"):
        workspaces.opened(tmp_path / "full")
    with pytest.raises(urdf_ik.ArgumentError, match="no effect without collision_free"):
        workspaces.workspace(arm, world=urdf_ik.World())
    with pytest.raises(urdf_ik.ArgumentError, match=r"distributed\.Client"):
        workspaces.stored_workspace(arm, tmp_path / "new.zarr", 0.9, 5, client="tcp://127.0.0.1:8786")


def test_the_command_computes_a_store_and_continues_it(tmp_path: Path) -> None:
    """The same sums as a map in a file; a picture of a layer; options that do not go together."""
    path, file = tmp_path / "map.zarr", tmp_path / "map.npz"
    asked = ("workspace", "zyyzyz_6r", "--voxel", "0.9", "--orientations", "5")
    text = succeed(*asked, "--store", str(path))
    assert text == succeed(*asked, "--store", str(path))
    assert text == succeed(*asked, "-o", str(file))
    data = json.loads(succeed(*asked, "--store", str(path), "-f", "json"))
    assert data["poses"]["reached"] == workspaces.opened(path).totals()["poses"]["reached"]
    picture = tmp_path / "map.png"
    succeed("plot", "zyyzyz_6r", "workspace", "--map", str(path), "-o", str(picture))
    assert picture.stat().st_size > 1000
    for wrong, words in (
        (("--workers", "2"), "give --store"),
        (("--store", str(path), "--workers", "2", "--scheduler", "tcp://127.0.0.1:9"), "workers of its own"),
        (("--store", str(path), "-o", str(file)), "into a file or into a store"),
        (("--store", str(file)), "no store of this package"),
    ):
        result = call(*asked, *wrong)
        assert result.exit_code == 2 and words in " ".join(result.stderr.replace("│", " ").split()), result.stderr
