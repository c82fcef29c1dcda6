"""Sizes and times of arms in WebAssembly and of their pages, as a table: python benchmarks/web.py [ARM ...].

Node, Chromium and playwright are needed, and what `make wasm page` builds. Times of a pose are processor times of Node
with answers as objects of JavaScript, the least of six runs. A page's first time is from its opening to its first
solutions, the least of three. A move's time is that of solving, of moving arm and ghosts and of laying out the panel,
without drawing, while the target moves on a circle: the mean of 100, the least of nine. A page's rate is that of frames
drawn while it moves so, the greatest of three.
"""

from __future__ import annotations

import gzip
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

import urdf_ik
from urdf_ik.export import html
from urdf_ik.export.page import WEB

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT / "tests" / "support"))

from arms_outside import GENERAL  # noqa: E402
from browser import chromium  # noqa: E402

ARMS = ("planar_2r", "scara_rrpr", "zyyzyz_6r", GENERAL, "srs_7r")
TIMER = """
const [module, file] = process.argv.slice(1), {pathToFileURL} = await import('node:url');
const {load} = await import(pathToFileURL(module)), arm = await load(pathToFileURL(file));
const value = (i, j) => ((i * 7919 + j * 104729) % 1000) / 250 - 2;
const poses = Array.from({length: 256}, (_, i) => arm.fk(arm.joints.map((_, j) => value(i, j))));
let best = Infinity;
for (let round = 0; round < 6; ++round) {
  const start = process.cpuUsage();
  for (let k = 0; k < 4; ++k) for (const T of poses) arm.ik(T);
  const {user, system} = process.cpuUsage(start);
  best = Math.min(best, (user + system) / (4 * poses.length));
}
console.log(best);
"""
MOVING = """async () => {
    const {state, view} = urdfIk, T = state.T, start = performance.now(), before = view.frames;
    while (performance.now() - start < 3000) {
        const at = 0.004 * (performance.now() - start), moved = T.slice();
        moved[3] += 0.05 * Math.cos(at), moved[7] += 0.05 * Math.sin(at);
        state.moveTarget(moved, 'handles');
        await new Promise(requestAnimationFrame);
    }
    return 1000 * (view.frames - before) / (performance.now() - start);
}"""
# Drawing waits for the browser's next frame, which comes when this has returned.
UPDATING = """() => {
    const {state, view} = urdfIk, T = state.T, start = performance.now();
    for (let k = 0; k < 100; ++k) {
        const at = 0.0628 * k, moved = T.slice();
        moved[3] += 0.05 * Math.cos(at), moved[7] += 0.05 * Math.sin(at);
        state.moveTarget(moved, 'handles');
        view.scene.updateMatrixWorld();
        document.body.getBoundingClientRect();
    }
    return (performance.now() - start) / 100;
}"""


def pose_time(arm: urdf_ik.Arm, folder: Path) -> float:
    """Microseconds of a pose."""
    file = folder / "arm.json"
    file.write_text(urdf_ik.compile(arm))
    command = ["node", "--input-type=module", "-e", TIMER, str(WEB / "urdf_ik.js"), str(file)]
    return float(subprocess.run(command, capture_output=True, text=True, check=True).stdout)


def seen(page: str, folder: Path, browser: Any) -> tuple[float, float, float]:
    """Milliseconds until the page has its first solutions, and of a move; frames a second while its target moves."""
    file = folder / "arm.html"
    file.write_text(page)
    first, move, rate = float("inf"), float("inf"), 0.0
    for _ in range(3):
        tab = browser.new_page(viewport={"width": 1000, "height": 640})
        tab.goto(file.as_uri())
        tab.wait_for_function("document.documentElement.dataset.ready")
        first = min(first, float(tab.evaluate("document.documentElement.dataset.ready")))
        move = min(move, *(tab.evaluate(UPDATING) for _ in range(3)))
        rate = max(rate, tab.evaluate(MOVING))
        tab.close()
    return first, move, rate


def main() -> None:
    """Print the table."""
    data = (WEB / "urdf_ik.wasm").read_bytes()
    print(f"urdf_ik.wasm: {len(data) / 1e3:.0f} kB, {len(gzip.compress(data, 9)) / 1e3:.0f} kB gzipped\n")
    print("| arm | one pose [us] | page [kB] | first solutions [ms] | a move without drawing [ms] | frames a second |")
    print("|---|---|---|---|---|---|")
    with tempfile.TemporaryDirectory() as place, chromium() as browser:
        for name in sys.argv[1:] or ARMS:
            arm = urdf_ik.load(name)
            page = html(arm)
            first, move, rate = seen(page, Path(place), browser)
            row = (
                f"{pose_time(arm, Path(place)):.1f}",
                f"{len(page) / 1e3:.0f}",
                f"{first:.0f}",
                f"{move:.1f}",
                f"{rate:.0f}",
            )
            print("|", " | ".join((arm.name, *row)), "|", flush=True)


if __name__ == "__main__":
    main()
