"""File access: reads are bounded and never wait for the writer of a pipe; writes are atomic."""

from __future__ import annotations

import contextlib
import os
import secrets
import stat
import sys
from collections.abc import Callable
from pathlib import Path
from typing import IO, Any

from urdf_ik.errors import ArgumentError, UrdfIkError, printable
from urdf_ik.support import inputs

STDIN = "standard input"
_QUOTED = 200
"""Greatest length of a path in a message [characters]."""


def name_of(path: object) -> str:
    r"""A path as messages call it.

    Example:
        >>> name_of("a\nb.csv")
        'a\\nb.csv'
    """
    return printable(path, _QUOTED)


def called(file: Any) -> str:
    """A file that is open as messages call it.

    Example:
        >>> import io
        >>> called(io.BytesIO(b""))
        'the file'
    """
    stdin = file is getattr(sys.stdin, "buffer", sys.stdin)
    return STDIN if stdin else name_of(getattr(file, "name", "the file"))


def opened(path: Path) -> IO[bytes]:
    """A file open for reading; a pipe without a writer is empty at once.

    Raises:
        OSError: it cannot be opened.
        ValueError: its name holds a null byte.

    Example:
        >>> _ = Path("poses.csv").write_bytes(b"x,y,z")
        >>> with opened(Path("poses.csv")) as file:
        ...     file.read()
        b'x,y,z'
    """

    def at_once(name: str, flags: int) -> int:
        # Without O_NONBLOCK, opening a named pipe waits for its first writer.
        found = os.open(name, flags | os.O_NONBLOCK)
        os.set_blocking(found, True)
        return found

    return open(path, "rb", opener=at_once if os.name == "posix" else None)


def require_regular(path: Path, error: Callable[[str], UrdfIkError] = ArgumentError) -> None:
    """Refuse a missing file, and pipes and devices, on which other packages would block or read without end.

    Raises:
        UrdfIkError: ``error``; there is no regular file of this name.

    Example:
        >>> require_regular(Path("missing.parquet"))
        Traceback (most recent call last):
        urdf_ik.errors.ArgumentError: cannot read missing.parquet: there is no such file
    """
    if not os.path.isfile(path):
        problem = "it is no regular file" if os.path.lexists(path) else "there is no such file"
        raise error(f"cannot read {name_of(path)}: {problem}")


def read(source: Any, most: int, error: Callable[[str], UrdfIkError] = ArgumentError) -> bytes:
    """All of a file of at most ``most`` bytes; of a larger one no more than that is read.

    Args:
        source: a path, or a file open for reading, of bytes or text.
        most: greatest size [bytes].
        error: what is raised.

    Raises:
        UrdfIkError: ``error``; it cannot be read, or is larger.

    Example:
        >>> Path("poses.csv").write_bytes(b"x,y,z") and read(Path("poses.csv"), 10)
        b'x,y,z'
    """
    is_open = hasattr(source, "read") and not isinstance(source, type)
    name = called(source) if is_open else name_of(source)
    where = None if is_open else inputs.path(source, "path", error)
    try:
        if where is None:
            data = from_open(source, most)
        else:
            with opened(where) as file:
                data = file.read(most + 1)
    except (OSError, ValueError, TypeError) as failure:  # null bytes, a closed file, no UTF-8, no file
        raise error(f"cannot read {name}: {getattr(failure, 'strerror', None) or failure}") from None
    if not isinstance(data, str | bytes):
        raise error(f"cannot read {name}: its read() gave {type(data).__name__}; it must give bytes or text")
    found = data.encode(errors="surrogatepass") if isinstance(data, str) else data
    if len(found) > most:
        raise error(f"{name} is larger than {_size(most)}; no more is read")
    return found


def from_open(file: Any, most: int) -> Any:
    """The contents of an open file, up to a little more than ``most`` bytes or characters.

    Example:
        >>> import io
        >>> from_open(io.BytesIO(b"x,y,z"), 2)
        b'x,y'
    """
    try:
        data = file.read(most + 1)
    except TypeError:  # an object whose read() takes no size
        return file.read()
    parts, count = [data], most
    # One read of a pipe may return fewer bytes than requested.
    while isinstance(data, str | bytes) and data and (count := count - len(data)) >= 0:
        data = file.read(count + 1)
        parts.append(data)
    return parts[0][:0].join(parts) if all(isinstance(part, type(parts[0])) for part in parts[1:]) else data


def _size(count: int) -> str:
    return f"{count >> 20} MiB" if count >= 2**20 else f"{count} bytes"


def writable(path: str | os.PathLike[str], error: Callable[[str], UrdfIkError] = ArgumentError) -> Path:
    """The path of a file that may be written; whether the disk takes it is seen when it is written.

    Raises:
        UrdfIkError: ``error``; it is no path, is a folder, or its folder is not there.

    Example:
        >>> writable("missing/plan.csv")
        Traceback (most recent call last):
        urdf_ik.errors.ArgumentError: cannot write missing/plan.csv: there is no folder missing
    """
    file = inputs.path(path, "path", error)
    try:
        problem = ""
        if file.is_dir():
            problem = "it is a folder"
        elif not file.parent.is_dir():
            problem = f"there is no folder {name_of(file.parent)}"
    except OSError as failure:
        problem = str(failure.strerror or failure)
    except ValueError as failure:
        problem = str(failure)
    if problem:
        raise error(f"cannot write {name_of(file)}: {problem}")
    return file


def write(
    path: str | os.PathLike[str],
    content: bytes | Callable[[IO[bytes]], object],
    error: Callable[[str], UrdfIkError] = ArgumentError,
) -> None:
    """Write a file; one that is there already is replaced when the new one is whole, and not before.

    Args:
        path: the file. A device or a pipe is written as it is; a link is followed.
        content: its bytes, or what writes them to an open file.
        error: what is raised.

    Raises:
        UrdfIkError: ``error``; it cannot be written, and the message names the folder.

    Example:
        >>> write("plan.csv", b"waypoint,branch")
        >>> Path("plan.csv").read_text()
        'waypoint,branch'
    """
    file = writable(path, error)
    try:
        target, there = Path(os.path.realpath(file)), _status(file)
        if there is not None and not stat.S_ISREG(there.st_mode):
            # A pipe that nobody reads is refused instead of waited for.
            _put(target, content, getattr(os, "O_NONBLOCK", 0))
            return
        unfinished = target.with_name(f".{os.getpid()}-{secrets.token_hex(4)}.unfinished")
        try:
            _put(unfinished, content, os.O_CREAT | os.O_EXCL)
            if there is not None:
                unfinished.chmod(stat.S_IMODE(there.st_mode))
            unfinished.replace(target)
        except PermissionError:  # a folder that takes no new files may hold one that can be written
            if there is None:
                raise
            _put(target, content, os.O_TRUNC)
        finally:
            with contextlib.suppress(OSError):
                unfinished.unlink(missing_ok=True)
    except (OSError, ValueError) as failure:  # ValueError: a name that no file system can hold
        reason = getattr(failure, "strerror", None) or failure
        raise error(f"cannot write {name_of(file)}: {reason} (folder {name_of(file.parent.absolute())})") from None


def _status(file: Path) -> os.stat_result | None:
    try:
        return file.stat()
    except FileNotFoundError:
        return None


def _put(target: Path, content: bytes | Callable[[IO[bytes]], object], flags: int) -> None:
    found = os.open(target, os.O_WRONLY | flags | getattr(os, "O_BINARY", 0), 0o666)
    if os.name == "posix":
        os.set_blocking(found, True)
    with open(found, "wb") as file:
        if isinstance(content, bytes):
            file.write(content)
        else:
            content(file)
