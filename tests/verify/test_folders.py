"""The arms of a folder: rows against the checks of each arm alone, and what is refused."""

import json
import shutil
from pathlib import Path

import pytest
from command import call

import urdf_ik
from urdf_ik.model import catalogue
from urdf_ik.verify import completeness, crosscheck
from urdf_ik.verify.folders import FAILED, NOT_AN_ARM, NOT_CHECKED, PASSED, REFUSED, FolderCheck, check_folder

BROKEN = "<robot name='broken'><link name='a'/>"


@pytest.fixture
def lab(tmp_path: Path) -> Path:
    """A folder with three arms, one of them in a folder of its own, and a file that is cut short."""
    folder = tmp_path / "lab"
    (folder / "small").mkdir(parents=True)
    for name in ("puma_560", "zyyzyz_6r"):
        shutil.copy(catalogue.resolve(name).path, folder / f"{name}.urdf")
    shutil.copy(catalogue.resolve("planar_2r").path, folder / "small" / "planar_2r.urdf")
    (folder / "broken.urdf").write_text(BROKEN)
    (folder / "notes.txt").write_text("no robot")
    return folder


def test_each_row_is_the_check_of_that_arm_alone(lab: Path) -> None:
    """Reports are those of ``crosscheck.check``; the broken file is refused with its reason, and ends nothing."""
    found = check_folder(lab, n=10, seed=3)
    assert [each.file for each in found.arms] == [
        "broken.urdf",
        "puma_560.urdf",
        "small/planar_2r.urdf",
        "zyyzyz_6r.urdf",
    ]
    assert [each.result for each in found.arms] == [REFUSED, PASSED, PASSED, PASSED]
    for each in found.arms[1:]:
        alone = crosscheck.check(urdf_ik.load(lab / each.file), n=10, seed=3)
        assert each.report == alone.to_dict()
    assert "the text ends early" in found.arms[0].words and not found.passed
    assert str(found).endswith("FAILED: 4 files: 3 passed, 1 refused")
    assert json.loads(found.to_json())["arms"][1]["robot"] == "puma_560"
    assert FolderCheck.from_json(found.to_json()) == found


def test_files_without_an_arm_are_listed_and_do_not_count(lab: Path) -> None:
    """Obstacles, with status 0; but an arm whose base is called otherwise is refused."""
    (lab / "broken.urdf").write_text(fixed("cell"))
    found = check_folder(lab, n=2)
    assert [each.result for each in found.arms] == [NOT_AN_ARM, PASSED, PASSED, PASSED] and found.passed
    assert "there is no movable chain" in found.arms[0].words
    assert found.verdict() == "PASSED: 4 files: 3 passed, 1 not an arm"
    result = call("check", str(lab), "-n", "2")
    assert result.exit_code == 0 and "not an arm" in result.stdout
    assert check_folder(lab / "small", n=2, base="nowhere").arms[0].result == REFUSED


def fixed(name: str) -> str:
    """A URDF of two links that are fixed to each other."""
    joint = '<joint name="j" type="fixed"><parent link="floor"/><child link="table"/></joint>'
    return f'<robot name="{name}"><link name="floor"/><link name="table"/>{joint}</robot>'


def test_missed_solutions_are_looked_for_where_there_are_six_turning_joints(lab: Path) -> None:
    """Reports are those of ``completeness.compare``; an arm of two joints is not checked, which is no failure."""
    (lab / "broken.urdf").unlink()
    found = check_folder(lab, n=1, complete=True)
    assert [each.result for each in found.arms] == [PASSED, NOT_CHECKED, PASSED] and found.passed
    alone = completeness.compare(urdf_ik.load(lab / "puma_560.urdf"), n=1)
    assert found.arms[0].report == alone.to_dict()
    assert "six turning joints" in found.arms[1].words


def test_an_arm_that_is_not_pinocchios_fails(lab: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Where the solver's answers are wrong, its row says which property and which pose."""
    solve = urdf_ik.Arm.fk

    def off(arm: urdf_ik.Arm, q: object) -> object:
        T = solve(arm, q)
        T[..., 0, 3] += 1e-3 * (arm.name == "puma_560")
        return T

    monkeypatch.setattr(urdf_ik.Arm, "fk", off)
    found = check_folder(lab, n=5)
    assert [each.result for each in found.arms] == [REFUSED, FAILED, PASSED, PASSED]
    assert found.arms[1].words.startswith("FAILED forward kinematics, position: pose ")


def test_what_cannot_be_checked_is_refused(lab: Path, tmp_path: Path) -> None:
    """A folder without a URDF, numbers that make no sense."""
    (tmp_path / "empty").mkdir()
    with pytest.raises(urdf_ik.UrdfError, match=r"holds no file that ends in \.urdf"):
        check_folder(tmp_path / "empty")
    with pytest.raises(urdf_ik.ArgumentError, match="n=0"):
        check_folder(lab, n=0)
