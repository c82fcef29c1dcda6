#!/usr/bin/env python3
"""A map in a store: poses a second of this process, of one worker and of two, beside the bare batch call; and memory.

    python benchmarks/scale.py [--robot NAME] [--voxel M] [--orientations N] [--block POSES] [--workers N ...]
                               [--repeats R] [--small] [--within]

The bare batch call is ``arm.ik`` on blocks of the same poses, made beforehand, between the maps. What a chunk costs
beside its poses is the difference between the map in blocks and in blocks a sixteenth as large (``--small``). Ways to
make the map alternate, and the best of the repeats counts, since other work on the machine only ever adds time.
Processor time, of the workers and of this process, says what the work costs where the clock on the wall is ruled by
that other work. Peak memory is that of each process.
"""

import argparse
import resource
import shutil
import sys
import tempfile
import time
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

import urdf_ik
from urdf_ik.maps import cluster, workspaces
from urdf_ik.maps.workspaces.creation import samples, targets

MB = 2**20 if sys.platform == "darwin" else 2**10


def peak() -> float:
    """Peak memory of this process [MB]."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / MB


class Bare:
    """``arm.ik`` on stacks drawn from the whole map: processor time [s] a pose."""

    def __init__(self, arm: urdf_ik.Arm, options: argparse.Namespace, grid: workspaces.Grid) -> None:
        self.arm, self.chosen = arm, samples(arm, options.orientations)
        self.centres = grid.centres_in(grid.whole)
        self.positions = max(1, min(options.block, 2**18) // options.orientations)
        self.rng, self.found = np.random.default_rng(0), list[float]()

    def measure(self, calls: int = 5) -> None:
        """Some more calls."""
        for _ in range(calls):
            start = int(self.rng.integers(0, max(1, len(self.centres) - self.positions)))
            stack = targets(self.arm.task, self.chosen, self.centres[start : start + self.positions])
            begin = time.process_time()
            self.arm.ik(stack)
            self.found.append((time.process_time() - begin) / len(stack))

    @property
    def seconds(self) -> float:
        """Median of the calls: some blocks have fewer solutions than others."""
        return float(np.median(self.found))


class Made(NamedTuple):
    """What a map took: seconds on the wall, of the makers' processors and of this process beside them; and its size."""

    wall: float
    makers: float
    keeper: float
    chunks: int
    size: int


def made(arm: urdf_ik.Arm, options: argparse.Namespace, block: int, client: Any) -> Made:
    """Make the map, and delete it."""
    folder = Path(tempfile.mkdtemp(dir=options.folder))
    before, own, begin = _of_workers(client, "cpu"), time.process_time(), time.perf_counter()
    found = workspaces.stored_workspace(
        arm, folder / "map.zarr", options.voxel, options.orientations, within_limits=options.within, block=block,
        client=client,
    )  # fmt: skip
    wall, own = time.perf_counter() - begin, time.process_time() - own
    makers = sum(_of_workers(client, "cpu")) - sum(before)
    size = sum(each.stat().st_size for each in folder.rglob("*") if each.is_file())
    shutil.rmtree(folder)
    return Made(wall, makers or own, own if makers else 0.0, found.blocks.count, size)


def least(runs: list[Made]) -> Made:
    """The least of each time."""
    return Made(*(min(each) for each in zip(*runs, strict=True)))


def main() -> None:
    """Print a line for each way to make the map."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--robot", default="zyyzyz_6r")
    parser.add_argument("--voxel", type=float, default=0.1)
    parser.add_argument("--orientations", type=int, default=103)
    parser.add_argument("--block", type=int, default=2**18)
    parser.add_argument("--workers", type=int, nargs="*", default=[0, 1, 2], help="0: this process")
    parser.add_argument("--within", action="store_true", help="count solutions within the limits, too")
    parser.add_argument("--small", action="store_true", help="measure what a chunk costs, too")
    parser.add_argument("--repeats", type=int, default=3)
    parser.add_argument("--folder", help="where the stores are made")
    options = parser.parse_args()
    arm = urdf_ik.load(options.robot)
    grid = workspaces.workspace(arm, options.voxel, 1, within_limits=False).grid
    poses, bare = grid.count * options.orientations, Bare(arm, options, grid)
    clients = {count: None if count == 0 else cluster.connect(workers=count) for count in options.workers}
    for count, client in clients.items():
        if client is not None:
            client.wait_for_workers(count)
        made(arm, argparse.Namespace(**{**vars(options), "voxel": 1.0}), options.block, client)  # all is imported
    runs: dict[tuple[int, bool], list[Made]] = {}
    for _ in range(options.repeats):
        for count, client in clients.items():
            bare.measure()
            for small in (False, True)[: 1 + options.small]:
                block = options.block // (16 if small else 1)
                runs.setdefault((count, small), []).append(made(arm, options, block, client))
    print(f"{arm.name}: {poses:.4g} poses; bare batch call {1e6 * bare.seconds:.3f} us of a processor a pose")
    for count, client in clients.items():
        best = least(runs[count, False])
        words = f"{count} worker{'s' * (count > 1)}" if count else "this process"
        print(
            f"{words}: {best.wall:.1f} s, {poses / best.wall / 1e6:.2f} million poses/s, {best.chunks} chunks, "
            f"{best.chunks / best.wall:.2f} chunks/s, {best.size / 1e6:.1f} MB on the disk\n"
            f"  of a processor: {1e6 * best.makers / poses:.3f} us a pose, "
            f"{100 * bare.seconds * poses / best.makers:.0f} % of the bare call's speed; "
            f"{1e3 * best.keeper / best.chunks:.1f} ms a chunk of this process beside"
        )
        if options.small:
            small = least(runs[count, True])
            more = small.chunks - best.chunks
            wall, cpu = small.wall - best.wall, small.makers + small.keeper - best.makers - best.keeper
            print(
                f"  a chunk beside its poses, {small.chunks} against {best.chunks}: {1e3 * wall / more:.1f} ms, of "
                f"processors {1e3 * cpu / more:.1f} ms"
            )
        print(f"  peak memory: this process {peak():.0f} MB", end="")
        print("".join(f", a worker {each:.0f} MB" for each in _of_workers(client, "peak")), flush=True)
        if client is not None:
            client.close()


def _of_workers(client: Any, what: str) -> list[float]:
    """Processor time [s] or peak memory [MB] of each worker; [] where this process works."""

    def found() -> float:  # workers do not have this file: it travels as its code
        import resource

        used = resource.getrusage(resource.RUSAGE_SELF)
        return used.ru_utime + used.ru_stime if what == "cpu" else used.ru_maxrss / 2**10

    return [] if client is None else list(client.run(found).values())


if __name__ == "__main__":
    main()
