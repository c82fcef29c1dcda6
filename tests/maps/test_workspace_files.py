"""Files of maps that are damaged or hostile."""

from __future__ import annotations

import io
import zipfile
from pathlib import Path

import numpy as np
import pytest

import urdf_ik
from urdf_ik import ArgumentError
from urdf_ik.maps import workspaces


@pytest.fixture(scope="module")
def file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A small map."""
    path = tmp_path_factory.mktemp("maps") / "map.npz"
    workspaces.workspace(urdf_ik.load("planar_2r"), voxel=0.1, orientations=2).save(path)
    return path


def test_damaged_maps_are_refused_or_read(file: Path, tmp_path: Path) -> None:
    """Bytes changed, cut off and added anywhere: an error of ours, or the map as it was."""
    data, rng = file.read_bytes(), np.random.default_rng(5)
    whole = workspaces.read(file)
    damaged = tmp_path / "damaged.npz"
    refused = 0
    for k in range(400):
        content = bytearray(data)
        for _ in range(int(rng.integers(1, 4))):
            content[int(rng.integers(len(content)))] = int(rng.integers(256))
        if k % 4 == 0:
            content = content[: int(rng.integers(len(content)))]
        damaged.write_bytes(content)
        try:
            found = workspaces.read(damaged)
        except ArgumentError as error:
            refused += 1
            assert str(damaged) in str(error)
        else:
            np.testing.assert_array_equal(found.counts, whole.counts)
    assert refused > 200


def test_a_map_that_unpacks_to_too_much_is_refused(file: Path, tmp_path: Path) -> None:
    """By what the archive says, before anything is unpacked; whoever wants more says so."""
    bomb = tmp_path / "bomb.npz"
    with zipfile.ZipFile(file) as old, zipfile.ZipFile(bomb, "w", zipfile.ZIP_DEFLATED) as new:
        for name in old.namelist():
            new.writestr(name, old.read(name))
        new.writestr("zeros.npy", bytes(2**20))
        new.getinfo("zeros.npy").file_size = 2**31
    with pytest.raises(ArgumentError, match="at most 1024 MiB are read; most="):
        workspaces.read(bomb)
    with pytest.raises(ArgumentError, match="at most 0.0009766 MiB"):
        workspaces.read(file, most=1024)
    assert workspaces.read(file, most=2**20).grid.shape == workspaces.read(file).grid.shape


def test_a_map_is_never_a_pickle(tmp_path: Path) -> None:
    """What a file holds is data."""
    file = tmp_path / "pickle.npz"
    buffer = io.BytesIO()
    np.savez(buffer, header=np.array([{"a": 1}], dtype=object))
    file.write_bytes(buffer.getvalue())
    with pytest.raises(ArgumentError, match="pickle"):
        workspaces.read(file)


@pytest.mark.skipif(not Path("/dev/zero").exists(), reason="there is no such device")
def test_a_device_is_not_read_as_a_map() -> None:
    """Where there is no regular file, nothing is read: what a device gives has no end."""
    for ask in (workspaces.read, workspaces.opened):
        with pytest.raises(ArgumentError, match=r"/dev/zero: it is no regular file"):
            ask("/dev/zero")
