"""dataset(): creates samples in memory, as a Zarr group or as a folder of Parquet files."""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Mapping
from functools import cached_property
from importlib import import_module
from pathlib import Path
from typing import Any, overload

import numpy as np
from numpy.typing import NDArray

from urdf_ik.arm import Arm
from urdf_ik.cell import World
from urdf_ik.errors import ArgumentError, JobError, MissingPackage, UnsupportedArm
from urdf_ik.maps.datasets.samples import CHUNK, Drawing, Samples
from urdf_ik.maps.datasets.stored_samples import FORMAT, VERSION, StoredSamples
from urdf_ik.maps.engine import Folder, free_space, run, zarr_writer
from urdf_ik.maps.engine.store_folder import checked_path, finished
from urdf_ik.support import inputs

PARQUET = "data sets in Parquet need pyarrow; install it with: pip install 'urdf-ik[scale]'"
KINDS = (".zarr", ".parquet")
"""Endings of a store's name, which say what it is."""
SEEDS = 2**64
"""Seeds are whole numbers from 0 to one less than this."""

Progress = Callable[[int, int], object]
_UNITS = {"q": "rad or m", "T": "m", "solutions": "rad or m"}


@overload
def dataset(
    arm: Arm,
    n: int,
    *,
    seed: int = ...,
    store: None = ...,
    world: World | None = ...,
    collisions: bool | None = ...,
    client: None = ...,
    chunk: int = ...,
    threads: inputs.Threads = ...,
    progress: Progress | None = ...,
) -> Samples: ...


@overload
def dataset(
    arm: Arm,
    n: int,
    *,
    seed: int = ...,
    store: str | os.PathLike[str],
    world: World | None = ...,
    collisions: bool | None = ...,
    client: Any = ...,
    chunk: int = ...,
    threads: inputs.Threads = ...,
    progress: Progress | None = ...,
) -> StoredSamples: ...


def dataset(
    arm: Arm,
    n: int,
    *,
    seed: int = 0,
    store: str | os.PathLike[str] | None = None,
    world: World | None = None,
    collisions: bool | None = None,
    client: Any = None,
    chunk: int = CHUNK,
    threads: inputs.Threads = 1,
    progress: Progress | None = None,
) -> Samples | StoredSamples:
    """Draw joint vectors within the limits, with the pose and every solution of each.

    The random numbers of a chunk come from a counter (Philox) that starts at the chunk's number, so that they are the
    same on every worker: a data set has the same bytes for any number of workers, and after any kill. A smaller one
    with the same seed and chunk is the beginning of a larger one.

    Args:
        arm: the arm.
        n: number of samples.
        seed: of the random numbers.
        store: folder to make it in: a Zarr group where its name ends in '.zarr', a folder of Parquet files where it
            ends in '.parquet'; default: in memory.
        world: obstacles that count for collisions.
        collisions: whether to look for collisions; default: where the URDF has shapes for them.
        client: a ``distributed.Client`` whose workers make the chunks of a store; default: this process does.
        chunk: samples of a chunk; another number draws other samples.
        threads: number of threads that solve, or 'auto'.
        progress: called with the number of finished samples, and of all.

    Raises:
        ArgumentError: an invalid number, a client without a store, or samples that do not fit in memory.
        UnsupportedArm: no solver takes this arm.
        UrdfError: the URDF has no collision shapes, and collisions are asked for.
        JobError: the store is in use, is of another question, does not fit on the disk or cannot be written; or the
            scheduler or the workers cannot go on.

    Example:
        >>> import urdf_ik
        >>> arm = urdf_ik.load("zyyzyz_6r")
        >>> found = dataset(arm, 100, seed=7, store="samples.zarr")
        >>> bool((found.read(0, 10).q == dataset(arm, 100, seed=7).q[:10]).all())
        True
    """
    inputs.arm(arm)
    if not arm.structure.branches:
        raise UnsupportedArm(f"{arm.name}: no solver for this arm yet. {arm.structure}")
    n, chunk = inputs.whole(n, "n", low=1, high=2**53), inputs.whole(chunk, "chunk", low=1, high=2**40)
    seed, threads = inputs.whole(seed, "seed", high=SEEDS - 1), inputs.threads(threads)
    collisions = None if collisions is None else inputs.flag(collisions, "collisions")
    if world is not None:
        inputs.kind(world, "snapshot", "world", "a urdf_ik.World")
    inputs.callback(progress, "progress")
    if collisions is None:
        collisions = world is not None or arm.cell.collisions.has_geometry
    if world is not None and not collisions:
        raise ArgumentError("a world is given with collisions=False; leave one of the two out")
    drawing = Drawing(arm, n, seed, world, collisions, chunk, threads)
    if store is None:
        if client is not None:
            raise ArgumentError("client is for data sets in a store; give store='samples.zarr', too")
        return _in_memory(drawing, progress)
    return _in_store(drawing, inputs.path(store, "store", JobError), client, progress)


def _in_memory(drawing: Drawing, progress: Progress | None) -> Samples:
    # The chunks, and all of them once more as one.
    hint = "take fewer samples, or a store"
    free_space.require_memory(2 * drawing.n * _size(_one(drawing)), f"{drawing.n:.4g} samples", hint)
    parts: list[dict[str, Any]] = []
    for chunk in range(drawing.chunks):
        parts.append(drawing.samples(chunk).columns)
        if progress is not None:
            progress(drawing.rows(chunk).stop, drawing.n)
    joined: dict[str, Any] = {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}
    return Samples(**{"collision": None, **joined})


def _in_store(drawing: Drawing, path: Path, client: Any, progress: Progress | None) -> StoredSamples:
    if path.suffix not in KINDS:
        raise JobError(f"{path}: a store of samples is called something{' or something'.join(KINDS)}")
    one = _one(drawing)
    folder = checked_path(path)
    needed = _size(one) * max(0, drawing.n - len(finished(folder)) * drawing.chunk)
    free_space.require_disk(folder, needed, f"{drawing.n:.4g} samples", "take fewer samples, or another disk")
    job: Job = ZarrJob(drawing) if path.suffix == ".zarr" else ParquetJob(drawing)
    question = {**drawing.described(), "format": FORMAT, "version": VERSION, "kind": path.suffix, "columns": list(one)}

    def tick(done: int, total: int) -> None:
        if progress is not None:
            progress(min(done * drawing.chunk, drawing.n), drawing.n)

    with Folder(path, question, drawing.chunks, *job.frame()) as kept:
        run(job, kept, client=client, progress=tick)
        kept.finish()
    return StoredSamples(path)


class Job:
    """Makes the files of a chunk; a format says how.

    Args:
        drawing: what decides the samples.
    """

    def __init__(self, drawing: Drawing) -> None:
        self.drawing = drawing

    def __getstate__(self) -> dict[str, Any]:
        return {"drawing": self.drawing}

    def __call__(self, chunk: int) -> Mapping[str, bytes]:
        """The files of a chunk."""
        raise NotImplementedError

    def frame(self) -> tuple[Mapping[str, bytes], Mapping[str, bytes]]:
        """The files that stand before any chunk, and those of them that are others when all chunks are there."""
        raise NotImplementedError


class ZarrJob(Job):
    """Chunks of a Zarr group."""

    def __call__(self, chunk: int) -> Mapping[str, bytes]:
        """The files of a chunk."""
        columns = self.drawing.samples(chunk).columns
        return self._encoder.files((chunk,), {name: _stored(array) for name, array in columns.items()})

    def frame(self) -> tuple[Mapping[str, bytes], Mapping[str, bytes]]:
        """The group's metadata."""
        files = zarr_writer.group_files(self._plans, (), {"complete": False, **self.drawing.described()})
        return files, zarr_writer.with_attributes(files, {"complete": True})

    @cached_property
    def _plans(self) -> tuple[zarr_writer.ArrayPlan, ...]:
        drawing = self.drawing
        dimensions = {
            "q": ("joint",),
            "T": ("row", "column"),
            "solutions": ("branch", "joint"),
            "within": ("branch",),
            "branch": (),
            "singular_values": ("direction",),
            "collision": (),
        }
        return tuple(
            zarr_writer.ArrayPlan(
                name,
                ("sample", *dimensions[name]),
                (drawing.n, *array.shape[1:]),
                (drawing.chunk, *array.shape[1:]),
                _stored(array).dtype.name,
                float("nan") if array.dtype.kind == "f" else 0,
                {"units": _UNITS.get(name, "1")},
            )
            for name, array in _one(drawing).items()
        )

    @cached_property
    def _encoder(self) -> zarr_writer.Encoder:
        return zarr_writer.Encoder(self._plans)


class ParquetJob(Job):
    """A Parquet file for each chunk; a column's arrays are lists of fixed length, rows first."""

    def __call__(self, chunk: int) -> Mapping[str, bytes]:
        """The file of a chunk."""
        arrow, parquet = _arrow("pyarrow"), _arrow("pyarrow.parquet")
        columns = {}
        for name, array in self.drawing.samples(chunk).columns.items():
            flat = arrow.array(array.reshape(-1))
            width = int(np.prod(array.shape[1:]))
            columns[name] = flat if array.ndim == 1 else arrow.FixedSizeListArray.from_arrays(flat, width)
        table = arrow.table(columns).replace_schema_metadata({"urdf-ik": json.dumps(self.drawing.described())})
        out = arrow.BufferOutputStream()
        level = zarr_writer.LEVEL
        parquet.write_table(table, out, compression="zstd", compression_level=level, row_group_size=len(table))
        return {f"part-{chunk:08}.parquet": out.getvalue().to_pybytes()}

    def frame(self) -> tuple[Mapping[str, bytes], Mapping[str, bytes]]:
        """Nothing stands beside the chunks."""
        _arrow("pyarrow")
        return {}, {}


def _one(drawing: Drawing) -> dict[str, NDArray[Any]]:
    """The arrays of a single sample."""
    return Drawing(**{**vars(drawing), "n": 1}).samples(0).columns


def _size(columns: Mapping[str, NDArray[Any]]) -> int:
    return sum(array.nbytes for array in columns.values())


def _stored(array: Any) -> Any:
    """Truth as 0 and 1 for readers that know no other numbers."""
    return array.astype(np.uint8) if array.dtype == np.bool_ else array


def _arrow(name: str) -> Any:
    try:
        return import_module(name)
    except ImportError:
        raise MissingPackage(PARQUET) from None
