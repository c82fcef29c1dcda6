"""The ten tasks of the documentation: each line of the page does what the task asks."""

import csv
import re
import shlex
from pathlib import Path

import numpy as np
import pytest
from command import succeed

import urdf_ik
from urdf_ik.model import catalogue

PAGE = (Path(__file__).parents[2] / "docs" / "start.md").read_text(encoding="utf-8").partition("## Ten tasks")[2]
LINES = re.findall(r"^urdf-ik .*$", PAGE, re.MULTILINE)
SEAM = "x,y,z,roll,pitch,yaw\n0.4,-0.2,0.3,0,1.5707963,0\n0.4,0,0.3,0,1.5707963,0\n0.4,0.2,0.3,0,1.5707963,0\n"


def test_every_line_of_the_page_runs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """In their order, in one folder; what they write is what the tasks ask for."""
    monkeypatch.chdir(tmp_path)
    Path("my_arm.urdf").write_bytes(catalogue.resolve("puma_560").path.read_bytes())
    Path("seam.csv").write_text(SEAM)
    assert len(LINES) == 12 and len(re.findall(r"^\d+\. ", PAGE, re.MULTILINE)) == 10
    printed = {line: succeed(*shlex.split(line)[1:]) for line in LINES}
    arm = urdf_ik.load("my_arm.urdf")
    T = urdf_ik.pose([0.4, 0.0, 0.3], rpy=[0.0, np.pi / 2, 0.0])
    kept = arm.ik(T).within_limits().collision_free()
    with Path("free.csv").open(encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert sorted(row["branch"] for row in rows) == sorted(kept[k].branch for k in range(len(kept)))
    assert "no solution" in printed[LINES[4]] and "reach" in printed[LINES[4]]
    assert "2 solutions" in printed[LINES[5]]
    assert "PASSED" in printed[LINES[8]]
    assert Path("plan.csv").stat().st_size and Path("path.png").read_bytes().startswith(b"\x89PNG")
    assert re.search(r"^ *0\.\d+ .* 3 ", printed[LINES[11]], re.MULTILINE)
