#!/usr/bin/env python3
"""Compare urdf-ik with its peers: the same poses, the same process, measured by Pinocchio.

    python benchmarks/bench.py [--poses N] [--repeats R] [--seed S] [--robot NAME ...] [--peer NAME ...]

Repetitions of the solvers alternate and the best one counts, since other work only ever adds time. us a call: one pose,
all solutions as an array. k/s: thousands of poses a second, all solutions of each; a solver without a batch takes a
call for each pose. complete: share of poses answered with every solution that any of the solvers found (error at most
1e-9 m and rad by Pinocchio), the planted one included. near-singular: 1e-1 to 1e-7 rad from a singularity. singular,
answered: exactly singular, at least one solution. round: all joints at multiples of 90 degrees; complete there: every
solution at which the arm is not singular. wrong answers: share of all these poses answered with a joint vector that
misses the pose and is not flagged as approximate.
"""

import argparse
import gc
import os
import platform
import sys
import time
from collections.abc import Callable
from functools import partial
from importlib.metadata import version
from pathlib import Path
from typing import Any

import complete
import numpy as np
from peers import PEERS, Peer, Unavailable
from robots import GENERAL, ROBOTS, Robot

import urdf_ik

SINGLE_CALLS, BATCH = 1000, 20_000  # a repetition; poses in a batch
SLOW_CALLS = 20  # a repetition, for solvers of half a millisecond and more
GENERAL_CALLS, GENERAL_BATCH = 50, 400  # the same for general arms
COLUMNS = (
    "solver", "us a call", "batch, 1 thread [k/s]", "batch, 2 threads [k/s]", "complete, random",
    "complete, near-singular", "singular, answered", "round, us a call", "complete, round", "wrong answers",
)  # fmt: skip


def seconds(work: Callable[[], Any]) -> float:
    """Seconds that the work takes, without a collection in between."""
    gc.collect()
    gc.disable()
    try:
        start = time.perf_counter()
        work()
        return time.perf_counter() - start
    finally:
        gc.enable()


def one_by_one(peer: Peer, prepared: list[Any]) -> None:
    """A call for each pose."""
    solve = peer.solve
    for each in prepared:
        solve(each)


def speed(
    peers: list[Peer], targets: np.ndarray, round_targets: np.ndarray, repeats: int, *, general: bool
) -> dict[str, list[float]]:
    """Least of alternating repetitions: us a call, us at round poses, and k/s of a batch with one and two threads."""
    batch = targets[: GENERAL_BATCH if general else BATCH]
    best: dict[str, list[float]] = {}
    for repetition in range(repeats + 1):  # the first one warms up and is thrown away
        for peer in peers if repetition % 2 else peers[::-1]:
            slow = peer.kind in ("ssik", "toolbox") or (general and peer.kind != "urdf-ik")
            calls = SLOW_CALLS if slow else GENERAL_CALLS if general else SINGLE_CALLS
            times = []
            for chosen in (targets[:calls], round_targets[:calls]):
                prepared = [peer.prepare(T) for T in chosen]
                times.append(seconds(partial(one_by_one, peer, prepared)) / len(chosen))
            many = peer.prepare(batch) if peer.batch is not None else None
            for threads in (1, 2):
                times.append(
                    times[0] if peer.batch is None else seconds(partial(peer.batch, many, threads)) / len(batch)
                )
            if repetition:
                best[peer.kind] = np.minimum(times, best.get(peer.kind, [np.inf] * 4)).tolist()
    return {kind: [1e6 * t[0], 1e6 * t[1], 1e-3 / t[2], 1e-3 / t[3]] for kind, t in best.items()}


def share(count: int, total: int) -> str:
    """A percentage that says 100 only where it is all of them."""
    return "100 %" if count == total else f"{min(100.0 * count / total, 99.9):.1f} %"


def measure(robot: Robot, wanted: list[str], poses: int, repeats: int, seed: int) -> list[list[str]]:
    """All rows of one arm, one a solver; a peer that is missing is a row that says so."""
    arm = urdf_ik.load(robot.urdf, base="base", tip="tool")
    peers: list[Peer] = []
    missing: list[list[str]] = []
    for kind in wanted:
        try:
            peers.append(PEERS[kind](arm))
        except Unavailable as reason:
            missing.append([kind, str(reason), *["-"] * (len(COLUMNS) - 2)])
    reference, rng = robot.reference, np.random.default_rng(seed)
    planted = complete.draw_random(reference, max(poses, BATCH), rng)
    round_vectors = 0.5 * np.pi * rng.integers(-1, 3, (max(10, poses // 4), 6))
    general = robot.structure == "general"
    fast = speed(peers, reference.poses(planted), reference.poses(round_vectors), repeats, general=general)
    kinds = [
        complete.tally(peers, reference, planted[:poses]),
        complete.tally(peers, reference, complete.draw_singular(reference, poses, rng, complete.NEAR)),
        complete.tally(peers, reference, complete.draw_singular(reference, max(1, poses // 4), rng, (0.0,))),
        complete.tally(peers, reference, round_vectors, isolated=True),
    ]
    rows = []
    for peer, *tallies in zip(peers, *kinds, strict=True):
        random, near, exact, at_round = tallies
        call, call_at_round, *batches = fast[peer.kind]
        cells = [peer.name, f"{call:.2f}", *(f"{each:.0f}" if each >= 10.0 else f"{each:.2f}" for each in batches)]
        cells += [share(random.complete, random.poses), share(near.complete, near.poses)]
        cells += [share(exact.answered, exact.poses), f"{call_at_round:.2f}", share(at_round.complete, at_round.poses)]
        rows.append([*cells, share(sum(each.wrong for each in tallies), sum(each.poses for each in tallies))])
    return rows + missing


def machine() -> str:
    """One line on where the figures come from."""
    info = Path("/proc/cpuinfo")
    lines = info.read_text().splitlines() if info.exists() else []
    cpu = next((line.partition(":")[2].strip() for line in lines if line.startswith("model name")), platform.machine())
    packages = ", ".join(f"{name} {version(name)}" for name in ("numpy", "pin"))
    return f"{cpu}, {os.cpu_count()} cores, Python {platform.python_version()}, {packages}"


def main(arguments: list[str] | None = None) -> int:
    """Run the comparison and print it as Markdown."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--poses", type=int, default=500, help="poses for the completeness columns (default 500)")
    parser.add_argument("--repeats", type=int, default=15, help="alternating repetitions (default 15)")
    parser.add_argument("--seed", type=int, default=2, help="seed of the poses (default 2)")
    names = tuple(robot.name for robot in (*ROBOTS, *GENERAL))
    parser.add_argument("--robot", nargs="*", choices=names, default=names, metavar="NAME", help=f"of {names}")
    parser.add_argument("--peer", nargs="*", choices=tuple(PEERS), default=tuple(PEERS), metavar="NAME")
    options = parser.parse_args(arguments)
    if options.poses < 1 or options.repeats < 1:
        parser.error("one pose and one repetition at least")
    print(machine())
    for robot in (*ROBOTS, *GENERAL):
        if robot.name in options.robot:
            print(f"{robot.name} ...", file=sys.stderr, flush=True)
            rows = measure(robot, options.peer, options.poses, options.repeats, options.seed)
            print(f"\n**{robot.name}**\n\n| {' | '.join(COLUMNS)} |\n|---|{'---:|' * (len(COLUMNS) - 1)}")
            print("\n".join(f"| {' | '.join(row)} |" for row in rows), flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
