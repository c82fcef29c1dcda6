"""StoredSamples: a data set on the disk, read in parts."""

from __future__ import annotations

import os
from collections.abc import Iterator
from dataclasses import fields
from importlib import import_module
from typing import Any

import numpy as np

from urdf_ik.errors import ArgumentError, JobError, UrdfIkError, printable
from urdf_ik.maps.datasets.samples import Samples
from urdf_ik.maps.engine import free_space
from urdf_ik.maps.engine.store_folder import finished, read_question
from urdf_ik.maps.engine.zarr_reader import MAX_CHUNK, OpenedGroup
from urdf_ik.support import files, inputs
from urdf_ik.support.files import name_of
from urdf_ik.support.text import quoted

FORMAT, VERSION = "urdf-ik samples", 1
_COLUMNS = frozenset(each.name for each in fields(Samples))


class StoredSamples:
    """A data set in a Zarr group or in Parquet files, which any reader of these formats takes, too.

    Attributes:
        path: the store.
        about: what the samples are of, as the store's question says.
        n: number of samples.
        chunk: samples of a chunk.
        columns: names of the arrays.

    Raises:
        JobError: there is no such store, or it is damaged.

    Example:
        >>> import urdf_ik
        >>> made = urdf_ik.maps.dataset(urdf_ik.load("zyyzyz_6r"), 100, store="samples.parquet")
        >>> found = StoredSamples("samples.parquet")
        >>> found.n, found.about["robot"], found.complete
        (100, 'zyyzyz_6r', True)
    """

    def __init__(self, path: str | os.PathLike[str]) -> None:
        self.path = inputs.path(path, "path", JobError)
        self.about = read_question(self.path)
        if self.about.get("format") != FORMAT or self.about.get("version") != VERSION:
            found = f"{quoted(self.about.get('format'))}, version {self.about.get('version')}"
            raise JobError(f"{self.path} holds no samples that this package reads: it is of the format {found}")
        self.n = inputs.whole(self.about.get("n"), "n", JobError, low=1, high=2**53)
        self.chunk = inputs.whole(self.about.get("chunk"), "chunk", JobError, low=1, high=2**53)
        columns = inputs.items(self.about.get("columns"), "columns", "names of arrays", JobError)
        if unknown := [name for name in columns if not isinstance(name, str) or name not in _COLUMNS]:
            raise JobError(f"{name_of(self.path)} is a damaged store: there is no column {quoted(unknown[0])}")
        if not {"robot", "joints", "branches"} <= set(self.about):
            raise JobError(f"{name_of(self.path)} is a damaged store: it does not say what the samples are of")
        self.columns: tuple[str, ...] = columns

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
            JobError: a chunk of them is not there, or damaged.

        Example:
            >>> import urdf_ik
            >>> made = urdf_ik.maps.dataset(urdf_ik.load("zyyzyz_6r"), 100, store="samples.zarr", chunk=30)
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
            raise JobError(
                f"{self.path} is not complete: {len(missing)} of the {len(wanted)} chunks that are asked for are not "
                "made yet; run what makes it again, with the same store"
            )
        try:
            found = self._zarr(start, end) if self.path.suffix == ".zarr" else self._parquet(wanted, start, end)
            for name in ("within", "collision"):
                if name in found:
                    found[name] = found[name].astype(np.bool_)
            return Samples(**{"collision": None, **found})
        except UrdfIkError:
            raise
        except Exception as error:  # Arrow and NumPy each have their own ways to say that a file is damaged
            if isinstance(error, OSError) and error.strerror:
                raise JobError(f"{name_of(self.path)}: cannot read it: {error.strerror}") from None
            reason = printable(f"{type(error).__name__} {error}", 200)
            raise JobError(
                f"{name_of(self.path)} is damaged ({reason}); the run that made it makes what is damaged again"
            ) from None

    def __iter__(self) -> Iterator[Samples]:
        """The samples chunk by chunk."""
        for start in range(0, self.n, self.chunk):
            yield self.read(start, min(start + self.chunk, self.n))

    def _zarr(self, start: int, stop: int) -> dict[str, Any]:
        group, most = OpenedGroup(self.path), free_space.available_memory()
        return {name: group.read(name, (slice(start, stop),), most) for name in self.columns}

    def _parquet(self, wanted: range, start: int, stop: int) -> dict[str, Any]:
        parquet = import_module("pyarrow.parquet")
        joints, branches = len(self.about["joints"]), len(self.about["branches"])
        shapes = {"T": (4, 4), "solutions": (branches, joints)}
        found: dict[str, list[Any]] = {name: [] for name in self.columns}
        for chunk in wanted:
            part = self.path / f"part-{chunk:08}.parquet"
            files.require_regular(part, JobError)
            with files.opened(part) as data:  # Arrow takes no names that are not UTF-8
                file = parquet.ParquetFile(data)
                groups = [file.metadata.row_group(k) for k in range(file.metadata.num_row_groups)]
                if file.metadata.num_rows > self.chunk or sum(each.total_byte_size for each in groups) > MAX_CHUNK:
                    raise JobError(f"{name_of(self.path)}: part {chunk} holds more than {self.chunk} samples or 1 GiB")
                table = file.read(columns=list(self.columns))
            for name in self.columns:
                column = table.column(name).combine_chunks()
                listed = hasattr(column, "flatten") and hasattr(column.type, "list_size")
                values = (column.flatten() if listed else column).to_numpy(zero_copy_only=False)
                width = (column.type.list_size,) if listed else ()
                found[name].append(values.reshape(-1, *shapes.get(name, width)))
        first = wanted.start * self.chunk
        return {name: np.concatenate(parts)[start - first : stop - first] for name, parts in found.items()}
