"""The command `urdf-ik calibrate`."""

import json
from pathlib import Path

import numpy as np
import pytest
from command import succeed
from measured import true_arm

import urdf_ik
from urdf_ik.model.poses import to_quat_wxyz


@pytest.fixture(scope="module")
def measurements(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """60 measured poses as CSV."""
    true = true_arm("zyyzyz_6r", 0)
    q, T = true.measured(1, 60)
    header = ",".join([*true.nominal.joint_names, "x", "y", "z", "qw", "qx", "qy", "qz"])
    path = tmp_path_factory.mktemp("measured") / "poses.csv"
    np.savetxt(path, np.hstack([q, T[:, :3, 3], to_quat_wxyz(T)]), delimiter=",", header=header, comments="")
    return path


def test_it_writes_urdf_report_and_json(measurements: Path, tmp_path: Path) -> None:
    """The new URDF is another arm with the same joints; the page and the next poses are there."""
    urdf, page = tmp_path / "calibrated.urdf", tmp_path / "report.html"
    out = succeed("calibrate", "zyyzyz_6r", "--measured", str(measurements), "-o", str(urdf), "--report", str(page),
                  "--next", "3", "--json")  # fmt: skip
    read = json.loads(out)
    assert read["after"]["position"] < 0.1 * read["before"]["position"]
    assert np.shape(read["next"]["q"]) == (3, 6)
    assert page.read_text().startswith("<!doctype html>")
    before, after = urdf_ik.load("zyyzyz_6r"), urdf_ik.load(urdf)
    assert after.joint_names == before.joint_names
    assert not urdf_ik.compare(before, after, n=5).same


def test_it_prints_tables(measurements: Path) -> None:
    """The text names every parameter, and the unobservable ones."""
    out = succeed("calibrate", "zyyzyz_6r", "--measured", str(measurements), "--next", "2")
    assert "unobservable" in out and "joint_2 xyz x" in out and "poses to measure next" in out
