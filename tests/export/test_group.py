"""What a motion planner asks of a compiled arm: the half of the MoveIt plugin that knows nothing of ROS."""

import subprocess
from pathlib import Path

import core_arms
import native_arms
import numpy as np
import pytest
from numpy.typing import NDArray

import urdf_ik

Array = NDArray[np.float64]

POSES = 12
# Six and seven joints, of which a pose leaves one number free.
ARMS = [(name, arm) for name, arm in core_arms.every_arm() if arm.dof in (6, 7)][:48:6]
FIXED = np.array([[0.0, -1, 0, 0], [1, 0, 0, 0], [0, 0, 1, 0.3], [0, 0, 0, 1]])


def joint_vectors(arm: urdf_ik.Arm, many: int, seed: int) -> Array:
    """Joint vectors (many, n) inside the limits."""
    low, high = np.clip(np.nan_to_num(arm.limits, posinf=np.pi, neginf=-np.pi), -np.pi, np.pi).T
    return np.random.default_rng(seed).uniform(low, high, (many, arm.dof))


def searched(files: list[Path], T: Array, seeds: Array, *links: str) -> subprocess.CompletedProcess[bytes]:
    """The program's answer to poses and seeds."""
    given = np.array([len(T)], np.int64).tobytes() + np.ascontiguousarray(T).tobytes() + seeds.tobytes()
    command = [str(native_arms.built("group.cpp")), *map(str, files), *links]
    return subprocess.run(command, input=given, capture_output=True, timeout=300, check=False)


def solutions(data: bytes, n: int) -> list[Array]:
    """The solutions (k, n) of each pose."""
    found, at = [], 0
    while at < len(data):
        (count,) = np.frombuffer(data, np.int64, 1, at)
        found.append(np.frombuffer(data, np.float64, count * n, at + 8).reshape(-1, n))
        at += 8 + 8 * count * n
    return found


@pytest.mark.parametrize("links", [(), ("stand-in table", "stand-in gripper")], ids=["own links", "fixed links"])
@pytest.mark.parametrize(("name", "arm"), ARMS, ids=[name for name, _ in ARMS])
def test_solutions_are_inside_limits_and_nearest_first(
    name: str, arm: urdf_ik.Arm, links: tuple[str, ...], tmp_path: Path
) -> None:
    """All images inside the limits, by distance to the seed; the program checks callback, consistency and timeout."""
    file = tmp_path / "arm.json"
    file.write_text(urdf_ik.compile(arm))
    q, seeds = joint_vectors(arm, POSES, 1), joint_vectors(arm, POSES, 2)
    T = arm.fk(q)
    asked = T if not links else np.linalg.inv(FIXED) @ T @ FIXED
    done = searched([file, file], asked, seeds, *links)
    assert done.returncode == 0, done.stderr.decode()
    found = solutions(done.stdout, arm.dof)
    assert len(found) == POSES
    for i, rows in enumerate(found):
        assert (rows >= arm.limits[:, 0]).all() and (rows <= arm.limits[:, 1]).all()
        assert np.abs(arm.fk(rows) - T[i]).max(initial=0.0) < 1e-8
        apart = np.linalg.norm(rows - seeds[i], axis=1)
        assert (np.diff(apart) >= -1e-9).all()
        if arm.redundancy is None and np.isfinite(arm.limits).all():
            every = arm.ik(T[i])
            assert len(rows) == every.turns().count
        if arm.redundancy is None:
            assert np.abs(np.remainder(rows - q[i] + np.pi, 2 * np.pi) - np.pi).max(axis=1).min() < 1e-6


def test_what_does_not_fit_the_arm_is_refused(tmp_path: Path) -> None:
    """A URDF that was calibrated since, and a link that is missing or moves relative to the arm's base, are named."""
    arm = urdf_ik.load("zyyzyz_6r")
    text = arm.model.xml.decode().replace('xyz="0 0 0.1"', 'xyz="0 0 0.1001"')
    now, then = tmp_path / "now.json", tmp_path / "then.json"
    now.write_text(urdf_ik.compile(arm))
    then.write_text(urdf_ik.compile(urdf_ik.load(text)))
    for other, links, words in (
        (then, (), "the URDF changed since; urdf-ik compile writes it anew"),
        (now, ("base_link", "elsewhere"), "elsewhere"),
        (now, ("stand-in gripper", "tool0"), "gripper is not fixed to base_link"),
    ):
        refused = searched([now, other], arm.fk(np.zeros((1, 6))), np.zeros((1, 6)), *links)
        assert refused.returncode == 1 and words in refused.stderr.decode()
