#!/usr/bin/env python3
"""Poses a second of ``arm.ik`` on one thread and on two, for batches of several sizes.

    python benchmarks/threads.py [--robot NAME ...] [--batch N ...] [--repeats R] [--alone]

One thread and two alternate; of the repetitions the median counts. Other work on the machine takes the second core
away, and then two threads are no faster than one. ``--alone`` measures at a real-time priority, before which other work
waits: under Linux, as root, and for a second or so.
"""

import argparse
import os
import time

import numpy as np
from robots import ROBOTS

import urdf_ik

POSES = 200_000  # that each size solves in all


def main() -> None:
    """Print a line for each arm and size."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--robot", nargs="*", default=[robot.name for robot in ROBOTS])
    parser.add_argument("--batch", type=int, nargs="*", default=[1_000, 10_000, 100_000])
    parser.add_argument("--alone", action="store_true")
    options = parser.parse_args()
    rng = np.random.default_rng(0)
    print("| arm | poses | 1 thread [k/s] | 2 threads [k/s] | times as fast | processor time a pose [us] |")
    print("|---|---:|---:|---:|---:|---:|")
    for robot in ROBOTS:
        if robot.name not in options.robot:
            continue
        arm = urdf_ik.load(robot.urdf, base="base", tip="tool")
        targets = {batch: arm.fk(rng.uniform(-3.0, 3.0, (batch, arm.dof))) for batch in options.batch}
        for batch, T in targets.items():
            wall, cpu = seconds(arm, T, max(5, POSES // batch // 4), options.alone)
            rates = [batch / each / 1e3 for each in wall]
            print(
                f"| {robot.name} | {batch} | {rates[0]:.0f} | {rates[1]:.0f} | {rates[1] / rates[0]:.2f} "
                f"| {1e6 * cpu[0] / batch:.3f}, {1e6 * cpu[1] / batch:.3f} |"
            )


def seconds(arm: urdf_ik.Arm, T: np.ndarray, repeats: int, alone: bool) -> tuple[list[float], list[float]]:
    """Medians of wall-clock and processor time of a call, with one thread and with two."""
    arm.ik(T, threads=2)
    taken = np.zeros((2, 2, repeats))
    if alone:
        os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(1))
    try:
        for k in range(repeats):
            for threads in (1, 2) if k % 2 else (2, 1):
                begin = time.perf_counter(), time.process_time()
                arm.ik(T, threads=threads)
                taken[:, threads - 1, k] = time.perf_counter() - begin[0], time.process_time() - begin[1]
    finally:
        if alone:
            os.sched_setscheduler(0, os.SCHED_OTHER, os.sched_param(0))
    wall, cpu = np.median(taken, axis=-1).tolist()
    return wall, cpu


if __name__ == "__main__":
    main()
