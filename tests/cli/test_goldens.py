"""The JSON of the commands, kept in goldens/commands.json: every key, text and count, and numbers to rounding.

``python tests/cli/test_goldens.py`` (with tests/support in PYTHONPATH) writes the file anew.
"""

import json
import math
import os
import sys
import tempfile
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from command import call

import urdf_ik

GOLDENS = Path(__file__).parents[1] / "goldens" / "commands.json"
VOLATILE = {
    "seconds": "time",
    "loading": "time",
    "time": "time",
    "version": "of this package",
    "urdf_ik": "its version in files",
    "instructions": "the instruction set in use",
    "versions": "of packages",
    "made": "date and versions in a lock and in a compiled arm",
    "source": "absolute path of the URDF",
    "file": "path of a written file",
    "singular_values": "of a fit, of which the least are rounding",
}
"""Keys whose values differ from run to run or from machine to machine, and what they hold."""
WORST = {"detail", "index", "q"}
"""Keys of a row of a check that say where its worst error is: any place, where all errors are rounding."""
ABSOLUTE, RELATIVE = 1e-7, 1e-7
"""Differences of numbers [rad, m] that other processors and instruction sets make; errors of 1e-16 count as zero."""
SEAM = "x,y,z,roll,pitch,yaw\n0.4,-0.1,0.3,0,1.5707963,0\n0.4,0,0.3,0,1.5707963,0\n0.4,0.1,0.3,0,1.5707963,0\n"
CELL = """<robot name="cell"><link name="floor"/><link name="box"><collision><origin xyz="0.5 0.5 0.2"/>
<geometry><box size="0.2 0.2 0.4"/></geometry></collision></link>
<joint name="fixed" type="fixed"><parent link="floor"/><child link="box"/></joint></robot>"""
SOLVER = """import urdf_ik
arm = urdf_ik.load("zyyzyz_6r")
def solve(T):
    answer = arm.ik(T)
    return answer.q[answer.valid][1:]
"""
CASES = (
    "ik zyyzyz_6r --q 0.3,-0.5,0.8,0.4,0.7,-0.2 --world cell.urdf",
    "ik zyyzyz_6r --q 0.3,-0.5,0.8,0.4,0.7,-0.2 --nearest 0,0,0,0,0,0 --metric max --degrees",
    "ik scara_rrpr --random 2 --seed 3 --turns",
    "ik srs_7r --xyz 0.3,0.2,0.5 --rpy 3.14,0,0.3 --redundancy 0,0.4",
    "ik planar_2r --task planar-position --xyz 0.1,0.05,0",
    "ik zyyzyz_6r --xyz 9 0 0 --quat-xyzw 0 0 0 1",
    "fk zyyzyz_6r --q 0.3,-0.5,0.8,0.4,0.7,-0.2 --tool-xyz 0,0,0.1",
    "fk srs_7r --q 10,20,30,40,50,60,70 --degrees",
    "info zyyzyz_6r",
    "info srs_7r --lock joint_3=30deg --degrees",
    "info rail_6r --chains",
    "info dh_6r --pairs",
    "explain zyyzyz_6r --q 0.3,-0.5,0.8,0.4,0.7,-0.2 --world cell.urdf",
    "explain srs_7r --q 0.3,-0.5,0.8,0.4,0.7,-0.2,0.1",
    "explain planar_2r --task planar-position --xyz 0.3 0 0",
    "check zyyzyz_6r -n 10",
    "check dh_6r --complete -n 1",
    "compare zyyzyz_6r puma_560 -n 5",
    "compare planar_2r planar_2r --tool-xyz B=0,0,0.01 -n 5",
    "freeze puma_560 puma.lock.json",
    "verify puma_560 puma.lock.json",
    "verify puma_560 puma.lock.json --tool-xyz 0,0,0.01",
    "judge zyyzyz_6r --solver half.py:solve -n 2",
    "path zyyzyz_6r --poses seam.csv --tip tool0 --alternatives",
    "path puma_560 --q 0,0,0,0,0,0 --q 0.1,0.1,0.1,0.1,0.1,0.1 --no-collisions --timed timed.csv",
    "workspace planar_2r",
    "workspace zyyzyz_6r --voxel 0.6 --orientations 5 --values manipulability,margin",
    "placement zyyzyz_6r --poses seam.csv --bounds=-0.5,-0.5,0,0.5,0.5,0 --step 0.5 --headings 2",
    "calibrate zyyzyz_6r --measured measured.csv --next 1",
)
"""Each runs with --json, in this order, in one folder."""
COMPILED = ("planar_2r", "puma_560")


def inputs() -> None:
    """Write the files that the cases read into the current folder."""
    Path("seam.csv").write_text(SEAM)
    Path("cell.urdf").write_text(CELL)
    Path("half.py").write_text(SOLVER)
    arm = urdf_ik.load("zyyzyz_6r")
    rng = np.random.default_rng(0)
    q = np.clip(rng.uniform(-2.0, 2.0, (30, arm.dof)), *arm.limits.T)
    xyz = arm.fk(q + 0.002 * np.arange(arm.dof))[:, :3, 3]
    header = ",".join([*arm.joint_names, "x", "y", "z"])
    np.savetxt("measured.csv", np.hstack([q, xyz]), "%.9f", delimiter=",", header=header, comments="")


def answer(case: str) -> dict[str, Any]:
    """The status and the output of a case, without what is volatile."""
    result = call(*case.split(), "--json")
    return {"status": result.exit_code, "output": steady(json.loads(result.stdout))}


def compiled(name: str) -> Any:
    """The file that `urdf-ik compile` writes."""
    assert call("compile", name, "-o", "compiled.json").exit_code == 0
    return steady(json.loads(Path("compiled.json").read_text()))


def steady(value: Any) -> Any:
    """A value without its volatile keys."""
    if isinstance(value, dict):
        left_out = {*VOLATILE, *(WORST if "worst" in value else ())}
        return {key: steady(inner) for key, inner in value.items() if key not in left_out}
    return [steady(inner) for inner in value] if isinstance(value, list) else value


def same(found: Any, kept: Any, at: str = "") -> None:
    """Require equal keys, texts and integers, and close numbers."""
    if isinstance(kept, dict):
        assert isinstance(found, dict) and list(found) == list(kept), at
        for key in kept:
            same(found[key], kept[key], f"{at}.{key}")
    elif isinstance(kept, list):
        assert isinstance(found, list) and len(found) == len(kept), at
        for k, pair in enumerate(zip(found, kept, strict=True)):
            same(*pair, f"{at}[{k}]")
    elif isinstance(kept, float):
        # Rounding decides whether a joint stands half a turn one way or the other.
        turned = -kept if ".q[" in at and abs(abs(kept) - math.pi) <= ABSOLUTE else kept
        close = ABSOLUTE + RELATIVE * abs(kept)
        assert isinstance(found, int | float) and min(abs(found - kept), abs(found - turned)) <= close, (at, found)
    else:
        assert found == kept, (at, found)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder that the cases share: verify reads the lock that freeze wrote."""
    path = tmp_path_factory.mktemp("goldens")
    before = Path.cwd()
    os.chdir(path)
    inputs()
    os.chdir(before)
    return path


@pytest.fixture(scope="module")
def kept() -> dict[str, Any]:
    """The kept answers by case."""
    return json.loads(GOLDENS.read_text())  # type: ignore[no-any-return]


@pytest.mark.parametrize("case", CASES)
def test_the_answer_is_that_of_the_golden(
    case: str, kept: dict[str, Any], folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Status and JSON of each command."""
    monkeypatch.chdir(folder)
    if case.startswith("verify") and not Path("puma.lock.json").exists():
        assert call("freeze", "puma_560", "puma.lock.json").exit_code == 0
    same(answer(case), kept[case])


@pytest.mark.parametrize("name", COMPILED)
def test_the_compiled_arm_is_that_of_the_golden(
    name: str, kept: dict[str, Any], folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The file of `urdf-ik compile`."""
    monkeypatch.chdir(folder)
    same(compiled(name), kept[f"compile {name}"])


def main() -> None:
    """Write the goldens, one line a case."""
    with tempfile.TemporaryDirectory() as place:
        os.chdir(place)
        inputs()
        found = {case: answer(case) for case in CASES} | {f"compile {name}": compiled(name) for name in COMPILED}
    lines = [f"{json.dumps(case)}: {json.dumps(value, separators=(',', ':'))}" for case, value in found.items()]
    GOLDENS.write_text("{\n" + ",\n".join(lines) + "\n}\n")


if __name__ == "__main__":
    sys.exit(main())
