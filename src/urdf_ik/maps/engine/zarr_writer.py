"""The files of Zarr groups with dimensions as xarray names them: metadata first, then chunk by chunk.

Every array is cut into chunks along its leading dimensions, compressed by Zstandard, and each chunk ends with a CRC-32C
checksum, which every Zarr reader checks. The metadata of all arrays stand once more in the group's, so that opening a
group takes one file. The format is Zarr's third.
"""

from __future__ import annotations

import json
import struct
import warnings
from collections.abc import Mapping
from dataclasses import dataclass, field
from importlib import import_module
from typing import Any

import numpy as np
from numpy.typing import NDArray

from urdf_ik.errors import MissingPackage
from urdf_ik.support.text import plain

INSTALL = "stores need Zarr; install it with: pip install 'urdf-ik[scale]'"
LEVEL = 1
"""Of Zstandard: more takes longer than solving, and saves little."""


@dataclass(frozen=True)
class ArrayPlan:
    """An array of a group that is filled chunk by chunk.

    Attributes:
        name: of the array.
        dimensions: names of its dimensions.
        shape: its lengths along them.
        chunk: lengths of a chunk.
        kind: type of its numbers.
        fill: value where nothing was written, and beyond the end.
        attributes: what is said of it, such as ``units``.
    """

    name: str
    dimensions: tuple[str, ...]
    shape: tuple[int, ...]
    chunk: tuple[int, ...]
    kind: str
    fill: float = 0
    attributes: Mapping[str, Any] = field(default_factory=dict)


@dataclass(frozen=True, eq=False)
class Coordinate:
    """An array of a group that is there from the beginning: what the places along dimensions are.

    Attributes:
        name: of the array; that of its dimension, for what xarray calls an index.
        dimensions: names of its dimensions.
        values: the numbers.
        attributes: what is said of it, such as ``units``.
    """

    name: str
    dimensions: tuple[str, ...]
    values: NDArray[Any]
    attributes: Mapping[str, Any] = field(default_factory=dict)


def package() -> Any:
    """The package ``zarr``.

    Raises:
        MissingPackage: it is not installed.

    Example:
        >>> package().__name__
        'zarr'
    """
    try:
        import zarr
    except ImportError:
        raise MissingPackage(INSTALL) from None
    return zarr


def group_files(
    plans: tuple[ArrayPlan, ...], coordinates: tuple[Coordinate, ...], about: Mapping[str, Any]
) -> dict[str, bytes]:
    """The files of a group without chunks, by their paths in it: metadata, attributes and coordinates.

    Example:
        >>> plan = ArrayPlan("height", ("x",), (4,), (2,), "float32", np.nan, {"units": "m"})
        >>> sorted(group_files((plan,), (Coordinate("x", ("x",), np.arange(4.0)),), {"robot": "none"}))
        ['height/zarr.json', 'x/c/0', 'x/zarr.json', 'zarr.json']
    """
    zarr = package()
    memory: dict[str, Any] = {}
    store = zarr.storage.MemoryStore(store_dict=memory)
    group = zarr.create_group(store, zarr_format=3, attributes=plain(dict(about), nulls=True))
    for each in coordinates:
        group.create_array(
            each.name, data=each.values, dimension_names=each.dimensions, compressors=_codecs(),
            attributes=plain(dict(each.attributes)), config={"write_empty_chunks": True},
        )  # fmt: skip
    for plan in plans:
        _create(group, plan, plan.shape)
    with warnings.catch_warnings():
        # Zarr warns that other readers may not know of it; those find each array's own metadata.
        warnings.simplefilter("ignore")
        zarr.consolidate_metadata(store)
    return {name: buffer.to_bytes() for name, buffer in memory.items()}


def with_attributes(files: Mapping[str, bytes], changes: Mapping[str, Any]) -> dict[str, bytes]:
    """The file with a group's attributes after changes, by its path in the group.

    Example:
        >>> files = group_files((), (), {"complete": False})
        >>> json.loads(with_attributes(files, {"complete": True})["zarr.json"])["attributes"]
        {'complete': True}
    """
    found = json.loads(files["zarr.json"])
    found["attributes"] |= changes
    return {"zarr.json": json.dumps(found, indent=2).encode()}


class Encoder:
    """Makes the files of chunks as Zarr writes them.

    Args:
        plans: the arrays of the group.

    Example:
        >>> encoder = Encoder((ArrayPlan("height", ("x",), (4,), (2,), "float32"),))
        >>> sorted(encoder.files((1,), {"height": np.ones(2, np.float32)}))
        ['height/c/1']
    """

    def __init__(self, plans: tuple[ArrayPlan, ...]) -> None:
        package()
        self._plans = {plan.name: plan for plan in plans}
        self._compress = import_module("numcodecs").Zstd(level=LEVEL).encode
        self._checksum = import_module("google_crc32c").value

    def files(self, place: tuple[int, ...], arrays: Mapping[str, NDArray[Any]]) -> dict[str, bytes]:
        """The files of a chunk of each array, by their paths in the group.

        Args:
            place: number of the chunk along the leading dimensions; it is the first one along the others.
            arrays: the numbers of the chunk, fewer of them at the end of a dimension.

        Example:
            >>> encoder = Encoder((ArrayPlan("height", ("x",), (3,), (2,), "uint8"),))
            >>> sorted(encoder.files((1,), {"height": np.ones(1, np.uint8)}))
            ['height/c/1']
        """
        found = {}
        for name, values in arrays.items():
            plan = self._plans[name]
            whole = np.ascontiguousarray(values, dtype=np.dtype(plan.kind).newbyteorder("<"))
            if values.shape != plan.chunk:
                whole = np.full(plan.chunk, plan.fill, whole.dtype)
                whole[tuple(slice(0, length) for length in values.shape)] = values
            # The steps of ``_codecs``, without Zarr's own way to them, which takes milliseconds.
            packed = bytes(self._compress(whole))
            numbers = (*place, *(0,) * (len(plan.chunk) - len(place)))
            found[f"{name}/c/{'/'.join(map(str, numbers))}"] = packed + struct.pack("<I", self._checksum(packed))
        return found


def _create(group: Any, plan: ArrayPlan, shape: tuple[int, ...]) -> Any:
    return group.create_array(
        plan.name, shape=shape, chunks=plan.chunk, dtype=plan.kind, fill_value=plan.fill, compressors=_codecs(),
        dimension_names=plan.dimensions, attributes=plain(dict(plan.attributes)),
    )  # fmt: skip


def _codecs() -> list[Any]:
    from zarr.codecs import Crc32cCodec, ZstdCodec

    return [ZstdCodec(level=LEVEL), Crc32cCodec()]
