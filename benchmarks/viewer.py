"""What a move of the target costs the viewer: the server's processor, and the page's own work, without its drawing.

    python benchmarks/viewer.py [ARM] [--moves 150]

The page is Chromium's, drawn in software; the time of drawing says nothing about a graphics card and is left out. The
page's work is the processor time of its main thread (Chromium's Performance domain) for each frame that it drew: 33 ms
leave 30 frames a second. Software draws fewer frames than there are moves. Chromium and playwright are needed, and
example-robot-data for the default arm, whose meshes are 1.9 MB.
"""

from __future__ import annotations

import argparse
import shutil
import time
from typing import Any

import numpy as np
from playwright.sync_api import sync_playwright

import urdf_ik
from urdf_ik.model import link_shapes
from urdf_ik.show.viewer import Viewer

CHROMIUM = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None)
SOFTWARE = ("--no-sandbox", "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader")
RATE = 30.0  # moves a second
COUNT = "() => { window.drawn = 0; (function next() { window.drawn++; requestAnimationFrame(next); })(); }"


def busy(page: Any) -> float:
    """S that the page's main thread has worked so far."""
    found = page.send("Performance.getMetrics")["metrics"]
    return float(next(each["value"] for each in found if each["name"] == "TaskDuration"))


def main() -> None:
    """Move the target up and down, first without a page, then with one."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("arm", nargs="?", default="ur5", help="a URDF or a name")
    parser.add_argument("--moves", type=int, default=150, help="how often the target is moved")
    given = parser.parse_args()
    arm = urdf_ik.load(given.arm)
    meshes = [body.mesh for body in link_shapes.read(arm.model).bodies]
    size = sum(4 * (mesh.vertices.size + mesh.faces.size) for mesh in meshes)
    print(f"{arm.name}: shapes of {size / 1e6:.2f} MB, {sum(len(mesh.faces) for mesh in meshes)} triangles")
    with Viewer(arm, port=0) as viewer, sync_playwright() as driver:
        T = np.tile(viewer.state.target, (given.moves, 1, 1))
        T[:, 2, 3] += 0.05 * np.sin(0.1 * np.arange(given.moves))
        begun = time.process_time()
        for each in T:
            viewer.move_target(each)
            viewer.settle()
        print(f"server: {1e3 * (time.process_time() - begun) / given.moves:.1f} ms of processor a move")
        browser = driver.chromium.launch(executable_path=CHROMIUM, args=list(SOFTWARE))
        tab = browser.new_page(viewport={"width": 900, "height": 700})
        tab.goto(viewer.url)
        tab.get_by_text("inside the limits").first.wait_for(timeout=120_000)
        tab.wait_for_timeout(5000)
        page = tab.context.new_cdp_session(tab)
        page.send("Performance.enable", {"timeDomain": "threadTicks"})
        tab.evaluate(COUNT)
        before = busy(page)
        for each in T:
            viewer.move_target(each)
            tab.wait_for_timeout(1e3 / RATE)
        work, frames = 1e3 * (busy(page) - before), tab.evaluate("window.drawn")
        print(f"page: {work / frames:.1f} ms of its main thread a frame, drawing left out ({frames} frames)")
        browser.close()


if __name__ == "__main__":
    main()
