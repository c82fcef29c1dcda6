"""Sizes and times of arms in WebAssembly and of their pages, as a table: python benchmarks/web.py [ARM ...].

Node, Chromium and playwright are needed, and what `make wasm page` builds. Times of a pose are processor times of Node
with answers as objects of JavaScript, the least of six runs. A page's first time is from its opening to its first
solutions, the least of three; its rate is that of frames while the target moves on a circle, the greatest of three.
"""

from __future__ import annotations

import gzip
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

import urdf_ik
from urdf_ik.export import html
from urdf_ik.export.page import WEB

ARMS = ("planar_2r", "scara_rrpr", "zyyzyz_6r", "general_6r", "srs_7r")
CHROMIUM = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None)
SOFTWARE = ("--no-sandbox", "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader")
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


def pose_time(arm: urdf_ik.Arm, folder: Path) -> float:
    """Microseconds of a pose."""
    file = folder / "arm.json"
    file.write_text(urdf_ik.compile(arm))
    command = ["node", "--input-type=module", "-e", TIMER, str(WEB / "urdf_ik.js"), str(file)]
    return float(subprocess.run(command, capture_output=True, text=True, check=True).stdout)


def seen(page: str, folder: Path, browser: Any) -> tuple[float, float]:
    """Milliseconds until the page has its first solutions, and frames a second while its target moves."""
    file = folder / "arm.html"
    file.write_text(page)
    first, rate = float("inf"), 0.0
    for _ in range(3):
        tab = browser.new_page(viewport={"width": 1000, "height": 640})
        tab.goto(file.as_uri())
        tab.wait_for_function("document.documentElement.dataset.ready")
        first = min(first, float(tab.evaluate("document.documentElement.dataset.ready")))
        rate = max(rate, tab.evaluate(MOVING))
        tab.close()
    return first, rate


def main() -> None:
    """Print the table."""
    data = (WEB / "urdf_ik.wasm").read_bytes()
    print(f"urdf_ik.wasm: {len(data) / 1e3:.0f} kB, {len(gzip.compress(data, 9)) / 1e3:.0f} kB gzipped\n")
    print("| arm | one pose [us] | page [kB] | first solutions [ms] | frames a second |\n|---|---|---|---|---|")
    from playwright.sync_api import sync_playwright

    with tempfile.TemporaryDirectory() as place, sync_playwright() as running:
        browser = running.chromium.launch(executable_path=CHROMIUM, args=list(SOFTWARE))
        for name in sys.argv[1:] or ARMS:
            arm = urdf_ik.load(name)
            page = html(arm)
            first, rate = seen(page, Path(place), browser)
            print(f"| {name} | {pose_time(arm, Path(place)):.1f} | {len(page) / 1e3:.0f} | {first:.0f} | {rate:.0f} |")
        browser.close()


if __name__ == "__main__":
    main()
