"""Stores and maps that were damaged, or made to harm: read as they are, or refused in words; no hang, no bomb."""

from __future__ import annotations

import os
import re
import shutil
import zlib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import urdf_ik
from urdf_ik.errors import JobError, UrdfIkError
from urdf_ik.maps import placements, workspaces
from urdf_ik.maps.datasets import StoredSamples
from urdf_ik.maps.engine import zarr_writer
from urdf_ik.maps.engine.zarr_reader import OpenedGroup

NUMBERS = (b"0", b"-1", b"1e308", b"NaN", b"null", b"[]", b"{}", b'"x"', b"99999999999999999999", b"true", b"2.5")


def _map(path: Path) -> None:
    found = workspaces.opened(path)
    found.values(), found.totals(), found.slice(), repr(found), found.look_up([[0.1, 0.1]])


def _samples(path: Path) -> None:
    found = StoredSamples(path)
    found.read(), repr(found), list(found)


def _bases(path: Path) -> None:
    found = placements.opened(path)
    found.places(), found.values()


USES: dict[str, Callable[[Path], None]] = {
    "map.zarr": _map, "map.npz": _map, "samples.zarr": _samples, "samples.parquet": _samples, "bases.zarr": _bases,
}  # fmt: skip


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with one store of each kind."""
    folder = tmp_path_factory.mktemp("stores")
    arm = urdf_ik.load("planar_2r")
    workspaces.workspace(arm, 0.2, 2, store=folder / "map.zarr")
    workspaces.workspace(arm, 0.2, 2).save(folder / "map.npz")
    for kind in ("zarr", "parquet"):
        urdf_ik.maps.dataset(arm, 10, store=folder / f"samples.{kind}", chunk=4)
    bounds = [[-0.1, -0.1, 0], [0.1, 0.1, 0]]
    urdf_ik.maps.placement(arm, arm.fk([0.2, 0.4]), bounds=bounds, step=0.1, store=folder / "bases.zarr")
    return folder


def _damage(file: Path, rng: Any) -> None:
    """Bytes, numbers, the end, or the whole file are others; or it is a folder, or a pipe that nobody writes to."""
    data, kind = bytearray(file.read_bytes()), int(rng.integers(6))
    if kind == 0 and data:
        data[int(rng.integers(len(data)))] ^= int(rng.integers(1, 256))
    elif kind == 1:
        del data[int(rng.integers(len(data) + 1)) :]
    elif kind == 2:
        data = bytearray(b"[" * 100_000)
    elif kind in (3, 4):
        found = list(re.finditer(rb'-?\d+\.?\d*(e-?\d+)?|"[^"]*"|null|true|false', bytes(data)))
        if found:
            one = found[int(rng.integers(len(found)))]
            data[one.start() : one.end()] = NUMBERS[int(rng.integers(len(NUMBERS)))]
        if file.name == "journal":  # whose lines have checksums
            bodies = [line.rpartition(b"\t")[0] for line in bytes(data).splitlines()]
            data = bytearray(b"".join(b"%s\t%08x\n" % (body, zlib.crc32(body)) for body in bodies))
    else:
        file.unlink()
        os.mkfifo(file) if rng.integers(2) else file.mkdir()
        return
    file.write_bytes(data)


@pytest.mark.skipif(os.name == "nt", reason="named pipes are things of POSIX")
@pytest.mark.parametrize("kind", USES)
def test_damaged_stores_are_refused_in_words(kind: str, made: Path, tmp_path: Path) -> None:
    """Or read, where what is damaged is not asked for."""
    refused = 0
    for seed in range(40):
        rng, copy = np.random.default_rng(seed), tmp_path / str(seed) / kind
        copy.parent.mkdir()
        (shutil.copytree if (made / kind).is_dir() else shutil.copyfile)(made / kind, copy)
        files = sorted(path for path in (copy.rglob("*") if copy.is_dir() else [copy]) if path.is_file())
        texts = [path for path in files if path.suffix == ".json" or path.name in ("question", "journal")]
        some = texts if texts and rng.integers(3) else files
        _damage(some[int(rng.integers(len(some)))], rng)
        try:
            USES[kind](copy)
        except UrdfIkError as error:
            refused += 1
            assert len(str(error)) < 1000
    assert refused > 4


def test_a_chunk_that_unpacks_to_more_than_it_should_is_not_unpacked(tmp_path: Path) -> None:
    """Its head says how much it is: a bomb with a good checksum is refused before it takes memory."""
    plan = zarr_writer.ArrayPlan("height", ("x",), (8,), (8,), "float64")
    large = zarr_writer.Encoder((zarr_writer.ArrayPlan("height", ("x",), (2**24,), (2**24,), "float64"),))
    files = zarr_writer.group_files((plan,), (), {}) | large.files((0,), {"height": np.zeros(2**24)})
    for name, data in files.items():
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_bytes(data)
    with pytest.raises(JobError, match="unpacks to 134217728 bytes, not 64"):
        OpenedGroup(tmp_path).read("height")


@pytest.mark.filterwarnings("ignore::UserWarning")
def test_arrays_of_other_codecs_are_not_read(tmp_path: Path) -> None:
    """Such as Zarr's second format, whose codecs may be pickle, or chunks of a terabyte."""
    import zarr

    old = zarr.create_group(str(tmp_path / "old"), zarr_format=2)
    old.create_array("x", data=np.zeros(3))
    with pytest.raises(JobError):
        OpenedGroup(tmp_path / "old")
    other = zarr.create_group(str(tmp_path / "other"), zarr_format=3)
    other.create_array("x", data=np.zeros(3), compressors=None)
    zarr.consolidate_metadata(str(tmp_path / "other"))
    with pytest.raises(JobError, match="no array of this package"):
        OpenedGroup(tmp_path / "other").read("x")


def test_questions_and_journals_are_bounded(made: Path, tmp_path: Path) -> None:
    """A file beyond its limit is not read, and the error names the limit."""
    for name, most in (("question", 2**24), ("journal", 2**27)):
        copy = tmp_path / name / "map.zarr"
        shutil.copytree(made / "map.zarr", copy)
        with (copy / ".urdf-ik" / name).open("r+b") as file:
            file.truncate(most + 1)
        with pytest.raises(JobError, match=f"larger than {most >> 20} MiB"):
            _map(copy)


@pytest.mark.parametrize("kind", ["zarr", "parquet"])
def test_a_store_whose_name_is_not_utf_8(tmp_path: Path, kind: str) -> None:
    """A file system takes any bytes for a name; the samples are written and read as elsewhere."""
    store = os.fsdecode(bytes(tmp_path) + b"/s\377." + kind.encode())
    assert len(urdf_ik.maps.dataset(urdf_ik.load("planar_2r"), 10, store=store).read()) == 10


def test_a_working_directory_that_is_gone(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A relative path then names nothing; the message says why. Arms with a name are loaded all the same."""
    gone = tmp_path / "gone"
    gone.mkdir()
    monkeypatch.chdir(gone)
    gone.rmdir()
    arm = urdf_ik.load("planar_2r")
    for act in (
        lambda: urdf_ik.maps.dataset(arm, 10, store="samples.zarr"),
        lambda: urdf_ik.maps.workspace(arm, 0.2, 2, store="map.zarr"),
        lambda: urdf_ik.maps.workspace(arm, 0.2, 2, output="map.npz"),
    ):
        with pytest.raises(UrdfIkError, match="the working directory is gone, give an absolute path"):
            act()
    assert len(urdf_ik.maps.dataset(arm, 10, store=tmp_path / "samples.zarr")) == 10


@pytest.mark.parametrize("name", ["map.zarr", "samples.zarr", "samples.parquet"])
def test_a_chunk_that_cannot_be_read(made: Path, name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """The permission is denied; the store is not called damaged."""

    def denied(path: Path) -> None:
        raise PermissionError(13, "Permission denied", str(path))

    monkeypatch.setattr("urdf_ik.support.files.opened", denied)
    monkeypatch.setattr("urdf_ik.support.files.read", lambda path, most, error: path.read_bytes())
    with pytest.raises(JobError, match="cannot read .*: Permission denied"):
        USES[name](made / name)
