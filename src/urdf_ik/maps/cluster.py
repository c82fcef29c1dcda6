"""Blocks on Dask's workers: Dask hands them out, repeats those of a worker that died, and brings the results back."""

import asyncio
import pickle
import uuid
from collections.abc import Iterable, Iterator
from concurrent.futures import CancelledError
from importlib import import_module
from itertools import islice
from typing import Any

from numpy.typing import NDArray

from urdf_ik import _core
from urdf_ik.errors import ArgumentError, JobError
from urdf_ik.support import extras
from urdf_ik.version import __version__

ANSWER_WITHIN = 10.0
"""Time within which a scheduler has to answer [s]."""
WORKER_WITHIN = 60.0
"""Time within which a scheduler needs a worker [s]."""
AHEAD = 2
"""Blocks under way for each thread of the workers: the next block is there when one is finished."""
CLUSTER_SETTINGS = {
    "distributed.scheduler.worker-ttl": "60s",
    "distributed.nanny.pre-spawn-environ.MALLOC_TRIM_THRESHOLD_": None,
    "distributed.worker.profile.enabled": False,
    "distributed.admin.tick.interval": "1s",
    "distributed.admin.system-monitor.interval": "5s",
}
"""Dask's settings for the cluster that :func:`connect` starts.

By Dask's defaults a worker that hangs keeps its blocks for five minutes; workers return freed memory at once, so
that the system clears new pages for each few thousand poses and solving takes twice as long; and each process measures
itself up to a hundred times a second for a dashboard, a tenth of a core in all."""


def package(name: str) -> Any:
    """A package of the extra ``scale``.

    Raises:
        MissingPackage: it is not installed.
    """
    try:
        return import_module(name)
    except ImportError:
        raise extras.missing("stores and workers need Zarr, Dask and xarray", "scale") from None


def versions() -> dict[str, str]:
    """The versions on which the last digits of a block depend."""
    return {"urdf-ik": __version__, "instructions": _core.isa()}


def connect(scheduler: str | None = None, workers: int | None = None) -> Any:
    """A ``distributed.Client`` of a scheduler's address, or of a cluster of worker processes on this machine.

    Closing the client ends the cluster that was started for it.

    Raises:
        MissingPackage: Dask is not installed.
        JobError: no scheduler answers there, or the worker processes do not start.
    """
    distributed = package("distributed")
    if scheduler is not None:
        try:
            asyncio.run(_greet(scheduler))  # the client would wait for ever for a listener that says nothing
            return distributed.Client(scheduler, timeout=ANSWER_WITHIN)
        except Exception as error:  # Dask and its transports have many errors for a wrong address
            raise JobError(
                f"no scheduler answers at {scheduler} within {ANSWER_WITHIN:g} s ({_first(error)}); start one with "
                "`dask scheduler` and give the address that it prints, such as tcp://10.0.0.5:8786"
            ) from None
    with package("dask.config").set(CLUSTER_SETTINGS):
        try:
            return distributed.Client(
                n_workers=workers or 1, threads_per_worker=1, dashboard_address="127.0.0.1:0", silence_logs="CRITICAL"
            )
        except Exception as error:  # from the operating system, such as too little memory, or from Dask
            count = f"{workers or 1} worker process{'es' if (workers or 1) > 1 else ''}"
            raise JobError(f"{count} could not be started ({_first(error)}); leave the workers out") from None


async def _greet(address: str) -> None:
    connection = package("distributed.comm").connect(address, ANSWER_WITHIN)
    await (await asyncio.wait_for(connection, ANSWER_WITHIN)).close()


def _first(error: BaseException) -> str:
    """The text of the first cause."""
    while (cause := error.__cause__ or error.__context__) is not None:
        error = cause
    return str(error)[:200] or type(error).__name__


def results(question: Any, blocks: Iterable[int], client: Any) -> Iterator[tuple[int, dict[str, NDArray[Any]]]]:
    """Numbers and arrays of blocks, in the order in which the workers of a ``distributed.Client`` finish them.

    Raises:
        ArgumentError: not a synchronous Dask client.
        JobError: there is no worker, a worker has another version of this package, a block ends workers, or the
            scheduler is gone.
    """
    distributed = package("distributed")
    if not isinstance(client, distributed.Client) or client.asynchronous:
        raise ArgumentError(f"client={client!r} given; a distributed.Client that is not asynchronous is needed")
    address = client.scheduler.address if client.scheduler is not None else "no address"
    try:
        client.wait_for_workers(1, timeout=WORKER_WITHIN)
        yield from _finished(question, iter(blocks), client, distributed)
    except ModuleNotFoundError as error:
        raise JobError(f"a worker cannot import {error.name}: install this package there, too") from None
    except distributed.KilledWorker as error:
        raise JobError(
            f"a block ended several workers: have they enough memory? Take smaller blocks ({error})"
        ) from None
    except TimeoutError:
        raise JobError(f"the scheduler at {address} has no worker after {WORKER_WITHIN:g} s; start one") from None
    except (OSError, CancelledError, RuntimeError) as error:
        if client.status == "running" and not isinstance(error, CancelledError):
            raise
        raise JobError(f"the scheduler at {address} is gone; start it, and run again") from None


def _finished(question: Any, blocks: Iterator[int], client: Any, distributed: Any) -> Iterator[tuple[int, Any]]:
    run = f"urdf-ik-{uuid.uuid4().hex[:12]}"
    # The question is the result of a task: Dask brings it to every worker, also to those that join later.
    shared = client.submit(pickle.loads, pickle.dumps(question), key=run)
    under_way: dict[Any, int] = {}
    finished = distributed.as_completed()
    while True:
        room = max(AHEAD, AHEAD * sum(client.nthreads().values())) - len(under_way)
        for block in islice(blocks, max(0, room)):
            future = client.submit(_solved, shared, block, versions(), key=f"{run}-{block}")
            under_way[future] = block
            finished.add(future)
        if not under_way:
            return
        future = next(finished)
        yield under_way.pop(future), future.result()


def _solved(question: Any, block: int, ours: dict[str, str]) -> dict[str, NDArray[Any]]:
    """The arrays of a block, on a worker."""
    theirs = versions()
    if theirs != ours:
        address = package("distributed").get_worker().address
        raise JobError(
            f"the worker at {address} has urdf-ik {theirs['urdf-ik']} with {theirs['instructions']} instructions, and "
            f"this process {ours['urdf-ik']} with {ours['instructions']}: the last digits would differ; install the "
            "same version there, or set URDF_IK_ISA to the lesser one on both"
        )
    arrays: dict[str, NDArray[Any]] = question.solved(question.blocks.part(block))
    return arrays
