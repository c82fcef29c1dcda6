"""How much memory and disk there is, and whether what is to be made fits."""

from __future__ import annotations

import contextlib
import shutil
from pathlib import Path


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


def size_text(count: int) -> str:
    """A number of bytes for people.

    Example:
        >>> size_text(3 * 2**30), size_text(2**20)
        ('3 GiB', '1 MiB')
    """
    return f"{count / 2**30:.3g} GiB" if count >= 2**29 else f"{count / 2**20:.3g} MiB"
