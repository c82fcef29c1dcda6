"""Data sets: what the samples say holds by Pinocchio; the same bytes however they are made; what is refused."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from command import oracle

import urdf_ik
from urdf_ik.maps import engine
from urdf_ik.maps.datasets import StoredSamples
from urdf_ik.maps.datasets.samples import Drawing
from urdf_ik.maps.engine.store_folder import PRIVATE, finished

pytest.importorskip("zarr")
parquet = pytest.importorskip("pyarrow.parquet")


@pytest.fixture(scope="module")
def arm() -> urdf_ik.Arm:
    """A six-joint arm."""
    return urdf_ik.load("zyyzyz_6r")


def files(path: Path) -> dict[str, bytes]:
    """Every file of a folder."""
    return {str(each.relative_to(path)): each.read_bytes() for each in path.rglob("*") if each.is_file()}


def same(one: urdf_ik.maps.datasets.Samples, other: urdf_ik.maps.datasets.Samples) -> None:
    """Two sets of samples are the same to the last bit."""
    assert one.columns.keys() == other.columns.keys()
    for name, array in one.columns.items():
        np.testing.assert_array_equal(array, other.columns[name])
        assert array.dtype == other.columns[name].dtype


def test_what_the_samples_say_is_so(arm: urdf_ik.Arm) -> None:
    """Poses by Pinocchio, every solution in its pose, the branch that was drawn, limits, singular values, contacts."""
    found = urdf_ik.maps.dataset(arm, 200, seed=3, chunk=64)
    pinocchio = oracle()
    low, high = arm.limits.T
    assert ((found.q >= low) & (found.q <= high)).all()
    for k in range(0, 200, 9):
        T = pinocchio.pose(found.q[k])
        np.testing.assert_allclose(found.T[k], T, atol=1e-9)
        solutions = found.solutions[k][~np.isnan(found.solutions[k]).any(axis=1)]
        assert len(solutions) == len(arm.ik(T))
        for q in solutions:
            np.testing.assert_allclose(pinocchio.pose(q), T, atol=1e-9)
        own = found.solutions[k, found.branch[k]]
        np.testing.assert_allclose(np.mod(own - found.q[k] + np.pi, 2.0 * np.pi), np.pi, atol=1e-7)
        assert found.within[k, found.branch[k]]
        gains = found.singular_values[k]
        assert (np.diff(gains) <= 0.0).all()
        assert found.collision is not None and found.collision[k] == arm.cell.collisions.in_collision(found.q[k])
    np.testing.assert_array_equal(found.within, arm.ik(found.T).within_limits().valid)


def test_seven_joints_are_solved_at_the_value_that_was_drawn() -> None:
    """Every sample is among its own solutions."""
    found = urdf_ik.maps.dataset(urdf_ik.load("srs_7r"), 50, collisions=False)
    assert (found.branch >= 0).all() and found.collision is None


def test_a_data_set_is_a_prefix_of_a_larger_one(arm: urdf_ik.Arm) -> None:
    """The same seed: the same samples; another seed: others."""
    small, large = (urdf_ik.maps.dataset(arm, n, seed=5, chunk=40, collisions=False) for n in (70, 130))
    same(small, type(large)(**{"collision": None, **{k: v[:70] for k, v in large.columns.items()}}))
    assert not np.isin(urdf_ik.maps.dataset(arm, 70, seed=6, chunk=40, collisions=False).q, small.q).any()


@pytest.mark.parametrize("kind", ["zarr", "parquet"])
def test_a_store_holds_what_memory_would(arm: urdf_ik.Arm, tmp_path: Path, kind: str) -> None:
    """Whole, in parts over the chunks' ends, and chunk by chunk."""
    whole = urdf_ik.maps.dataset(arm, 100, chunk=30)
    made = urdf_ik.maps.dataset(arm, 100, chunk=30, store=tmp_path / f"samples.{kind}")
    same(made.read(), whole)
    same(made.read(25, 61), type(whole)(**{name: array[25:61] for name, array in whole.columns.items()}))
    assert [len(part.q) for part in made] == [30, 30, 30, 10] and made.complete and len(made) == 100


def test_others_read_it(arm: urdf_ik.Arm, tmp_path: Path) -> None:
    """Plain xarray and plain pyarrow."""
    xarray = pytest.importorskip("xarray")
    whole = urdf_ik.maps.dataset(arm, 100, chunk=30)
    for kind in ("zarr", "parquet"):
        urdf_ik.maps.dataset(arm, 100, chunk=30, store=tmp_path / f"samples.{kind}")
    found = xarray.open_zarr(tmp_path / "samples.zarr")
    assert found.solutions.dims == ("sample", "branch", "joint") and found.attrs["complete"] is True
    np.testing.assert_array_equal(found.solutions.values, whole.solutions)
    table = parquet.read_table(tmp_path / "samples.parquet")
    assert len(table) == 100
    np.testing.assert_array_equal(np.stack(table["q"].to_numpy()), whole.q)
    np.testing.assert_array_equal(table["branch"].to_numpy(), whole.branch)


@pytest.mark.parametrize("kind", ["zarr", "parquet"])
def test_interrupted_or_damaged_it_ends_with_the_same_bytes(arm: urdf_ik.Arm, tmp_path: Path, kind: str) -> None:
    """Ctrl-C after two chunks, then a flipped bit."""
    options: dict[str, Any] = {"chunk": 20, "collisions": False}
    whole, path = tmp_path / f"whole.{kind}", tmp_path / f"samples.{kind}"
    urdf_ik.maps.dataset(arm, 100, **options, store=whole)

    def stop(done: int, total: int) -> None:
        if done >= 40:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt, match="2 of 5 chunks are kept"):
        urdf_ik.maps.dataset(arm, 100, **options, store=path, progress=stop)
    with pytest.raises(urdf_ik.JobError, match="not complete: 1 of the 2 chunks"):
        StoredSamples(path).read(30, 45)
    urdf_ik.maps.dataset(arm, 100, **options, store=path)
    assert files(path) == files(whole)
    file = next(each for each in sorted(path.rglob("*")) if each.is_file() and each.stat().st_size > 5000)
    data = bytearray(file.read_bytes())
    data[len(data) // 2] ^= 1
    file.write_bytes(data)
    urdf_ik.maps.dataset(arm, 100, **options, store=path)
    assert files(path) == files(whole)


def test_workers_make_the_same_bytes(arm: urdf_ik.Arm, tmp_path: Path) -> None:
    """One worker and two: what this process makes."""
    pytest.importorskip("distributed")
    path = tmp_path / "whole.zarr"
    urdf_ik.maps.dataset(arm, 600, chunk=50, store=path)
    for workers in (1, 2):
        with engine.connect(workers=workers) as client:
            urdf_ik.maps.dataset(arm, 600, chunk=50, store=tmp_path / f"{workers}.zarr", client=client)
        assert files(tmp_path / f"{workers}.zarr") == files(path)


def test_bad_input_is_refused_in_words(arm: urdf_ik.Arm, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Numbers, names, other questions, no room."""
    for wrong in ({"n": 0}, {"n": 5, "chunk": 0}, {"n": 5, "seed": -1}, {"n": 5, "client": object()}):
        with pytest.raises(urdf_ik.ArgumentError):
            urdf_ik.maps.dataset(arm, **wrong)
    with pytest.raises(urdf_ik.ArgumentError, match="collisions=False"):
        urdf_ik.maps.dataset(arm, 5, world=urdf_ik.World(), collisions=False)
    with pytest.raises(urdf_ik.JobError, match=r"\.zarr or something\.parquet"):
        urdf_ik.maps.dataset(arm, 5, store=tmp_path / "samples.csv")
    path = tmp_path / "samples.zarr"
    made = urdf_ik.maps.dataset(arm, 5, store=path)
    for other, words in (
        ({"seed": 1}, "seed is 0 in the store and 1 now"),
        ({"n": 6}, "n is 5 in the store and 6 now"),
    ):
        with pytest.raises(urdf_ik.JobError, match=words):
            urdf_ik.maps.dataset(arm, **{"n": 5, **other}, store=path)
    with pytest.raises(urdf_ik.ArgumentError, match="there are 0 to 5"):
        made.read(3, 9)
    with pytest.raises(urdf_ik.JobError, match="no store of this package"):
        StoredSamples(tmp_path)
    assert finished(path) == {0} and (path / PRIVATE).is_dir()
    monkeypatch.setattr("urdf_ik.maps.engine.free_space.free_disk", lambda _: 2**20)
    with pytest.raises(urdf_ik.JobError, match=r"1e\+09 samples take up to .* GiB on the disk.*1 MiB free"):
        urdf_ik.maps.dataset(arm, 10**9, store=tmp_path / "large.zarr")
    with pytest.raises(urdf_ik.ArgumentError, match=r"1e\+12 samples take .* GiB of memory.* a store"):
        urdf_ik.maps.dataset(arm, 10**12)


def test_pairs_that_may_touch_travel_with_the_drawing(arm: urdf_ik.Arm) -> None:
    """A changed table of pairs is the same on a worker."""
    import pickle

    changed = urdf_ik.load("zyyzyz_6r")
    changed = changed.with_cell(changed.cell.allow(*changed.cell.collisions.checked_pairs[0]))
    drawing = Drawing(changed, 10, 0, None, True, 10, 1)
    assert pickle.loads(pickle.dumps(drawing)).pairs == drawing.pairs != arm.cell.collisions.checked_pairs
