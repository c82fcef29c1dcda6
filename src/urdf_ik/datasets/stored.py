"""StoredSamples: a data set on the disk, read in parts."""

from __future__ import annotations

import os
from collections.abc import Iterator
from importlib import import_module
from typing import Any

import numpy as np

from urdf_ik.datasets.drawing import Samples
from urdf_ik.errors import ArgumentError, StoreError
from urdf_ik.guards import inputs
from urdf_ik.scale import zarrs
from urdf_ik.scale.folder import finished, read_question

FORMAT, VERSION = "urdf-ik samples", 1


class StoredSamples:
    """A data set in a Zarr group or in Parquet files, which any reader of these formats takes, too.

    Attributes:
        path: the store.
        about: what the samples are of, as the store's question says.
        n: number of samples.
        chunk: samples of a chunk.
        columns: names of the arrays.

    Raises:
        StoreError: there is no such store, or it is damaged.

    Example:
        >>> import urdf_ik
        >>> made = urdf_ik.dataset(urdf_ik.load("zyyzyz_6r"), 100, store="samples.parquet")
        >>> found = StoredSamples("samples.parquet")
        >>> found.n, found.about["robot"], found.complete
        (100, 'zyyzyz_6r', True)
    """

    def __init__(self, path: str | os.PathLike[str]) -> None:
        self.path = inputs.path(path, "path", StoreError)
        self.about = read_question(self.path)
        if self.about.get("format") != FORMAT or self.about.get("version") != VERSION:
            found = f"{self.about.get('format')!r}, version {self.about.get('version')}"
            raise StoreError(f"{self.path} holds no samples that this package reads: it is of the format {found}")
        self.n, self.chunk = int(self.about["n"]), int(self.about["chunk"])
        self.columns: tuple[str, ...] = tuple(self.about["columns"])

    def __len__(self) -> int:
        return self.n

    def __repr__(self) -> str:
        return f"<StoredSamples {str(self.path)!r}: {self.n} of {self.about['robot']}>"

    @property
    def complete(self) -> bool:
        """Whether all chunks are there; if not, ``dataset`` with the same store goes on with it."""
        return len(finished(self.path)) == -(-self.n // self.chunk)

    def read(self, start: int = 0, stop: int | None = None) -> Samples:
        """The samples from ``start`` up to ``stop``, without it up to the end, in memory.

        Raises:
            ArgumentError: there are no such samples.
            StoreError: a chunk of them is not there, or damaged.

        Example:
            >>> import urdf_ik
            >>> made = urdf_ik.dataset(urdf_ik.load("zyyzyz_6r"), 100, store="samples.zarr", chunk=30)
            >>> made.read(20, 70).q.shape
            (50, 6)
        """
        start = inputs.whole(start, "start", high=2**53)
        end = self.n if stop is None else inputs.whole(stop, "stop", high=2**53)
        if not 0 <= start < end <= self.n:
            raise ArgumentError(f"samples {start} to {end} asked for; there are 0 to {self.n}")
        wanted = range(start // self.chunk, -(-end // self.chunk))
        done = finished(self.path)
        if missing := [chunk for chunk in wanted if chunk not in done]:
            raise StoreError(
                f"{self.path} is not complete: {len(missing)} of the {len(wanted)} chunks that are asked for are not "
                "made yet; run what makes it again, with the same store"
            )
        try:
            found = self._zarr(start, end) if self.path.suffix == ".zarr" else self._parquet(wanted, start, end)
        except (OSError, ValueError, RuntimeError) as error:
            raise StoreError(
                f"{self.path} is damaged ({error}); the run that made it makes what is damaged again"
            ) from None
        for name in ("within", "collision"):
            if name in found:
                found[name] = found[name].astype(np.bool_)
        return Samples(**{"collision": None, **found})

    def __iter__(self) -> Iterator[Samples]:
        """The samples chunk by chunk."""
        for start in range(0, self.n, self.chunk):
            yield self.read(start, min(start + self.chunk, self.n))

    def _zarr(self, start: int, stop: int) -> dict[str, Any]:
        group = zarrs.package().open_group(str(self.path), mode="r")
        return {name: np.asarray(group[name][start:stop]) for name in self.columns}

    def _parquet(self, wanted: range, start: int, stop: int) -> dict[str, Any]:
        parquet = import_module("pyarrow.parquet")
        joints, branches = len(self.about["joints"]), len(self.about["branches"])
        shapes = {"T": (4, 4), "solutions": (branches, joints)}
        found: dict[str, list[Any]] = {name: [] for name in self.columns}
        for chunk in wanted:
            table = parquet.read_table(self.path / f"part-{chunk:08}.parquet")
            for name in self.columns:
                column = table.column(name).combine_chunks()
                listed = hasattr(column, "flatten") and hasattr(column.type, "list_size")
                values = (column.flatten() if listed else column).to_numpy(zero_copy_only=False)
                width = (column.type.list_size,) if listed else ()
                found[name].append(values.reshape(-1, *shapes.get(name, width)))
        first = wanted.start * self.chunk
        return {name: np.concatenate(parts)[start - first : stop - first] for name, parts in found.items()}
