"""Chunks as tasks on Dask's workers; the scheduler hands them out, this process keeps what they make.

Each worker gets the job once, also one that joins later. A few chunks a thread are under way at any time, so that
neither the scheduler nor this process holds more than these. A chunk whose worker died is made by another one; one that
takes far longer than the others did is handed to another worker, too, and whoever is first counts. A scheduler that is
started again gets the job and the chunks under way anew.
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
from typing import TYPE_CHECKING, Any

from urdf_ik import _core
from urdf_ik.errors import ArgumentError, JobError, MissingPackage, printable
from urdf_ik.support import inputs
from urdf_ik.support.text import quoted

if TYPE_CHECKING:
    from urdf_ik.maps.engine.jobs import Job

INSTALL = "long work on workers needs Dask; install it with: pip install 'urdf-ik[scale]'"
ANSWER_WITHIN = 10.0
"""s in which a scheduler has to answer."""
READY_WITHIN = 60.0
"""s in which all workers have to answer before they are given work."""
PATIENCE = 60.0
"""s after which a chunk may be handed to a second worker; see :data:`SLOWER`."""
SLOWER = 10.0
"""A chunk is handed to a second worker when it has taken this many times as long as the slowest one before it."""
MOST_A_CORE = 4
"""Worker processes that are started for each core of this machine at most."""
OF_OUR_OWN = {
    "distributed.scheduler.worker-ttl": f"{PATIENCE:g}s",
    "distributed.nanny.pre-spawn-environ.MALLOC_TRIM_THRESHOLD_": None,
    "distributed.worker.profile.enabled": False,
    "distributed.admin.tick.interval": "1s",
    "distributed.admin.system-monitor.interval": "5s",
}
"""Dask's settings for the cluster that :func:`connect` makes. By its defaults workers give freed memory back at once;
the arrays of each few thousand poses are then new pages, which the system clears, and solving takes twice as long. And
each process looks at itself up to a hundred times a second for a dashboard, a tenth of a core in all."""
AHEAD = 2
"""Chunks under way for each thread of the workers: the next one is there when one is finished."""
LEAST_AHEAD = 4
"""Chunks under way while there are no workers yet: a cluster that grows with its work sees some."""
LOSSES = 3
"""Times that a chunk may be lost on its way before the run ends."""
_TICK = 1.0
_NO_NEWS = 300.0  # s without a scheduler or without a worker, after which the run ends


def connect(scheduler: str | None = None, workers: int | None = None) -> Any:
    """A ``distributed.Client`` of a scheduler's address, or of a cluster of worker processes on this machine.

    Closing the client ends the cluster that was made for it.

    Raises:
        MissingPackage: Dask is not installed.
        ArgumentError: no address, or a number of workers that makes no sense.
        JobError: no scheduler answers there.

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
        with import_module("dask.config").set(OF_OUR_OWN):
            return distributed.Client(
                n_workers=workers or 1,
                threads_per_worker=1,
                dashboard_address="127.0.0.1:0",
                silence_logs="CRITICAL",
            )
    try:
        # The client itself would wait for ever for one that is connected and says nothing.
        _in_time(lambda: asyncio.run(_greet(scheduler)), ANSWER_WITHIN)
        return distributed.Client(scheduler, timeout=ANSWER_WITHIN)
    except Exception as error:  # Dask and its transports each have their own ways to refuse an address
        reason = printable(error, 200) or type(error).__name__
        raise JobError(
            f"no scheduler answers at {printable(scheduler)} within {ANSWER_WITHIN:g} s ({reason}); start one with "
            "`dask scheduler` and give the address that it prints, such as tcp://10.0.0.5:8786"
        ) from None


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


def on_workers(
    job: Job, pending: Iterable[int], keep: Callable[[int, Mapping[str, bytes]], object], client: Any
) -> None:
    """Make chunks on the workers of a ``distributed.Client``, and hand each to ``keep`` when it is made.

    Raises:
        ArgumentError: the client is of another kind.
        JobError: the client is closed, a worker has another version of this package, chunks end
            workers, or the scheduler is gone.
    """
    distributed = _package()
    if not isinstance(client, distributed.Client) or client.asynchronous:
        raise ArgumentError(f"client={quoted(client)} given; a distributed.Client that is not asynchronous is needed")
    if client.status != "running":
        raise JobError(f"the client of {_address(client)} is {client.status}; connect a new one")
    run = _Run(job, list(pending), keep, client)
    try:
        run.finish()
    finally:
        run.clear()


class _Run:
    """One run's chunks: those that wait, and those under way."""

    def __init__(
        self, job: Job, pending: list[int], keep: Callable[[int, Mapping[str, bytes]], object], client: Any
    ) -> None:
        self._client, self._keep = client, keep
        self._name = f"urdf-ik-{uuid.uuid4().hex[:12]}"
        self._payload = pickle.dumps(job)
        self._made_by = versions()
        self._waiting = pending[::-1]
        self._under_way: dict[Any, int] = {}
        self._begun: dict[int, float] = {}
        self._copies: set[int] = set()
        self._losses: dict[int, int] = {}
        self._slowest = 0.0
        self._most = LEAST_AHEAD
        self._next_look = 0.0
        self._workers: Mapping[str, Any] = {}
        self._hanging: dict[str, float] = {}
        self._last_news = time.monotonic()

    def finish(self) -> None:
        """Make all chunks."""
        self._introduce()
        while self._waiting or self._under_way:
            self._look_around()
            self._hand_out()
            self._take(self._news())

    def clear(self) -> None:
        """Take back what is still under way, and the job."""
        for future in self._under_way:
            future.release()
        if self._client.status == "running":
            # A scheduler that has gone in the meantime took it along, and a worker that hangs keeps it.
            with contextlib.suppress(Exception):
                _in_time(lambda: self._client.unregister_worker_plugin(self._name), ANSWER_WITHIN)

    def _introduce(self) -> None:
        """Check the workers that there are, and send the job to each, also to those that come later."""
        plugin = _plugin(self._name, self._payload)
        try:
            for address, found in _in_time(lambda: self._client.run(_probe()), READY_WITHIN).items():
                _require_same(address, found, self._made_by)
            _in_time(lambda: self._client.register_plugin(plugin, name=self._name), READY_WITHIN)
        except (OSError, TimeoutError) as error:
            raise JobError(f"not all workers of {_address(self._client)} answer: {error}") from None

    def _look_around(self) -> None:
        """Every second: how many workers there are, and which chunks take too long."""
        now = time.monotonic()
        if now < self._next_look:
            return
        self._next_look = now + _TICK
        self._workers = self._client.scheduler_info(n_workers=-1)["workers"]
        self._hanging = {address: since for address, since in self._hanging.items() if now - since < PATIENCE}
        threads = sum(worker["nthreads"] for worker in self._workers.values())
        self._most = max(LEAST_AHEAD, AHEAD * threads)
        if not threads and now - self._last_news > _NO_NEWS:
            raise JobError(
                f"{_address(self._client)} has had no worker for {_NO_NEWS:g} s; start one, and run again"
            )
        self._look_for_slow_ones(now)

    def _hand_out(self) -> None:
        """Fill up what is under way."""
        while self._waiting and len(self._under_way) < self._most:
            self._submit(self._waiting.pop())

    def _submit(self, chunk: int) -> None:
        """Hand a chunk to the workers, except for those that seem to hang."""
        others = [address for address in self._workers if address not in self._hanging] if self._hanging else []
        future = self._client.submit(
            _made, self._name, chunk, self._made_by, key=f"{self._name}-{chunk}-{uuid.uuid4().hex[:6]}", pure=False,
            workers=others or None,
        )  # fmt: skip
        self._under_way[future] = chunk
        self._begun.setdefault(chunk, time.monotonic())

    def _news(self) -> list[Any]:
        """The chunks under way that have ended, in whatever way, after waiting for one."""
        distributed = _package()
        try:
            return list(distributed.wait(list(self._under_way), timeout=_TICK, return_when="FIRST_COMPLETED").done)
        except TimeoutError:
            return []
        except distributed.CancelledError:
            self._again()
            return []

    def _again(self) -> None:
        """The scheduler went away, and with it all that was under way: wait for it, and hand everything out anew."""
        until = time.monotonic() + _NO_NEWS
        while self._client.status != "running":
            if self._client.status == "closed" or time.monotonic() > until:
                raise JobError(f"the scheduler at {_address(self._client)} is gone; start it, and run again")
            time.sleep(0.1)
        self._waiting += sorted({*self._under_way.values()}, reverse=True)
        self._under_way.clear()
        self._begun.clear()
        self._copies.clear()
        self._introduce()

    def _take(self, futures: list[Any]) -> None:
        """Keep what chunks brought that have ended."""
        mine = [future for future in futures if future in self._under_way]
        good = [future for future in mine if future.status == "finished"]
        results = dict(zip((future.key for future in good), self._gathered(good), strict=False))
        for future in mine:
            chunk = self._under_way.pop(future, None)
            if chunk is None:  # its other copy is among these, too
                continue
            files = results.get(future.key)
            if files is None:
                self._lost(future, chunk)
                continue
            self._keep(chunk, files)
            self._last_news = time.monotonic()
            self._slowest = max(self._slowest, self._last_news - self._begun.pop(chunk, self._last_news))
            for other in [each for each, of in self._under_way.items() if of == chunk]:
                del self._under_way[other]
                other.release()

    def _gathered(self, futures: list[Any]) -> list[Any]:
        """What chunks brought, all in one message; [] where it does not come through."""
        if not futures:
            return []
        try:
            found: list[Any] = _in_time(lambda: self._client.gather(futures), PATIENCE)
            return found
        except TimeoutError:
            for addresses in self._client.who_has(futures).values():
                self._hanging |= dict.fromkeys(addresses, time.monotonic())
        except Exception as error:
            # A worker died with them, or the scheduler did: what they brought is made again.
            if self._client.status == "closed":
                raise JobError(
                    f"the scheduler at {_address(self._client)} is gone; start it, and run again"
                ) from error
        return []

    def _lost(self, future: Any, chunk: int) -> None:
        """A chunk brought nothing: hand it out again, unless that will not help."""
        distributed = _package()
        if future.status == "error":
            error = future.exception()
            if isinstance(error, distributed.KilledWorker):
                raise JobError(
                    f"chunk {chunk} ended {error.allowed_failures + 1} workers, the last one at "
                    f"{error.last_worker.address}: have they enough memory? Take smaller chunks"
                )
            if isinstance(error, ModuleNotFoundError):
                raise JobError(f"a worker cannot import {error.name}: install this package there, too")
            raise error
        self._losses[chunk] = self._losses.get(chunk, 0) + (not self._hanging)
        if self._losses[chunk] > LOSSES:
            raise JobError(f"chunk {chunk} was lost {self._losses[chunk]} times on its way here")
        self._waiting.append(chunk)

    def _look_for_slow_ones(self, now: float) -> None:
        """Hand a chunk that takes far longer than the others to a second worker."""
        late = now - max(PATIENCE, SLOWER * self._slowest)
        overdue = {chunk for chunk in self._under_way.values() if self._begun[chunk] < late} - self._copies
        if not overdue:
            return
        for address, tasks in self._client.processing().items():
            if any(future.key in tasks for future, chunk in self._under_way.items() if chunk in overdue):
                self._hanging[address] = now
        for chunk in overdue:
            self._copies.add(chunk)
            self._submit(chunk)


def _package() -> Any:
    """Dask's ``distributed``."""
    try:
        return import_module("distributed")
    except ImportError:
        raise MissingPackage(INSTALL) from None


def versions() -> dict[str, str]:
    """What must be the same wherever chunks are made, for their bytes to be the same.

    Example:
        >>> sorted(versions())
        ['instructions', 'urdf-ik']
    """
    from urdf_ik import __version__

    return {"urdf-ik": __version__, "instructions": _core.isa()}


def _require_same(address: str, found: Mapping[str, str] | None, ours: Mapping[str, str]) -> None:
    if found is None:
        raise JobError(
            f"the worker at {address} does not have this package: install urdf-ik {ours['urdf-ik']} there"
        )
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


def _address(client: Any) -> str:
    scheduler = client.scheduler
    return str(scheduler.address if scheduler is not None else "the scheduler")


def _probe() -> Callable[[], dict[str, str] | None]:
    """A function for workers that may lack this package: defined here inside, it travels as its code."""

    def found() -> dict[str, str] | None:
        from importlib import import_module

        try:
            return dict(import_module("urdf_ik.maps.engine.dask_workers").versions())
        except ImportError:
            pass
        try:
            return {"urdf-ik": str(import_module("urdf_ik").__version__), "instructions": "other"}
        except ImportError:
            return None

    return found


def _plugin(name: str, payload: bytes) -> Any:
    """The job, as Dask brings it to every worker that is there or joins."""

    class Holder(_package().WorkerPlugin):  # type: ignore[misc]
        """Holds a job for the tasks of one worker."""

        def __init__(self) -> None:
            self.name, self.payload = name, payload
            self.job: Any = None

    return Holder()


def _made(name: str, chunk: int, ours: Mapping[str, str]) -> Mapping[str, bytes]:
    """The files of a chunk, made on a worker."""
    worker = _package().get_worker()
    _require_same(worker.address, versions(), ours)
    holder = worker.plugins[name]
    if holder.job is None:  # here, in a task, whose errors come back
        holder.job = pickle.loads(holder.payload)
    files: Mapping[str, bytes] = holder.job(chunk)
    return files
