#!/usr/bin/env python3
"""What someone waits for on a fresh machine: from the start of Python to the first solution, and what imports take.

    python benchmarks/cold_start.py [--md] [--repeats R] [--robot NAME ...] [--slow]

Every run is a process of its own, whose home and cache folders are new and empty, so that nothing compiled or derived
before is found. It reads the URDF from a file, solves one pose and ends. The best of the repetitions counts; processor
time is that of the process and its children. ssik derives its solver of a general arm in minutes: ``--slow`` asks it,
once. EAIK reads URDFs of its own, and takes no general arm.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
from robots import CALIBRATED_UR10E, GENERAL, ROBOTS, Robot

TIMEOUT = 900.0  # s, after which a run counts as failed

_SOLVE = {
    "urdf-ik": """
import sys, numpy as np, urdf_ik
arm = urdf_ik.load(sys.argv[1], base="base", tip="tool")
assert np.isfinite(arm.ik(np.load(sys.argv[2])).q).any()
""",
    "EAIK": """
import sys, numpy as np
from eaik.IK_URDF import UrdfRobot
bot = UrdfRobot(sys.argv[1])
if not bot.hasKnownDecomposition():
    sys.exit("no decomposition for this arm")
bot.IK(np.load(sys.argv[2])).Q
""",
    "ssik": """
import sys, numpy as np, ssik
bot = ssik.Manipulator.from_urdf(sys.argv[1], base="base", ee="tool")
bot.solve(np.load(sys.argv[2]), respect_limits=False)
""",
}
_IMPORTS = {
    "python -c pass": "pass",
    "import numpy": "import numpy",
    "import urdf_ik": "import urdf_ik",
    "import yourdfpy, pinocchio, coal, typer, rich": "import yourdfpy, pinocchio, coal, typer, rich",
    "import eaik.IK_Robot": "import eaik.IK_Robot",
    "import ssik": "import ssik",
}


def run(command: list[str]) -> tuple[float, float] | None:
    """Seconds of wall clock and of processor time of one fresh process; None where it fails."""
    with tempfile.TemporaryDirectory() as home:
        caches = {"XDG_CACHE_HOME": f"{home}/cache", "NUMBA_CACHE_DIR": f"{home}/numba"}
        fresh = {**os.environ, **caches, "HOME": home, "OMP_NUM_THREADS": "1"}
        before, start = os.times(), time.perf_counter()
        try:
            done = subprocess.run(command, env=fresh, capture_output=True, timeout=TIMEOUT, check=False)
        except subprocess.TimeoutExpired:
            return None
        wall, after = time.perf_counter() - start, os.times()
    if done.returncode != 0:
        return None
    return wall, after.children_user + after.children_system - before.children_user - before.children_system


def best(command: list[str], repeats: int) -> tuple[float, float] | None:
    """The least of wall clock and of processor time over the repetitions."""
    runs = [run(command) for _ in range(repeats)]
    good = [each for each in runs if each is not None]
    return (min(w for w, _ in good), min(c for _, c in good)) if len(good) == len(runs) else None


def first_solutions(robots: list[Robot], repeats: int, *, slow: bool) -> list[list[str]]:
    """A row an arm and solver."""
    rows = []
    for robot in robots:
        with tempfile.TemporaryDirectory() as folder:
            urdf, pose = Path(folder, "arm.urdf"), Path(folder, "pose.npy")
            urdf.write_text(robot.urdf)
            np.save(pose, robot.reference.pose(np.array([0.3, -0.5, 0.8, 0.4, 0.7, -0.2])))
            for name, code in _SOLVE.items():
                general = robot.structure == "general"
                if name == "ssik" and general and not slow:
                    rows.append([robot.name, name, "minutes: asked with --slow", "-"])
                    continue
                often = 1 if name == "ssik" and general else repeats
                times = best([sys.executable, "-c", code, str(urdf), str(pose)], often)
                cells = ["does not take it", "-"] if times is None else [f"{times[0]:.2f}", f"{times[1]:.2f}"]
                rows.append([robot.name, name, *cells])
    return rows


def imports(repeats: int) -> list[list[str]]:
    """A row an import, with its ratio to NumPy's; and the command, with its ratio to what it builds upon."""
    times = {name: best([sys.executable, "-c", code], repeats) for name, code in _IMPORTS.items()}
    command = "urdf-ik ik zyyzyz_6r"
    times[command] = best([sys.executable, "-m", "urdf_ik.cli", "ik", "zyyzyz_6r"], repeats)
    numpy, parts = times["import numpy"], times["import yourdfpy, pinocchio, coal, typer, rich"]
    rows = []
    for name, each in times.items():
        if each is None or numpy is None:
            rows.append([name, "not installed", "-", "-"])
            continue
        to_parts = f"{each[0] / parts[0]:.2f}" if parts is not None and name == command else "-"
        rows.append([name, f"{each[0]:.3f}", f"{each[0] / numpy[0]:.2f}", to_parts])
    return rows


def show(title: str, columns: list[str], rows: list[list[str]], *, markdown: bool) -> None:
    """Print one table."""
    print(f"\n**{title}**\n" if markdown else f"\n{title}")
    if markdown:
        print("| " + " | ".join(columns) + " |\n|---|" + "---:|" * (len(columns) - 1))
        print("\n".join("| " + " | ".join(row) + " |" for row in rows))
        return
    widths = [max(len(row[i]) for row in [columns, *rows]) for i in range(len(columns))]
    for row in [columns, *rows]:
        print("  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)).rstrip())


def main(arguments: list[str] | None = None) -> int:
    """Measure and print both tables."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    everything = [*ROBOTS, *GENERAL[:1], CALIBRATED_UR10E]
    parser.add_argument("--md", action="store_true", help="print Markdown")
    parser.add_argument("--repeats", type=int, default=5, help="processes of each kind, the best counts (default 5)")
    parser.add_argument("--robot", nargs="*", choices=[r.name for r in everything], help="only these arms")
    parser.add_argument("--slow", action="store_true", help="ask ssik for general arms too: minutes")
    options = parser.parse_args(arguments)
    if options.repeats < 1:
        parser.error("at least one repetition")
    robots = [r for r in everything if not options.robot or r.name in options.robot]
    rows = first_solutions(robots, options.repeats, slow=options.slow)
    show("to the first solution", ["arm", "solver", "s", "s of processor time"], rows, markdown=options.md)
    columns = ["process", "s", "x import numpy", "x import of its parts"]
    show("imports and the command", columns, imports(options.repeats), markdown=options.md)
    return 0


if __name__ == "__main__":
    sys.exit(main())
