"""Ctrl-C and SIGTERM at any moment of the command: status 130, no traceback, no half file, no process left.

``URDF_IK_MOMENTS=200 python -m pytest tests/cli/test_interrupts.py`` takes as many moments as its number, over all
commands; 21 by default. It prints the longest time to an end.
"""

from __future__ import annotations

import os
import random
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from command import ARM, start, succeed

from urdf_ik.maps import cluster

pytestmark = pytest.mark.skipif(not Path("/proc/self/status").exists(), reason="the test reads Linux's /proc")

COMMANDS = {
    "ik": ("ik", ARM, "--random", "200000", "--check", "-f", "csv", "-o", "solutions.csv"),
    "check": ("check", ARM, "-n", "20000"),
    "complete": ("check", ARM, "--complete", "-n", "20000"),
    "workspace": ("workspace", ARM, "--voxel", "0.02", "--store", "map.zarr"),
    "workers": ("workspace", ARM, "--voxel", "0.02", "--store", "map.zarr", "--workers", "2"),
    "scheduler": ("workspace", ARM, "--voxel", "0.02", "--store", "map.zarr", "--scheduler", "{scheduler}"),
}
MOMENTS = int(os.environ.get("URDF_IK_MOMENTS", "21"))
LATEST = {"workers": 8.0, "scheduler": 6.0}  # s after the first line of the command; others: 4
PATIENCE = 60.0


def by_default() -> None:
    """Take signals as a program in the foreground does: children of a script's ``&`` ignore Ctrl-C."""
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, signal.SIG_DFL)


def begun(child: subprocess.Popen[bytes]) -> bool:
    """Whether the first line of the command has run: since then SIGTERM is caught, which Python does not do itself."""
    for line in Path(f"/proc/{child.pid}/status").read_text().splitlines():
        if line.startswith("SigCgt"):
            return bool(int(line.split()[1], 16) >> (signal.SIGTERM - 1) & 1)
    return False


def until(condition: Callable[[], bool]) -> None:
    """Wait for something that must happen soon."""
    end = time.monotonic() + PATIENCE
    while not condition():
        assert time.monotonic() < end, "nothing happens"
        time.sleep(0.002)


def is_gone(group: int) -> bool:
    """Whether no process of a group is left but those that have ended."""
    for status in Path("/proc").glob("[0-9]*/stat"):
        try:
            state, _, of = status.read_text().rpartition(")")[2].split()[:3]
        except (FileNotFoundError, ProcessLookupError):
            continue
        if int(of) == group and state != "Z":
            return False
    return True


@pytest.fixture(scope="module")
def scheduler() -> Iterator[str]:
    """The address of a scheduler with one worker that does not belong to the command."""
    with cluster.connect(workers=1) as client:
        yield client.scheduler.address


@pytest.mark.parametrize("name", COMMANDS)
def test_a_signal_at_any_moment_ends_it(name: str, tmp_path: Path, request: pytest.FixtureRequest) -> None:
    """Over start-up and work, SIGINT to the whole group (a terminal's Ctrl-C) or SIGTERM to the process ends it."""
    rng = random.Random(name)
    longest = 0.0
    address = request.getfixturevalue("scheduler") if name == "scheduler" else ""
    words = [word.format(scheduler=address) for word in COMMANDS[name]]
    for k in range(max(1, MOMENTS // len(COMMANDS))):
        place = tmp_path / str(k)
        place.mkdir()
        number = signal.SIGINT if k % 3 else signal.SIGTERM
        wait = rng.uniform(0.0, LATEST.get(name, 4.0))
        child = start(*words, cwd=place, start_new_session=True, preexec_fn=by_default)
        until(lambda child=child: begun(child))  # type: ignore[misc]
        time.sleep(wait)
        assert child.poll() is None, child.communicate()
        sent = time.monotonic()
        if number == signal.SIGINT:
            os.killpg(child.pid, number)
        else:
            child.send_signal(number)
        child.wait(timeout=PATIENCE)
        longest = max(longest, time.monotonic() - sent)
        until(lambda child=child: is_gone(child.pid))  # type: ignore[misc]
        out, err = child.communicate(timeout=PATIENCE)
        moment = f"{number.name} after {wait:.3f} s: {err.decode()}"
        assert child.returncode == 130, moment
        assert b"Traceback" not in err and b"rror" not in err and b"xception" not in err, moment
        assert out == b"", moment
        assert not list(place.rglob("*.unfinished")) and not (place / "solutions.csv").exists(), moment
    print(f"{name}: {longest:.2f} s at most", file=sys.stderr)


INTERRUPTED = """
import os, signal
from urdf_ik.cli import interrupts
from urdf_ik.maps.store import BlockStore
interrupts.GRACE = 60.0  # on a busy machine the message takes its time
write = BlockStore.write
def written(self, block, arrays):
    if block == 1:
        os.kill(os.getpid(), signal.SIGINT)
    write(self, block, arrays)
BlockStore.write = written
"""


def test_an_interrupted_store_says_how_much_it_keeps(tmp_path: Path) -> None:
    """After the first block: the message names the blocks that are kept, and the same command continues from there."""
    words = ("workspace", ARM, "--voxel", "0.1", "--orientations", "100", "--store")
    child = start(*words, "cut.zarr", first=INTERRUPTED, cwd=tmp_path, preexec_fn=by_default)
    _, err = child.communicate(timeout=PATIENCE)
    assert (child.returncode, b"1 of " in err, b" blocks are kept" in err) == (130, True, True), err
    for store in ("cut.zarr", "whole.zarr"):
        succeed(*words, str(tmp_path / store))
    files = sorted(path.relative_to(tmp_path / "whole.zarr") for path in (tmp_path / "whole.zarr").rglob("c/*"))
    assert files
    for file in files:
        whole, cut = tmp_path / "whole.zarr" / file, tmp_path / "cut.zarr" / file
        assert whole.is_dir() or whole.read_bytes() == cut.read_bytes()


def test_an_interrupt_that_a_package_swallows_still_ends_it() -> None:
    """A package that catches BaseException around an import, as trimesh does, changes neither status nor time."""
    program = """
import os, signal
from urdf_ik.cli.interrupts import guarded
def work():
    try:
        os.kill(os.getpid(), signal.SIGINT)
    except BaseException:
        pass
    {rest}
guarded(work)
"""
    for rest in ("pass", "raise TypeError('of a half-imported package')", "import time; time.sleep(60)"):
        done = subprocess.run(
            [sys.executable, "-c", program.format(rest=rest)],
            capture_output=True,
            preexec_fn=by_default,
            timeout=30,
            check=False,
        )
        assert (done.returncode, done.stdout, done.stderr) == (130, b"", b"")


def test_an_ignored_signal_stays_ignored() -> None:
    """``nohup`` and a script's ``&`` ask a program to ignore Ctrl-C; the work goes on."""
    program = "import os, signal; from urdf_ik.cli.interrupts import guarded; guarded(lambda: {work})"
    done = subprocess.run(
        [sys.executable, "-c", program.format(work="os.kill(os.getpid(), signal.SIGINT) or print('done')")],
        capture_output=True,
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_IGN),
        timeout=30,
        check=False,
    )
    assert (done.returncode, done.stdout) == (0, b"done\n")
