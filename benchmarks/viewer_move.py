#!/usr/bin/env python3
"""What one move of the viewer's target costs: solving, limits, self-collision, singularity, and placing all links.

    python benchmarks/viewer_move.py [--arms NAME ...] [--moves N]

The target goes round a circle through the arm's first pose, as a hand would drag it. The goal for six joints: solving
and marking below 2 ms. Measured is the processor's time in this thread, so that other programs do not count.
"""

from __future__ import annotations

import argparse
import time

import numpy as np

import urdf_ik
from urdf_ik.show.viewer import state as states

ARMS = ("zyyzyz_6r", "puma_560", "ur5", "srs_7r")
GOAL = 2.0


def moves(name: str, count: int) -> tuple[np.ndarray, np.ndarray]:
    """Milliseconds (count,) of solving and marking, and of placing every link of every ghost."""
    arm = urdf_ik.load(name)
    state = states.start(arm)
    home, radius = state.target, 0.1 * arm.chain.size
    solving, placing = np.empty(count), np.empty(count)
    for k, angle in enumerate(np.linspace(0.0, 2.0 * np.pi, count)):
        T = home.copy()
        T[:3, 3] += radius * np.array([np.cos(angle) - 1.0, np.sin(angle), 0.3 * np.sin(2.0 * angle)])
        begin = time.thread_time()
        state = states.with_target(state, T)
        solved = time.thread_time()
        arm.link_poses(np.stack([state.q, *(ghost.q for ghost in state.ghosts)]))
        solving[k], placing[k] = 1e3 * (solved - begin), 1e3 * (time.thread_time() - solved)
    return solving, placing


def main() -> None:
    """Print a line an arm."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--arms", nargs="+", default=ARMS, help="catalogue names or URDF files")
    parser.add_argument("--moves", type=int, default=1000)
    arguments = parser.parse_args()
    print(f"{'arm':<16}{'solve and mark [ms]: median':>28}{'99 %':>8}{'most':>8}{'links [ms]: median':>22}")
    for name in arguments.arms:
        solving, placing = moves(name, arguments.moves)
        middle, late = np.percentile(solving, [50, 99])
        met = "" if late < GOAL else f"   over {GOAL:g} ms"
        print(f"{name:<16}{middle:>28.2f}{late:>8.2f}{solving.max():>8.2f}{np.median(placing):>22.2f}{met}")


if __name__ == "__main__":
    main()
