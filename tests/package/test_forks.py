"""Processes that are forked or spawned from a program with threads: they work, whatever the other threads are at."""

import multiprocessing
import os
import subprocess
import sys
import textwrap
from pathlib import Path

import pytest

LIMIT = 300.0  # [s], of a program that needs two; a child that waits for ever is ended by it
pytestmark = pytest.mark.skipif(not hasattr(os, "fork"), reason="this system does not fork")

FIRST_CALLS = """
    import os, sys, threading, time

    import urdf_ik

    def work():
        arm = urdf_ik.load("zyyzyz_6r")
        q = [0.3, -0.5, 0.8, 0.4, 0.7, -0.2]
        assert len(arm.ik(arm.fk(q))) == 8 and arm.structure.cuspidal is False
        assert not arm.cell.collisions.in_collision(q)
        world = urdf_ik.World()
        world.add("ball", urdf_ik.Sphere(0.1), urdf_ik.pose([3.0, 0.0, 0.0]))
        assert arm.clearance(q, world) > 0.0 and len(arm.to_pinocchio(q)) == 6

    thread = threading.Thread(target=work)
    thread.start()
    time.sleep({delay})
    child = os.fork()
    if not child:
        work()
        os._exit(0)
    thread.join()
    assert os.waitpid(child, 0)[1] == 0
"""

PROCESSES = """
    import multiprocessing
    import threading

    import urdf_ik

    def work(arm, q):
        return len(arm.ik(arm.fk(q), threads=2)), arm.cell.collisions.in_collision(q)

    if __name__ == "__main__":
        arm = urdf_ik.load("zyyzyz_6r")
        q = [0.3, -0.5, 0.8, 0.4, 0.7, -0.2]
        threads = [threading.Thread(target=work, args=(arm, q)) for _ in range(4)]
        for thread in threads:
            thread.start()
        with multiprocessing.get_context("{how}").Pool(2) as pool:
            assert pool.starmap(work, [(arm, q)] * 4) == [(8, False)] * 4
        for thread in threads:
            thread.join()
"""


@pytest.mark.parametrize("delay", [0.05, 0.5])
def test_a_fork_amid_first_calls_of_a_thread(delay: float, tmp_path: Path) -> None:
    """Modules half imported, properties half computed: the child finds them whole, or not begun."""
    run(FIRST_CALLS.replace("{delay}", str(delay)), tmp_path)


@pytest.mark.parametrize("how", multiprocessing.get_all_start_methods())
def test_processes_of_every_kind(how: str, tmp_path: Path) -> None:
    """An arm goes to other processes, and is solved there, while threads use it here."""
    run(PROCESSES.replace("{how}", how), tmp_path)


def run(text: str, folder: Path) -> None:
    """Run a program, without the warning that it forks with threads."""
    file = folder / "program.py"
    file.write_text(textwrap.dedent(text))
    command = [sys.executable, "-W", "ignore", str(file)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=LIMIT, check=False)
    assert done.returncode == 0, done.stderr[-2000:]
