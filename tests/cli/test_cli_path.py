"""urdf-ik path: what it prints, what it writes, and how it says that there is no way."""

import csv
import re
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest
from command import ARM, call, cell, comma, oracle, strict_json, succeed
from numpy.typing import NDArray
from seams import seam

import urdf_ik
from urdf_ik.cli import console
from urdf_ik.model import catalogue

Array = NDArray[np.float64]
SHORT = 0.3, 20  # m, waypoints


@pytest.fixture
def file(tmp_path: Path) -> str:
    """The seam as a CSV."""
    poses = seam(*SHORT)
    rows = np.hstack([poses[:, :3, 3], urdf_ik.model.poses.to_quat_wxyz(poses)])
    name = tmp_path / "seam.csv"
    np.savetxt(name, rows, fmt="%.17g", delimiter=",", header="x,y,z,qw,qx,qy,qz", comments="")
    return str(name)


def far(folder: Path) -> str:
    """A line that leaves the arm's reach."""
    name = folder / "far.npy"
    np.save(name, seam(3.0, 60))
    return str(name)


def columns(path: Path, names: Sequence[str]) -> Array:
    """Columns of a CSV, by name."""
    with path.open() as opened:
        return np.array([[float(row[name]) for name in names] for row in csv.DictReader(opened)])


def test_the_files_reach_the_waypoints(file: str, tmp_path: Path) -> None:
    """The plan that is written, in any format, leads through the waypoints by Pinocchio's kinematics."""
    found = {suffix: tmp_path / f"plan.{suffix}" for suffix in ("csv", "json")}
    for out in found.values():
        succeed("path", ARM, "-p", file, "--output", str(out))
    q = columns(found["csv"], urdf_ik.load(ARM).joint_names)
    np.testing.assert_allclose(oracle().poses(q), seam(*SHORT), rtol=0.0, atol=1e-9)
    assert np.array_equal(strict_json(found["json"].read_text())["q"], q)


def test_a_written_plan_keeps_to_the_straight_segment(tmp_path: Path) -> None:
    """Two waypoints far apart: half way from each row of the CSV to the next, the tip is near the line by Pinocchio."""
    ends = seam(*SHORT)[[0, -1]]
    name, out = tmp_path / "ends.npy", tmp_path / "plan.csv"
    np.save(name, ends)
    result = call("path", ARM, "-p", str(name), "--output", str(out))
    waypoint, q = np.split(columns(out, ("waypoint", *urdf_ik.load(ARM).joint_names)), [1], axis=1)
    assert result.exit_code == 0 and f"{out}: {len(q)} joint vectors; rad, m" in result.stderr
    assert (waypoint[0], waypoint[-1]) == (0, 1) and len(q) > 3
    tips = oracle().poses((q[1:] + q[:-1]) / 2.0)[:, :3, 3]
    along = ends[1, :3, 3] - ends[0, :3, 3]
    off = np.cross(tips - ends[0, :3, 3], along) / np.linalg.norm(along)
    assert np.linalg.norm(off, axis=1).max() < 1e-3


def test_the_motion_in_time_keeps_within_the_velocities(file: str, tmp_path: Path) -> None:
    """It begins and ends at rest at the path's ends, and no joint exceeds the URDF's velocity."""
    out = tmp_path / "motion.csv"
    text = succeed("path", ARM, "-p", file, "--timed", str(out))
    arm = urdf_ik.load(ARM)
    t, q, qd = np.split(columns(out, ("t", *arm.joint_names, *(f"{name} qd" for name in arm.joint_names))), [1, 7], 1)
    assert f" {t[-1, 0]:.3f} s (" in text
    data = strict_json(succeed("path", ARM, "-p", file, "--timed", str(out.with_suffix(".json")), "--json"))
    assert data["found"] and strict_json(out.with_suffix(".json").read_text())["qd"] == qd.tolist()
    np.testing.assert_allclose(oracle().poses(q[[0, -1]]), seam(*SHORT)[[0, -1]], rtol=0.0, atol=1e-6)
    velocity = {joint.name: joint.velocity for joint in arm.model.joints}
    assert (np.abs(qd) <= 1.001 * np.array([velocity[name] for name in arm.joint_names])).all()
    assert np.abs(qd[[0, -1]]).max() < 1e-3 and (np.diff(t[:, 0]) > 0.0).all()


def test_a_plan_is_written_where_it_cannot_be_timed(tmp_path: Path) -> None:
    """A URDF without velocities: the plan is printed and written, and what lacks is named; the status is 2."""
    arm = tmp_path / "slow.urdf"
    arm.write_text(re.sub(r' velocity="[^"]*"', ' velocity="0"', catalogue.resolve(ARM).path.read_text()))
    name, out, timed = tmp_path / "seam.npy", tmp_path / "plan.csv", tmp_path / "motion.csv"
    np.save(name, seam(*SHORT))
    result = call("path", str(arm), "-p", str(name), "--output", str(out), "--timed", str(timed))
    assert result.exit_code == 2 and "cost " in result.stdout and out.exists() and not timed.exists()
    assert "no velocity limit for joint_1" in result.stderr


def test_where_there_is_no_plan_every_branch_says_why(tmp_path: Path) -> None:
    """Status 1, a row a start branch with its waypoint and reason as ``explain`` has them; no file but JSON."""
    name = far(tmp_path)
    plan = urdf_ik.load(ARM).follow(np.load(name))
    assert not plan.found
    out, data = tmp_path / "plan.csv", tmp_path / "plan.json"
    result = call("path", ARM, "-p", name, "--output", str(out), "--timed", str(data))
    assert result.exit_code == 1 and not out.exists() and f"{out} was not written: there is no plan" in result.stderr
    for stop in plan.stops:
        (row,) = [line for line in result.stdout.splitlines() if line.startswith(f"{stop.branch} ")]
        assert row.split(stop.branch)[1].split()[:2] == [str(stop.waypoint), stop.cause] and row.endswith(stop.reason)
    assert "reach 2.1 m" in result.stdout
    result = call("path", ARM, "-p", name, "-f", "json", "--output", str(data))
    answer = strict_json(result.stdout)
    assert result.exit_code == 1 and not answer["found"]
    assert [stop["branch"] for stop in answer["stops"]] == [stop.branch for stop in plan.stops]
    assert strict_json(data.read_text())["found"] is False


def test_start_and_end_are_kept(file: str) -> None:
    """A start that is typed is where the plan begins, also where it is not the best one; so is an end."""
    start = urdf_ik.load(ARM).follow(seam(*SHORT)).alternatives[-1].q
    for option, place in (("--start", 0), ("--end", -1)):
        answer = strict_json(succeed("path", ARM, "-p", file, option, comma(start[place]), "-f", "json"))
        assert np.array_equal(answer["q"][place], start[place])


def test_a_wall_stands_in_the_way(file: str, tmp_path: Path) -> None:
    """A cell whose wall stands on the path: no plan, and the wall is named; far from it, it is no obstacle."""
    on_the_path, elsewhere = seam(*SHORT)[10, :3, 3], np.array([3.0, 3.0, 3.0])
    for place, status in ((on_the_path, 1), (elsewhere, 0)):
        world = cell(tmp_path / "cell.urdf", 'box size="0.1 0.02 0.1"', place)
        result = call("path", ARM, "-p", file, "--world", world)
        assert result.exit_code == status and "world         post" in result.stdout
        assert ("contact" in result.stdout and "and post touch" in result.stdout) == (status == 1)
    assert call("path", ARM, "-p", file, "--world", world, "--no-collisions").exit_code == 2


def test_the_branch_is_changed_where_that_is_allowed(tmp_path: Path) -> None:
    """A path that no branch follows all the way is followed with a change, and the table names it."""
    arm = urdf_ik.load(ARM)
    corners = np.concatenate([seam(*SHORT), urdf_ik.line(arm.fk([-2.5, 0.4, -1.2, 0.3, 0.9, 0.1]),
                                                   arm.fk([-2.6, 0.5, -1.1, 0.3, 0.9, 0.1]), 5)])  # fmt: skip
    name = tmp_path / "two.npy"
    np.save(name, corners)
    assert call("path", ARM, "-p", str(name)).exit_code == 1
    plan = arm.follow(corners, reconfigure=True)
    result = call("path", ARM, "-p", str(name), "--reconfigure", "--timed", str(tmp_path / "motion.csv"))
    assert result.exit_code == 0 and plan.changes and f"reconfigurations  {len(plan.changes)}\n" in result.stdout
    for change in plan.changes:
        row = [str(change.waypoint), *change.before.split(), *change.after.split(), "yes" if change.free else "no"]
        assert row in [line.split() for line in result.stdout.splitlines()]
    assert "it changes its branch" in result.stderr


@pytest.mark.parametrize(
    ("args", "words"),
    [
        ((), ("--poses", "seam.csv")),
        (("-p", "{file}", "--output", "plan.txt"), ("--output", ".csv, .json")),
        (("-p", "{file}", "--output", "no/folder/plan.csv"), ("no folder",)),
        (("-p", "{file}", "--timed", "motion"), ("--timed", ".csv, .json")),
        (("-p", "{file}", "--start", "1,2"), ("--start", "joint_6")),
        (("-p", "{file}", "--start", "0,0,0,0,0,0"), ("start is no solution of waypoint 0",)),
        (("-p", "{file}", "--margin", "-1"), ("margin=-1.0", "at least 0")),
        (("-p", "{file}", "--cost", "l3"), ("l3", "time")),
        (("-p", "{file}", "--max-step", "0.1,0.2"), ("--max-step", "joint_6")),
        (("-p", "{file}", "--max-step", "0"), ("max_step", "between 1e-15 and")),
        (("-p", "{file}", "--tolerance", "0.1"), ("--tolerance", "2 are needed")),
    ],
)
def test_what_is_wrong_is_answered_in_words(file: str, args: tuple[str, ...], words: tuple[str, ...]) -> None:
    """Before anything is solved, with the option and what would be valid."""
    result = call("path", ARM, *(arg.format(file=file) for arg in args))
    assert result.exit_code in (2, 3)
    message = result.output.replace("│", " ")
    message = " ".join(message.split())
    assert all(word in message for word in words), message


def test_long_work_says_how_far_it_is(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    """Where nobody sees a bar there is a line now and then; short work is silent."""
    with console.Progress("following") as shown:
        shown.tick(1, 2)
    assert not capsys.readouterr().err
    monkeypatch.setattr(console, "WORD_AFTER", -1.0)
    monkeypatch.setattr(console, "WORD_EVERY", -1.0)
    with console.Progress("following") as shown:
        shown.tick(1, 2)
        shown.say("looking")
    assert capsys.readouterr().err.splitlines() == ["following: 1 of 2, 0 s so far", "following: looking, 0 s so far"]
