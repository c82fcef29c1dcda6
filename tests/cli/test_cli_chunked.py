"""``placement`` and ``check FOLDER``: what they print is what the library finds."""

import json
import shutil
from pathlib import Path

import numpy as np
import pytest
from command import ARM, call, cell, strict_json, succeed
from pictures import is_png
from seams import seam

import urdf_ik
from urdf_ik.maps import placements
from urdf_ik.model import catalogue
from urdf_ik.verify import crosscheck

BOX = "--bounds=-0.5,-0.5,0,0.5,0.5,0"


@pytest.fixture
def targets(tmp_path: Path) -> Path:
    """Some poses of a seam, in a file."""
    path = tmp_path / "seam.npy"
    np.save(path, seam()[::6])
    return path


def test_the_best_places_are_those_of_the_map(targets: Path, tmp_path: Path) -> None:
    """JSON and table hold what ``maps.placement`` finds for the same question; a mount brings roll and pitch in."""
    asked = {"bounds": [[-0.5, -0.5, 0], [0.5, 0.5, 0]], "step": 0.5, "turns": 2}
    found = placements.placement(urdf_ik.load(ARM), np.load(targets), **asked)
    picture = tmp_path / "map.png"
    typed = ("placement", ARM, "-p", str(targets), BOX, "--step", "0.5", "--headings", "2")
    told = strict_json(succeed(*typed, "--output", str(picture), "-f", "json"))
    assert is_png(picture.read_bytes())
    assert [place["reached"] for place in told["places"]] == [place.reached for place in found.places()]
    assert np.allclose([place["pose"] for place in told["places"]], [place.pose for place in found.places()])
    table = succeed(*typed, "--degrees")
    assert "targets       5" in table and "yaw [deg]" in table and "roll" not in table
    assert max(map(len, table.splitlines())) <= 80
    hanging = succeed(*typed, "--mount", "180,0,0", "--degrees")
    assert "roll [deg]" in hanging and " 180 " in hanging


def test_a_path_and_a_world_have_columns_of_their_own(targets: Path, tmp_path: Path) -> None:
    """With --path whether it is followed, with --world the clearance."""
    typed = ("placement", ARM, "-p", str(targets), "--bounds=0,0,0,0,0,0", "--step", "1", "--path")
    text = succeed(*typed, "--world", cell(tmp_path / "cell.urdf", 'sphere radius="0.1"', (3, 3, 0.5)))
    assert "clearance" in text and "followed      1\n" in text


def test_a_folder_is_checked_in_one_table(tmp_path: Path) -> None:
    """A row a file: the check of that arm alone; status 1 where one fails or cannot be read, 0 where all pass."""
    lab = tmp_path / "lab"
    (lab / "small").mkdir(parents=True)
    shutil.copy(catalogue.resolve("planar_2r").path, lab / "small")
    shutil.copy(catalogue.resolve("puma_560").path, lab)
    (lab / "cell.urdf").write_text('<robot name="cell"><link name="floor"/></robot>')
    table = succeed("check", str(lab), "-n", "5")
    assert table.count("PASSED") == 2 and "no movable chain" in table
    (lab / "cut.urdf").write_text("<robot name=")
    result = call("check", str(lab), "-n", "5", "-f", "json")
    arms = strict_json(result.stdout)["arms"]
    assert result.exit_code == 1
    assert [(each["file"], each["passed"]) for each in arms] == [
        *(("cell.urdf", None), ("cut.urdf", False), ("puma_560.urdf", True), ("small/planar_2r.urdf", True))
    ]
    alone = crosscheck.check(urdf_ik.load("puma_560"), n=5)
    assert arms[2]["report"] == json.loads(alone.to_json())


@pytest.mark.parametrize(
    ("typed", "words"),
    [
        (("placement", ARM, "-p", "{t}", BOX, "--step", "0"), "step=0.0 given"),
        (("placement", ARM, "-p", "{t}", "--bounds=1,2", "--step", "1"), "holds 2 values, 6 are needed"),
        (("placement", ARM, "-p", "{t}", BOX, "--step", "1", "--output", "map.bmp"), "pictures are written as"),
        (("check", "{folder}", "--lock", "a=1"), "--lock is for an arm"),
    ],
)
def test_what_makes_no_sense_is_refused(typed: tuple[str, ...], words: str, targets: Path, tmp_path: Path) -> None:
    """Status 2, and one message that says what would be valid."""
    given = [each.format(t=targets, folder=tmp_path) for each in typed]
    result = call(*given)
    assert result.exit_code == 2 and words in result.stderr
