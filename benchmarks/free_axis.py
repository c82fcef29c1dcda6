#!/usr/bin/env python3
"""Paths of arms whose tool may turn about its axis: what turning saves, and what brute force finds.

    python benchmarks/free_axis.py [--arms ur5 puma_560 ...] [--paths N] [--waypoints M] [--values V] [--seed S]

Random straight lines of up to 0.25 m and half a radian are followed with the rotation about the tool's z axis fixed and
with it free. Brute force solves every waypoint at V rotations and finds the cheapest way by dynamic programming along
each branch, steps of up to 0.35 rad of the rotation from one waypoint to the next; it heeds no tolerance between the
waypoints. All costs are sums of squares, the default of ``follow``.
"""

from __future__ import annotations

import argparse
import time

import numpy as np
from numpy.typing import NDArray

import urdf_ik

Array = NDArray[np.float64]
WINDOW = 0.35
"""rad that the rotation may change by from one waypoint to the next."""


def random_path(arm: urdf_ik.Arm, rng: np.random.Generator, count: int) -> Array:
    """A straight line from the pose of random joint vectors, turning on the way."""
    low, high = np.clip(arm.limits.T, -1.5, 1.5)
    start = arm.fk(rng.uniform(low, high))
    end = start @ urdf_ik.pose([0.0, 0.0, 0.0], rpy=rng.uniform(-0.5, 0.5, 3))
    end[:3, 3] = start[:3, 3] + rng.uniform(-0.25, 0.25, 3)
    return urdf_ik.line(start, end, count)


def brute_force(arm: urdf_ik.Arm, path: Array, count: int) -> float:
    """The least sum of squares over ``count`` rotations at every waypoint; infinite where there is no way."""
    values = np.linspace(-np.pi, np.pi, count, endpoint=False)
    solutions = arm.ik(path[:, None], redundancy=values)
    inside = solutions.within_limits().valid
    around = np.arange(-int(WINDOW / (values[1] - values[0])), 1 + int(WINDOW / (values[1] - values[0])))
    neighbours = (np.arange(count)[:, None] + around) % count
    best = np.inf
    for column in range(solutions.q.shape[-2]):
        q, good = solutions.q[:, :, column], inside[:, :, column]
        cost = np.where(good[0], 0.0, np.inf)
        for k in range(1, len(path)):
            if not np.isfinite(cost).any():
                break
            total = cost[neighbours]
            for j in range(arm.dof):
                step = q[k, :, j, None] - q[k - 1, :, j][neighbours]
                total = total + (step - 2.0 * np.pi * np.round(step / (2.0 * np.pi))) ** 2
            cost = np.where(good[k], np.nan_to_num(total, nan=np.inf).min(axis=1), np.inf)
        best = min(best, float(cost.min()))
    return best


def main() -> None:
    """Print a line a path."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--arms", nargs="+", default=["ur5", "puma_560", "zyyzyz_6r"])
    parser.add_argument("--paths", type=int, default=6)
    parser.add_argument("--waypoints", type=int, default=30)
    parser.add_argument("--values", type=int, default=3600)
    parser.add_argument("--seed", type=int, default=0)
    asked = parser.parse_args()
    heads = ("fixed", 10), ("free", 10), ("brute force", 13), ("free / brute", 14), ("fixed [s]", 11), ("free [s]", 10)
    print(f"{'arm':<12}" + "".join(f"{head:>{width}}" for head, width in heads))
    for name in asked.arms:
        fixed = urdf_ik.load(name)
        free = fixed.with_free_axis("z")
        rng = np.random.default_rng(asked.seed)
        for _ in range(asked.paths):
            path = random_path(fixed, rng, asked.waypoints)
            costs, seconds = [], []
            for arm in (fixed, free):
                begin = time.perf_counter()
                costs.append(arm.follow(path, collisions=False).cost)
                seconds.append(time.perf_counter() - begin)
            least = brute_force(free, path, asked.values) if asked.values else np.nan
            share = costs[1] / least if np.isfinite(least) else np.nan
            print(
                f"{name:<12}{costs[0]:>10.5f}{costs[1]:>10.5f}{least:>13.5f}{share:>14.4f}"
                f"{seconds[0]:>11.2f}{seconds[1]:>10.2f}",
                flush=True,
            )


if __name__ == "__main__":
    main()
