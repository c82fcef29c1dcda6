#!/usr/bin/env python3
"""Following a stream of poses, one a call: ``tracker.step`` against ssik's ``Tracker.update``.

    python benchmarks/tracker.py [--cycles N] [--repeats R] [--dt S] [--seed S]

Both follow the poses of the same smooth joint paths, each of its own model of the arm (ssik's prebuilt one), a Python
call a pose; the joint vector and the status of every answer are read. Repetitions alternate in the same process and the
best one counts. ``answered`` is how often each status came. Without ssik only our rows are printed.
"""

import argparse
import math
import sys
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import bench
import numpy as np
from robots import UR5, UR5E, Robot
from seven_joints import IIWA, PANDA

import urdf_ik

# Arms, their names among ssik's prebuilt ones (None: it has none), and joint vectors [rad] that paths go around.
ARMS: tuple[tuple[Robot, str | None, tuple[float, ...]], ...] = (
    (UR5, None, (0.3, -1.2, 1.4, -0.6, 1.1, 0.2)),
    (UR5E, "ur5e", (0.3, -1.2, 1.4, -0.6, 1.1, 0.2)),
    (IIWA, "iiwa14", (0.2, 0.6, 0.3, -1.2, 0.2, 0.9, 0.3)),
    (PANDA, "panda", (0.2, -0.4, 0.3, -1.9, 0.2, 1.8, 0.5)),
)


@dataclass(frozen=True)
class Row:
    """What one tracker did on one arm.

    Attributes:
        robot: the arm.
        tracker: whose it is.
        us: microseconds a call, the best repetition's mean.
        answered: how often each status came.
        worst: the greatest error [m or rad] of the answers called ok, by Pinocchio; ssik's by its own model.
    """

    robot: str
    tracker: str
    us: float
    answered: str
    worst: float


def path(centre: tuple[float, ...], cycles: int, dt: float, seed: int) -> np.ndarray:
    """Joint vectors (cycles, n) [rad] around a centre, at most 0.5 rad/s fast."""
    rng, t = np.random.default_rng(seed), dt * np.arange(cycles)[:, None]
    phases = rng.uniform(0.0, 2.0 * np.pi, (2, len(centre)))
    Q: np.ndarray = np.array(centre) + 0.2 * np.sin(t + phases[0]) + 0.1 * np.sin(2.0 * t + phases[1])
    return Q


def measure(
    robot: Robot, prebuilt: str | None, centre: tuple[float, ...], cycles: int, repeats: int, dt: float, seed: int
) -> list[Row]:
    """The rows of one arm."""
    Q = path(centre, cycles, dt, seed)
    arm = urdf_ik.load(robot.urdf, base="base", tip="tool")
    targets = [robot.reference.pose(q) for q in Q]
    answers: dict[str, list[tuple[np.ndarray, str]]] = {}

    def ours() -> None:
        tracker = arm.tracker(Q[0], dt)
        answers["urdf-ik"] = [(step.q, step.status) for step in map(tracker.step, targets)]

    ways: dict[str, Callable[[], None]] = {"urdf-ik": ours}
    model: Any = None
    try:
        import ssik

        model = prebuilt and ssik.Manipulator.from_prebuilt(prebuilt)
    except ImportError:
        print("ssik: not installed", file=sys.stderr)
    if model:
        seen = [model.fk(q) for q in Q]

        def theirs() -> None:
            tracker = model.tracker(Q[0])
            answers["ssik"] = [(step.q, step.status.value) for step in map(tracker.update, seen)]

        ways["ssik"] = theirs
    best = dict.fromkeys(ways, math.inf)
    for _ in range(repeats):
        for name, work in ways.items():
            best[name] = min(best[name], bench.seconds(work) / cycles)
    rows = []
    for name in ways:
        ok = [(q, k) for k, (q, status) in enumerate(answers[name]) if status == "ok"]
        if name == "urdf-ik":
            worst = max(robot.reference.error(q, targets[k]) for q, k in ok)
        else:
            worst = max(float(np.abs(model.fk(q) - seen[k]).max()) for q, k in ok)
        counts = Counter(status for _, status in answers[name])
        answered = ", ".join(f"{count} {status}" for status, count in counts.items())
        rows.append(Row(robot.name, name, 1e6 * best[name], answered, worst))
    return rows


def main(arguments: list[str] | None = None) -> int:
    """Run the comparison and print it."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--cycles", type=int, default=500, help="poses of a path (default 500)")
    parser.add_argument("--repeats", type=int, default=7, help="alternating repetitions (default 7)")
    parser.add_argument("--dt", type=float, default=0.004, help="length of a cycle [s] (default 0.004)")
    parser.add_argument("--seed", type=int, default=0, help="seed of the paths (default 0)")
    options = parser.parse_args(arguments)
    if options.cycles < 1 or options.repeats < 1 or not options.dt > 0.0:
        parser.error("one cycle and one repetition at least, and a cycle longer than 0 s")
    print("| arm | tracker | us a call | answered | worst error | times as fast |")
    print("|---|---|---:|---|---:|---:|")
    for robot, prebuilt, centre in ARMS:
        rows = measure(robot, prebuilt, centre, options.cycles, options.repeats, options.dt, options.seed)
        slowest = max(row.us for row in rows)
        for row in rows:
            print(
                f"| {row.robot} | {row.tracker} | {row.us:.1f} | {row.answered} | {row.worst:.1e} "
                f"| {slowest / row.us:.1f} |"
            )
    return 0


if __name__ == "__main__":
    sys.exit(main())
