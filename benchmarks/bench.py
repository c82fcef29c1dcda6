#!/usr/bin/env python3
"""Compare urdf-ik with its peers: the same poses, the same process, measured by Pinocchio.

    python benchmarks/bench.py [--md] [--poses N] [--repeats R] [--seed S] [--robot NAME ...] [--peer NAME ...]

For each arm it prints, for every solver: microseconds a call for one pose, result ready as an array; thousands of poses
a second in batch with one and with two threads, all solutions of each; the ratios to EAIK, or to ssik on general arms,
which EAIK does not take; the share of poses answered completely, for random poses and for poses 1e-1 to 1e-7 rad from a
singularity, and the share of exactly singular poses answered at all; and what it takes and loses at round poses, those
of joint vectors whose joints all are multiples of 90 degrees. Last comes what a calibration costs: an arm as calibrated
against the same arm as designed. Repetitions of the solvers alternate and the best one counts, since no machine is
quiet and other work only ever adds time.
"""

from __future__ import annotations

import argparse
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
import timing
from peers import PEERS, Eaik, Peer, Ssik, Unavailable, UrdfIk
from rich.console import Console
from rich.table import Table
from robots import CALIBRATED_UR10E, GENERAL, ROBOTS, UR10E, Robot

SINGLE_CALLS = 1000  # a repetition
SLOW_CALLS = 20  # a repetition, for solvers of half a millisecond and more
BATCH = 20_000  # poses in a batch
CALIBRATED_BATCH = 2_000  # the same where an arm is compared as designed and as calibrated
GENERAL_CALLS, GENERAL_BATCH = 50, 400  # the same for general arms, on which this package is slow, too


def _speed(
    peers: list[Peer], targets: np.ndarray, round_targets: np.ndarray, repeats: int, *, general: bool
) -> dict[str, dict[str, float]]:
    """Best of alternating repetitions.

    ``us`` a call, ``us round`` the same at round poses, ``batch 1`` and ``batch 2`` thousands of poses a second.
    """
    batch = targets[: GENERAL_BATCH if general else BATCH]
    slow = {p.name: isinstance(p, Ssik) or (general and not isinstance(p, UrdfIk)) for p in peers}
    calls = {p.name: SLOW_CALLS if slow[p.name] else GENERAL_CALLS if general else SINGLE_CALLS for p in peers}
    singles = {p.name: [p.prepare(t) for t in targets[: calls[p.name]]] for p in peers}
    batches = {p.name: p.prepare_batch(batch) for p in peers if p.batch_call}

    def one_by_one(peer: Peer) -> None:
        solve = peer.solve
        for prepared in singles[peer.name]:
            solve(prepared)

    def round_ones(peer: Peer) -> None:
        for prepared in rounded[peer.name]:
            peer.solve(prepared)

    rounded = {p.name: [p.prepare(t) for t in round_targets[: calls[p.name]]] for p in peers}
    kinds: tuple[str, ...] = ("us", "us round", "batch 1", "batch 2")
    samples: dict[str, dict[str, list[float]]] = {p.name: {kind: [] for kind in kinds} for p in peers}
    for repetition in range(repeats + 1):  # the first one warms up and is thrown away
        for peer in peers if repetition % 2 else peers[::-1]:
            row = samples[peer.name]
            row["us"].append(1e6 * timing.seconds(partial(one_by_one, peer)) / calls[peer.name])
            row["us round"].append(1e6 * timing.seconds(partial(round_ones, peer)) / len(rounded[peer.name]))
            if peer.batch_call:
                for threads in (1, 2):
                    seconds = timing.seconds(partial(peer.solve_batch, batches[peer.name], threads))
                    row[f"batch {threads}"].append(1e-3 * len(batch) / seconds)
    return {
        name: {k: (min if k.startswith("us") else max)(v[1:]) for k, v in row.items() if v}
        for name, row in samples.items()
    }


def _ratio(value: float | None, base: float | None, *, less_is_better: bool = False) -> str:
    """How many times better the value is than the base."""
    if value is None or base is None:
        return "-"
    return f"{base / value if less_is_better else value / base:.2f}"


def _share(count: int, total: int) -> str:
    """A percentage that says 100 only where it is all of them."""
    percent = 100.0 * count / total
    return "100 %" if count == total else f"{min(percent, 99.9):.1f} %"


COLUMNS = (
    "solver",
    "us a call",
    "x {base}",
    "batch, 1 thread [k/s]",
    "x {base}",
    "batch, 2 threads [k/s]",
    "x {base}",
    "complete, random",
    "complete, near-singular",
    "singular, answered",
    "round, us a call",
    "complete, round",
    "wrong answers",
)

FOOTNOTE = """
Best of the repetitions. us a call: one pose, all solutions as an array. k/s: thousands of poses a second, all solutions
of each. x EAIK, x ssik: times as fast as that, by its single call where it has no batch. complete: share of poses
answered with every solution that any of the solvers found (error at most 1e-9 m and rad by Pinocchio), the planted one
included. near-singular: 1e-1 to 1e-7 rad from a singularity. singular, answered: exactly singular, at least one
solution. round: all joints at multiples of 90 degrees; complete there: every solution that any solver found at which
the arm is not singular, and one solution at least. wrong answers: share of all these poses answered with a joint vector
that misses the pose and is not flagged as approximate."""


def measure(robot: Robot, wanted: list[type[Peer]], poses: int, repeats: int, seed: int) -> list[list[str]]:
    """All rows of one arm's table, one a solver; a peer that is missing is a row that says so."""
    peers: list[Peer] = []
    missing: list[list[str]] = []
    for kind in wanted:
        try:
            peers.append(kind(robot))
        except Unavailable as reason:
            missing.append([kind.name, str(reason), *["-"] * (len(COLUMNS) - 2)])
    reference, rng = robot.reference, np.random.default_rng(seed)
    planted = complete.draw_random(reference, max(poses, BATCH), rng)
    targets = np.array([reference.pose(q) for q in planted])
    round_vectors = 0.5 * np.pi * rng.integers(-1, 3, (max(10, poses // 4), 6))
    round_targets = np.array([reference.pose(q) for q in round_vectors])
    speed = _speed(peers, targets, round_targets, repeats, general=robot.structure == "general")
    base = next((speed[p.name] for p in peers if isinstance(p, _base(robot))), {})
    if base and "batch 1" not in base:
        # A solver without a batch takes a call for each pose, whatever the threads.
        base |= {f"batch {threads}": 1e3 / base["us"] for threads in (1, 2)}
    random = complete.tally(peers, reference, planted[:poses])
    near = complete.tally(peers, reference, complete.draw_singular(reference, poses, rng, complete.NEAR))
    exact = complete.tally(peers, reference, complete.draw_singular(reference, max(1, poses // 4), rng, (0.0,)))
    at_round = complete.tally(peers, reference, round_vectors, isolated=True)
    rows = []
    for peer, a, b, c, d in zip(peers, random, near, exact, at_round, strict=True):
        row = speed[peer.name]
        cells = [peer.name, f"{row['us']:.2f}", _ratio(row["us"], base.get("us"), less_is_better=True)]
        for key in ("batch 1", "batch 2"):
            value = row.get(key)
            cells += [
                "-" if value is None else f"{value:.0f}" if value >= 10.0 else f"{value:.2f}",
                _ratio(value, base.get(key)),
            ]
        cells += [_share(a.complete, a.poses), _share(b.complete, b.poses), _share(c.answered, c.poses)]
        cells += [f"{row['us round']:.2f}", _share(d.complete, d.poses)]
        cells.append(_share(sum(each.wrong for each in (a, b, c, d)), sum(each.poses for each in (a, b, c, d))))
        rows.append(cells)
    return rows + missing


def _base(robot: Robot) -> type[Peer]:
    """The peer that the ratios are to."""
    return Ssik if robot.structure == "general" else Eaik


def calibration(repeats: int, seed: int) -> list[list[str]]:
    """Rows of the arm as designed and as calibrated: this package alone, one pose and in batch, in one run."""
    arms = {robot.name: (UrdfIk(robot), robot.reference) for robot in (UR10E, CALIBRATED_UR10E)}
    planted = np.random.default_rng(seed).uniform(-np.pi, np.pi, (CALIBRATED_BATCH, 6))
    batches = {name: reference.poses(planted) for name, (_, reference) in arms.items()}
    calls = {name: np.full(SINGLE_CALLS, np.inf) for name in arms}
    best = dict.fromkeys(arms, np.inf)
    for repetition in range(repeats + 1):  # the first one warms up and is thrown away
        for name in list(arms)[:: 1 if repetition % 2 else -1]:
            solver, poses = arms[name][0], batches[name]
            seconds = timing.seconds(partial(solver.solve_batch, poses, 1))
            single = np.array([_timed_call(solver.solve, T) for T in poses[:SINGLE_CALLS]])
            if repetition:
                best[name], calls[name] = min(best[name], seconds), np.minimum(calls[name], single)
    times = {name: 1e6 * seconds / CALIBRATED_BATCH for name, seconds in best.items()}
    medians = {name: 1e6 * float(np.median(seconds)) for name, seconds in calls.items()}
    return [
        [
            name,
            f"{medians[name]:.2f}",
            f"{medians[name] / medians[UR10E.name]:.1f}",
            f"{times[name]:.2f}",
            f"{times[name] / times[UR10E.name]:.1f}",
        ]
        for name in arms
    ]


def _timed_call(solve: Callable[[Any], Any], T: np.ndarray) -> float:
    """Seconds of one call."""
    start = time.perf_counter()
    solve(T)
    return time.perf_counter() - start


CALIBRATION = "what a calibration costs"
CALIBRATION_COLUMNS = ("arm", "us a call, median of poses", "x UR10e", "us a pose, batch, 1 thread", "x UR10e")


def _machine() -> str:
    """One line on where the figures come from."""
    cpu = platform.processor() or platform.machine()
    info = Path("/proc/cpuinfo")
    if info.exists():
        names = (line for line in info.read_text().splitlines() if line.startswith("model name"))
        cpu = next(names, cpu).partition(":")[2].strip() or cpu
    packages = ", ".join(f"{name} {version(name)}" for name in ("numpy", "pin"))
    return f"{cpu}, {os.cpu_count()} cores, Python {platform.python_version()}, {packages}"


def _show(console: Console, title: str, columns: tuple[str, ...], rows: list[list[str]], *, markdown: bool) -> None:
    """Print one table."""
    if markdown:
        print(f"\n**{title}**\n")
        print("| " + " | ".join(columns) + " |")
        print("|---|" + "---:|" * (len(columns) - 1))
        for row in rows:
            print("| " + " | ".join(row) + " |")
        return
    table = Table(title=title, title_justify="left")
    for i, column in enumerate(columns):
        table.add_column(column, justify="right" if i else "left", overflow="fold")
    for row in rows:
        table.add_row(*row)
    console.print(table)


def main(arguments: list[str] | None = None) -> int:
    """Run the comparison and print it."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--md", action="store_true", help="print Markdown, the tables alone")
    parser.add_argument("--poses", type=int, default=500, help="poses for the completeness columns (default 500)")
    parser.add_argument("--repeats", type=int, default=15, help="alternating repetitions (default 15)")
    parser.add_argument("--seed", type=int, default=2, help="seed of the poses (default 2)")
    everything = (*(r.name for r in (*ROBOTS, *GENERAL)), CALIBRATION)
    parser.add_argument("--robot", nargs="*", choices=everything, metavar="NAME", help=f"only these: {everything}")
    parser.add_argument("--peer", nargs="*", help="only these solvers: " + ", ".join(p.name for p in PEERS))
    options = parser.parse_args(arguments)
    robots = [r for r in (*ROBOTS, *GENERAL) if not options.robot or r.name in options.robot]
    calibrated = not options.robot or CALIBRATION in options.robot
    wanted = [p for p in PEERS if not options.peer or p.name in options.peer]
    if not (robots or calibrated) or not wanted or options.poses < 1 or options.repeats < 1:
        parser.error("nothing to do: name at least one arm and one solver, one pose and one repetition")
    # A pipe has no width of its own, and so many columns want some.
    console = Console(width=None if sys.stdout.isatty() else 150)
    if not options.md:
        print(_machine())
    for robot in robots:
        print(f"{robot.name} ...", file=sys.stderr, flush=True)
        base = _base(robot).name
        columns = tuple(column.format(base=base) for column in COLUMNS)
        rows = measure(robot, wanted, options.poses, options.repeats, options.seed)
        _show(console, robot.name, columns, rows, markdown=options.md)
    if calibrated:
        rows = calibration(options.repeats, options.seed)
        _show(console, CALIBRATION, CALIBRATION_COLUMNS, rows, markdown=options.md)
    if not options.md:
        print(FOOTNOTE)
    return 0


if __name__ == "__main__":
    sys.exit(main())
