"""Chunks as tasks on Dask's workers; the scheduler hands them out, this process keeps what they make.

The job is a task itself, and each chunk depends on it: Dask brings it to the workers that need it, also to those that
join later, and repeats the tasks of a worker that died. A few chunks a thread are under way at any time, so that
neither the scheduler nor this process holds more. A scheduler that was started again gets the job and the chunks under
way anew.
"""

from __future__ import annotations

import asyncio
import contextlib
import os
import pickle
import threading
import time
import uuid
from collections.abc import Callable, Iterable, Mapping
from concurrent.futures import Future
from importlib import import_module
from typing import Any

from urdf_ik.errors import ArgumentError, JobError, MissingPackage, printable
from urdf_ik.maps.engine.arm_jobs import Job, versions
from urdf_ik.support import inputs
from urdf_ik.support.text import quoted

INSTALL = "long work on workers needs Dask; install it with: pip install 'urdf-ik[scale]'"
ANSWER_WITHIN = 10.0
"""s in which a scheduler has to answer when a client is made."""
READY_WITHIN = 60.0
"""s in which all workers have to answer before they are given work, and in which finished chunks have to arrive."""
BACK_WITHIN = 300.0
"""s without a scheduler or without a worker, after which a run ends."""
MOST_A_CORE = 4
"""Greatest number of worker processes that are started for each core of this machine."""
CLUSTER_SETTINGS = {
    "distributed.scheduler.worker-ttl": "60s",
    "distributed.nanny.pre-spawn-environ.MALLOC_TRIM_THRESHOLD_": None,
    "distributed.worker.profile.enabled": False,
    "distributed.admin.tick.interval": "1s",
    "distributed.admin.system-monitor.interval": "5s",
}
"""Dask's settings for the cluster that :func:`connect` makes.

By Dask's defaults a worker that hangs keeps its chunks for five minutes; workers give freed memory back at once, so
that the system clears new pages for each few thousand poses and solving takes twice as long; and each process measures
itself up to a hundred times a second for a dashboard, a tenth of a core in all."""
AHEAD = 2
"""Chunks under way for each thread of the workers: the next chunk is there when one is finished."""
LEAST_AHEAD = 4
"""Chunks under way while there are no workers yet: a cluster that grows with its work sees some."""
LOSSES = 3
"""Number of times that a chunk may be lost on its way before the run ends."""
_TICK = 1.0

Keep = Callable[[int, Mapping[str, bytes]], object]


def connect(scheduler: str | None = None, workers: int | None = None) -> Any:
    """A ``distributed.Client`` of a scheduler's address, or of a cluster of worker processes on this machine.

    Closing the client ends the cluster that was made for it.

    Raises:
        MissingPackage: Dask is not installed.
        ArgumentError: an invalid address or number of workers.
        JobError: no scheduler answers there, or the worker processes do not start.

    Example:
        >>> connect(workers=0)
        Traceback (most recent call last):
        urdf_ik.errors.ArgumentError: workers=0 given; a whole number from 1 to ... is needed
    """
    if workers is not None:
        workers = inputs.whole(workers, "workers", low=1, high=MOST_A_CORE * (os.cpu_count() or 1))
    if not isinstance(scheduler, str | None):
        raise ArgumentError(f"scheduler={quoted(scheduler)} given; an address such as tcp://10.0.0.5:8786 is needed")
    distributed = _package()
    if scheduler is None:
        return _own_cluster(distributed, workers or 1)
    try:
        # The client itself would wait for ever for a listener that is connected and says nothing.
        _in_time(lambda: asyncio.run(_greet(scheduler)), ANSWER_WITHIN)
        # The client tries to reconnect to a lost scheduler for as long as it waited for the first connection.
        return distributed.Client(scheduler, timeout=BACK_WITHIN)
    except Exception as error:  # Dask and its transports each have their own ways to refuse an address
        raise JobError(
            f"no scheduler answers at {printable(scheduler)} within {ANSWER_WITHIN:g} s ({_reason(error)}); start one "
            "with `dask scheduler` and give the address that it prints, such as tcp://10.0.0.5:8786"
        ) from None


def _own_cluster(distributed: Any, workers: int) -> Any:
    """A client of new worker processes on this machine."""
    with import_module("dask.config").set(CLUSTER_SETTINGS):
        try:
            return distributed.Client(
                n_workers=workers, threads_per_worker=1, dashboard_address="127.0.0.1:0", silence_logs="CRITICAL"
            )
        except Exception as error:  # of the operating system, as there is no memory, or of Dask
            first: BaseException = error
            while (cause := first.__cause__ or first.__context__) is not None:
                first = cause
            count = f"{workers} worker process{'es' if workers > 1 else ''}"
            raise JobError(f"{count} could not be started ({_reason(first)}); leave the workers out") from None


def _reason(error: BaseException) -> str:
    return printable(error, 200) or type(error).__name__


async def _greet(address: str) -> None:
    comm = await asyncio.wait_for(import_module("distributed.comm").connect(address, ANSWER_WITHIN), ANSWER_WITHIN)
    await comm.close()


def _in_time(call: Callable[[], Any], seconds: float) -> Any:
    """What a call to the cluster returns or raises; a ``TimeoutError`` when it takes too long, and is left behind."""
    found: Future[Any] = Future()

    def act() -> None:
        try:
            found.set_result(call())
        except BaseException as error:
            found.set_exception(error)

    threading.Thread(target=act, name="urdf-ik cluster", daemon=True).start()
    try:
        return found.result(seconds)
    except TimeoutError:
        raise TimeoutError(f"no answer within {seconds:g} s") from None


def on_workers(job: Job, pending: Iterable[int], keep: Keep, client: Any) -> None:
    """Make chunks on the workers of a ``distributed.Client``, and hand each to ``keep`` when it is made.

    Raises:
        ArgumentError: not a synchronous Dask client.
        JobError: the client is closed, a worker has another version of this package, chunks end workers, or the
            scheduler is gone.
    """
    distributed = _package()
    if not isinstance(client, distributed.Client) or client.asynchronous:
        raise ArgumentError(f"client={quoted(client)} given; a distributed.Client that is not asynchronous is needed")
    run = _Run(job, list(pending), keep, client)
    if client.status != "running":
        raise JobError(f"the client of {run.address} is {client.status}; connect a new one")
    try:
        run.finish()
    finally:
        run.clear()


class _Run:
    """One run's chunks: those that wait, and those under way."""

    def __init__(self, job: Job, pending: list[int], keep: Keep, client: Any) -> None:
        self._client, self._keep = client, keep
        self._payload = pickle.dumps(job)
        self._made_by = versions()
        self._waiting = pending[::-1]
        self._under_way: dict[Any, int] = {}
        self._losses: dict[int, int] = {}
        self._job: Any = None
        self._most = LEAST_AHEAD
        self._next_look = 0.0
        self._last_news = time.monotonic()
        self.address = str(client.scheduler.address) if client.scheduler is not None else "no scheduler"

    def finish(self) -> None:
        """Make all chunks."""
        self._introduce()
        while self._waiting or self._under_way:
            self._take(self._ended())

    def clear(self) -> None:
        """Take back what is still under way, and the job."""
        for future in (*self._under_way, self._job):
            with contextlib.suppress(Exception):  # the scheduler has gone, and all futures with it
                future.release()

    def _introduce(self) -> None:
        """Check the workers that there are, and hand the job to the scheduler."""
        try:
            for address, found in _in_time(lambda: self._client.run(_probe()), READY_WITHIN).items():
                _require_same(address, found, self._made_by)
        except (OSError, TimeoutError) as error:
            raise JobError(f"not all workers of {self.address} answer: {error}") from None
        self._job = self._submit("job", pickle.loads, self._payload)

    def _submit(self, name: object, *call: Any) -> Any:
        return self._client.submit(*call, key=f"urdf-ik-{name}-{uuid.uuid4().hex[:12]}", pure=False)

    def _count_threads(self) -> None:
        """Every second: how many threads the workers have."""
        now = time.monotonic()
        if now < self._next_look:
            return
        self._next_look = now + _TICK
        workers = self._client.scheduler_info(n_workers=-1)["workers"]
        threads = sum(worker["nthreads"] for worker in workers.values())
        self._most = max(LEAST_AHEAD, AHEAD * threads)
        if threads:
            self._last_news = now
        elif now - self._last_news > BACK_WITHIN:
            raise JobError(f"{self.address} has had no worker for {BACK_WITHIN:g} s; start one, and run again")

    def _hand_out(self) -> None:
        """Fill up what is under way."""
        while self._waiting and len(self._under_way) < self._most:
            chunk = self._waiting.pop()
            self._under_way[self._submit(chunk, _made, self._job, chunk, self._made_by)] = chunk

    def _ended(self) -> list[Any]:
        """The chunks under way that are finished or lost, after waiting for one."""
        distributed = _package()
        try:
            if self._client.status != "running" or self._job.cancelled():
                self._reconnect()
            self._count_threads()
            self._hand_out()
            return list(distributed.wait(list(self._under_way), timeout=_TICK, return_when="FIRST_COMPLETED").done)
        except TimeoutError:  # none is finished yet
            return []
        except (OSError, distributed.CancelledError):  # the scheduler went away
            self._reconnect()
            return []

    def _take(self, ended: list[Any]) -> None:
        """Keep the chunks that are finished, and hand the others out again."""
        results = self._gathered([future for future in ended if future.status == "finished"])
        for future in ended:
            chunk = self._under_way.pop(future)
            if future.key in results:
                self._keep(chunk, results[future.key])
            else:
                self._repeat(future, chunk)

    def _gathered(self, futures: list[Any]) -> dict[str, Mapping[str, bytes]]:
        """The files of finished chunks by key, in one message; {} where it does not come through."""
        try:
            found = _in_time(lambda: self._client.gather(futures), READY_WITHIN) if futures else []
            return dict(zip((future.key for future in futures), found, strict=True))
        except Exception:  # a worker died or hangs, or the scheduler is gone: the chunks are made again
            return {}

    def _repeat(self, future: Any, chunk: int) -> None:
        """Hand a chunk out again, unless that will not help."""
        if future.status == "error":
            error = future.exception()
            if isinstance(error, _package().KilledWorker):
                raise JobError(
                    f"chunk {chunk} ended {error.allowed_failures + 1} workers, the last one at "
                    f"{error.last_worker.address}: have they enough memory? Take smaller chunks"
                )
            if isinstance(error, ModuleNotFoundError):
                raise JobError(f"a worker cannot import {error.name}: install this package there, too")
            raise error
        if self._client.status == "running":
            self._losses[chunk] = self._losses.get(chunk, 0) + 1
            if self._losses[chunk] > LOSSES:
                raise JobError(f"chunk {chunk} was lost {self._losses[chunk]} times on its way here")
        self._waiting.append(chunk)

    def _reconnect(self) -> None:
        """Wait for a scheduler that went away, and hand out anew all that was under way."""
        since = time.monotonic()
        while self._client.status != "running":
            gone = time.monotonic() - since
            if self._client.status == "closed" or gone > BACK_WITHIN:
                raise JobError(f"the scheduler at {self.address} is gone for {gone:.0f} s; start it, and run again")
            time.sleep(0.1)
        self._waiting += sorted(self._under_way.values(), reverse=True)
        self._under_way.clear()
        self._last_news = time.monotonic()
        self._introduce()


def _package() -> Any:
    """Dask's ``distributed``."""
    try:
        return import_module("distributed")
    except ImportError:
        raise MissingPackage(INSTALL) from None


def _require_same(address: str, found: Mapping[str, str] | None, ours: Mapping[str, str]) -> None:
    if found is None:
        raise JobError(f"the worker at {address} does not have this package: install urdf-ik {ours['urdf-ik']} there")
    if found["urdf-ik"] != ours["urdf-ik"]:
        raise JobError(
            f"the worker at {address} has urdf-ik {found['urdf-ik']}, and this process {ours['urdf-ik']}: install the "
            "same there"
        )
    if found["instructions"] != ours["instructions"]:
        raise JobError(
            f"the worker at {address} computes with {found['instructions']} instructions, and this process with "
            f"{ours['instructions']}: the last digits would differ; set URDF_IK_ISA to the lesser one on both"
        )


def _probe() -> Callable[[], dict[str, str] | None]:
    """A function for workers that may lack this package: defined here inside, it travels as its code."""

    def found() -> dict[str, str] | None:
        from importlib import import_module

        try:
            return dict(import_module("urdf_ik.maps.engine.arm_jobs").versions())
        except ImportError:
            pass
        try:
            return {"urdf-ik": str(import_module("urdf_ik").__version__), "instructions": "other"}
        except ImportError:
            return None

    return found


def _made(job: Job, chunk: int, ours: Mapping[str, str]) -> Mapping[str, bytes]:
    """The files of a chunk, made on a worker."""
    _require_same(_package().get_worker().address, versions(), ours)
    return job(chunk)
