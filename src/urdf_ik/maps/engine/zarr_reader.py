"""OpenedGroup: reads Zarr groups of unknown origin; sizes are bounded, codecs are this package's, pickle is refused."""

from __future__ import annotations

import math
import os
import struct
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from urdf_ik.errors import JobError, UrdfIkError, printable
from urdf_ik.maps.engine import zarr_writer
from urdf_ik.support import files
from urdf_ik.support.text import quoted

MAX_METADATA = 2**24
"""Greatest size of a group's metadata [bytes]."""
MAX_CHUNK = 2**30
"""Bytes that a chunk of an array may unpack to."""
_MOST_CHUNKS = 2**22
"""Chunks that one question may look at."""
_CODECS = ["BytesCodec", "ZstdCodec", "Crc32cCodec"]
_ZSTD = b"\x28\xb5\x2f\xfd"


class OpenedGroup:
    """The arrays of a group.

    Args:
        folder: the group.

    Raises:
        JobError: it cannot be read, or its metadata are too large or damaged.

    Example:
        >>> from urdf_ik.maps.engine import Folder
        >>> made = zarr_writer.group_files((), (zarr_writer.Coordinate("x", ("x",), np.arange(3.0)),), {})
        >>> with Folder("axis.zarr", {"what": "an axis"}, 0, made):
        ...     OpenedGroup(Path("axis.zarr")).read("x").tolist()
        [0.0, 1.0, 2.0]
    """

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        files.read(folder / "zarr.json", JobError)
        try:
            self._group = zarr_writer.package().open_group(str(folder), mode="r", zarr_format=3, use_consolidated=True)
        except UrdfIkError:
            raise
        except Exception as error:  # Zarr, JSON and NumPy each have their own ways to say that a file is damaged
            raise self._damaged("its metadata", error) from None

    def shape(self, name: str) -> tuple[int, ...]:
        """Lengths of an array along its dimensions.

        Raises:
            JobError: there is no such array, or it is damaged.
        """
        return tuple(int(length) for length in self._array(name).shape)

    def nbytes(self, name: str) -> int:
        """Bytes of an array in memory.

        Raises:
            JobError: there is no such array, or it is damaged.
        """
        found = self._array(name)
        return int(math.prod(found.shape) * np.dtype(found.dtype).itemsize)

    def read(self, name: str, part: tuple[slice, ...] | None = None, most: int = MAX_CHUNK) -> NDArray[Any]:
        """An array, or a part of it: a slice for each of its leading dimensions.

        Raises:
            JobError: there is no such array, it is larger than ``most`` bytes, or it is damaged.
        """
        found = self._array(name)
        try:
            given = part or ()
            whole = (*given, *(slice(None),) * (len(found.shape) - len(given)))
            spans = [each.indices(length)[:2] for each, length in zip(whole, found.shape, strict=True)]
            size = math.prod(max(0, end - start) for start, end in spans) * np.dtype(found.dtype).itemsize
            if size > most:
                raise JobError(f"{self._name}: {printable(name)} takes {size} bytes; at most {most} are read at once")
            self._look_at_chunks(name, found, spans)
            return np.asarray(found[tuple(slice(start, end) for start, end in spans)])
        except UrdfIkError:
            raise
        except Exception as error:  # the same of its chunks
            raise self._damaged(printable(name), error) from None

    @property
    def _name(self) -> str:
        return files.name_of(self._folder)

    def _damaged(self, what: str, error: Exception) -> JobError:
        if isinstance(error, OSError) and error.strerror:
            return JobError(f"{self._name}: cannot read {what}: {error.strerror}")
        reason = printable(f"{type(error).__name__} {error}", 200)
        return JobError(f"{self._name}: {what} is damaged ({reason}); the run that made it makes what is damaged again")

    def _array(self, name: str) -> Any:
        try:
            found = self._group[name]
            codecs = [type(each).__name__ for each in found.metadata.codecs]
            kind, chunk = np.dtype(found.dtype), math.prod(found.chunks) * np.dtype(found.dtype).itemsize
        except Exception as error:  # the same of its metadata
            raise self._damaged(printable(name), error) from None
        if codecs != _CODECS or kind.kind not in "fiub" or not 0 < chunk <= MAX_CHUNK:
            raise JobError(
                f"{self._name}: {printable(name)} is no array of this package: chunks of {chunk} bytes, type {kind}, "
                f"codecs {quoted(codecs)}"
            )
        return found

    def _look_at_chunks(self, name: str, found: Any, spans: list[tuple[int, int]]) -> None:
        """Refuse chunks that unpack to more than they should, before they are unpacked."""
        size = math.prod(found.chunks) * np.dtype(found.dtype).itemsize
        ranges = [range(start // side, -(-end // side)) for (start, end), side in zip(spans, found.chunks, strict=True)]
        if math.prod(map(len, ranges)) > _MOST_CHUNKS:
            raise JobError(f"{self._name}: {printable(name)} is cut into more than {_MOST_CHUNKS} chunks")
        for place in np.ndindex(*map(len, ranges)):
            numbers = "/".join(str(span[k]) for span, k in zip(ranges, place, strict=True))
            file = self._folder / name / "c" / numbers
            if os.path.lexists(file):
                with file.open("rb") as data:
                    unpacked = _unpacked(data.read(18))
                if unpacked != size:
                    raise JobError(
                        f"{self._name}: {printable(name)} is damaged: chunk {numbers} unpacks to {unpacked} bytes, not "
                        f"{size}; the run that made it makes what is damaged again"
                    )


def _unpacked(head: bytes) -> int | None:
    """Bytes that Zstandard's frame unpacks to, as its head says (RFC 8878, 3.1.1.1); None where it does not say."""
    if len(head) < 6 or head[:4] != _ZSTD:
        return None
    flags = head[4]
    single = bool(flags & 0x20)
    at = 5 + (not single) + (0, 1, 2, 4)[flags & 3]
    width = (1 if single else 0, 2, 4, 8)[flags >> 6]
    if not width or len(head) < at + width:
        return None
    value = int(struct.unpack("<" + {1: "B", 2: "H", 4: "I", 8: "Q"}[width], head[at : at + width])[0])
    return value + 256 if width == 2 else value
