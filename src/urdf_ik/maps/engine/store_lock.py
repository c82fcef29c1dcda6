"""Lock: a locked file in a store, which names the run in progress; a second run is refused."""

from __future__ import annotations

import contextlib
import fcntl
import json
import os
import socket
import time
from pathlib import Path

from urdf_ik.errors import JobError


class Lock:
    """A file that says which process works in a folder, locked by the kernel for as long as that process lives.

    A killed process leaves the file, but not the kernel's lock: the next run on that machine takes it over. The file of
    another machine, whose processes are not visible from here, stays in force until a user deletes it.

    Args:
        path: the file; its folder is there.

    Example:
        >>> from pathlib import Path
        >>> lock = Lock(Path("lock"))
        >>> lock.take("map.zarr")
        >>> lock.release()
    """

    def __init__(self, path: Path) -> None:
        self._path = path
        self._file: int | None = None

    def take(self, name: str) -> None:
        """Hold the lock from now on.

        Raises:
            JobError: another run holds it; ``name`` is what the message calls the store.
        """
        while True:
            file = os.open(self._path, os.O_RDWR | os.O_CREAT, 0o644)
            try:
                fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except OSError:
                holder = _read(file)
                os.close(file)
                raise JobError(f"{name} is in use by another run{_who(holder)}; wait for it, or end it") from None
            # A run that has just ended deletes the file: what is locked must be the one that others see.
            if _is(self._path, file):
                break
            os.close(file)
        holder = _read(file)
        if holder.get("host") not in (None, socket.gethostname()):
            os.close(file)
            raise JobError(
                f"{name} is in use by another run{_who(holder)}, which cannot be seen from here; if that run is gone, "
                f"delete {self._path}"
            )
        self._file = file
        text = json.dumps({"pid": os.getpid(), "host": socket.gethostname(), "since": time.strftime("%F %T %z")})
        with contextlib.suppress(OSError):  # a full disk: the kernel's lock holds without the words
            os.ftruncate(file, 0)
            os.pwrite(file, text.encode(), 0)

    def release(self) -> None:
        """Let the next run in."""
        if self._file is not None:
            self._path.unlink(missing_ok=True)
            os.close(self._file)
            self._file = None


def _read(file: int) -> dict[str, object]:
    """The contents of a lock file; {} if it is empty or unreadable."""
    try:
        found = json.loads(os.pread(file, 4096, 0))
    except (OSError, ValueError):
        return {}
    return found if isinstance(found, dict) else {}


def _who(holder: dict[str, object]) -> str:
    if not holder:
        return ""
    return f", process {holder.get('pid')} on {holder.get('host')} since {holder.get('since')}"


def _is(path: Path, file: int) -> bool:
    """Whether the file that is open is still the one at ``path``."""
    try:
        return os.path.samestat(os.stat(path), os.fstat(file))
    except FileNotFoundError:
        return False
