"""Ctrl-C ends long calls, and leaves no thread behind."""

from __future__ import annotations

import os
import signal
import threading
import time
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pytest

import urdf_ik

if TYPE_CHECKING:
    from collections.abc import Callable

# Far more work than can be done before the signal arrives.
POSES = 400_000
AFTER = 0.3
PATIENCE = 60.0


def interrupted(call: Callable[[], object]) -> None:
    """Run a call that a signal reaches when it has begun; it must end by KeyboardInterrupt, and its threads with it."""

    def threads() -> set[str]:
        return {each.name for each in Path("/proc/self/task").iterdir()}

    before = threads()
    timer = threading.Timer(AFTER, os.kill, (os.getpid(), signal.SIGINT))
    # A process that was begun in the background ignores the signal.
    handler = signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        with pytest.raises(KeyboardInterrupt):
            timer.start()
            for _ in range(1000):
                call()
        timer.join()
    finally:
        signal.signal(signal.SIGINT, handler)
    # A thread that waits for a core ends as soon as it gets one, without having worked.
    until = time.monotonic() + PATIENCE
    while not threads() <= before and time.monotonic() < until:
        time.sleep(0.01)
    assert threads() <= before  # one that ended meanwhile was another test's


pytestmark = pytest.mark.skipif(not Path("/proc/self/task").is_dir(), reason="there is no /proc to count threads in")


@pytest.mark.parametrize(
    ("name", "threads"),
    [
        ("puma_560", 3),
        *(
            pytest.param(name, threads, marks=pytest.mark.slow)
            for name in ("puma_560", "srs_7r", "kinova", "scara_rrpr")
            for threads in (1, 3)
            if (name, threads) != ("puma_560", 3)
        ),
    ],
)
def test_a_batch_ends(name: str, threads: int) -> None:
    """Closed forms, seven joints, elimination and four joints; by the thread that was called, and with others."""
    arm = urdf_ik.load(name)
    T = np.tile(arm.fk(np.random.default_rng(1).uniform(-1.0, 1.0, (1000, arm.dof))), (POSES // 1000, 1, 1))
    interrupted(lambda: arm.ik(T, threads=threads))
    # The arm is as it was.
    assert len(arm.ik(T[0]))


@pytest.mark.slow
def test_forward_kinematics_ends() -> None:
    """The same of poses of many joint vectors."""
    arm = urdf_ik.load("puma_560")
    q = np.zeros((POSES, 6))
    interrupted(lambda: arm.fk(q))


@pytest.mark.slow
def test_a_path_ends() -> None:
    """A path with many waypoints of seven joints."""
    arm = urdf_ik.load("srs_7r")
    q = np.array([0.3, 0.5, -0.4, 0.9, 0.2, -0.6, 0.1])
    there = arm.fk(q)
    there[:3, 3] += 0.05
    waypoints = urdf_ik.line(arm.fk(q), there, 400)
    interrupted(lambda: arm.follow(waypoints))


def test_other_signals_are_handled_meanwhile() -> None:
    """A handler that raises nothing runs while a batch is solved, and the batch is solved all the same."""
    arm = urdf_ik.load("kinova")
    T = arm.fk(np.random.default_rng(2).uniform(-1.0, 1.0, (200, 6)))
    seen: list[bool] = []
    old = signal.signal(signal.SIGUSR1, lambda *_: seen.append(True))
    try:
        whole = arm.ik(T)
        os.kill(os.getpid(), signal.SIGUSR1)
        again = arm.ik(np.tile(T, (20, 1, 1)))
    finally:
        signal.signal(signal.SIGUSR1, old)
    assert seen
    np.testing.assert_array_equal(again.q[: len(T)], whole.q)
