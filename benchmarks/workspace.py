#!/usr/bin/env python3
"""A workspace map's poses a second beside those of the bare batch kernel on the same poses, and its peak memory.

    python benchmarks/workspaces.py [--robot NAME] [--voxel M] [--orientations N] [--repeats R]

One thread. The kernel solves chunk by chunk into the same arrays, with no more work than handing it the poses; the map
makes the poses, solves, counts and keeps. Both run in turns; the best processor time of each counts. The goals for
counts of solutions alone, `zyyzyz_6r`, voxels of 0.1 m and 200 orientations: 60 percent of the kernel, less than 1 GiB.
"""

from __future__ import annotations

import argparse
import resource
import sys
import time

import numpy as np

import urdf_ik
from urdf_ik.maps import workspaces
from urdf_ik.maps.workspaces.orientations import Targets


def kernel_seconds(arm: urdf_ik.Arm, found: workspaces.WorkspaceMap) -> float:
    """Seconds that the kernel alone takes for all poses of a map."""
    count = len(found.samples)
    step = max(1, workspaces.CHUNK // count)
    targets = Targets(arm.task, found.samples, step)
    columns = len(found.about.branches)
    q, flags = np.empty((step * count, columns, arm.dof)), np.empty((step * count, columns), np.uint8)
    total = 0.0
    for start in range(0, found.grid.count, step):
        poses = targets.at(found.grid.centres(slice(start, min(start + step, found.grid.count))))
        m = len(poses)
        begin = time.process_time()
        arm._core.solve(poses, None, q[:m], flags[:m], None, 1)
        total += time.process_time() - begin
    return total


def main() -> None:
    """Print the two rates for each thing that can be counted."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--robot", default="zyyzyz_6r")
    parser.add_argument("--voxel", type=float, default=0.1)
    parser.add_argument("--orientations", type=int, default=200)
    parser.add_argument("--repeats", type=int, default=3)
    options = parser.parse_args()
    arm = urdf_ik.load(options.robot)
    if arm.task != "pose":
        parser.error(f"{options.robot} controls {arm.task!r}; the comparison is for arms that control poses")
    small = workspaces.workspace(arm, 0.5, 2)
    print(f"{arm.name}, {arm.structure.family}: {small.about.sampled}")
    print(f"{'counted':<26}{'million poses/s':>16}{'kernel':>8}{'ratio':>7}")
    for name, within in (
        ("solutions", False),
        ("solutions, within limits", True),
    ):
        bare, whole = [], []
        for _ in range(options.repeats):
            start = time.process_time()
            found = workspaces.workspace(arm, options.voxel, options.orientations, within_limits=within)
            whole.append(time.process_time() - start)
            bare.append(kernel_seconds(arm, found))
        poses = found.solutions.size
        rates = poses / min(whole) / 1e6, poses / min(bare) / 1e6
        print(f"{name:<26}{rates[0]:>16.2f}{rates[1]:>8.2f}{rates[0] / rates[1]:>7.2f}", flush=True)
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / (2**30 if sys.platform == "darwin" else 2**20)
    print(f"{poses} poses; peak memory of the process {peak:.2f} GiB")


if __name__ == "__main__":
    main()
