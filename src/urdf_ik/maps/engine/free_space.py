"""Free memory and disk space, and the check that a result fits."""

from __future__ import annotations

import contextlib
import os
import shutil
from pathlib import Path

from urdf_ik.errors import ArgumentError, JobError
from urdf_ik.support.files import name_of


def available_memory() -> int:
    """Bytes of memory that can be had without swapping.

    Example:
        >>> available_memory() > 0
        True
    """
    import psutil  # only long work needs it

    found = [int(psutil.virtual_memory().available)]
    group = Path("/sys/fs/cgroup")
    with contextlib.suppress(OSError, ValueError):  # a container's own limit, where there is one
        found.append(int((group / "memory.max").read_text()) - int((group / "memory.current").read_text()))
    return max(0, min(found))


def free_disk(folder: Path) -> int:
    """Bytes that the disk of a folder has free.

    Example:
        >>> free_disk(Path(".")) > 0
        True
    """
    return shutil.disk_usage(folder).free


def require_memory(needed: int, what: str, hint: str) -> None:
    """Refuse a result that does not fit in memory, before any work.

    Args:
        needed: bytes that it takes.
        what: the results and their number, in the plural.
        hint: what would make it fit.

    Raises:
        ArgumentError: it does not fit; with the numbers.

    Example:
        >>> require_memory(2**70, "10 samples", "take fewer")
        Traceback (most recent call last):
        urdf_ik.errors.ArgumentError: 10 samples take 1.1e+12 GiB of memory, and ... are free; take fewer
    """
    free = available_memory()
    if needed > free:
        raise ArgumentError(f"{what} take {size_text(needed)} of memory, and {size_text(free)} are free; {hint}")


def require_disk(place: Path, needed: int, what: str, hint: str) -> None:
    """Refuse a result that does not fit on the disk, before any work.

    Args:
        place: the file or folder that it goes to.
        needed: bytes of it, which are compressed at best.
        what: the results and their number, in the plural.
        hint: what would make it fit.

    Raises:
        JobError: it does not fit, with the numbers; or there is no such folder.

    Example:
        >>> require_disk(Path("samples.zarr"), 2**70, "10 samples", "take fewer")
        Traceback (most recent call last):
        urdf_ik.errors.JobError: 10 samples take up to 1.1e+12 GiB on the disk, and ... free; take fewer
    """
    folder = Path(os.path.realpath(place)).parent
    if not os.path.isdir(folder):  # of a name that no file can have, too
        raise JobError(f"{name_of(place)}: there is no folder {name_of(folder)}")
    free = free_disk(folder)
    if needed > free:
        there = f"{name_of(folder)} has {size_text(free)} free"
        raise JobError(f"{what} take up to {size_text(needed)} on the disk, and {there}; {hint}")


def size_text(count: int) -> str:
    """A number of bytes for people.

    Example:
        >>> size_text(3 * 2**30), size_text(2**20)
        ('3 GiB', '1 MiB')
    """
    return f"{count / 2**30:.3g} GiB" if count >= 2**29 else f"{count / 2**20:.3g} MiB"
