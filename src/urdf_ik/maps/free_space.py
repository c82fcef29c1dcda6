"""Free memory and disk space, and the check that a result fits."""

from __future__ import annotations

import contextlib
import os
import shutil
from pathlib import Path

from urdf_ik.errors import ArgumentError, JobError


def available_memory() -> int:
    """Bytes of memory that are free without swapping."""
    import psutil  # only long work needs it

    free = [int(psutil.virtual_memory().available)]
    group = Path("/sys/fs/cgroup")
    with contextlib.suppress(OSError, ValueError):  # a container's own limit, where there is one
        free.append(int((group / "memory.max").read_text()) - int((group / "memory.current").read_text()))
    return max(0, min(free))


def free_disk(folder: Path) -> int:
    """Bytes that the disk of a folder has free."""
    return shutil.disk_usage(folder).free


def require_memory(needed: int, what: str, hint: str) -> None:
    """Refuse a result that does not fit in memory, before any work.

    Args:
        needed: size of the result [bytes].
        what: the results and their number, in the plural.
        hint: a change that makes it fit.

    Raises:
        ArgumentError: it does not fit; with the numbers.
    """
    free = available_memory()
    if needed > free:
        raise ArgumentError(f"{what} take {size_text(needed)} of memory, and {size_text(free)} are free; {hint}")


def require_disk(place: Path, needed: int, what: str, hint: str) -> None:
    """Refuse a result that does not fit on the disk of the file or folder ``place``, before any work.

    Raises:
        JobError: it does not fit, with the numbers; or there is no such folder.
    """
    folder = Path(os.path.realpath(place)).parent
    if not folder.is_dir():
        raise JobError(f"{place}: there is no folder {folder}")
    free = free_disk(folder)
    if needed > free:
        there = f"{folder} has {size_text(free)} free"
        raise JobError(f"{what} take up to {size_text(needed)} on the disk, and {there}; {hint}")


def size_text(count: int) -> str:
    """A number of bytes in GiB or MiB."""
    return f"{count / 2**30:.3g} GiB" if count >= 2**29 else f"{count / 2**20:.3g} MiB"
