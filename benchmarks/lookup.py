#!/usr/bin/env python3
"""Time to look up poses in maps of several numbers of orientations: ``found.look_up(T)`` in one call.

    python benchmarks/lookup.py [--robot NAME] [--poses N] [--orientations N ...]

Wall-clock and processor time, best of three.
"""

from __future__ import annotations

import argparse
import time

import numpy as np

import urdf_ik


def main() -> None:
    """Print a line for each number of orientations."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--robot", default="zyyzyz_6r")
    parser.add_argument("--poses", type=int, default=10**6)
    parser.add_argument("--orientations", type=int, nargs="*", default=[103, 200, 1000])
    options = parser.parse_args()
    arm = urdf_ik.load(options.robot)
    T = arm.fk(np.random.default_rng(0).uniform(-3.0, 3.0, (options.poses, arm.dof)))
    for count in options.orientations:
        found = urdf_ik.maps.workspace(arm, 0.4, count, within_limits=False)
        taken = []
        for _ in range(3):
            begin = time.perf_counter(), time.process_time()
            found.look_up(T)
            taken.append((time.perf_counter() - begin[0], time.process_time() - begin[1]))
        wall, cpu = np.min(taken, axis=0)
        print(f"{options.poses} poses, {count} orientations: {wall:.2f} s, of a processor {cpu:.2f} s", flush=True)


if __name__ == "__main__":
    main()
