"""run(): computes chunks one after the other in this process, or as tasks on Dask's workers."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from urdf_ik.maps.engine.arm_jobs import Job
from urdf_ik.maps.engine.store_folder import Folder
from urdf_ik.support import inputs

Tick = Callable[[int, int], object]


class Interrupted(KeyboardInterrupt):
    """Ctrl-C during long work; the message says what is kept."""


def run(job: Job, store: Folder, *, client: Any = None, progress: Tick | None = None) -> int:
    """Make all missing chunks of a store.

    Args:
        job: makes a chunk's files.
        store: where they go; the chunks that it holds are read and checked first.
        client: a ``distributed.Client`` whose workers make the chunks; default: this process does.
        progress: called with the number of finished chunks, and of all.

    Returns:
        Number of chunks that were made.

    Raises:
        ArgumentError: ``client`` is not a Dask client.
        JobError: the disk is full or cannot be written, or the scheduler or the workers cannot go on. What is finished
            is kept.
        Interrupted: Ctrl-C. What is finished is kept.

    Example:
        >>> from urdf_ik.maps.engine import Folder
        >>> with Folder("numbers", {"what": "squares"}, 3) as store:
        ...     run(lambda k: {str(k): str(k * k).encode()}, store)
        3
    """
    if client is not None:
        inputs.kind(client, "scheduler_info", "client", "a distributed.Client")
    pending = store.pending()
    done = store.chunks - len(pending)

    def keep(chunk: int, files: Mapping[str, bytes]) -> None:
        nonlocal done
        store.keep(chunk, files)
        done += 1
        if progress is not None:
            progress(done, store.chunks)

    if progress is not None:
        progress(done, store.chunks)
    try:
        if client is None:
            for chunk in pending:
                keep(chunk, job(chunk))
        elif pending:
            from urdf_ik.maps.engine.dask_workers import on_workers  # only a cluster needs Dask

            on_workers(job, pending, keep, client)
    except KeyboardInterrupt:
        raise Interrupted(
            f"interrupted; {done} of {store.chunks} chunks are kept in {store.path}, and the same run goes on from "
            "there"
        ) from None
    return len(pending)
