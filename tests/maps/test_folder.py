"""Stores on the disk: killed, cut short, damaged, in use, of another question, and on a full disk."""

from __future__ import annotations

import hashlib
import os
import resource
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

import urdf_ik
from urdf_ik.maps.engine import Folder, Interrupted, run
from urdf_ik.maps.engine.store_folder import PRIVATE, finished

QUESTION = {"what": "noise", "grid": {"voxel": 0.1, "shape": [2, 3, 4]}, "made_by": "1.0"}
CHUNKS = 40


def noise(chunk: int) -> dict[str, bytes]:
    """Two files that only the chunk's number decides."""
    rng = np.random.default_rng(chunk)
    return {f"a/c/{chunk}": rng.bytes(30000), f"b/c/{chunk}": rng.bytes(100)}


def folder(path: Path, question: dict[str, object] | None = None) -> Folder:
    """A store of noise."""
    return Folder(path, question or QUESTION, CHUNKS, {"about.txt": b"noise", "state": b"begun"}, {"state": b"done"})


def contents(path: Path) -> dict[str, str]:
    """Every file of a folder, hidden ones included, with a digest of its bytes."""
    return {
        str(each.relative_to(path)): hashlib.sha256(each.read_bytes()).hexdigest()
        for each in sorted(path.rglob("*"))
        if each.is_file()
    }


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> dict[str, str]:
    """The files of a store that was made without an interruption."""
    path = tmp_path_factory.mktemp("whole") / "store"
    finish(path)
    assert len(list((path / "a/c").iterdir())) == CHUNKS
    return contents(path)


def finish(path: Path) -> int:
    """Make what is left of a store; the number of chunks that were made."""
    with folder(path) as store:
        made = run(noise, store)
        store.finish()
    return made


SLOWLY = """
import sys, time
from pathlib import Path
sys.path.insert(0, sys.argv[2])
import test_folder
from urdf_ik.maps.engine import run

def slow(chunk):
    time.sleep(0.01 if chunk < int(sys.argv[3]) else 3600.0)
    return test_folder.noise(chunk)

with test_folder.folder(Path(sys.argv[1])) as store:
    run(slow, store)
"""


def start(path: Path, chunks: int = CHUNKS) -> subprocess.Popen[bytes]:
    """A process that fills a store slowly, and waits after so many chunks."""
    here = str(Path(__file__).parent)
    return subprocess.Popen([sys.executable, "-c", SLOWLY, str(path), here, str(chunks)], stderr=subprocess.PIPE)


def wait_for(path: Path, chunks: int) -> None:
    """Wait until a store holds so many chunks."""
    deadline = time.monotonic() + 60.0
    while len(finished(path)) < chunks:
        assert time.monotonic() < deadline
        time.sleep(0.002)


def test_killed_five_times_it_ends_with_the_same_bytes(tmp_path: Path, whole: dict[str, str]) -> None:
    """SIGKILL at random moments, each run a little further on: every file is that of a run without a kill."""
    path, rng, before = tmp_path / "store", np.random.default_rng(1), 0
    for _ in range(5):
        process = start(path)
        wait_for(path, before + 1)
        time.sleep(float(rng.uniform(0.0, 0.05)))
        process.send_signal(signal.SIGKILL)
        process.communicate()
        before = min(len(finished(path)), CHUNKS - 1)
    assert before > 4
    finish(path)
    assert contents(path) == whole


def test_a_write_that_was_cut_short_counts_for_nothing(tmp_path: Path, whole: dict[str, str]) -> None:
    """Half a line of the journal, half a file under its temporary name, a file that no line of the journal knows."""
    path = tmp_path / "store"
    with folder(path) as store:
        for chunk in range(10):
            store.keep(chunk, noise(chunk))
    journal = path / PRIVATE / "journal"
    text = journal.read_bytes()
    journal.write_bytes(text[:-20])
    unfinished = path / PRIVATE / "unfinished"
    unfinished.mkdir()
    (unfinished / "10").write_bytes(b"half")
    (path / "a/c/11").write_bytes(b"from nowhere")
    assert finish(path) == CHUNKS - 9
    assert contents(path) == whole


def test_a_store_that_was_being_made_is_made(tmp_path: Path, whole: dict[str, str]) -> None:
    """Killed before its question was written, a store is an empty one; what stands beside the chunks is mended, too."""
    path = tmp_path / "store"
    (path / PRIVATE).mkdir(parents=True)
    finish(path)
    assert contents(path) == whole
    (path / "about.txt").write_text("nois")
    (path / "state").unlink()
    assert finish(path) == 0
    assert contents(path) == whole


@pytest.mark.parametrize("harm", ["flipped", "cut", "gone", "swapped"])
def test_chunks_that_changed_on_the_disk_are_made_again(tmp_path: Path, whole: dict[str, str], harm: str) -> None:
    """One bit of a finished store, half a file, no file, the bytes of another chunk: only these are made again."""
    path = tmp_path / "store"
    finish(path)
    file = path / "a/c/7"
    data = bytearray(file.read_bytes())
    if harm == "flipped":
        data[12345] ^= 4
        file.write_bytes(data)
    elif harm == "cut":
        file.write_bytes(data[:100])
    elif harm == "gone":
        file.unlink()
    else:
        shutil.copy(path / "a/c/8", file)
    assert finish(path) == 1
    assert finish(path) == 0
    assert contents(path) == whole


def test_ctrl_c_keeps_what_is_done(tmp_path: Path, whole: dict[str, str]) -> None:
    """The message says how much, and the next run goes on from there."""
    path = tmp_path / "store"

    def until_ten(chunk: int) -> dict[str, bytes]:
        if chunk == 10:
            raise KeyboardInterrupt
        return noise(chunk)

    with folder(path) as store, pytest.raises(Interrupted, match=r"10 of 40 chunks are kept"):
        run(until_ten, store)
    assert finish(path) == CHUNKS - 10
    assert contents(path) == whole


def test_a_write_that_fails_keeps_what_is_done(tmp_path: Path, whole: dict[str, str]) -> None:
    """A limit on the size of files fails writes half way, as a full disk does: chunk 1 is not there at all."""
    path = tmp_path / "store"
    with folder(path) as store:
        store.keep(0, noise(0))
        soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
        resource.setrlimit(resource.RLIMIT_FSIZE, (20000, hard))
        try:
            with pytest.raises(urdf_ik.JobError, match=r"cannot write .*store: .*1 of 40 chunks are kept"):
                store.keep(1, noise(1))
        finally:
            resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))
    assert not (path / "a/c/1").exists() and finished(path) == {0}
    assert finish(path) == CHUNKS - 1
    assert contents(path) == whole


FULL = """
set -e
mount -t tmpfs -o size={size} tmpfs "$1"
"$2" -c "$3" "$1/store" "$4" 40 || true
cp -r "$1/store" "$5"
"""


def test_a_full_disk_keeps_what_is_done(tmp_path: Path, whole: dict[str, str]) -> None:
    """On a file system of 700 kB the run ends in words; its store, moved to a larger one, is gone on with."""
    small, moved = tmp_path / "small", tmp_path / "moved"
    small.mkdir()
    here, script = str(Path(__file__).parent), FULL.format(size="700k")
    command = ["unshare", "--mount", "--map-root-user", "sh", "-c", script, "sh", str(small), sys.executable, SLOWLY]
    try:
        done = subprocess.run([*command, here, str(moved)], capture_output=True, text=True, check=False, timeout=120)
    except FileNotFoundError:
        pytest.skip("no unshare here: no small file system can be mounted")
    if "mount" in done.stderr and not moved.exists():
        pytest.skip(f"no small file system can be mounted: {done.stderr.strip()}")
    assert "No space left on device" in done.stderr and "chunks are kept" in done.stderr, done.stderr
    kept = len(finished(moved))
    assert 0 < kept < CHUNKS
    assert finish(moved) == CHUNKS - kept
    assert contents(moved) == whole


def test_a_store_of_another_question_is_refused_with_the_difference(tmp_path: Path, whole: dict[str, str]) -> None:
    """The grid, the version, a thing that only one of the two has; the store is left as it was."""
    path = tmp_path / "store"
    finish(path)
    for change, words in (
        ({"grid": {"voxel": 0.2, "shape": [2, 3, 4]}}, r"grid\.voxel is 0\.1 in the store and 0\.2 now"),
        ({"made_by": "2.0"}, r'made_by is "1\.0" in the store and "2\.0" now'),
        ({"seed": 3}, r"seed is not set in the store and 3 now"),
    ):
        with pytest.raises(urdf_ik.JobError, match=words):
            folder(path, {**QUESTION, **change})
    assert contents(path) == whole


def test_a_store_in_use_is_refused_with_who_uses_it(tmp_path: Path) -> None:
    """By another process of this machine, until it is gone; by another machine, until its file is deleted."""
    path = tmp_path / "store"
    process = start(path, 1)
    wait_for(path, 1)
    with pytest.raises(urdf_ik.JobError, match=rf"in use by another run, process {process.pid} on "):
        folder(path)
    process.send_signal(signal.SIGKILL)
    process.communicate()
    folder(path).close()
    lock = path / PRIVATE / "lock"
    lock.write_text('{"pid": 1, "host": "elsewhere", "since": "now"}')
    with pytest.raises(urdf_ik.JobError, match=r"process 1 on elsewhere.*delete .*lock"):
        folder(path)
    lock.unlink()
    folder(path).close()


def test_what_is_no_store_is_left_alone(tmp_path: Path) -> None:
    """A file, a folder with something else, an address, a folder that is not there."""
    (tmp_path / "file").write_text("text")
    (tmp_path / "full").mkdir()
    (tmp_path / "full" / "letter").write_text("text")
    for path, words in (
        (tmp_path / "file", "is a file"),
        (tmp_path / "full", "no store of this package"),
        (Path("missing") / "store", "there is no folder"),
    ):
        with pytest.raises(urdf_ik.JobError, match=words):
            folder(path)
    with pytest.raises(urdf_ik.JobError, match="a store is a folder on a disk"):
        Folder("s3://bucket/map.zarr", QUESTION, 1)
    assert os.listdir(tmp_path / "full") == ["letter"]
