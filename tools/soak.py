"""A soak: work of many kinds in random order from a seed, with memory and descriptors recorded after each piece.

    python tools/soak.py [--minutes 30] [--seed 0] [--only NAME ...]

Threads and forked processes solve and measure clearances, worlds change, stores are killed and continued, commands get
signals at random moments, viewers are opened, moved and closed. Every answer is compared with one that was computed
alone. A line a minute goes to standard error, the table at the end to standard output. The status is 1 when an answer
differed, a command did not end as it should, or this process kept memory, descriptors, threads or children.
"""

from __future__ import annotations

import argparse
import gc
import os
import random
import signal
import subprocess
import sys
import tempfile
import threading
import time
from collections import Counter, defaultdict
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import NamedTuple

import numpy as np

import urdf_ik

ARMS = ("zyyzyz_6r", "ur5", "puma_560")
POSES = 200
STORED = ("dataset", ARMS[0], "-n", "40000")
COMMANDS = (
    ("ik", ARMS[0], "--random", "200000", "--check", "-f", "csv", "-o", "solutions.csv"),
    ("check", ARMS[0], "-n", "20000"),
    ("check", ARMS[0], "--complete", "-n", "20000"),
    ("workspace", ARMS[0], "--voxel", "0.02", "--store", "map.zarr"),
    ("dataset", ARMS[0], "-n", "2000000", "--store", "samples.zarr"),
)
INTERRUPTED = 130
PATIENCE = 300.0
"""Time after which a command counts as one that does not end [s]."""
WARM = 0.25
"""Share of the time after which the process must no longer grow: by then every piece of work has run."""
KEPT = {"memory": 64.0, "descriptors": 8, "threads": 4, "children": 0}
"""Greatest growth of what the process holds from there to the end; memory in MiB."""


class Seen(NamedTuple):
    """What the process holds: resident memory [MiB], descriptors, threads, child processes."""

    memory: float
    descriptors: int
    threads: int
    children: int

    def __str__(self) -> str:
        return (
            f"{self.memory:.0f} MiB, {self.descriptors} descriptors, {self.threads} threads, {self.children} children"
        )


class Alone(NamedTuple):
    """An arm with answers that one thread computed before any other work began."""

    arm: urdf_ik.Arm
    poses: np.ndarray
    solutions: np.ndarray
    q: np.ndarray
    clearances: np.ndarray


def seen() -> Seen:
    """What this process holds now."""
    gc.collect()
    status = dict(line.split(":", 1) for line in Path("/proc/self/status").read_text().splitlines())
    # A descriptor fewer: that of the folder itself.
    descriptors = len(os.listdir("/proc/self/fd")) - 1
    children = Path(f"/proc/self/task/{os.getpid()}/children").read_text().split()
    return Seen(int(status["VmRSS"].split()[0]) / 1024.0, descriptors, int(status["Threads"]), len(children))


def alone(name: str, rng: np.random.Generator) -> Alone:
    """An arm, and its answers by one thread."""
    arm = urdf_ik.load(name)
    poses = arm.fk(rng.uniform(-3.0, 3.0, (POSES, arm.dof)))
    q = rng.uniform(-1.5, 1.5, (20, arm.dof))
    clearances = np.asarray(arm.clearance(q)) if arm.cell.collisions.has_geometry else np.zeros(0)
    return Alone(arm, poses, arm.ik(poses, threads=1).q, q, clearances)


def same(known: Alone) -> None:
    """Compare an arm's answers, computed now, with those computed alone."""
    np.testing.assert_array_equal(known.arm.ik(known.poses).q, known.solutions)
    if len(known.clearances):
        np.testing.assert_array_equal(known.arm.clearance(known.q), known.clearances)


class Soak:
    """The pieces of work, and what they need of each other."""

    def __init__(self, seed: int, folder: Path) -> None:
        self.rng, self.numbers = random.Random(seed), np.random.default_rng(seed)
        self.folder, self.count, self.slowest = folder, 0, 0.0
        self.known = [alone(name, self.numbers) for name in ARMS]
        self._run(*STORED, "--store", str(folder / "whole.zarr"))

    def threads(self) -> None:
        """Eight threads ask all arms."""
        with ThreadPoolExecutor(8) as pool:
            for done in [pool.submit(same, self.rng.choice(self.known)) for _ in range(24)]:
                done.result()

    def forks(self) -> None:
        """Four children of a fork ask an arm while a thread of the parent does."""
        busy = threading.Thread(target=same, args=(self.rng.choice(self.known),))
        busy.start()
        children = []
        for _ in range(4):
            known = self.rng.choice(self.known)
            child = os.fork()
            if child == 0:
                status = 1
                try:
                    same(known)
                    status = 0
                finally:
                    os._exit(status)
            children.append(child)
        busy.join()
        ended = [os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) for child in children]
        assert ended == [0] * 4, f"children ended with {ended}"

    def worlds(self) -> None:
        """A world that changes 60 times answers as one that is built anew."""
        known = self.known[1]
        world, size = urdf_ik.World(), self.rng.choice((10, 300, 3000))
        places = urdf_ik.pose(self.numbers.uniform(-2.0, 2.0, (size + 60, 3)))
        for k in range(size):
            world.add(f"box {k}", urdf_ik.Box(0.05), places[k])
        for k in range(size, size + 60):
            name = self.rng.choice(world.names) if len(world) else ""
            match self.rng.randrange(3) if name else 0:
                case 0:
                    world.add(f"box {k}", urdf_ik.Box(0.05), places[k])
                case 1:
                    world.move(name, places[k])
                case _:
                    world.remove(name)
            if k % 6 == 0:
                anew = urdf_ik.World()
                for each in world:
                    anew.add(*each)
                q = known.q[k % len(known.q)]
                assert known.arm.clearance(q, world) == known.arm.clearance(q, anew)

    def kills(self) -> None:
        """A store whose command was killed is continued to the bytes of one that was not."""
        store = self._place() / "cut.zarr"
        child = self._start(*STORED, "--store", str(store))
        time.sleep(self.rng.uniform(0.0, 4.0))
        child.kill()
        child.communicate()
        self._run(*STORED, "--store", str(store))
        for file in (self.folder / "whole.zarr" / "q").rglob("*"):
            other = store / file.relative_to(self.folder / "whole.zarr")
            assert file.is_dir() or file.read_bytes() == other.read_bytes(), f"{other} differs"

    def signals(self) -> None:
        """A command that gets Ctrl-C or SIGTERM ends with status 130, without a traceback and half a file."""
        place, words = self._place(), self.rng.choice(COMMANDS)
        number = self.rng.choice((signal.SIGINT, signal.SIGTERM))
        child = self._start(*words, cwd=place, start_new_session=True)
        while child.poll() is None and not self._catches_signals(child.pid):
            time.sleep(0.002)
        wait = self.rng.uniform(0.0, 4.0)
        time.sleep(wait)
        sent = time.monotonic()
        child.send_signal(number)
        err = self._ended(child)
        took, moment = time.monotonic() - sent, f"{number.name} to {words[0]} after {wait:.3f} s"
        assert child.returncode == INTERRUPTED, f"{moment}: status {child.returncode}, {err.decode()[-300:]}"
        assert b"Traceback" not in err, f"{moment}: {err.decode()[-300:]}"
        assert not list(place.rglob("*.unfinished")), f"{moment}: half a file"
        self.slowest = max(self.slowest, took)

    def viewers(self) -> None:
        """Two viewers are open at once, get targets and joint values, and close."""
        from urdf_ik.show.viewer import Viewer

        known = self.known[0]
        with Viewer(known.arm, port=0) as one, Viewer(known.arm, port=0) as other:
            for k in range(6):
                one.move_target(known.poses[self.rng.randrange(POSES)])
                other.move_joint(k, self.rng.uniform(-1.0, 1.0))
            assert one.settle(30.0) and other.settle(30.0), "a viewer does not settle"

    def _place(self) -> Path:
        self.count += 1
        place = self.folder / str(self.count)
        place.mkdir()
        return place

    @staticmethod
    def _start(*words: str, **options: object) -> subprocess.Popen[bytes]:
        command = [sys.executable, "-X", "faulthandler", "-c", "from urdf_ik.cli import main; main()", *words]
        return subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, **options)  # type: ignore[call-overload,no-any-return]

    def _run(self, *words: str) -> None:
        child = self._start(*words)
        err = self._ended(child)
        assert child.returncode == 0, f"{' '.join(words)}: status {child.returncode}, {err.decode()[-300:]}"

    @staticmethod
    def _ended(child: subprocess.Popen[bytes]) -> bytes:
        """What a command wrote to standard error; one that does not end is killed."""
        try:
            return child.communicate(timeout=PATIENCE)[1]
        except subprocess.TimeoutExpired:
            child.kill()
            child.communicate()
            raise

    @staticmethod
    def _catches_signals(process: int) -> bool:
        """Whether the first line of the command has run: Python itself does not catch SIGTERM."""
        try:
            status = Path(f"/proc/{process}/status").read_text()
        except OSError:
            return True
        caught = next(line.split()[1] for line in status.splitlines() if line.startswith("SigCgt"))
        return bool(int(caught, 16) >> (signal.SIGTERM - 1) & 1)


PIECES: dict[str, Callable[[Soak], None]] = {
    each.__name__: each for each in (Soak.threads, Soak.forks, Soak.worlds, Soak.kills, Soak.signals, Soak.viewers)
}


def kept(records: list[tuple[float, Seen]], length: float) -> list[str]:
    """What the process holds at the end beyond what it held when it was warm."""
    warm = [each for at, each in records if at >= WARM * length] or [records[-1][1]]
    # The least of several counts: a piece may leave something to the next garbage collection.
    first, last = warm[: max(1, len(warm) // 4)], warm[-max(1, len(warm) // 4) :]
    found = []
    for field, most in KEPT.items():
        grown = min(getattr(each, field) for each in last) - max(getattr(each, field) for each in first)
        if grown > most:
            found.append(f"{field} grew by {grown:g}")
    return found


def main() -> int:
    """Run the soak and print its table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--minutes", type=float, default=30.0)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--only", nargs="*", choices=PIECES, default=list(PIECES), metavar="NAME")
    given = parser.parse_args()
    length = 60.0 * given.minutes
    # Where a script's `&` started this, Ctrl-C is ignored, and the commands would ignore it as well.
    signal.signal(signal.SIGINT, signal.default_int_handler)
    done: Counter[str] = Counter()
    failures: dict[str, list[str]] = defaultdict(list)
    with tempfile.TemporaryDirectory(prefix="urdf-ik-soak-") as folder:
        soak = Soak(given.seed, Path(folder))
        began, told = time.monotonic(), 0.0
        records = [(0.0, seen())]
        while (at := time.monotonic() - began) < length:
            name = soak.rng.choice(given.only)
            try:
                PIECES[name](soak)
            except Exception as error:
                failures[name].append(f"{type(error).__name__}: {error}")
                print(f"{at:6.0f} s {name}: {failures[name][-1]}", file=sys.stderr, flush=True)
            done[name] += 1
            records.append((time.monotonic() - began, seen()))
            if at - told > 60.0:
                told = at
                print(f"{at:6.0f} s {sum(done.values())} pieces, {records[-1][1]}", file=sys.stderr, flush=True)
    print(f"seed {given.seed}, {given.minutes:g} minutes: {', '.join(f'{done[name]} {name}' for name in done)}")
    for what, each in (("at first", records[0][1]), ("at the end", records[-1][1])):
        print(f"{what}: {each}")
    print(f"at most: {Seen(*(max(values) for values in zip(*(each for _, each in records), strict=True)))}")
    print(f"slowest end after a signal: {soak.slowest:.2f} s")
    grown = kept(records, length)
    for name, texts in failures.items():
        for text in texts:
            print(f"FAILED {name}: {text}")
    for text in grown:
        print(f"KEPT {text}")
    print("clean" if not failures and not grown else "not clean")
    return int(bool(failures or grown))


if __name__ == "__main__":
    sys.exit(main())
