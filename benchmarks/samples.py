#!/usr/bin/env python3
"""A data set made by several numbers of workers: whether its bytes are the same, and what it costs.

    python benchmarks/samples.py [--robot NAME] [-n N] [--workers N ...] [--kind zarr|parquet] [--folder FOLDER]

All files of each store are read, and their digest is compared.
"""

from __future__ import annotations

import argparse
import hashlib
import shutil
import tempfile
import time
from pathlib import Path

import urdf_ik
from urdf_ik.maps import engine


def main() -> None:
    """Print a line for each number of workers."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--robot", default="planar_2r")
    parser.add_argument("-n", type=int, default=10**7)
    parser.add_argument("--workers", type=int, nargs="*", default=[1, 2, 4])
    parser.add_argument("--kind", default="zarr", choices=["zarr", "parquet"])
    parser.add_argument("--folder", help="where the stores are made")
    options = parser.parse_args()
    arm, digests = urdf_ik.load(options.robot), set()
    for count in options.workers:
        folder = Path(tempfile.mkdtemp(dir=options.folder))
        with engine.connect(workers=count) as client:
            client.wait_for_workers(count)
            before, begin = sum(client.run(_used).values()), time.perf_counter()
            store = folder / f"samples.{options.kind}"
            urdf_ik.maps.dataset(arm, options.n, collisions=False, store=store, client=client)
            wall, cpu = time.perf_counter() - begin, sum(client.run(_used).values()) - before
        found, size = _digest(folder)
        shutil.rmtree(folder)
        digests.add(found)
        print(
            f"{arm.name}, {options.n:.4g} samples, {count} workers: {wall:.0f} s, of their processors {cpu:.0f} s, "
            f"{size / 1e6:.0f} MB, digest {found[:16]}", flush=True,
        )  # fmt: skip
    print("the same bytes" if len(digests) == 1 else "OTHER BYTES")


def _used() -> float:
    """Processor time [s] of a process; workers get it as its code."""
    import time

    return time.process_time()


def _digest(folder: Path) -> tuple[str, int]:
    """Of the names and bytes of all files, and how many bytes these are."""
    total, size = hashlib.blake2b(), 0
    for path in sorted(path for path in folder.rglob("*") if path.is_file()):
        data = path.read_bytes()
        total.update(f"{path.relative_to(folder)} {len(data)} ".encode() + hashlib.blake2b(data).digest())
        size += len(data)
    return total.hexdigest(), size


if __name__ == "__main__":
    main()
