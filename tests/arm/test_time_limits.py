"""Work on many things ends at its time limit, with what it has, and says what was not looked at."""

from __future__ import annotations

import json
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from typer.testing import CliRunner

import urdf_ik
from urdf_ik.cli import app
from urdf_ik.model import catalogue
from urdf_ik.support import watch
from urdf_ik.verify import check_proof, completeness, crosscheck, judge, surveys

Settings = dict[str, Any]


@pytest.fixture
def ended_after(monkeypatch: pytest.MonkeyPatch) -> Callable[[int], Settings]:
    """Settings under which the time limit passes with the k-th call of ``progress``."""

    def settings(calls: int) -> Settings:
        said: list[tuple[int, int]] = []
        monkeypatch.setattr(watch, "monotonic", lambda: 1e9 if len(said) >= calls else 0.0)
        return {"time_limit": 1.0, "progress": lambda done, total: said.append((done, total))}

    return settings


def vectors(arm: urdf_ik.Arm, count: int) -> np.ndarray:
    """Joint vectors inside the limits."""
    low, high = np.clip(arm.limits.T, -np.pi, np.pi)
    drawn: np.ndarray = np.random.default_rng(0).uniform(low, high, (count, arm.dof))
    return drawn


def test_intervals_of_the_poses_that_were_looked_at_are_whole(ended_after: Callable[[int], Settings]) -> None:
    """The poses that time left out have none, which is not said to be unreachable; the others have all of theirs."""
    arm = urdf_ik.load("panda")
    T = arm.fk(vectors(arm, 100))
    some, every = arm.intervals(T, **ended_after(1)), arm.intervals(T)
    assert 0 < some.looked_at.sum() < 100
    assert every.looked_at.all() and every.unlooked == ""
    assert np.array_equal(some.count, np.where(some.looked_at, every.count, 0))
    assert f"{some.looked_at.sum()} of 100 poses" in some.unlooked
    assert some.unlooked in repr(some) and some[99].unlooked == some.unlooked and some[0].unlooked == ""
    assert list(map(str, some[0])) == list(map(str, every[0]))
    with pytest.raises(urdf_ik.ArgumentError, match="not looked at"):
        some.nearest(vectors(arm, 100))


def test_intervals_in_a_world_of_the_poses_in_time_are_whole(ended_after: Callable[[int], Settings]) -> None:
    """The time may pass while contacts are looked for, too."""
    arm, world = urdf_ik.load("srs_7r"), urdf_ik.World()
    world.add("ball", urdf_ik.Sphere(0.2), urdf_ik.pose([0.5, 0.1, 0.6]))
    T = arm.fk(vectors(arm, 5))
    some, every = arm.intervals(T, world=world, **ended_after(2)), arm.intervals(T, world=world)
    assert 0 < some.looked_at.sum() < 5
    for i in np.flatnonzero(some.looked_at):
        assert list(map(str, some[int(i)])) == list(map(str, every[int(i)]))


def test_a_sweep_out_of_time_is_thinner_and_as_wide(ended_after: Callable[[int], Settings]) -> None:
    """Its values are among those of the whole sweep, with the same solutions there, and no gap is left."""
    arm = urdf_ik.load("srs_7r")
    T = arm.fk(vectors(arm, 1))[0]
    some, every = arm.sweep(T, 20_000, **ended_after(1)), arm.sweep(T, 20_000)
    assert every.unlooked == ""
    assert f"{len(some.redundancy)} of 20000 values" in some.unlooked
    here = np.isin(every.redundancy, some.redundancy)
    assert here.sum() == len(some.redundancy) < 20_000
    assert np.array_equal(every.redundancy[here], some.redundancy)
    assert np.array_equal(every.solutions.q[here], some.solutions.q, equal_nan=True)
    assert np.diff(np.flatnonzero(here)).max() == np.diff(np.flatnonzero(here)).min()


def test_every_arm_answers_the_poses_that_were_looked_at(ended_after: Callable[[int], Settings]) -> None:
    """All arms are compared over the same poses."""
    a, b = urdf_ik.load("ur5"), urdf_ik.load("puma_560")
    T = a.fk(vectors(a, 80))
    some = urdf_ik.compare_many([a, b], T, collisions=False, **ended_after(1))
    every = urdf_ik.compare_many([a, b], T, collisions=False)
    assert every.unlooked == "" and every.poses == 80
    assert 0 < some.poses < 80
    assert f"{some.poses} of 80 poses" in some.unlooked and some.unlooked in str(some)
    assert list(map(repr, some.rows)) == [repr(row) for row in every.rows if row.pose < some.poses]


def test_a_lock_that_was_not_looked_through_has_not_passed(ended_after: Callable[[int], Settings]) -> None:
    """Without a difference it has neither passed nor failed."""
    arm = urdf_ik.load("planar_2r")
    lock = urdf_ik.freeze(arm)
    assert lock.verify(arm, time_limit=1e6).passed
    some = lock.verify(arm, **ended_after(1))
    assert 0 < some.poses < len(lock.poses)
    assert not some.passed and not some.differences
    assert some.verdict().startswith("NOT ENDED") and f"{some.poses} of {len(lock.poses)}" in some.verdict()


@pytest.mark.parametrize("how", ["check", "completeness", "judge", "proofs", "survey"])
def test_a_check_that_was_cut_off_has_not_passed(how: str, ended_after: Callable[[int], Settings]) -> None:
    """Without a fault it has neither passed nor failed; without a limit it passes."""
    arm = urdf_ik.load("puma_560")
    run = {
        "check": lambda **given: crosscheck.check(arm, n=300, collision=False, **given),
        "completeness": lambda **given: completeness.compare(arm, n=8, **given),
        "judge": lambda **given: judge(arm, lambda T: arm.ik(T).to_array(), n=2, **given),
        "proofs": lambda **given: check_proof(arm, arm.ik(arm.fk(vectors(arm, 2))), **given),
        "survey": lambda **given: surveys.survey([catalogue.resolve("puma_560").path] * 2, n=2, **given),
    }[how]
    assert run(time_limit=1e6).passed
    assert run().unlooked == ""
    some = run(**ended_after(1))
    assert not some.passed
    assert some.verdict().startswith("NOT ENDED") and some.unlooked in some.verdict()
    assert json.loads(some.to_json())["unlooked"] == some.unlooked


def test_a_store_of_a_survey_holds_what_was_in_time(ended_after: Callable[[int], Settings], tmp_path: Path) -> None:
    """The first arms are kept, and the same call without a limit goes on; the arms are those of one run."""
    files = [catalogue.resolve(name).path for name in ("planar_2r", "puma_560", "zyyzyz_6r")]
    some = surveys.survey(files, n=2, store=tmp_path / "night", **ended_after(2))
    assert len(some.arms) == 1 and not some.passed and "1 of 3 files" in some.verdict()
    said: list[int] = []
    every = surveys.survey(files, n=2, store=tmp_path / "night", progress=lambda done, total: said.append(done))
    assert said == [1, 2, 3] and every.passed and every == surveys.survey(files, n=2)
    assert some.arms == every.arms[:1]


def test_an_arm_whose_check_was_cut_off_has_not_passed(monkeypatch: pytest.MonkeyPatch) -> None:
    """The time passes during the first arm's check: its row says so, and the second arm is not looked at."""
    ticks = iter(range(10**6))
    monkeypatch.setattr(watch, "monotonic", lambda: float(next(ticks)))
    files = [catalogue.resolve("planar_2r").path] * 2
    some = surveys.survey(files, n=2000, time_limit=6.0)
    assert [each.result for each in some.arms] == [surveys.NOT_ENDED] and "not looked at" in some.arms[0].words
    assert some.verdict().startswith("NOT ENDED") and "1 of 2 files" in some.verdict()


def test_a_lock_that_was_cut_short_says_so(ended_after: Callable[[int], Settings]) -> None:
    """The poses of the user come first; the lock keeps what was left out, and whoever verifies it is told."""
    arm = urdf_ik.load("planar_2r")
    own = arm.fk(vectors(arm, 3))
    whole = urdf_ik.freeze(arm, own, time_limit=1e6)
    assert whole == urdf_ik.freeze(arm, own) and whole.unlooked == "" and "unlooked" not in whole.to_text()
    some = urdf_ik.freeze(arm, own, **ended_after(2))
    kinds = [pose.kind for pose in some.poses]
    assert kinds.count("own") == 3 and 3 < len(kinds) < len(whole.poses)
    assert set(some.poses) <= set(whole.poses)
    assert f"{len(kinds)} of {len(whole.poses)} poses" in some.unlooked and some.unlooked in repr(some)
    again = type(some).from_text(some.to_text())
    assert again == some
    assert any(some.unlooked in note for note in again.verify(arm).notes)


def test_a_fit_out_of_time_is_the_best_so_far(monkeypatch: pytest.MonkeyPatch) -> None:
    """After a few evaluations the errors have fallen, and what was not done is said."""
    arm = urdf_ik.load("ur5")
    q = vectors(arm, 60)
    measured = arm.fk(q + np.linspace(-0.02, 0.03, 6))
    whole = urdf_ik.calibrate(arm, q, measured, fit="offsets", time_limit=1e6)
    assert whole.unlooked == "" and whole.validated is not None
    ticks = iter(range(10**6))
    monkeypatch.setattr(watch, "monotonic", lambda: float(next(ticks)))
    some = urdf_ik.calibrate(arm, q, measured, fit="offsets", time_limit=6.0)
    assert whole.after.position < some.after.position < 0.75 * some.before.position
    assert "in the midst of the fit" in some.unlooked and some.unlooked in some.verdict()
    assert some.validated is None
    assert "not looked at" in some.to_json()


def test_without_time_for_the_folds_the_fit_is_whole(ended_after: Callable[[int], Settings]) -> None:
    """The numbers are those without a limit; errors of unseen measurements are left out."""
    arm = urdf_ik.load("ur5")
    q = vectors(arm, 60)
    measured = arm.fk(q + 0.01)
    some = urdf_ik.calibrate(arm, q, measured, fit="offsets", **ended_after(3))
    assert np.array_equal(some.x, urdf_ik.calibrate(arm, q, measured, fit="offsets").x)
    assert some.validated is None and "after the fit" in some.unlooked


def test_the_commands_take_a_time_limit(tmp_path: Path) -> None:
    """With no time a lock does not pass, and the tables say what was not looked at."""
    lock, poses = tmp_path / "arm.lock.json", tmp_path / "poses.csv"
    arm = urdf_ik.load("planar_2r")
    urdf_ik.freeze(arm).save(lock)
    done = CliRunner().invoke(app, ["verify", "planar_2r", str(lock), "--time-limit", "0"])
    assert done.exit_code == 1 and "NOT ENDED" in done.stdout
    assert CliRunner().invoke(app, ["verify", "planar_2r", str(lock), "--time-limit", "600"]).exit_code == 0
    poses.write_text("x,y,z,qw,qx,qy,qz\n0.4,0.2,0.3,1,0,0,0\n")
    command = ["compare", "ur5", "ur10", "-n", "2", "--poses", str(poses), "--time-limit", "0", "--json"]
    found = json.loads(CliRunner().invoke(app, command).stdout)
    assert "0 of 1 poses" in found["poses"]["unlooked"]
    done = CliRunner().invoke(app, ["freeze", "planar_2r", str(lock), "--time-limit", "0"])
    assert done.exit_code == 1 and "0 of 50 poses" in done.stdout
    for more in (["--proof", "-n", "1"], ["-n", "2"], ["--complete", "-n", "1"]):
        done = CliRunner().invoke(app, ["check", "puma_560", *more, "--time-limit", "0"])
        assert done.exit_code == 1 and "NOT ENDED" in done.stdout
    (tmp_path / "lab").mkdir()
    shutil.copy(catalogue.resolve("planar_2r").path, tmp_path / "lab" / "arm.urdf")
    done = CliRunner().invoke(app, ["check", str(tmp_path / "lab"), "--time-limit", "0"])
    assert done.exit_code == 1 and "0 of 1 files" in done.stdout


@pytest.mark.parametrize(("setting", "value"), [("time_limit", -1.0), ("time_limit", "soon"), ("progress", 3)])
def test_settings_that_make_no_sense_are_refused(setting: str, value: object) -> None:
    """The message names the setting."""
    arm = urdf_ik.load("srs_7r")
    q = vectors(arm, 3)
    T, wrong = arm.fk(q), {setting: value}
    lock = urdf_ik.freeze(urdf_ik.load("planar_2r"))
    calls: list[Callable[[], object]] = [
        lambda: arm.intervals(T, **wrong),
        lambda: arm.sweep(T[0], **wrong),
        lambda: urdf_ik.compare_many([arm], T, **wrong),
        lambda: lock.verify(urdf_ik.load("planar_2r"), **wrong),
        lambda: urdf_ik.calibrate(arm, q, T, **wrong),
        lambda: urdf_ik.freeze(arm, **wrong),
        lambda: check_proof(arm, arm.ik(T), **wrong),
        lambda: surveys.survey([catalogue.resolve("planar_2r").path], **wrong),
    ]
    for call in calls:
        with pytest.raises(urdf_ik.ArgumentError, match=setting):
            call()
