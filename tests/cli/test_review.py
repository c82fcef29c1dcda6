"""A change of an arm in review: the steps of action.yml in a clean clone, and `urdf-ik verify` of several files."""

import json
import os
import re
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest
import yaml
from command import call, succeed

from urdf_ik.model import catalogue

ROOT = Path(__file__).resolve().parents[2]
ARMS = ("planar_2r", "scara_rrpr", "puma_560")
Run = Callable[..., tuple[int, str]]


def git(*arguments: str, cwd: Path) -> None:
    """Run git, which must succeed."""
    identity = ("-c", "user.name=A", "-c", "user.email=a@b.c", "-c", "init.defaultBranch=main")
    subprocess.run(["git", *identity, *arguments], cwd=cwd, check=True, capture_output=True)


@pytest.fixture(scope="module")
def repository(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A repository of three URDFs and their lock files in another folder."""
    folder = tmp_path_factory.mktemp("repository")
    (folder / "robots").mkdir()
    (folder / "locks").mkdir()
    for name in ARMS:
        file = folder / "robots" / f"{name}.urdf"
        file.write_bytes(catalogue.resolve(name).path.read_bytes())
        succeed("freeze", str(file), str(folder / "locks" / f"{name}.lock.json"), "--tip", "tool0")
    git("init", "-q", cwd=folder)
    git("add", ".", cwd=folder)
    git("commit", "-q", "-m", "three arms", cwd=folder)
    return folder


@pytest.fixture
def clone(repository: Path, tmp_path: Path) -> Path:
    """A clean clone."""
    git("clone", "-q", str(repository), str(tmp_path / "clone"), cwd=tmp_path)
    return tmp_path / "clone"


def acted(clone: Path, **inputs: str) -> tuple[int, str, dict[str, str]]:
    """Run the action's steps as GitHub does: status, log with the summary, and outputs."""
    action = yaml.safe_load((ROOT / "action.yml").read_text())
    values = {f"inputs.{name}": str(each["default"]) for name, each in action["inputs"].items()}
    values |= {f"inputs.{name.replace('_', '-')}": value for name, value in inputs.items()}
    values |= {"inputs.install": "none", "runner.temp": str(clone.parent)}
    files = {name: clone.parent / name for name in ("GITHUB_OUTPUT", "GITHUB_STEP_SUMMARY")}
    for file in files.values():
        file.write_text("")
    status, log = 0, ""
    for step in action["runs"]["steps"]:
        if "inputs.install" in step.get("if", ""):
            continue
        env = {name: re.sub(r"\$\{\{ (.*?) \}\}", lambda m: values[m[1]], text) for name, text in step["env"].items()}
        path = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
        env = os.environ | env | {name: str(file) for name, file in files.items()} | {"PATH": path}
        command = ["bash", "--noprofile", "--norc", "-eo", "pipefail", "-c", step["run"]]
        done = subprocess.run(command, cwd=clone, env=env, capture_output=True, text=True, timeout=120, check=False)
        status, log = status or done.returncode, log + done.stdout
    outputs = dict(line.split("=", 1) for line in files["GITHUB_OUTPUT"].read_text().splitlines())
    return status, log + files["GITHUB_STEP_SUMMARY"].read_text(), outputs


def test_a_changed_axis_fails_at_its_line_and_a_reformatted_file_passes(clone: Path) -> None:
    """The log annotates the joint's line, the summary has the table, SARIF the same place."""
    changed, rewritten = clone / "robots" / "puma_560.urdf", clone / "robots" / "scara_rrpr.urdf"
    lines = changed.read_text().splitlines()
    joint = next(k for k, line in enumerate(lines) if '<joint name="joint_2"' in line)
    axis = next(k for k in range(joint, len(lines)) if "<axis" in lines[k])
    lines[axis] = '<axis xyz="0 0 -1"/>'
    changed.write_text("\n".join(lines))
    rewritten.write_text(re.sub(r'="([^"]*)"', r"='\1'", rewritten.read_text()).replace("><", ">\n\n<"))
    status, log, outputs = acted(clone, locks="locks", changed_since="HEAD")
    assert status == 1
    assert outputs["verified"] == "robots/puma_560.urdf robots/scara_rrpr.urdf"
    assert f"::error file=robots/puma_560.urdf,line={joint + 1},title=urdf-ik kinematics::joint_2: its axis" in log
    assert "robots/scara_rrpr.urdf: PASSED" in log and "::error file=robots/scara" not in log
    assert f"| robots/puma_560.urdf:{joint + 1} | kinematics | joint_2: its axis is negated" in log
    results = json.loads(Path(outputs["sarif"]).read_text())["runs"][0]["results"]
    place = results[0]["locations"][0]["physicalLocation"]
    assert place == {"artifactLocation": {"uri": "robots/puma_560.urdf"}, "region": {"startLine": joint + 1}}


def test_an_unchanged_repository_passes_and_another_solver_is_judged(clone: Path) -> None:
    """Without changed-since all files with a lock are verified; a solver that forgets a branch fails."""
    (clone / "half.py").write_text(
        'import urdf_ik\narm = urdf_ik.load("planar_2r")\ndef solve(T):\n    return arm.ik(T).to_array()[1:]\n'
    )
    status, log, outputs = acted(clone, files="robots/planar*", locks="locks", solver="half.py:solve")
    assert status == 1 and "::error file=robots/planar_2r.urdf,title=urdf-ik judge::half.py:solve disagrees" in log
    status, log, outputs = acted(clone, locks="locks")
    assert status == 0 and log.count(": PASSED") == 2 * len(ARMS) and "::error" not in log
    assert not json.loads(Path(outputs["sarif"]).read_text())["runs"][0]["results"]


def test_a_broken_file_is_annotated_and_the_others_are_verified(clone: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The error's own line; the status is that of a broken URDF. A lock file lies beside its robot by default."""
    monkeypatch.chdir(clone)
    file = clone / "locks" / "puma_560.urdf"
    text = (clone / "robots" / "puma_560.urdf").read_text().replace('type="revolute"', 'type="revolving"', 1)
    file.write_text(text)
    line = text[: text.index("revolving")].count("\n") + 1
    result = call("verify", "locks/puma_560.urdf", "robots/planar_2r.urdf", "--locks", "locks", "--format", "github")
    assert result.exit_code == 3
    assert f"::error file=locks/puma_560.urdf,line={line},title=urdf-ik unreadable::" in result.stdout
    assert "robots/planar_2r.urdf: PASSED" in result.stdout
    assert call("verify", "locks/puma_560.urdf").exit_code == 3
