#!/usr/bin/env python3
"""Poses a second of planar and SCARA arms in a batch, one thread, beside what copying their output costs.

    python benchmarks/few_joints.py [--poses N] [--repeats R]

Output: joint vectors and flags of both elbows. The goal of each row is 10 million poses a second, or 70 percent of what
copying the output costs, whichever is less. Repetitions alternate and the best one counts.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable
from typing import Any

import numpy as np

import urdf_ik

LINK = '<link name="{}"/>'
JOINT = (
    '<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/><origin xyz="{xyz}"/>'
    '<axis xyz="0 0 1"/><limit lower="-3" upper="3" effort="1" velocity="1"/></joint>'
)


def parallel_arm(kinds: str) -> Any:
    """An arm whose axes all point up, one link of 0.4 m behind each turning joint; kinds such as 'RRPR'."""
    names = ["base", *(f"link_{i}" for i in range(1, len(kinds))), "last", "tool"]
    parts = [LINK.format(name) for name in names]
    reach = "0 0 0.1"
    for i, kind in enumerate(kinds):
        parts.append(
            JOINT.format(
                name=f"joint_{i + 1}",
                kind="prismatic" if kind == "P" else "revolute",
                parent=names[i],
                child=names[i + 1],
                xyz=reach,
            )
        )
        reach = "0.4 0 0" if kind == "R" else "0 0 0"
    parts.append(
        f'<joint name="tip" type="fixed"><parent link="last"/><child link="tool"/><origin xyz="{reach}"/></joint>'
    )
    return urdf_ik.load(f'<robot name="{kinds}">{"".join(parts)}</robot>', "base", "tool")


def best(work: Callable[[], Any], repeats: int) -> float:
    """Seconds of the fastest of so many calls, after one that warms up."""
    work()
    took = []
    for _ in range(repeats):
        start = time.perf_counter()
        work()
        took.append(time.perf_counter() - start)
    return min(took)


def main() -> None:
    """Print one row an arm."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--poses", type=int, default=200_000)
    parser.add_argument("--repeats", type=int, default=9)
    options = parser.parse_args()
    rng = np.random.default_rng(0)
    print("| arm | target | million poses a second | copying | ratio | us a call | goal |")
    print("|---|---|---:|---:|---:|---:|---|")
    for kinds, task in (("RR", "planar position"), ("RR", "pose"), ("RRR", "pose"), ("RRPR", "pose"), ("PRRR", "pose")):
        arm = parallel_arm(kinds)
        poses = arm.fk(rng.uniform(-2.5, 2.5, (options.poses, arm.dof)))
        targets = np.ascontiguousarray(arm.solver.control.plane.coordinates(poses)[:, :2]) if task != "pose" else poses
        solver = arm.for_task(task)
        solutions = solver.ik(targets)
        q, flags = solutions._q, solutions._info
        to_q, to_flags = np.empty_like(q), np.empty_like(flags)

        # Into arrays that exist, as the copies have them too.
        def solve(solver=solver, targets=targets, solutions=solutions) -> None:
            solver.ik(targets, out=solutions)

        def copy(q=q, flags=flags, to_q=to_q, to_flags=to_flags) -> None:
            np.copyto(to_q, q)
            np.copyto(to_flags, flags)

        def one(arm=solver, target=targets[0]) -> None:
            for _ in range(200):
                arm.ik(target)

        rate = 1e-6 * options.poses / best(solve, options.repeats)
        copying = 1e-6 * options.poses / best(copy, options.repeats)
        call = 1e6 * best(one, options.repeats) / 200
        goal = min(10.0, 0.7 * copying)
        print(f"| {kinds} | {task} | {rate:.2f} | {copying:.1f} | {rate / copying:.2f} | {call:.2f} "
              f"| {'reached' if rate >= goal else 'missed'} ({goal:.1f}) |")  # fmt: skip


if __name__ == "__main__":
    main()
