#!/usr/bin/env python3
"""A map in a store: poses a second of this process, of one worker and of two, beside the bare batch call; and memory.

    python benchmarks/scale.py [--robot NAME] [--voxel M] [--orientations N] [--block POSES] [--workers N ...] [--small]

The bare batch call is ``arm.ik`` on blocks of the same poses, made beforehand. What a chunk costs beside its poses is
the difference between the map in blocks and in blocks a sixteenth as large. Peak memory is that of each process.
"""

from __future__ import annotations

import argparse
import resource
import shutil
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

import numpy as np

import urdf_ik
from urdf_ik import scale, workspace
from urdf_ik.workspace.sampling import Targets, samples

MB = 2**20 if sys.platform == "darwin" else 2**10


def peak() -> float:
    """Peak memory of this process [MB]."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / MB


def bare_rate(arm: urdf_ik.Arm, options: argparse.Namespace, grid: workspace.Grid, poses: int = 2**18) -> float:
    """Poses a second of ``arm.ik`` on a stack drawn from the whole map, as one call; the median of five."""
    chosen = samples(arm, options.orientations)
    step = max(1, poses // options.orientations)
    rng, rates = np.random.default_rng(0), []
    for _ in range(5):
        start = int(rng.integers(0, max(1, grid.count - step)))
        targets = Targets(arm.task, chosen, step).at(grid.centres(slice(start, start + step))).copy()
        begin = time.perf_counter()
        arm.ik(targets)
        rates.append(len(targets) / (time.perf_counter() - begin))
    return float(np.median(rates))


def made(
    arm: urdf_ik.Arm, options: argparse.Namespace, block: int, client: Any
) -> tuple[float, workspace.StoredMap, int]:
    """Seconds that a map takes, the map, and the bytes of its folder."""
    folder = Path(tempfile.mkdtemp(dir=options.folder))
    begin = time.perf_counter()
    found = workspace.compute(
        arm, options.voxel, options.orientations, within_limits=options.within, store=folder / "map.zarr", block=block,
        client=client,
    )  # fmt: skip
    seconds = time.perf_counter() - begin
    size = sum(each.stat().st_size for each in folder.rglob("*") if each.is_file())
    shutil.rmtree(folder)
    return seconds, found, size


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
    parser.add_argument("--folder", help="where the stores are made")
    options = parser.parse_args()
    arm = urdf_ik.load(options.robot)
    grid = workspace.compute(arm, options.voxel, 1, within_limits=False).grid
    poses = grid.count * options.orientations
    print(f"{arm.name}: {poses:.4g} poses; bare batch call {bare_rate(arm, options, grid) / 1e6:.2f} million poses/s")
    for workers in options.workers:
        client = None if workers == 0 else scale.connect(workers=workers)
        if client is not None:
            client.wait_for_workers(workers)
            made(arm, argparse.Namespace(**{**vars(options), "voxel": 1.0}), options.block, client)  # all is imported
        seconds, found, size = made(arm, options, options.block, client)
        words = f"{workers} workers" if workers else "this process"
        print(
            f"{words}: {seconds:.1f} s, {poses / seconds / 1e6:.2f} million poses/s, {found.blocks.count} chunks, "
            f"{found.blocks.count / seconds:.2f} chunks/s, {size / 1e6:.1f} MB on the disk", flush=True,
        )  # fmt: skip
        if options.small:
            longer, small, _ = made(arm, options, options.block // 16, client)
            each = (longer - seconds) / (small.blocks.count - found.blocks.count)
            print(f"  {small.blocks.count} chunks in {longer:.1f} s: {1e3 * each:.1f} ms a chunk beside its poses")
        print(f"  peak memory: this process {peak():.0f} MB", end="")
        if client is not None:
            print("".join(f", a worker {each:.0f} MB" for each in client.run(_peak()).values()), end="")
            client.close()
        print(flush=True)


def _peak() -> Any:
    """The same for workers, who do not have this file."""

    def found() -> float:
        import resource

        return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 2**10

    return found


if __name__ == "__main__":
    main()
