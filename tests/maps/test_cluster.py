"""Chunks on Dask's workers: the same bytes as without, whatever happens to the workers; bad input in words."""

from __future__ import annotations

import contextlib
import os
import signal
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from test_folder import contents

import urdf_ik
from urdf_ik.maps import engine
from urdf_ik.maps.engine import Folder, dask_workers
from urdf_ik.maps.engine.store_folder import finished

distributed = pytest.importorskip("distributed")
GONE = 3.0
"""s for which the scheduler that comes back is away."""
PATIENCE = 240.0
"""s, on a machine that may have other work."""
MAP = {"voxel": 0.5, "orientations": 30, "block": 250}


@pytest.fixture(scope="module")
def client() -> Iterator[Any]:
    """Two worker processes."""
    with engine.connect(workers=2) as made:
        made.wait_for_workers(2, timeout=PATIENCE)
        yield made


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> dict[str, str]:
    """The files of a map that this process made."""
    path = tmp_path_factory.mktemp("whole") / "map.zarr"
    made(path)
    return contents(path)


def made(path: Path, **options: Any) -> urdf_ik.maps.workspaces.StoredMap:
    """A map of 1000 voxels in 125 blocks."""
    return urdf_ik.maps.workspace(urdf_ik.load("zyyzyz_6r"), **MAP, store=path, **options)


def once(chunks: int, act: Callable[[], object], monkeypatch: pytest.MonkeyPatch) -> None:
    """Do something when a store holds so many chunks, before it is given another one."""
    keep = Folder.keep

    def kept(store: Folder, chunk: int, files: Any) -> None:
        keep(store, chunk, files)
        if len(finished(store.path)) == chunks:
            act()

    monkeypatch.setattr(Folder, "keep", kept)


def a_worker(client: Any) -> tuple[str, int]:
    """Address and process id of one of the workers; all of them have this package loaded then."""
    client.run(engine.versions)
    return next(iter(client.run(os.getpid).items()))


def until(condition: Callable[[], bool]) -> None:
    """Wait for something that must happen."""
    deadline = time.monotonic() + PATIENCE
    while not condition():
        assert time.monotonic() < deadline, "nothing happens"
        time.sleep(0.02)


def test_workers_make_the_same_bytes(tmp_path: Path, client: Any, whole: dict[str, str]) -> None:
    """Two workers, and a run that this process began and they went on with."""
    made(tmp_path / "map.zarr", client=client)
    assert contents(tmp_path / "map.zarr") == whole


def test_a_worker_that_is_killed_loses_nothing(
    tmp_path: Path, client: Any, whole: dict[str, str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """SIGKILL to a worker in the middle: the map is whole, and its bytes are the same; another one takes its place."""
    path = tmp_path / "map.zarr"
    address, pid = a_worker(client)
    once(20, lambda: os.kill(pid, signal.SIGKILL), monkeypatch)
    made(path, client=client)
    assert contents(path) == whole
    until(lambda: address not in client.scheduler_info(n_workers=-1)["workers"])
    client.wait_for_workers(2, timeout=PATIENCE)
    assert pid not in client.run(os.getpid).values()


def test_a_worker_that_hangs_holds_nothing_up(
    tmp_path: Path, whole: dict[str, str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """A worker that is stopped counts as dead after Dask's time to live: another one makes its chunks."""
    monkeypatch.setattr(dask_workers, "READY_WITHIN", 15.0)
    monkeypatch.setitem(dask_workers.CLUSTER_SETTINGS, "distributed.scheduler.worker-ttl", "10s")
    client = engine.connect(workers=2)
    client.wait_for_workers(2, timeout=PATIENCE)
    path = tmp_path / "map.zarr"
    _, pid = a_worker(client)
    once(20, lambda: os.kill(pid, signal.SIGSTOP), monkeypatch)
    try:
        made(path, client=client)
    finally:
        with contextlib.suppress(ProcessLookupError):  # the scheduler may have given it up
            os.kill(pid, signal.SIGCONT)
        client.close()
    assert contents(path) == whole


def test_few_chunks_are_under_way(tmp_path: Path, client: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    """However many chunks there are, a few for each thread are with the scheduler."""
    most = 0
    hand_out = dask_workers._Run._hand_out

    def counted(run: Any) -> None:
        nonlocal most
        hand_out(run)
        most = max(most, len(run._under_way))

    monkeypatch.setattr(dask_workers._Run, "_hand_out", counted)
    made(tmp_path / "map.zarr", client=client)
    assert 0 < most <= max(dask_workers.LEAST_AHEAD, 2 * dask_workers.AHEAD)


def test_a_worker_with_another_version_is_refused(tmp_path: Path, client: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    """The version and the instruction set of this process differ from those of the workers."""
    ours = engine.versions()
    for change, words in (
        ({"urdf-ik": "9.9"}, rf"worker at .* has urdf-ik {urdf_ik.__version__}, and this process 9\.9"),
        ({"instructions": "v1"}, r"worker at .* computes with .* and this process with v1.*URDF_IK_ISA"),
    ):
        monkeypatch.setattr(dask_workers, "versions", lambda change=change: {**ours, **change})
        with pytest.raises(urdf_ik.JobError, match=words):
            made(tmp_path / "map.zarr", client=client)


def test_a_scheduler_that_does_not_answer(monkeypatch: pytest.MonkeyPatch) -> None:
    """Nobody listens there, somebody listens who is no scheduler, or it is no address."""
    monkeypatch.setattr(dask_workers, "ANSWER_WITHIN", 0.5)
    with socket.socket() as silent:
        silent.bind(("127.0.0.1", 0))
        silent.listen()
        listening = f"tcp://127.0.0.1:{silent.getsockname()[1]}"
        for address in (listening, "tcp://127.0.0.1:9", "nonsense"):
            with pytest.raises(urdf_ik.JobError, match=r"no scheduler answers at .* within 0\.5 s"):
                engine.connect(address)


def test_what_is_no_client_is_refused(tmp_path: Path) -> None:
    """An address in place of a client, no workers, workers without a store."""
    with pytest.raises(urdf_ik.ArgumentError, match=r"distributed\.Client"):
        made(tmp_path / "map.zarr", client="tcp://127.0.0.1:8786")
    with pytest.raises(urdf_ik.ArgumentError, match="store"):
        urdf_ik.maps.workspace(urdf_ik.load("planar_2r"), client=object())
    with pytest.raises(urdf_ik.ArgumentError, match="from 1 to"):
        engine.connect(workers=0)


def test_a_scheduler_that_goes_away_loses_no_finished_chunk(
    tmp_path: Path, whole: dict[str, str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """The run ends in words; the next one, in this process, goes on with what was kept."""
    path = tmp_path / "map.zarr"
    other = engine.connect(workers=1)
    once(20, other.cluster.close, monkeypatch)
    with pytest.raises(urdf_ik.JobError, match=r"scheduler at .* is gone"):
        made(path, client=other)
    other.close()
    assert 20 <= len(finished(path)) < made(path).blocks.count
    assert contents(path) == whole


@contextlib.contextmanager
def program(*arguments: object) -> Iterator[subprocess.Popen[bytes]]:
    """A process of Dask's command, killed at the end."""
    command = [sys.executable, "-m", "distributed.cli.dask_scheduler", *map(str, arguments)]
    if "worker" in arguments:
        command = [sys.executable, "-m", "dask", *map(str, arguments)]
    started = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    try:
        yield started
    finally:
        started.kill()
        started.wait()


def test_a_scheduler_that_comes_back_is_used_again(
    tmp_path: Path, whole: dict[str, str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Killed, gone for longer than a new client waits for an answer, and started again at the same address."""
    monkeypatch.setattr(dask_workers, "ANSWER_WITHIN", 1.0)
    path = tmp_path / "map.zarr"
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    scheduler = ("--host", "127.0.0.1", "--port", port, "--no-dashboard")
    worker = ("worker", f"tcp://127.0.0.1:{port}", "--nthreads", 1, "--no-nanny", "--no-dashboard")
    with contextlib.ExitStack() as running:
        first = running.enter_context(program(*scheduler))
        running.enter_context(program(*worker))
        with connected(f"tcp://127.0.0.1:{port}") as client:
            client.wait_for_workers(1, timeout=PATIENCE)

            def come_back() -> None:
                time.sleep(GONE)
                running.enter_context(program(*scheduler))
                running.enter_context(program(*worker))

            back = threading.Thread(target=come_back)

            def kill() -> None:
                first.kill()
                first.wait()
                back.start()

            once(20, kill, monkeypatch)
            made(path, client=client)
            back.join()
    assert contents(path) == whole


def connected(address: str) -> Any:
    """A client of a scheduler that is being started."""
    deadline = time.monotonic() + PATIENCE
    while True:
        try:
            return engine.connect(address)
        except urdf_ik.JobError:
            if time.monotonic() > deadline:
                raise


def test_workers_that_cannot_start_are_one_line(tmp_path: Path) -> None:
    """A process that may open few files starts no workers: one line on standard error says why."""
    command = 'ulimit -n 28; exec "$0" -m urdf_ik.cli workspace zyyzyz_6r --store "$1" --workers 2'
    arguments = ["bash", "-c", command, sys.executable, str(tmp_path / "map.zarr")]
    ended = subprocess.run(arguments, capture_output=True, text=True, timeout=120, check=False)
    assert ended.returncode == 2
    assert "2 worker processes could not be started ([Errno 24] Too many open files)" in ended.stderr
    assert len(ended.stderr.splitlines()) == 1
