"""Sizes and times of arms as one C++ file, as a table: python benchmarks/exported.py [ARM ...].

The compiler is that of the environment variable CXX. Times are processor times of one process, the least of five runs.
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
from pathlib import Path

import urdf_ik
from urdf_ik import export

ARMS = ("planar_2r", "scara_rrpr", "zyyzyz_6r", "srs_7r", "rail_6r")
FLAGS = ("-std=c++20", "-ffp-contract=fast", "-fno-math-errno", "-fno-trapping-math", "-fno-exceptions")
FREE = ("-Os", "-ffreestanding", "-fno-rtti", "-fno-stack-protector", "-fstack-usage")
TIMER = """
#include "arm.hpp"
#include <cstdio>
#include <ctime>
int main() {
    static double T[256 * 16], q[256 * arm::columns * arm::joints];
    static uint8_t flags[256 * arm::columns];
    for (int i = 0; i < 256; ++i) {
        double at[arm::joints];
        for (int j = 0; j < arm::joints; ++j) at[j] = ((i * 7919 + j * 104729) % 1000) / 250.0 - 2.0;
        arm::fk(at, T + 16 * i);
    }
    double single = 1e9, batch = 1e9;
    for (int round = 0; round < 5; ++round) {
        std::clock_t start = std::clock();
        for (int k = 0; k < 20; ++k) for (int i = 0; i < 256; ++i) arm::ik_batch(T + 16 * i, 1, q, flags);
        double took = double(std::clock() - start) / CLOCKS_PER_SEC / 5120;
        single = took < single ? took : single, start = std::clock();
        for (int k = 0; k < 20; ++k) arm::ik_batch(T, 256, q, flags);
        took = double(std::clock() - start) / CLOCKS_PER_SEC / 5120, batch = took < batch ? took : batch;
    }
    std::printf("%.2f %.2f", 1e6 * single, 1e6 * batch);
}
"""


def run(*command: str, cwd: str) -> str:
    """Run a command that must succeed; its output."""
    return subprocess.run(command, cwd=cwd, check=True, capture_output=True, text=True).stdout


def main(names: list[str]) -> None:
    """Print a row for each arm."""
    compiler = os.environ.get("CXX", "c++")
    print("| arm | lines | kB | compiling [s] | code and constants [kB] | one pose [us] | in a batch [us] |")
    print("|---|---|---|---|---|---|---|")
    for name in names or ARMS:
        text = export.cpp(urdf_ik.load(name), "arm")
        with tempfile.TemporaryDirectory() as folder:
            (Path(folder) / "arm.hpp").write_text(text)
            (Path(folder) / "free.cpp").write_text(
                '#include "arm.hpp"\nextern "C" int solve(const double* T, double* q, uint8_t* flags) '
                "{ return arm::ik(T, q, flags); }\n"
            )
            (Path(folder) / "timer.cpp").write_text(TIMER)
            run(compiler, *FLAGS, *FREE, "-c", "free.cpp", cwd=folder)
            code, data = run("size", "free.o", cwd=folder).splitlines()[1].split()[:2]
            began = os.times().children_user
            run(compiler, *FLAGS, "-O3", "-march=native", "timer.cpp", "-o", "timer", cwd=folder)
            compiling = os.times().children_user - began
            single, batch = run("./timer", cwd=folder).split()
        size = (int(code) + int(data)) / 1e3
        lines = text.count("\n")
        print(f"| {name} | {lines} | {len(text) / 1e3:.0f} | {compiling:.0f} | {size:.0f} | {single} | {batch} |")


if __name__ == "__main__":
    main(sys.argv[1:])
