#!/usr/bin/env python3
"""All tables of docs/speed.md in one run, each below the command that printed it: what ``make bench`` runs.

    python benchmarks/report.py [--before PYTHON] [--arms FOLDER] [--quick] [--only WORD ...] [--page FILE]

``--before`` and ``--arms`` are those of ``before_after.py``: another version's Python, and a folder of further arms.
``--quick`` measures each thing once and leaves out what takes longest: about a minute instead of ten. ``--only`` takes
the tables whose commands hold one of the words. ``--page docs/speed.md`` puts them into the page, each between the two
comments with its title. A table that takes longer than its time is cut off there, and says so.
"""

from __future__ import annotations

import argparse
import os
import platform
import shlex
import subprocess
import sys
import time
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path

HERE = Path(__file__).resolve().parent


@dataclass(frozen=True)
class Table:
    """One table.

    Attributes:
        title: what it shows.
        command: the file in this folder, and its arguments.
        quick: its arguments for ``--quick``; None: it is left out there.
        most: s after which it is cut off.
    """

    title: str
    command: str
    quick: str | None
    most: float


TABLES = (
    Table("Two versions", "before_after.py --repeats 3", "before_after.py --repeats 1", 900.0),
    Table("Compiling", "before_after.py --repeats 1 --build", None, 900.0),
    Table(
        "Six joints, other solvers",
        "bench.py --md --repeats 3 --poses 60 --robot UR5 'IRB 2400' 'z y y z y z'",
        "bench.py --md --repeats 1 --poses 20 --peer urdf-ik EAIK --robot UR5 'IRB 2400' 'z y y z y z'",
        300.0,
    ),
    Table(
        "General arms, other solvers",
        "bench.py --md --repeats 1 --poses 10 --peer urdf-ik ssik --robot 'Kinova j2n6s300' 'FANUC CRX-10iA/L'",
        None,
        240.0,
    ),
    Table("A calibrated arm", "bench.py --md --repeats 7 --robot 'what a calibration costs'", None, 90.0),
    Table("Seven joints, sixteen values", "seven_joints.py --poses 60 --repeats 3", None, 120.0),
    Table("Narrow windows", "intervals.py --poses 100", "intervals.py --poses 10", 90.0),
    Table("Few joints", "few_joints.py --repeats 3", None, 90.0),
    Table("Paths", "paths.py --waypoints 300 --repeats 3", None, 180.0),
    Table("Tracker", "tracker.py --repeats 3", None, 90.0),
    Table("Threads", "threads.py --robot UR5 --batch 1000 10000 100000", None, 90.0),
)


def state() -> str:
    """What is measured, and how busy the machine is."""
    git = subprocess.run(["git", "rev-parse", "--short", "HEAD"], cwd=HERE, capture_output=True, text=True, check=False)
    load = f", load {os.getloadavg()[0]:.1f}" if hasattr(os, "getloadavg") else ""
    return f"commit {git.stdout.strip() or 'unknown'}{load}"


def machine() -> str:
    """Where the numbers come from: processor and versions."""
    info = Path("/proc/cpuinfo")
    names = info.read_text().splitlines() if info.exists() else []
    named = (line.partition(":")[2].strip() for line in names if line.startswith("model name"))
    packages = ", ".join(f"{name} {version(name)}" for name in ("numpy", "pin"))
    return f"{next(named, platform.machine())}, {os.cpu_count()} cores, Python {platform.python_version()}, {packages}"


def printed(arguments: list[str], most: float) -> str:
    """What a script of this folder prints, or as much as it did in its time and why there is no more."""
    process = subprocess.Popen(
        [sys.executable, str(HERE / arguments[0]), *arguments[1:]],
        stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, start_new_session=True,
    )  # fmt: skip
    try:
        out, error = process.communicate(timeout=most)
    except subprocess.TimeoutExpired:
        os.killpg(process.pid, 9)  # and the processes that it began
        out, _ = process.communicate()
        return f"{out.strip()}\n\ncut off after {most:.0f} s"
    if process.returncode:
        return f"{out.strip()}\n\nended with an error: {(error.strip().splitlines() or ['?'])[-1]}"
    return out.strip()


def put(page: Path, title: str, text: str) -> None:
    """Put a table into the page, between the comments with its title."""
    begin, end = f"<!-- table: {title} -->\n", f"<!-- end: {title} -->\n"
    before, found, rest = page.read_text().partition(begin)
    _, ended, after = rest.partition(end)
    if not found or not ended:
        sys.exit(f"{page} has no {begin.strip()!r} with {end.strip()!r} behind it")
    page.write_text(f"{before}{begin}\n{text}\n\n{end}{after}")


def main(arguments: list[str] | None = None) -> int:
    """Print the tables."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--before", help="the Python of an environment with the version to compare with")
    parser.add_argument("--arms", help="a folder with URDFs of further arms")
    parser.add_argument("--quick", action="store_true", help="about a minute")
    parser.add_argument("--only", nargs="*", help="only tables whose commands hold one of these words")
    parser.add_argument("--page", type=Path, help="put the tables into this page, too")
    options = parser.parse_args(arguments)
    print(machine(), flush=True)
    if options.page:
        put(options.page, "machine", f"{machine()}.")
    start = time.monotonic()
    for table in TABLES:
        command = table.quick if options.quick else table.command
        if command is None or (options.only and not any(word in command for word in options.only)):
            continue
        given = shlex.split(command)
        if given[0] == "before_after.py":
            given += ["--before", options.before] if options.before else []
            given += ["--arms", options.arms] if options.arms else []
        began = time.monotonic()
        print(f"{table.title} ...", file=sys.stderr, flush=True)
        text = printed(given, table.most)
        took = time.monotonic() - began
        whole = f"`python benchmarks/{command}` ({took:.0f} s; {state()})\n\n{text}"
        print(f"\n## {table.title}\n\n{whole}", flush=True)
        if options.page:
            put(options.page, table.title, whole)
    print(f"\n{time.monotonic() - start:.0f} s in all")
    return 0


if __name__ == "__main__":
    sys.exit(main())
