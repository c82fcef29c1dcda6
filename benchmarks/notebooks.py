"""Time that each notebook takes to run: python benchmarks/notebooks.py [NOTEBOOK ...].

A row has the processor time of the kernel and its children, which other work on the machine hardly changes, and the
time on the wall. The status is 1 where a notebook fails, or its processor time is above 20 s.
"""

from __future__ import annotations

import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path

NOTEBOOKS = Path(__file__).resolve().parents[1] / "notebooks"
MOST = 20.0
"""Processor time that a notebook may take [s]."""


def main() -> None:
    """Print a row for each notebook, those named or all."""
    files = [Path(name) for name in sys.argv[1:]] or sorted(NOTEBOOKS.glob("*.ipynb"))
    bad = []
    print("| notebook | processor time [s] | time [s] |\n|---|---|---|")
    for file in files:
        start, before = time.monotonic(), resource.getrusage(resource.RUSAGE_CHILDREN)
        with tempfile.TemporaryDirectory() as folder:
            command = [
                sys.executable,
                "-m",
                "nbconvert",
                "--execute",
                "--to",
                "notebook",
                "--output-dir",
                folder,
                str(file),
            ]
            done = subprocess.run(command, capture_output=True, text=True, check=False)
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        spent = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
        failed = "" if done.returncode == 0 else f" failed: {done.stderr.strip().splitlines()[-1]}"
        print(f"| {file.stem}{failed} | {spent:.1f} | {time.monotonic() - start:.1f} |", flush=True)
        if failed or spent > MOST:
            bad.append(file.stem)
    print(f"\n{len(files) - len(bad)} of {len(files)} run within {MOST:.0f} s of processor time")
    sys.exit(bool(bad))


if __name__ == "__main__":
    main()
