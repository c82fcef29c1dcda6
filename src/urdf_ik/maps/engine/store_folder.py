"""Folder: a store on the disk that a long run fills chunk by chunk, and that outlives the run.

The folder ``.urdf-ik`` beside the data holds three files: ``question``, all that the data depend on; ``journal``, the
finished chunks with the digests of their files; and ``lock``, while a run is in progress. A file is written under a
temporary name and then renamed, so that it is never seen half written.
"""

from __future__ import annotations

import contextlib
import json
import os
import shutil
from collections.abc import Callable, Mapping
from functools import lru_cache
from pathlib import Path
from typing import Any

from urdf_ik.errors import JobError, printable
from urdf_ik.maps.engine.journal import Journal, Kept, digest
from urdf_ik.maps.engine.store_lock import Lock
from urdf_ik.support import files, inputs
from urdf_ik.support.files import name_of
from urdf_ik.support.text import json_text

PRIVATE = ".urdf-ik"
"""Name of the folder in a store for files that are not data."""
MAX_QUESTION = 2**24
"""Greatest size of a store's question [bytes]."""
MOST_CHUNKS = 100_000
"""Greatest number of chunks of a store, so that its journal stays small."""
MISSING = "not set"
"""Shown in place of a value that only one of two questions has."""

Question = Mapping[str, Any]


class Folder:
    """A store on the disk, held by this run until it is closed.

    Args:
        path: the store's folder; it is made where there is none.
        question: all that the data depend on, as JSON can hold it.
        chunks: number of chunks.
        files: what stands in the store before any chunk, by paths in it.
        last: those of ``files`` that are others when all chunks are there.

    Raises:
        JobError: the folder is no store, is a store of another question, is in use, or cannot be written.

    Example:
        >>> with Folder("numbers", {"what": "squares"}, 2) as store:
        ...     store.keep(1, {"one": b"1"})
        ...     store.pending()
        [0]
        >>> with Folder("numbers", {"what": "squares"}, 2) as store:
        ...     store.pending()
        [0]
    """

    def __init__(
        self,
        path: str | os.PathLike[str],
        question: Question,
        chunks: int,
        files: Mapping[str, bytes] | None = None,
        last: Mapping[str, bytes] | None = None,
    ) -> None:
        self.path = checked_path(path)
        if chunks > MOST_CHUNKS:
            raise JobError(f"{name_of(path)}: {chunks} chunks; at most {MOST_CHUNKS} are made, take larger ones")
        self._last = last or {}
        self.chunks = chunks
        self._own = self.path / PRIVATE
        self._temporary = self._own / "unfinished"
        self._lock = Lock(self._own / "lock")
        asked = json.loads(json_text(dict(question)))
        try:
            if (self._own / "question").exists():
                require_same(self.path, read_question(self.path), asked)
            self._own.mkdir(parents=True, exist_ok=True)
            self._lock.take(str(self.path))
        except OSError as error:
            raise JobError(f"cannot write {self.path}: {error.strerror}") from None
        try:
            shutil.rmtree(self._temporary, ignore_errors=True)
            if not (self._own / "question").exists():
                self._write("question", (self._own / "question"), json_text(asked).encode())
            require_same(self.path, read_question(self.path), asked)
            for name, data in (files or {}).items():
                if not self._holds(name, data) and not self._holds(name, self._last.get(name)):
                    self._write("first", self.path / name, data)
            self._journal = Journal(self._own / "journal")
        except OSError as error:
            self.close()
            raise self._cannot_write(error) from None
        except BaseException:
            self.close()
            raise

    def __enter__(self) -> Folder:
        return self

    def __exit__(self, *error: object) -> None:
        self.close()

    def close(self) -> None:
        """Let another run in.

        Example:
            >>> store = Folder("numbers", {"what": "squares"}, 2)
            >>> store.close()
        """
        shutil.rmtree(self._temporary, ignore_errors=True)
        self._lock.release()

    def pending(self, tick: Callable[[int, int], object] | None = None) -> list[int]:
        """The chunks that are not finished, after reading all files of those that are.

        A chunk of which a file is missing, or whose bytes are no longer those that were written, is not finished.

        Args:
            tick: called with the number of chunks that were looked at, and of all.

        Example:
            >>> with Folder("others", {"what": "cubes"}, 2) as store:
            ...     store.pending()
            [0, 1]
        """
        left = []
        for chunk in range(self.chunks):
            files = self._journal.chunks.get(chunk)
            if files is None or not all(self._is_whole(path, kept) for path, kept in files.items()):
                left.append(chunk)
            if tick is not None:
                tick(chunk + 1, self.chunks)
        return left

    def keep(self, chunk: int, files: Mapping[str, bytes]) -> None:
        """Write the files of a chunk, by their paths in the store, and note it as finished.

        Raises:
            JobError: the disk is full, or cannot be written; the chunk then counts as not finished.

        Example:
            >>> with Folder("numbers", {"what": "squares"}, 1) as store:
            ...     store.keep(0, {"zero": b"0"})
            ...     store.pending()
            []
        """
        try:
            for name, data in files.items():
                self._write(str(chunk), self.path / name, data)
            self._journal.add(chunk, {name: Kept(len(data), digest(data)) for name, data in files.items()})
        except OSError as error:
            raise self._cannot_write(error) from None

    def finish(self) -> None:
        """All chunks are finished: write the last files, and put the journal in order.

        Raises:
            JobError: the disk is full, or cannot be written.

        Example:
            >>> with Folder("numbers", {"what": "squares"}, 1, {"state": b"begun"}, {"state": b"done"}) as store:
            ...     store.keep(0, {"zero": b"0"})
            ...     store.finish()
        """
        try:
            for name, data in self._last.items():
                if not self._holds(name, data):
                    self._write("last", self.path / name, data)
            text = self._journal.text()
            if not self._holds(f"{PRIVATE}/journal", text):
                self._write("journal", self._own / "journal", text)
        except OSError as error:
            raise self._cannot_write(error) from None

    def _holds(self, name: str, data: bytes | None) -> bool:
        """Whether a file has these bytes."""
        try:
            return data is not None and files.read(self.path / name, JobError) == data
        except JobError:
            return False

    def _write(self, name: str, target: Path, data: bytes) -> None:
        """Write a file whole or not at all."""
        self._temporary.mkdir(exist_ok=True)
        unfinished = self._temporary / name
        try:
            with unfinished.open("wb", buffering=0) as file:
                written = file.write(data)
                while written < len(data):
                    written += file.write(data[written:])
            target.parent.mkdir(parents=True, exist_ok=True)
            unfinished.replace(target)
        except OSError:
            with contextlib.suppress(OSError):
                unfinished.unlink()
            raise

    def _is_whole(self, path: str, kept: Kept) -> bool:
        try:
            data = files.read(self.path / path, JobError)
        except JobError:
            return False
        return len(data) == kept.size and digest(data) == kept.digest

    def _cannot_write(self, error: OSError) -> JobError:
        journal = getattr(self, "_journal", None)
        done = 0 if journal is None else len(journal.chunks)
        return JobError(
            f"cannot write {self.path}: {error.strerror}; {done} of {self.chunks} chunks are kept, and the same run "
            "goes on from there when it can write"
        )


def checked_path(path: str | os.PathLike[str]) -> Path:
    """The path of a store to be made or gone on with.

    Raises:
        JobError: it is an address, its folder is missing, or something else is there already.

    Example:
        >>> checked_path("map.zarr").name
        'map.zarr'
    """
    store = inputs.path(path, "path", JobError)
    name = name_of(store)
    if "://" in str(path):
        raise JobError(f"{name}: a store is a folder on a disk; give a path")
    parent = Path(os.path.realpath(store)).parent  # resolve() raises where links lead round in a circle
    if not os.path.isdir(parent):
        raise JobError(f"{name}: there is no folder {name_of(parent)}")
    if os.path.exists(store) and not os.path.isdir(store):
        raise JobError(f"{name} is a file, and a store is a folder; give another path")
    try:
        if os.path.isdir(store) and not os.path.isdir(store / PRIVATE) and any(store.iterdir()):
            raise JobError(f"{name} is there already, and is no store of this package; give another path")
    except OSError as error:
        raise JobError(f"cannot read {name}: {error.strerror}") from None
    return store


def read_question(path: Path) -> dict[str, Any]:
    """What a store is of.

    Raises:
        JobError: it is no store, or its question cannot be read.

    Example:
        >>> with Folder("numbers", {"what": "squares"}, 1):
        ...     read_question(Path("numbers"))
        {'what': 'squares'}
    """
    file = path / PRIVATE / "question"
    if not os.path.lexists(file):
        raise JobError(f"{name_of(path)} is no store of this package: there is no {name_of(file)}")
    try:
        found = json.loads(files.read(file, JobError))
    except (ValueError, RecursionError) as error:
        if isinstance(error, JobError):
            raise
        raise JobError(f"{name_of(path)} is a damaged store: {name_of(file)}: {printable(error, 200)}") from None
    if not isinstance(found, dict):
        raise JobError(f"{name_of(path)} is a damaged store: {name_of(file)} holds no JSON object")
    return found


def finished(path: Path) -> frozenset[int]:
    """The chunks of a store that its journal calls finished; their files are not read.

    Example:
        >>> with Folder("odd", {"what": "squares"}, 2) as store:
        ...     store.keep(1, {"one": b"1"})
        >>> sorted(finished(Path("odd")))
        [1]
    """
    journal = path / PRIVATE / "journal"
    try:
        state = os.stat(journal)
    except OSError:
        return frozenset()
    return _finished(journal, state.st_ino, state.st_mtime_ns, state.st_size)


@lru_cache(maxsize=16)
def _finished(journal: Path, *state: int) -> frozenset[int]:
    """The same of a journal in one state: whoever reads a store block by block asks at each of them."""
    return frozenset(Journal(journal).chunks)


def require_same(path: Path, stored: Question, asked: Question) -> None:
    """Refuse a store of another question, with what differs.

    Raises:
        JobError: it does.

    Example:
        >>> require_same(Path("numbers"), {"what": "squares"}, {"what": "squares"})
    """
    one, other = _flat(stored), _flat(asked)
    differing = [
        f"{name} is {_short(one.get(name, MISSING))} in the store and {_short(other.get(name, MISSING))} now"
        for name in {**other, **one}
        if one.get(name, MISSING) != other.get(name, MISSING)
    ]
    if differing:
        more = f", and {len(differing) - 4} more differ" if len(differing) > 4 else ""
        raise JobError(
            f"{path} holds something else: {'; '.join(differing[:4])}{more}; give another path, or ask as before"
        )


def _short(text: str) -> str:
    return text if len(text) <= 72 else f"{text[:68]} ..."


def _flat(value: Any, name: str = "") -> dict[str, str]:
    """The leaves of nested dictionaries, by their names with dots, as JSON."""
    if not isinstance(value, Mapping):
        return {name: json.dumps(value)}
    return {
        key: text
        for inner, each in value.items()
        for key, text in _flat(each, f"{name}.{inner}" if name else inner).items()
    }
