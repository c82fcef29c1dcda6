"""Reading and writing of files, with errors of this package; a file is replaced when the new one is whole."""

import json
import os
import secrets
import shutil
import sys
from collections.abc import Callable
from pathlib import Path
from typing import IO, Any

from urdf_ik.errors import ArgumentError, UrdfIkError, printable

STDIN = "standard input"
_QUOTED = 200
"""Greatest length of a path in a message [characters]."""


def name_of(source: Any) -> str:
    """A path, or a file that is open, as messages call it."""
    if not hasattr(source, "read"):
        return printable(source, _QUOTED)
    stdin = source is getattr(sys.stdin, "buffer", sys.stdin)
    return STDIN if stdin else printable(getattr(source, "name", "the file"), _QUOTED)


def read(source: Any, error: Callable[[str], UrdfIkError] = ArgumentError) -> bytes:
    """All bytes of a path, or of a file open for reading; ``error`` is raised where it cannot be read."""
    try:
        data = source.read() if hasattr(source, "read") else Path(source).read_bytes()
    except (OSError, ValueError) as failure:  # ValueError: null bytes in the name, a closed file, no UTF-8
        raise error(f"cannot read {name_of(source)}: {getattr(failure, 'strerror', None) or failure}") from None
    return data.encode(errors="surrogatepass") if isinstance(data, str) else bytes(data)


def document(text: str, what: str, version: int, error: Callable[[str], UrdfIkError]) -> dict[str, Any]:
    """The object of a JSON text whose 'format' is ``what``, of a version; ``error`` is raised for any other text."""
    kind = what.removeprefix("urdf-ik ")
    try:
        data = json.loads(text)
    except (ValueError, RecursionError) as failure:
        raise error(f"no {kind}: {printable(failure, _QUOTED)}") from None
    if not isinstance(data, dict) or data.get("format") != what:
        raise error(f'no {kind}: it has no "format": "{what}"')
    if data.get("version") != version:
        raise error(f"a {kind} of version {data.get('version')!r}; this release reads version {version}")
    return data


def writable(path: str | os.PathLike[str]) -> Path:
    """The path of a file that may be written: no folder, in a folder that is there."""
    file = Path(path)
    if file.is_dir():
        raise ArgumentError(f"cannot write {name_of(file)}: it is a folder")
    if not file.parent.is_dir():
        raise ArgumentError(f"cannot write {name_of(file)}: there is no folder {name_of(file.parent)}")
    return file


def write(path: str | os.PathLike[str], content: bytes | Callable[[IO[bytes]], object]) -> None:
    """Write a file; one that is there already is replaced when the new one is whole, and not before.

    ``content``: bytes, or the function that writes them to an open file. A device or a pipe is written as it is; a
    link is followed. Where it cannot be written, the error names the folder.
    """
    file = writable(path)
    try:
        target = Path(os.path.realpath(file))
        if target.exists() and not target.is_file():
            _put(target, content)
            return
        unfinished = target.with_name(f".{os.getpid()}-{secrets.token_hex(4)}.unfinished")
        try:
            _put(unfinished, content)
            if target.exists():
                shutil.copymode(target, unfinished)
            unfinished.replace(target)
        finally:
            unfinished.unlink(missing_ok=True)
    except OSError as failure:
        reason = f"{failure.strerror or failure} (folder {name_of(file.parent.absolute())})"
        raise ArgumentError(f"cannot write {name_of(file)}: {reason}") from None


def _put(target: Path, content: bytes | Callable[[IO[bytes]], object]) -> None:
    with target.open("wb") as file:
        if isinstance(content, bytes):
            file.write(content)
        else:
            content(file)
