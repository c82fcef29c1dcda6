"""The journal of a store: which chunks are finished, and the size and digest of each of their files.

A line is the chunk's number, its files as JSON, ``{path: [bytes, digest]}``, and a checksum of both. Lines are only
appended, each in one write. A line that a kill or a full disk cut short fails its checksum and is ignored.
When all chunks are finished the lines are put in order, so that the journals of two runs are the same.
"""

from __future__ import annotations

import hashlib
import json
import os
import zlib
from pathlib import Path
from typing import NamedTuple

from urdf_ik.errors import JobError
from urdf_ik.support import files

MAX_BYTES = 2**27
"""Greatest size of a journal [bytes]."""


class Kept(NamedTuple):
    """A file that was written.

    Attributes:
        size: bytes.
        digest: of the bytes, see :func:`digest`.
    """

    size: int
    digest: str


def digest(data: bytes) -> str:
    """BLAKE2 of some bytes, 16 bytes of it in hexadecimal.

    Example:
        >>> digest(b"")
        'cae66941d9efbd404e4d88758ea67670'
    """
    return hashlib.blake2b(data, digest_size=16).hexdigest()


class Journal:
    """The finished chunks, in a file.

    Args:
        path: the file; a missing one is an empty one.
    """

    def __init__(self, path: Path) -> None:
        self._path = path
        self._good = 0  # bytes of whole lines
        self.chunks: dict[int, dict[str, Kept]] = {}
        text = files.read(path, JobError) if os.path.lexists(path) else b""
        for line in text.splitlines(keepends=True):
            entry = _parsed(line)
            if entry is None:
                break
            self.chunks[entry[0]] = entry[1]
            self._good += len(line)

    def add(self, chunk: int, files: dict[str, Kept]) -> None:
        """A chunk is finished.

        Raises:
            OSError: the line cannot be written; the journal is then as it was.
        """
        line = _line(chunk, files)
        file = os.open(self._path, os.O_WRONLY | os.O_CREAT, 0o644)
        try:
            os.ftruncate(file, self._good)  # without the half line of a run that was killed
            written = 0
            try:
                while written < len(line):
                    written += os.pwrite(file, line[written:], self._good + written)
            except OSError:
                os.ftruncate(file, self._good)
                raise
        finally:
            os.close(file)
        self._good += len(line)
        self.chunks[chunk] = files

    def text(self) -> bytes:
        """All lines, in the order of the chunks."""
        return b"".join(_line(chunk, self.chunks[chunk]) for chunk in sorted(self.chunks))


def _line(chunk: int, files: dict[str, Kept]) -> bytes:
    body = f"{chunk}\t{json.dumps(files, sort_keys=True)}"
    return f"{body}\t{zlib.crc32(body.encode()):08x}\n".encode()


def _parsed(line: bytes) -> tuple[int, dict[str, Kept]] | None:
    """The chunk and its files, None for a line that is not whole."""
    body, tab, check = line.rstrip(b"\n").rpartition(b"\t")
    if not tab or not line.endswith(b"\n") or check != f"{zlib.crc32(body):08x}".encode():
        return None
    chunk, _, listed = body.partition(b"\t")
    try:
        found = {path: Kept(int(size), str(check)) for path, (size, check) in json.loads(listed).items()}
        return int(chunk), found
    except (AttributeError, TypeError, ValueError, RecursionError):  # a checksum alone makes no journal
        return None
